"""A table of text, in the form that the template reads."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import xarray as xr

from vibropipe.figures.units import LOWERED
from vibropipe.words.vocabulary import PLAIN_SYMBOLS

DASH = "–"
MAX_ROWS, ROWS_SHOWN = 12, 10  # of a table, and of one that is cut

Datasets = Mapping[str, xr.Dataset]


# Heads and first cells that are names of quantities -> what is written.
SYMBOLS = {
    **PLAIN_SYMBOLS,
    "k1": "k₁", "k2": "k₂", "load": "load q", "friction": "friction d",
    "multiple": "m", "impacts_1": "struck, support 1", "impacts_2": "struck, support 2",
    "omega": "ω", "C1": "C₁", "C2": "C₂", "H1": "H₁", "H2": "H₂", "F2": "F₂", "mean": "mean",
    "multipliers": "multipliers",
}  # fmt: skip


@dataclass(frozen=True)
class Table:
    """A table; the first cell of each row names the row.

    Attributes
    ----------
    head : list of str
        One entry per column, with the one unit of the column in brackets. Names of quantities (`delta`, `harmonic 2`)
        are written as symbols, in the head and in first cells.
    rows : list of list of str
        Cells, as many per row as `head` has entries, with keys and commands in backticks. Of more than MAX_ROWS
        only ROWS_SHOWN are shown, and the note says so.
    note : str
        Below the table: what a dash means, what the numbers are.
    widths : tuple of str
        Column widths as typst expressions, for a table that is wider than the text; all "auto" if empty.
    left : int
        Number of columns that are flush left; the others are flush right.
    title : str
        Above the table, as of a figure: one line of at most 85 letters.
    scene, picture : str
        The scene and the picture after which the table stands; empty: after those of its kind, of its scene.
    """

    head: list[str]
    rows: list[list[str]] = field(default_factory=list)
    note: str = ""
    widths: tuple[str, ...] = ()
    left: int = 1
    title: str = ""
    scene: str = ""
    picture: str = ""

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
        rows, note = self.rows, self.note
        if len(rows) > MAX_ROWS:
            rows = rows[:ROWS_SHOWN]
            note = f"{note} {len(self.rows) - ROWS_SHOWN} more rows are in the dataset.".strip()
        return {
            "type": "table",
            "title": self.title,
            "head": [symbol(name) for name in self.head],
            "rows": [[symbol(row[0]), *row[1:]] for row in rows],
            "note": note,
            "widths": list(widths),
            "left": self.left,
        }


def symbol(name: str) -> str:
    """Return the symbol of a quantity by its name, which may have a unit in brackets; any other text stays."""
    bare, bracket, unit = name.partition(" (")
    if harmonic := re.fullmatch(r"harmonic (\d+)", bare):
        return f"A{harmonic[1].translate(LOWERED)}{bracket}{unit}"
    return f"{SYMBOLS.get(bare, bare)}{bracket}{unit}"
