"""Warning of the public functions that a motion or some rows did not end as requested."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from vibropipe.words.status import Status, UnsolvedWarning

if TYPE_CHECKING:
    import xarray as xr

# The caller of the public function that calls `warn_unsolved`, beyond what checks its keywords (`vibropipe.__init__`).
CALLER = 4


def warn_unsolved(dataset: xr.Dataset) -> xr.Dataset:
    """Warn the caller of a public function of each status other than ok, with rows and remedy; return the dataset."""
    status = dataset.variables["status"].values
    if (status == Status.OK).all():
        return dataset
    for code, rows in zip(*np.unique(status[status != Status.OK], return_counts=True), strict=True):
        where = f"{rows} of {status.size} rows: " if status.ndim else ""
        text = f"{where}status {Status(code).name.lower()}. {Status(code).remedy}"
        warnings.warn(text, UnsolvedWarning, stacklevel=CALLER)
    return dataset
