"""A table as the template takes it: a head and rows of text."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import xarray as xr

DASH = "–"
ZERO_WIDTH_SPACE = "\u200b"
SIDE_BY_SIDE = 5

Datasets = Mapping[str, xr.Dataset]


@dataclass(frozen=True)
class Table:
    """``head`` has one entry per column; the first cell of each row names the row.

    A head or first cell that the template knows as a name (``delta``, ``harmonic 2``) is set as its
    symbol; everything else is set as it stands. ``widths`` are those of the typesetter by column, all
    "auto" if empty; the first ``left`` columns are set flush left, the others flush right.
    """

    head: list[str]
    rows: list[list[str]] = field(default_factory=list)
    caption: str = ""
    widths: tuple[str, ...] = ()
    left: int = 1

    def as_data(self) -> dict[str, Any]:
        """Return what goes to the template; ValueError if a row has not one cell per column."""
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
    """Cut scenes that stand side by side into as many as a page is wide for."""
    names = list(datasets)
    return [
        {name: datasets[name] for name in names[at : at + SIDE_BY_SIDE]}
        for at in range(0, len(names), SIDE_BY_SIDE)
    ]


def breakable(name: str) -> str:
    """Let a scene's name be broken after its underscores, in a narrow column."""
    return name.replace("_", f"_{ZERO_WIDTH_SPACE}")
