"""Rows of scenes that can be cut into shards, and the attributes of their datasets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from vibropipe.scenes.costs import PlanError
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.solve.physical import physical_grid
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.words.wording import count, method_text

if TYPE_CHECKING:
    import xarray as xr


def row_grid(scene: BaseScene) -> SweepGrid:
    """Return the grid that a scene runs over, with the parameters that are not swept."""
    return SweepGrid(scene.over_arrays(), scene.follow_pair(), scene.resolved_exciter())


def stored_grid(scene: BaseScene) -> SweepGrid:
    """Return the grid of a scene as it is stored: in SI if the study has units."""
    grid, units = row_grid(scene), scene.mass_and_stiffness
    return grid if units is None else physical_grid(grid, *units)


def rows_of_shard(scene: BaseScene, shard: int, shards: int, most: int) -> tuple[int, int]:
    """Return the rows [start, stop) of shard `shard` of `shards`, counted from 1.

    Raises
    ------
    PlanError
        If the shard does not exist, or there are more shards than `most`.
    """
    if not 1 <= shards <= most:
        raise PlanError(
            f"scenes.{scene.name}: must be cut into 1 to {count(most, 'shard')}, got {shards}"
        )
    if not 1 <= shard <= shards:
        raise PlanError(f"shard: must be a number from 1 to {shards}, got {shard}")
    start, stop = row_grid(scene).cuts(shards)[shard - 1 : shard + 1]
    return start, stop


def with_origin(dataset: xr.Dataset, scene: BaseScene, origin: Mapping[str, Any]) -> xr.Dataset:
    """Return the dataset of a scene with its effects and its origin.

    Attributes of the solution (the method it chose, the accuracy it reached) override those of `origin`.
    """
    effects = {"effects": ", ".join(scene.called_effects())}
    attrs = {**origin, **dataset.attrs, **({} if "effects" in dataset.attrs else effects)}
    method = method_text(attrs["method"], attrs.get("steps_per_period"))
    return dataset.assign_attrs(attrs | {"method": method})
