"""Steady states over all combinations of swept parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vibropipe.scenes.keys.checks import check_backbone
from vibropipe.scenes.kind import Kind
from vibropipe.scenes.sweep.keys import CHECKS, SweepScene
from vibropipe.words.parameters import PARAMETERS, PHYSICAL, STARTS

if TYPE_CHECKING:
    import xarray as xr

# Dimensions of the rows of a sweep.
GRIDS = {*PARAMETERS, *PHYSICAL, *STARTS, "direction"}


def holds(dataset: xr.Dataset) -> bool:
    """Return whether a dataset has steady states over a grid of parameters or starts, or a single one."""
    has_rows = "regime" in dataset and "displacement_strobe" in dataset
    is_spread = "law_change_share" in dataset  # of one design
    return has_rows and not is_spread and {*dataset["regime"].dims} <= GRIDS | _own_names(dataset)


def _own_names(dataset: xr.Dataset) -> set[str]:
    """Return the names of one's own in the ties of a dataset."""
    if "ties" not in dataset.attrs:
        return set()
    # here, since it imports numba, which commands that only read studies do without
    from vibropipe.solve.rebuild import ties_of

    return {*ties_of(dataset).own}


KIND = Kind(
    __name__,
    SweepScene,
    CHECKS,
    unit="rows",
    check_among=check_backbone,
    can_be_cut=True,
    holds=holds,
)
