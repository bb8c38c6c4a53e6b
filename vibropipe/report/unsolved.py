"""Rows and motions whose status is other than ok: how many, where, why, and what to change."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.report.findings import extent_text
from vibropipe.report.table import DASH, Datasets, Table
from vibropipe.words.status import Status

UNSOLVED_HEADING = "Which rows and motions have no result?"
TITLE = "Rows and motions to look at"
NOTE = "With the ranges of the parameters in which they lie. A dash: one motion, or no range."
WIDTHS = ("3cm", "auto", "auto", "3.6cm", "1fr")


def unsolved_table(datasets: Datasets) -> Table | None:
    """Return a table of all rows and motions with a status other than ok; None if there are none."""
    rows = [row for name, dataset in datasets.items() for row in unsolved_rows(name, dataset)]
    head = ["scene", "status", "rows", "among", "what to do"]
    return Table(head, rows, NOTE, WIDTHS, left=5, title=TITLE) if rows else None


def unsolved_rows(name: str, dataset: xr.Dataset) -> list[list[str]]:
    """Return a row of the table for each status other than ok of a scene."""
    if "status" not in dataset:
        return []
    status = dataset["status"]
    rows = []
    for code in np.unique(status.values).tolist():
        if code == Status.OK:
            continue
        mask = status == code
        number = f"{int(mask.sum())} of {status.size}" if status.ndim else DASH
        reason = Status(code)
        # numbers of attractors mean nothing to a reader
        among = mask.any("attractor_id") if "attractor_id" in mask.dims else mask
        where = extent_text(among) or DASH
        text = reason.name.lower().replace("_", " ")
        rows.append([name, text, number, where, reason.remedy])
    return rows
