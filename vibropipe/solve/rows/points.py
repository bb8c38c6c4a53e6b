"""Steady states at scattered points of the parameters, each from a start of its own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibropipe.physics.effects import all_effects, has_soft_support
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.limits import MAX_ROW_WORK, START_WORK, row_work
from vibropipe.solve.rows.label import Variables, concatenate, coordinates, label_rows
from vibropipe.solve.rows.many import Rows, Start, solve_rows
from vibropipe.solve.rows.named import Named
from vibropipe.solve.rows.row_results import columns_of
from vibropipe.solve.sweep.blocks import LIMITS
from vibropipe.solve.threads import row_blocks
from vibropipe.words.parameters import DEFAULTS, FURTHER, PARAMETERS
from vibropipe.words.progress import Progress
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

# Marches of a call that may take the largest work of a row (some 25 s of a core); all others take START_WORK on
# average. Ordinary searches need at most half of it.
LONG_MARCHES = 100
# Share of a range within which a value is at its end.
AT_END = 1e-12


class Points(NamedTuple):
    """Solved points: parameters (n, p), and quantities over `row`."""

    parameters: np.ndarray
    variables: Variables

    def values(self, names: Sequence[Named]) -> np.ndarray:
        """Return the quantities (n, names); NaN where the motion has none, as without impacts."""
        columns = [name.values(self.variables, self.parameters) for name in names]
        return np.stack(columns, axis=1) if columns else np.empty((len(self.parameters), 0))

    @property
    def states(self) -> np.ndarray:
        """States (n, 3) at the section, of mass and housing."""
        held = ((), np.zeros(len(self.parameters)))
        kinds = ("displacement", "velocity", "housing_velocity")
        return np.stack([self.variables.get(f"{kind}_strobe", held)[1] for kind in kinds], axis=1)

    @property
    def is_stable(self) -> np.ndarray:
        """Whether the motion is a stable orbit (n,)."""
        stable: np.ndarray = self.variables["stable"][1] == 1
        return stable & (self.variables["period_multiple"][1] > 0)

    @property
    def laws(self) -> np.ndarray:
        """Laws of motion (n, 4): regime, m, p1, p2; of a motion with rest without its impacts, which accumulate."""
        regime, m = (self.variables[name][1] for name in ("regime", "period_multiple"))
        impacts = self.variables["impacts_per_orbit"][1]
        impacts = np.where((regime == Regime.WITH_REST)[:, None], 0, impacts)
        return np.column_stack([regime, m, impacts]).astype(int)

    def has_law(self, laws: np.ndarray) -> np.ndarray:
        """Return which motions (n,) are stable orbits of a law (4,), or each of its own (n, 4)."""
        has: np.ndarray = self.is_stable & (self.laws == laws).all(axis=1)
        return has

    def take(self, rows: Any) -> Points:
        """Return some of the points; impacts one by one are left out."""
        kept = {
            name: (dims, values[rows])
            for name, (dims, values) in self.variables.items()
            if dims[0] == "row" and name != "row_size"
        }
        return Points(self.parameters[rows], kept)


class WorkSpentError(Exception):
    """The marches of a call take more work than it may."""


@dataclass
class CallWork:
    """Work that is left for the marches of a call, in steps, beside START_WORK for each row."""

    left: float = field(default_factory=lambda: LONG_MARCHES * MAX_ROW_WORK)

    def take(self, work: int, rows: int) -> None:
        """Count the work that rows took; raises WorkSpentError where no more is left."""
        self.left -= work - START_WORK * rows
        if self.left < 0:
            raise WorkSpentError


def solve_points(
    parameters: np.ndarray,
    start: Start,
    outputs: tuple[str, ...],
    harmonics: int,
    progress: Progress | None = None,
    work: CallWork | None = None,
) -> Points:
    """Solve points, with the same kernel as `sweep` and bitwise the same on any number of threads.

    parameters : (n, p), valid, in the order of `PARAMETERS`
    start : (x0, v0) or (x0, v0, housing_v0) of all points, or as arrays (n,); displacements beyond a support are placed
        on it
    outputs : in the order of `OUTPUTS`
    progress : called as progress(done, total), in points
    work : what is left for these and later points
    Raises WorkSpentError if these take more than is left.
    """

    def rows(first: int, stop: int) -> list[np.ndarray]:
        return [parameters[first:stop]]

    def starts(first: int, stop: int) -> Start:
        return tuple(part if np.ndim(part) == 0 else part[first:stop] for part in start)

    columns = columns_of(parameters)
    effects, soft = all_effects(columns, pieces=True, housing=True), has_soft_support(columns)
    n, spent = len(parameters), list[int]()
    limits = LIMITS._replace(row_work=row_work(n))
    solver = limits, harmonics, outputs, progress, effects, soft, spent
    with closing(solve_rows(row_blocks(n), Rows(rows, starts), *solver)) as blocks:
        parts, begin = [], 0
        for stop, (solved,) in blocks:
            parts.append(label_rows(solved, parameters[begin:stop], outputs))
            begin = stop
    if work is not None:
        work.take(sum(spent), n)
    return Points(parameters, concatenate(parts))


def points_dataset(
    points: Points, dim: str, harmonics: int, attrs: Mapping[str, Any], varied: Sequence[str]
) -> xr.Dataset:
    """Return points as a dataset over `dim`, parameters that are not varied as scalars; impacts are ragged."""
    import xarray as xr

    columns = dict(zip(Parameters._fields, points.parameters.T, strict=True))
    coords = {
        name: (dim, values) if name in varied else ((), values[0])
        for name, values in columns.items()
        if name in varied or name not in FURTHER or (values != DEFAULTS[name]).any()
    }
    variables = {
        name: (tuple(dim if each == "row" else each for each in dims), values)
        for name, (dims, values) in points.variables.items()
    }
    block = xr.Dataset(variables, coordinates(points.variables, harmonics), dict(attrs))
    return describe(block.assign_coords(coords))


def within_ranges(parameters: np.ndarray) -> np.ndarray:
    """Return which rows (n,) of parameters lie in their ranges, with distinct supports."""
    inside = np.ones(len(parameters), bool)
    for column, entry in zip(parameters.T, PARAMETERS.values(), strict=True):
        low, high = entry.range.low, entry.range.high
        inside &= (column > low if entry.range.above else column >= low) & (column <= high)
    half, delta = (parameters[:, Parameters._fields.index(name)] for name in ("l", "delta"))
    return inside & (delta - half < delta + half)


def on_ends(values: np.ndarray, low: Any, high: Any) -> np.ndarray:
    """Return values in their ranges, those within rounding of an end on it: least squares searches stay inside."""
    least = AT_END * (high - low)
    return np.where(values - low < least, low, np.where(high - values < least, high, values))


def clipped(parameters: np.ndarray) -> np.ndarray:
    """Return rows of parameters, each moved into its range; one that must be above 0 stays above it."""
    moved = parameters.copy()
    for column, entry in zip(moved.T, PARAMETERS.values(), strict=True):
        low = max(entry.range.low, np.finfo(float).tiny) if entry.range.above else entry.range.low
        np.clip(column, low, entry.range.high, out=column)
    return moved
