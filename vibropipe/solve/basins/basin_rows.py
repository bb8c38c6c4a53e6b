"""The starts of basins as rows: each is marched by itself, so any of them make a shard."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np

from vibropipe.physics.exciter import Exciter
from vibropipe.physics.start import row_starts
from vibropipe.solve.basins.attractor_set import Attractor, AttractorSet
from vibropipe.solve.basins.attractors import scattered_starts
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.words.parameters import STARTS
from vibropipe.words.progress import Progress
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

# Exciters whose attractors a process keeps, since its shards need those of one or few of them.
SEARCHES_KEPT = 4
# Starts of a shard that are marched before progress is reported.
ROWS_AT_ONCE = 1 << 15

Assigned = tuple[np.ndarray, np.ndarray]
"""For each start the index of its attractor, or negative, and forcing periods (`AttractorSet.assigned`)."""


@dataclass(frozen=True)
class BasinRows:
    """A grid of starts, at each value of one parameter or at one exciter.

    exciter : a parameter of the grid takes the place of its own
    grid : over the parameter, if there is one, then `x0` and `v0`; rows are starts, v0 running fastest
    phase : phase of the force at the start, in turns
    searched : number of scattered starts that look for attractors first
    """

    exciter: Exciter
    grid: SweepGrid
    phase: float
    searched: int

    @property
    def parameter(self) -> str | None:
        """Name of the parameter beside the starts, or None."""
        return next((name for name in self.grid.dims if name not in STARTS), None)

    @property
    def x0(self) -> np.ndarray:
        """Displacements of the starts."""
        return self.grid.values["x0"]

    @property
    def v0(self) -> np.ndarray:
        """Velocities of the starts."""
        return self.grid.values["v0"]

    @property
    def starts_each(self) -> int:
        """Starts at each value of the parameter."""
        return self.x0.size * self.v0.size

    @cached_property
    def exciters(self) -> list[Exciter]:
        """The exciter at each value of the parameter."""
        name = self.parameter
        if name is None:
            return [self.exciter]
        return [replace(self.exciter, **{name: value}) for value in self.grid.values[name].tolist()]

    def starts(self, k: int, rows: np.ndarray | None = None) -> np.ndarray:
        """Return all starts (n, 2) of the exciter `k`, or those of some rows; within rounding of a support, on it."""
        if rows is None:
            rows = np.arange(k * self.starts_each, (k + 1) * self.starts_each)
        x0, v0 = self.grid.parameters(STARTS, rows).T
        return row_starts(np.tile(self.exciters[k].parameters(), (len(rows), 1)), x0, v0)

    def known(self, k: int) -> AttractorSet:
        """Return the attractors of the exciter `k` that scattered starts settle on."""
        return AttractorSet(self.exciters[k], _searched(self.exciters[k], self.searched))

    def settle(
        self, k: int, assigned: Assigned | None, progress: Progress | None
    ) -> tuple[AttractorSet, Assigned]:
        """Return all attractors of the exciter `k`, and that of each of its starts.

        `assigned` are those of the starts of all exciters that are known beforehand, from `assign` or shards.
        """
        attractors, part = self.known(k), slice(k * self.starts_each, (k + 1) * self.starts_each)
        first = None if assigned is None else (assigned[0][part], assigned[1][part])
        return attractors, attractors.settle(self.starts(k), self.phase, progress, first)

    def assign(self, start: int, stop: int) -> Iterator[Assigned]:
        """Yield the attractors of the rows [start, stop), as far as scattered starts know them, some at a time."""
        while start < stop:
            k = start // self.starts_each
            end = min(stop, (k + 1) * self.starts_each, start + ROWS_AT_ONCE)
            yield self.known(k).assigned(self.starts(k, np.arange(start, end)), self.phase)
            start = end

    def shard(self, start: int, stop: int, progress: Progress | None = None) -> xr.Dataset:
        """Return what `assign` yields over the dimension `row`, with the parameters of the rows."""
        import xarray as xr

        parts, done = [], 0
        for part in self.assign(start, stop):
            parts.append(part)
            done += len(part[0])
            if progress is not None:
                progress(done, stop - start)
        owner, periods = joined_rows(parts)
        variables = {
            "attractor_assigned": ("row", owner.astype(np.int32)),
            "periods_to_attractor": ("row", periods.astype(np.int32)),
        }
        attrs = {"row_start": start, "row_stop": stop}
        return describe(xr.Dataset(variables, self.grid.row_coords(np.arange(start, stop)), attrs))


def joined_rows(parts: Sequence[Assigned]) -> Assigned:
    """Return parts of rows, in their order, as one."""
    owners, periods = zip(*parts, strict=True)
    return np.concatenate(owners), np.concatenate(periods)


@lru_cache(maxsize=SEARCHES_KEPT)
def _searched(exciter: Exciter, starts: int) -> tuple[Attractor, ...]:
    """Return the attractors that scattered starts settle on."""
    attractors = AttractorSet(exciter)
    attractors.settle(scattered_starts(exciter, starts))
    return tuple(attractors.known)
