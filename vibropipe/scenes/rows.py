"""Rows of scenes, cut into shards or recomputed, and the attributes of their datasets."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibropipe.scenes.costs import PlanError
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.solve.physical import physical_grid
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.store import Difference, compare
from vibropipe.words.wording import count, method_text

if TYPE_CHECKING:
    import xarray as xr

    from vibropipe.scenes.kind import Kind


def stored_grid(scene: BaseScene) -> SweepGrid:
    """Return the grid of a scene as it is stored: in SI if the study has units."""
    grid, units = scene.row_grid(), scene.mass_and_stiffness
    return grid if units is None else physical_grid(grid, *units)


def rows_of_shard(scene: BaseScene, shard: int, shards: int, most: int) -> tuple[int, int]:
    """Return the rows [start, stop) of shard `shard` of `shards`, counted from 1.

    Raises PlanError if the shard does not exist, or there are more shards than `most`.
    """
    if not 1 <= shards <= most:
        raise PlanError(
            f"scenes.{scene.name}: must be cut into 1 to {count(most, 'shard')}, got {shards}"
        )
    if not 1 <= shard <= shards:
        raise PlanError(f"shard: must be a number from 1 to {shards}, got {shard}")
    start, stop = scene.row_grid().cuts(shards)[shard - 1 : shard + 1]
    return start, stop


def with_origin(dataset: xr.Dataset, scene: BaseScene, origin: Mapping[str, Any]) -> xr.Dataset:
    """Return the dataset of a scene with its effects and its origin.

    Attributes of the solution (the method it chose, the accuracy it reached) override those of `origin`.
    """
    effects = {"effects": ", ".join(scene.called_effects())}
    attrs = {**origin, **dataset.attrs, **({} if "effects" in dataset.attrs else effects)}
    method = method_text(attrs["method"], attrs.get("steps_per_period"))
    return dataset.assign_attrs(attrs | {"method": method})


class Recomputed(NamedTuple):
    """The recomputed part as text, its differences from the file, and the part that is not compared."""

    checked: str
    differences: list[Difference]
    not_compared: str = ""


TIMES = ("time", "asked_time", "plain_time")
TIMES_NOT_COMPARED = "times, which differ from run to run"


def whole_scene(path: Path, kind: Kind, scene: Any) -> Recomputed:
    """Solve a scene again and compare all but times, which are measured once."""
    if not kind.is_timed:
        return Recomputed("all of it", compare(path, kind.solve(scene)))
    again = kind.solve(scene.model_copy(update={"repeats": 1}))
    differences = compare(path, again, lambda name: name.startswith(TIMES))
    return Recomputed("all of it", differences, TIMES_NOT_COMPARED)


def sample_indices(count: int, n_samples: int, generator: np.random.Generator) -> list[int]:
    """Return a sorted random sample of the indices below `count`; all of them if there are no more."""
    if n_samples >= count:
        return list(range(count))
    return sorted(int(index) for index in generator.choice(count, n_samples, replace=False))
