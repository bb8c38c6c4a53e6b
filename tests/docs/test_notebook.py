"""The notebook runs from its first cell to its last, and shows what it shows here."""

from __future__ import annotations

import re
from typing import Any

from first_steps import NOTEBOOK, executed, stored


def shown(book: Any) -> list[Any]:
    """Return what each cell of code prints, and how many pictures it draws."""
    return [
        (
            [output.text for output in cell.outputs if output.output_type == "stream"],
            [output.data.get("text/plain", "") for output in cell.outputs if "data" in output],
            sum("image/png" in output.get("data", {}) for output in cell.outputs),
        )
        for cell in book.cells
        if cell.cell_type == "code"
    ]


def without_sizes(cells: list[Any]) -> list[Any]:
    """Leave out the text of a figure, which stands beside its picture."""
    return [
        (printed, [text for text in values if "Figure" not in text], drawn)
        for printed, values, drawn in cells
    ]


def test_what_the_notebook_shows_is_what_its_cells_give() -> None:
    cells = without_sizes(shown(stored()))
    assert without_sizes(shown(executed())) == cells
    assert sum(drawn for *_, drawn in cells) == 5
    assert len(cells) > 7


def test_links_of_the_notebook_lead_to_files() -> None:
    text = "\n".join(cell.source for cell in stored().cells if cell.cell_type == "markdown")
    links = re.findall(r"\]\(([^)#]+)", text)
    assert links
    for link in links:
        assert (NOTEBOOK.parent / link).is_file()
