"""Rows and motions whose status is other than ok: how many, where, why, and what to change."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.report.findings import extent_text
from vibropipe.report.section import Section
from vibropipe.report.table import DASH, Datasets, Table, breakable
from vibropipe.words.status import Status

TITLE = "Rows and motions to look at"
CAPTION = (
    "Rows and motions that did not end as requested: status, number, ranges of the parameters in which they lie, and "
    "what to change."
)
WIDTHS = ("3cm", "auto", "auto", "3.6cm", "1fr")


def unsolved_section(datasets: Datasets) -> list[Section]:
    """Return a section on all rows and motions with a status other than ok; none if there are none."""
    rows = [row for name, dataset in datasets.items() for row in unsolved_rows(name, dataset)]
    if not rows:
        return []
    table = Table(["scene", "status", "rows", "among", "what to do"], rows, CAPTION, WIDTHS, left=5)
    return [Section(TITLE, tables=[table])]


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
        where = extent_text(mask) or DASH
        text = breakable(reason.name.lower())
        rows.append([breakable(name), text, number, where, reason.remedy.replace("`", "")])
    return rows
