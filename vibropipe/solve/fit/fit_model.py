"""Measured quantities as functions of the parameters to be found, and the search for their least misfit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple, TypeVar

import numpy as np

from vibropipe.physics.exciter import Exciter, Parameters
from vibropipe.physics.ties import Ties
from vibropipe.solve.design.goals import CURVE
from vibropipe.solve.fit import curve_fit
from vibropipe.solve.rows.gradient import STEP, parameter_steps
from vibropipe.solve.rows.named import Named, harmonics_of, outputs_of
from vibropipe.solve.rows.points import clipped, on_ends, solve_points
from vibropipe.words.outputs import OUTPUTS

# Widths of the boxes around the best fit that samples are taken from, in shares of the ranges; samples refined in each;
# evaluations of a search.
BOXES = (1.0, 0.3, 0.1)
REFINED, MAX_EVALUATIONS = 4, 40
# Misfit where the motion has not the measured quantity, over the largest value measured or computed at so many points.
ABSENT, SIZED = 10.0, 32
# Largest misfit after a refinement in which what does not count stays the same, over that before it.
WORSE = 1.01
# Largest number of misfits at once.
BLOCK = 4_000_000


@dataclass(frozen=True)
class Measured:
    """What was measured.

    over : swept parameters (n,), or the phase of a motion
    values : (n, q)
    names : the quantities; empty for a motion
    weights : (q,), one over the standard deviation of each
    has_noise : whether the standard deviations are known
    """

    over: Mapping[str, np.ndarray]
    values: np.ndarray
    names: list[Named]
    weights: np.ndarray
    has_noise: bool

    @property
    def columns(self) -> list[str]:
        """Names of the quantities."""
        return [name.name for name in self.names] or [CURVE]


@dataclass(frozen=True)
class Model:
    """The measured quantities as functions of what is to be found.

    found : parameters, and names of one's own that ties use
    width : (k,), widths of their ranges
    """

    exciter: Exciter
    data: Measured
    found: list[str]
    x0: float | None
    v0: float
    absent: np.ndarray
    width: np.ndarray
    ties: Ties
    # Least relative change of a step and of the misfit in a search.
    TOLERANCE: ClassVar[float] = 1e-13

    @property
    def n_motions(self) -> int:
        """Number of motions: one for each line of a response, or one."""
        return len(self.data.values) if self.data.over.keys() <= {*Parameters._fields} else 1

    def values(self, points: np.ndarray) -> np.ndarray:
        """Return the quantities (n, rows, q) at values (n, k) of the parameters."""
        return self._solve(self.rows(points))[0]

    def rows(self, points: np.ndarray) -> np.ndarray:
        """Return all parameters (n * rows, p) at values (n, k) of those to be found; a motion is one row."""
        times = self.n_motions
        varied = dict(zip(self.found, np.repeat(points, times, axis=0).T, strict=True))
        swept = self.data.over.keys() & {*Parameters._fields}
        varied |= {name: np.tile(self.data.over[name], len(points)) for name in swept}
        tied = self.ties.values({**self.exciter.numbers()._asdict(), **varied})
        base = np.tile(np.array(self.exciter.numbers()), (times * len(points), 1))
        for name, values in (varied | tied).items():
            if name in Parameters._fields:
                base[:, Parameters._fields.index(name)] = values
        return clipped(base)

    def _solve(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the quantities (n, rows, q), and the laws (n, rows, 4), at all parameters; none without a tie."""
        data, is_known = self.data, np.isfinite(rows).all(axis=1)
        rows = np.where(is_known[:, None], rows, self.exciter.numbers())
        outputs = outputs_of(data.names) if data.names else curve_fit.OUTPUTS
        wanted = tuple(name for name in OUTPUTS if name in {*outputs, "stability"})
        solved = solve_points(rows, (self.x0, self.v0), wanted, harmonics_of(data.names))
        if data.names:
            values = solved.values(data.names).reshape(-1, *data.values.shape)
        else:
            phase = data.over["phase"]
            values = curve_fit.displacement_at(solved.variables, rows, phase)[:, :, None]
        values[~is_known.reshape(len(values), -1).all(axis=1)] = np.nan
        return values, solved.laws.reshape(len(values), -1, 4)

    def residuals(self, points: np.ndarray) -> np.ndarray:
        """Return weighted misfits (n, rows * q) at values (n, k) of the parameters."""
        return self.misfits(self.values(points)).reshape(len(points), -1)

    def costs(self, points: np.ndarray) -> np.ndarray:
        """Return sums of squared misfits (n,) at values (n, k) of the parameters, in blocks of limited memory."""
        block = max(1, BLOCK // self.data.values.size)
        return np.concatenate(
            [
                (self.residuals(points[n : n + block]) ** 2).sum(axis=1)
                for n in range(0, len(points), block)
            ]
        )

    def frozen_at(self, point: np.ndarray) -> Model | None:
        """Return a model in which the same numbers count everywhere as at values (k,); None if all do."""
        return None

    def misfits(self, values: np.ndarray) -> np.ndarray:
        """Return the weighted misfits (n, rows, q) of quantities."""
        data = self.data
        misfits = values - data.values
        for column, name in enumerate(data.names):
            misfits[..., column] = name.difference(values[..., column], data.values[:, column])
        return np.where(np.isfinite(misfits), misfits, self.absent) * data.weights

    def jacobian(self, point: np.ndarray) -> np.ndarray:
        """Return the derivatives (rows * q, k) of the weighted misfits by central differences.

        A neighbour with another law of motion is left out: the derivative is one-sided, or 0 with none on either side.
        So it is of motions without an orbit, whose means over chaos have no derivative.
        """
        k, base = len(point), self.rows(point[None])[0]
        steps = STEP * np.maximum(np.abs(point), 0.1 * self.width)
        of_parameters = [n for n, name in enumerate(self.found) if name in Parameters._fields]
        columns = [Parameters._fields.index(self.found[n]) for n in of_parameters]
        steps[of_parameters] = parameter_steps(base, columns)
        points = np.vstack([point, point - np.diag(steps), point + np.diag(steps)])
        rows = self.rows(points)
        values, laws = self._solve(rows)
        misfits, at = self.misfits(values), np.repeat(points[:, None], laws.shape[1], axis=1)
        at[:, :, of_parameters] = rows.reshape(*laws.shape[:2], -1)[
            :, :, columns
        ]  # within their ranges
        is_same = ((laws == laws[0]).all(axis=2) & (laws[0, :, 1] > 0))[..., None]
        misfits, at = (np.where(is_same, each, each[0]) for each in (misfits, at))
        low, high = slice(1, k + 1), slice(k + 1, None)
        width = np.einsum("nrn->nr", at[high] - at[low])[..., None]
        slopes = (misfits[high] - misfits[low]) / np.where(width > 0, width, np.inf)
        return np.asarray(slopes.reshape(k, -1).T)


M = TypeVar("M", bound=Model)


def with_absent(model: M, low: np.ndarray, high: np.ndarray) -> M:
    """Return the model with a misfit of absent quantities above those of all values in the ranges."""
    points = low + (high - low) * _sequence(low.size).random(SIZED)
    largest = np.abs(np.nan_to_num(model.values(points))).max(axis=(0, 1))
    return replace(
        model, absent=ABSENT * np.maximum(largest, np.abs(model.data.values).max(axis=0))
    )


def _sequence(k: int) -> Any:
    """Return Sobol's sequence without its first point, a corner."""
    from scipy.stats import qmc

    return qmc.Sobol(k, scramble=False).fast_forward(1)


class Search(NamedTuple):
    """A search of the least misfit.

    best : (k,), values of least misfit
    ends : (n, k), values where refinements ended
    costs : (n,), half of the sum of squared misfits there
    samples : number of samples of each round
    """

    best: np.ndarray
    ends: np.ndarray
    costs: np.ndarray
    samples: int


def search(model: Model, low: np.ndarray, high: np.ndarray, samples: int) -> Search:
    """Return the values of least misfit, and all where refinements ended."""
    sequence, ends, costs = _sequence(low.size), list[np.ndarray](), list[float]()
    middle, best, least = 0.5 * (low + high), 0.5 * (low + high), np.inf
    for share in BOXES:
        # Laws of motion divide the ranges: a search ends where its law does, so samples look around the best fit again.
        reach = 0.5 * share * (high - low)
        points = np.clip(middle + reach * (2 * sequence.random(samples) - 1), low, high)
        order = np.argsort(model.costs(points), kind="stable")
        for n in order[:REFINED]:
            end, cost = refined(model, points[n], low, high)
            ends.append(end)
            costs.append(cost)
            if cost < least * (1 - 1e-9):
                best, least = end, cost
        middle = best
    return Search(best, np.array(ends), np.array(costs), samples)


def refined(
    model: Model, point: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, float]:
    """Return values (k,) of least misfit next to some, and half of the sum of squared misfits."""
    end, cost = _least_squares(model, point, low, high)
    frozen = model.frozen_at(end)
    if frozen is None:
        return end, cost
    moved, _cost = _least_squares(frozen, end, low, high)
    moved_cost = 0.5 * float((model.residuals(moved[None]) ** 2).sum())
    return (moved, moved_cost) if moved_cost <= cost * WORSE else (end, cost)


def _least_squares(
    model: Model, point: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, float]:
    from scipy.optimize import least_squares

    fit = least_squares(
        lambda point: model.residuals(point[None])[0], point,
        lambda point: model.jacobian(point), bounds=(low, high), x_scale=high - low,
        xtol=model.TOLERANCE, ftol=model.TOLERANCE, max_nfev=MAX_EVALUATIONS,
    )  # fmt: skip
    return on_ends(fit.x, low, high), float(fit.cost)
