"""A design problem: points of the varied parameters, in shares of their ranges, and how far each misses its goals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from vibropipe.physics.exciter import Exciter, Parameters
from vibropipe.physics.ties import Ties
from vibropipe.solve.branch.places import with_places
from vibropipe.solve.design.goals import MET, YIELD, Bound, Goals
from vibropipe.solve.fit import curve_fit
from vibropipe.solve.rows.gradient import exact_slopes, values_and_jacobian
from vibropipe.solve.rows.many import Start
from vibropipe.solve.rows.named import SENSITIVITY, Named, harmonics_of, outputs_of
from vibropipe.solve.rows.points import CallWork, Points, clipped, solve_points, within_ranges
from vibropipe.words.outputs import OUTPUTS

# The output of derivatives.
OUTPUT = "sensitivity"
# Outputs that tell the law of a motion and whether it is stable.
OF_LAW = ("impacts", "stability")
# Directions beside those of the axes, for each parameter.
DIRECTIONS = 6
# No part of any sample misses a goal below this logarithm of the share that does: limits are ten deviations away.
LEAST_LOG_LOSS = -50.0


def directions(k: int) -> np.ndarray:
    """Return unit vectors (n, k): along each axis both ways, then of low discrepancy."""
    from scipy.special import ndtri
    from scipy.stats import qmc

    axes = np.vstack([np.eye(k), -np.eye(k)])
    if k == 1:
        return axes
    points = qmc.Halton(k, scramble=False).random(DIRECTIONS * k + 1)[1:]
    scattered = ndtri(points)
    return np.vstack([axes, scattered / np.linalg.norm(scattered, axis=1, keepdims=True)])


@dataclass(frozen=True)
class Problem:
    """Goals, varied parameters and start.

    exciter : parameters that are not varied
    vary : ranges of the varied ones
    x0, v0 : start of every motion
    tolerance : standard deviations of parameters
    allow : how far targets may be off if parameters are
    scatter : standard deviations of parameters that parts scatter by: given, or assumed; none if yields are not asked
        for
    margins : (bounds,), how far inside each bound a quantity is to be
    reach : standard deviations of `scatter` up to which the motions around a design are to have its law
    ties : parameters by expressions of others; `vary` then has names of one's own, too. They hold for designs: parts
        scatter in each parameter by itself
    work : what all marches of the search may take
    """

    exciter: Exciter
    vary: Mapping[str, tuple[float, float]]
    goals: Goals
    x0: float | None
    v0: float
    tolerance: Mapping[str, float] = field(default_factory=dict)
    allow: Mapping[str, float] = field(default_factory=dict)
    scatter: Mapping[str, float] = field(default_factory=dict)
    margins: np.ndarray | None = None
    reach: float = 0.0
    ties: Ties = field(default_factory=Ties)
    work: CallWork = field(default_factory=CallWork)

    @cached_property
    def following(self) -> list[str]:
        """Parameters that are tied to what is varied."""
        return self.ties.following(self.vary)

    @cached_property
    def columns(self) -> list[int]:
        """Columns of the varied parameters, and of those that are tied to them."""
        names = [name for name in (*self.vary, *self.following) if name in Parameters._fields]
        return [Parameters._fields.index(name) for name in names]

    @cached_property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Ranges of the varied parameters, and of those that are tied to them."""
        spans = self.ties.spans(self.exciter.numbers()._asdict(), self.vary)
        return {n: ends for n, ends in self.vary.items() if n in Parameters._fields} | spans

    @cached_property
    def scattered(self) -> tuple[list[int], np.ndarray]:
        """Columns of the parameters that parts scatter by, and their standard deviations."""
        columns = [Parameters._fields.index(name) for name in self.scatter]
        return columns, np.array([*self.scatter.values()])

    @cached_property
    def low(self) -> np.ndarray:
        """Lower ends of the ranges."""
        return np.array([ends[0] for ends in self.vary.values()])

    @cached_property
    def width(self) -> np.ndarray:
        """Widths of the ranges."""
        return np.array([ends[1] - ends[0] for ends in self.vary.values()])

    @cached_property
    def names(self) -> list[Named]:
        """The wanted quantities."""
        return self.goals.names

    @cached_property
    def smooth(self) -> list[int]:
        """Bounds on quantities with a derivative."""
        return [n for n, bound in enumerate(self.goals.bounds) if not bound.quantity.is_of_law]

    @cached_property
    def outputs(self) -> tuple[str, ...]:
        """Outputs that the quantities need."""
        wanted = {*outputs_of(self.names), *(curve_fit.OUTPUTS if self.goals.curve else ())}
        wanted |= {OUTPUT} if any(name.derived for name in self.names) else set()
        return tuple(name for name in OUTPUTS if name in wanted)

    def parameters(self, shares: np.ndarray) -> np.ndarray:
        """Return the parameters (n, p) of points (n, k) in shares of the ranges; nan where a tie has no value."""
        rows = np.tile(np.array(self.exciter.numbers()), (len(shares), 1))
        varied = dict(zip(self.vary, (self.low + shares * self.width).T, strict=True))
        tied = self.ties.values({**self.exciter.numbers()._asdict(), **varied}, self.following)
        for name, values in (varied | tied).items():
            if name in Parameters._fields:
                rows[:, Parameters._fields.index(name)] = values
        return rows

    def by_shares(self, share: np.ndarray, jacobian: np.ndarray) -> np.ndarray:
        """Return derivatives (q, k) by shares of the ranges from those (q, columns) by each parameter alone."""
        if not self.ties:
            return jacobian * self.width
        varied = dict(zip(self.vary, (self.low + share * self.width).tolist(), strict=True))
        given = {**self.exciter.numbers()._asdict(), **varied}
        names = [Parameters._fields[column] for column in self.columns]
        return self.ties.chained(given, names, self.vary, jacobian) * self.width

    def from_start(self, parameters: np.ndarray, sensitivity: bool = False) -> Points:
        """Return the motions that settle from the start at parameters (n, p), with sensitivities if asked for."""
        return self._solved(parameters, (self.x0, self.v0), sensitivity)

    def laws_from_start(self, parameters: np.ndarray) -> Points:
        """Return the motions that settle from the start at parameters (n, p), of which the laws alone are asked."""
        return solve_points(parameters, (self.x0, self.v0), OF_LAW, 1, work=self.work)

    def near(self, parameters: np.ndarray, states: np.ndarray, sensitivity: bool = False) -> Points:
        """Return the motions that settle from states (n, 3), with sensitivities if asked for."""
        return self._solved(parameters, tuple(states.T), sensitivity)

    def _solved(self, parameters: np.ndarray, start: Start, sensitivity: bool) -> Points:
        outputs = tuple(dict.fromkeys((*self.outputs, OUTPUT) if sensitivity else self.outputs))
        harmonics = harmonics_of(self.names)
        points = solve_points(parameters, start, outputs, harmonics, work=self.work)
        return with_places(points, self.names, OUTPUT in outputs)

    def linearised(
        self, parameters: np.ndarray, state: np.ndarray, columns: list[int]
    ) -> tuple[Points, np.ndarray, np.ndarray]:
        """Return the motion near a state, its quantities as `read` returns them, and their derivatives (q, columns)."""
        points, values, jacobian = values_and_jacobian(
            parameters, state, columns, self.near, self.read, self.difference,
            None if self.goals.curve or any(name.derived for name in self.names) else self.names,
        )  # fmt: skip
        for name in self.at_most:
            if name.is_without_contact(points.variables)[0]:
                jacobian[self.names.index(name)] = 0.0
        return points, values, jacobian

    @cached_property
    def at_most(self) -> list[Named]:
        """Quantities that are only bounded above: 0 stands for what a motion that never strikes does not have."""
        sought = [each.quantity for each in self.goals.objectives]
        sought += [bound.quantity for bound in self.goals.bounds if np.isfinite(bound.low)]
        return [name for name in self.names if name not in sought]

    def read(self, points: Points) -> np.ndarray:
        """Return the wanted quantities (n, names) and then the misses of the curve, if one is wanted."""
        plain = [name.plain() for name in self.names if not name.derived]
        values = np.empty((len(points.parameters), len(self.names)))
        values[:, [not name.derived for name in self.names]] = points.values(plain)
        for name in self.at_most:
            values[name.is_without_contact(points.variables), self.names.index(name)] = 0.0
        for column, name in enumerate(self.names):
            if name.derived == YIELD:
                values[:, column] = -self._log_loss(points)
            elif name.derived:
                values[:, column] = self._derived(points, name)
        if self.goals.curve is None:
            return values
        phase, wanted = self.goals.curve
        displacement = curve_fit.displacement_at(points.variables, points.parameters, phase)
        return np.hstack([values, displacement - wanted])

    def _derived(self, points: Points, name: Named) -> np.ndarray:
        """Return standard deviations or sensitivities (n,) of a quantity."""
        of = [name.parameter] if name.derived == SENSITIVITY else list(self.tolerance)
        columns = [Parameters._fields.index(each) for each in of]
        slopes = exact_slopes(points, [name.plain()], columns)[:, 0]
        if name.derived == SENSITIVITY:
            return slopes[:, 0]
        scaled = slopes * np.array([self.tolerance[each] for each in of])
        std: np.ndarray = np.linalg.norm(scaled, axis=1)
        return std

    def keeps_law_around(self, parameters: np.ndarray, laws: np.ndarray) -> np.ndarray:
        """Return where motions `reach` deviations around parameters (n, p), in many directions, have laws (n, 4)."""
        n = len(parameters)
        if not self.reach or not n:
            return np.ones(n, bool)
        columns, sigma = self.scattered
        moves = directions(len(columns)) * sigma
        rows = np.repeat(parameters, len(moves), axis=0)
        rows[:, columns] += self.reach * np.tile(moves, (n, 1))
        has_law = self.laws_from_start(clipped(rows)).has_law(np.repeat(laws, len(moves), axis=0))
        return np.asarray(has_law.reshape(n, -1).all(axis=1))

    def _log_loss(self, points: Points) -> np.ndarray:
        """Return the logarithm (n,) of the share of parts that miss a goal, to first order: smooth where none does.

        Goals are left out whose quantity has no derivative.
        """
        from scipy.special import log_ndtr

        least = np.full(len(points.parameters), LEAST_LOG_LOSS)
        distances = (np.nan_to_num(each, nan=np.inf) for each in self._distances(points))
        losses = [log_ndtr(-distance) for distance in distances]
        total: np.ndarray = np.logaddexp.reduce([least, *losses])
        return total

    def reliability(self, points: Points) -> np.ndarray:
        """Return the least distance (n,) to a limit of a goal in the standard deviations of its quantity.

        Goals are left out whose quantity has no derivative. The points have sensitivities.
        """
        endless = np.full(len(points.parameters), np.inf)
        distances = [np.nan_to_num(each, nan=np.inf) for each in self._distances(points)]
        least: np.ndarray = np.min([endless, *distances], axis=0)
        return least

    def _distances(self, points: Points) -> Iterator[np.ndarray]:
        """Yield the distances (n,) from each limit of each goal, in the standard deviations of its quantity."""
        columns, sigma = self.scattered
        for bound in (self.goals.bounds[n] for n in self.smooth):
            name, room = bound.quantity, self.room(bound)
            if name.derived or np.isinf(room):
                continue
            std = np.linalg.norm(exact_slopes(points, [name], columns)[:, 0] * sigma, axis=1)
            values = name.values(points.variables, points.parameters)
            for left in (name.difference(bound.high, values), name.difference(values, bound.low)):
                yield (left + room) / np.maximum(std, 1e-300)

    def room(self, bound: Bound) -> float:
        """Return how far a part may be beyond a goal: what is allowed of a target, without end if nothing is said."""
        if not bound.is_target or bound.quantity.is_of_law:
            return 0.0
        return self.allow.get(bound.quantity.name, np.inf)

    def distance(self, bound: Bound, values: np.ndarray) -> float:
        """Return how far the quantities (q,) of a design are from the nearest limit of a goal, negative beyond it."""
        column = values[self.names.index(bound.quantity)]
        below, above = bound.quantity.difference(
            np.array([bound.high, column]), np.array([column, bound.low])
        ).tolist()
        return min(below, above) + self.room(bound)

    def difference(self, one: np.ndarray, two: np.ndarray) -> np.ndarray:
        """Return one - two of quantities as `read` returns them, phases between -pi and pi."""
        differences = one - two
        for column, name in enumerate(self.names):
            differences[..., column] = name.difference(one[..., column], two[..., column])
        return differences

    def misses(self, values: np.ndarray) -> np.ndarray:
        """Return by how much quantities (..., q) miss the targets and bounds (..., bounds), over their scales.

        Positive above, negative below, 0 within.
        """
        missed = []
        for n, bound in enumerate(self.goals.bounds):
            column = values[..., self.names.index(bound.quantity)]
            scale = bound.scale(self.exciter.l)
            inside = self.inside(n)
            over = np.maximum(bound.quantity.difference(column, bound.high - inside), 0.0)
            under = np.minimum(bound.quantity.difference(column, bound.low + inside), 0.0)
            missed.append((over + under) / scale)
        return np.stack(missed, axis=-1) if missed else np.zeros((*values.shape[:-1], 0))

    def inside(self, n: int) -> float:
        """Return how far within a bound its quantity is aimed at: what is met is met in the last digit."""
        bound = self.goals.bounds[n]
        if bound.is_target or bound.quantity.is_of_law:
            return 0.0
        margin = 0.0 if self.margins is None else float(self.margins[n])
        return margin + 2 * MET * bound.scale(self.exciter.l)

    def residuals(self, values: np.ndarray) -> np.ndarray:
        """Return misses of bounds and targets and, over l, of the curve."""
        misses = self.misses(values)
        curve = values[..., len(self.names) :] / self.exciter.l
        return np.concatenate([misses, curve], axis=-1)

    def is_met(self, values: np.ndarray) -> np.ndarray:
        """Return whether all targets and bounds are met (...,)."""
        most = [MET if bound.is_target else 2 * MET for bound in self.goals.bounds]
        return (np.abs(self.misses(values)) <= most).all(axis=-1)

    def costs(self, values: np.ndarray) -> np.ndarray:
        """Return the objectives (..., objectives), each to be least."""
        signs = np.array([each.sign for each in self.goals.objectives])
        columns = [self.names.index(each.quantity) for each in self.goals.objectives]
        return values[..., columns] * signs

    def is_valid(self, points: Points, values: np.ndarray) -> np.ndarray:
        """Return which points (n,) are stable orbits in range that have all quantities."""
        return points.is_stable & np.isfinite(values).all(axis=1) & within_ranges(points.parameters)
