"""A table of text, in the form that the template reads."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import xarray as xr

DASH = "–"
ZERO_WIDTH_SPACE = "\u200b"
MAX_COLUMNS = 6  # scenes beside each other on the width of a page

Datasets = Mapping[str, xr.Dataset]


@dataclass(frozen=True)
class Table:
    """A table; the first cell of each row names the row.

    The template sets symbols for known names (`delta`, `harmonic 2`) in the head and in first cells.

    Attributes
    ----------
    head : list of str
        One entry per column.
    rows : list of list of str
        Cells, as many per row as `head` has entries.
    caption : str
        Caption of the table.
    widths : tuple of str
        Column widths as typst expressions; all "auto" if empty.
    left : int
        Number of columns that are flush left; the others are flush right.
    """

    head: list[str]
    rows: list[list[str]] = field(default_factory=list)
    caption: str = ""
    widths: tuple[str, ...] = ()
    left: int = 1

    def as_data(self) -> dict[str, Any]:
        """Return the table as JSON data; raises ValueError if a row has not one cell per column."""
        for row in self.rows:
            if len(row) != len(self.head):
                raise ValueError(
                    f"a table of {len(self.head)} columns has a row of {len(row)}: {row}"
                )
        widths = self.widths or ("auto",) * len(self.head)
        if len(widths) != len(self.head):
            raise ValueError(f"a table of {len(self.head)} columns has {len(widths)} widths")
        return {
            "head": self.head,
            "rows": self.rows,
            "caption": self.caption,
            "widths": list(widths),
            "left": self.left,
        }


def blocks(datasets: Datasets) -> list[Datasets]:
    """Split scenes into groups of at most MAX_COLUMNS."""
    names = list(datasets)
    return [
        {name: datasets[name] for name in names[at : at + MAX_COLUMNS]}
        for at in range(0, len(names), MAX_COLUMNS)
    ]


def breakable(name: str) -> str:
    """Allow line breaks after the underscores of a name."""
    return name.replace("_", f"_{ZERO_WIDTH_SPACE}")
