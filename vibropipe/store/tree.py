"""The tree of a study's datasets: `xarray.DataTree` with a filter and a table that suit ragged impacts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import xarray as xr

from vibropipe.store.table import RAGGED, table

if TYPE_CHECKING:
    import pandas as pd


class StudyTree(xr.DataTree):
    """A tree of datasets, a scene each, as `open_study` returns it.

    The methods of `xarray.Dataset` with the same names would repeat every impact for each point of the grid.
    """

    __slots__ = ()

    def where(self, condition: xr.DataArray, drop: bool = False) -> xr.Dataset:
        """Return the quantities of a scene where a condition holds, NaN elsewhere.

        Parameters
        ----------
        condition : xarray.DataArray
            Truth values over dimensions of the grid, or over those of listed events (`impact`, ...).
        drop : bool
            Whether to leave out values of a coordinate at which the condition holds nowhere; the condition is then
            computed.

        Returns
        -------
        xarray.Dataset
            The quantities over the grid, as lazy as before; over events if the condition is.
        """
        dataset = self.to_dataset()
        events = set(condition.dims) & set(RAGGED)
        if events:
            over = [name for name, values in dataset.items() if events & set(values.dims)]
            selected = dataset[over]
        else:
            selected = dataset.drop_dims([dim for dim in RAGGED if dim in dataset.dims])
        return selected.where(condition.compute() if drop else condition, drop=drop)

    def to_dataframe(self) -> pd.DataFrame:
        """Return the points of a scene as a table (see `vibropipe.table`)."""
        return table(self)
