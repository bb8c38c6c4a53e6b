"""From a sample to a design: targets met, bounds kept and an objective lowered, along one law of motion."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from vibropipe.solve.design.goals import MET
from vibropipe.solve.design.problem import Problem
from vibropipe.solve.rows.named import Named
from vibropipe.solve.rows.points import on_ends, within_ranges

# Residual in place of that of a trial with another law of motion: steps that lead there are refused.
REFUSED = 1e3
# Refused trials after which a search for targets ends; trials of one, and steps that lower a cost.
MAX_REFUSED = 12
MAX_TRIALS, MAX_ITERATIONS = 60, 60
# Residual of a trial that ends a search for targets: rounding.
THERE = 1e-13
# Reach of the first step in shares of the ranges, the reach and the predicted gain at which steps end.
FIRST_REACH, LAST_REACH, LAST_GAIN = 0.05, 1e-6, 1e-9
# Cost of a miss of 1 relative to that of a whole objective.
PENALTY = 10.0
# Steps of Newton's method that bring a trial back to what is to be met.
CORRECTIONS = 4


class _EndedError(Exception):
    """A search stands at the end of its law of motion, or where it was to lead."""


@dataclass
class Trial:
    """A point tried: its share of the ranges, quantities and their derivatives by the shares; `valid` if same law."""

    share: np.ndarray
    values: np.ndarray
    jacobian: np.ndarray
    state: np.ndarray
    valid: bool


class Linear(NamedTuple):
    """The cost at a trial, its gradient, and slopes and values of what must be 0 (`is_equal`) or at most 0."""

    cost: float
    gradient: np.ndarray
    slopes: np.ndarray
    values: np.ndarray
    is_equal: np.ndarray

    def violation(self) -> float:
        """Return by how much what must be 0, or at most 0, is missed."""
        missed = np.where(self.is_equal, np.abs(self.values), np.maximum(self.values, 0.0))
        return float(missed.sum())

    def merit(self) -> float:
        """Return the cost with its penalty."""
        return self.cost + PENALTY * self.violation()

    def gain(self, move: np.ndarray) -> float:
        """Return by how much a move lowers the merit."""
        after = self._replace(values=self.values + self.slopes @ move)
        missed = PENALTY * (self.violation() - after.violation())
        return missed - float(self.gradient @ move)

    def least_move(self, share: np.ndarray, reach: float) -> np.ndarray:
        """Return the move of least merit within a reach and the ranges."""
        from scipy.optimize import linprog

        k, n = share.size, len(self.values)
        # Unknowns: the move, then the miss of each row.
        above = np.hstack([self.slopes, -np.eye(n)])
        below = np.hstack([-self.slopes, -np.eye(n)])[self.is_equal]
        ends = [(max(-reach, -u), min(reach, 1 - u)) for u in share.tolist()]
        solved = linprog(
            np.concatenate([self.gradient, np.full(n, PENALTY)]),
            A_ub=np.vstack([above, below]) if n else None,
            b_ub=np.concatenate([-self.values, self.values[self.is_equal]]) if n else None,
            bounds=[*ends, *[(0.0, None)] * n],
            method="highs-ds",
        )
        return np.zeros(k) if solved.x is None else solved.x[:k]


@dataclass
class Search:
    """Searches from one sample on; each trial starts from the settled state of the last one.

    share : (k,), the sample
    state : (3,), its settled state
    law : (4,), its law of motion, which is kept
    last : the last valid trial
    path : the trials of the last `improve`
    refused : trials with another law of motion
    """

    problem: Problem
    share: np.ndarray
    state: np.ndarray
    law: np.ndarray
    refused: int = 0
    last: Trial = field(init=False)
    path: list[Trial] = field(default_factory=list)
    _tried: dict[bytes, Trial] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.last = self.at(self.share)

    def at(self, share: np.ndarray) -> Trial:
        """Return the trial at a point."""
        share = on_ends(share, 0.0, 1.0)
        key = share.tobytes()
        if key in self._tried:
            return self._tried[key]
        problem = self.problem
        parameters = problem.parameters(share[None])[0]
        if not within_ranges(parameters[None])[0]:  # by a tie
            self.refused += 1
            return replace(self.last, share=share, valid=False)
        point, values, jacobian = problem.linearised(parameters, self.state, problem.columns)
        valid = bool(
            problem.is_valid(point, values[None])[0]
            and (point.laws[0] == self.law).all()
            and problem.keeps_law_around(parameters[None], self.law[None])[0]
        )
        trial = Trial(share, values, problem.by_shares(share, jacobian), point.states[0], valid)
        self._tried[key] = trial
        if valid:
            self.last, self.state = trial, trial.state
        else:
            self.refused += 1
        return trial

    def meet(self) -> Trial:
        """Return the trial that meets targets, bounds and the curve, or misses them least in squares."""
        from scipy.optimize import least_squares

        problem = self.problem

        def residuals(share: np.ndarray) -> np.ndarray:
            trial = self.at(share)
            if self.refused - refused > MAX_REFUSED or (
                trial.valid and self._distance(trial) < THERE
            ):
                raise _EndedError
            misses = problem.residuals(trial.values)[self._kept(trial)]
            return misses if trial.valid else np.full_like(misses, REFUSED)

        def slopes(share: np.ndarray) -> np.ndarray:
            slopes = self._slopes(self.at(share))
            if not np.isfinite(slopes).all():  # moved off an end of a range, to another law
                raise _EndedError
            return slopes

        begin, refused = self.last, self.refused
        self._tried = {begin.share.tobytes(): begin}
        if self._distance(begin) > 0:
            with suppress(_EndedError):
                least_squares(
                    residuals, self._inside(begin.share), slopes, bounds=(0.0, 1.0),
                    xtol=1e-14, ftol=1e-15, gtol=1e-15, max_nfev=MAX_TRIALS,
                )  # fmt: skip
        nearest = self._settle(min(self._valid(), key=self._distance))
        if problem.goals.curve is not None or problem.is_met(nearest.values):
            return nearest
        # Least squares creep along a bound that a step towards a target leaves at once.
        refused = self.refused
        met = self.improve(None)
        if problem.is_met(met.values):
            return met
        self.refused = refused
        return self._settle(nearest)

    def improve(self, which: int | None = 0, limits: dict[int, float] | None = None) -> Trial:
        """Return the trial of least cost that meets targets and bounds, from the last one on.

        Successive linear programs within a reach that shrinks where they do not hold, or the law changes. The trials
        that they led to, one after the other, are `path`.

        which : number of the objective; None for targets and bounds alone
        limits : largest values of other objectives
        """
        problem, limits = self.problem, limits or {}
        best = self.last
        self.path = [best]
        cost = 1.0 if which is None else abs(self._cost(best, which))
        scale = max(cost, 1e-3 * problem.exciter.l)

        def linear(trial: Trial) -> Linear:
            return self._linear(trial, which, limits, scale)

        def merit(trial: Trial) -> float:
            return linear(trial).merit() if trial.valid else np.inf

        reach = FIRST_REACH
        for _ in range(MAX_ITERATIONS):
            here = linear(best)
            move = here.least_move(best.share, reach)
            predicted = here.gain(move)
            trial = self._restored(self.at(best.share + move), linear)
            gained = merit(best) - merit(trial)
            if gained > 0:
                best = trial
                self.path.append(best)
            reach = min(1.0, 2 * reach) if gained >= 0.5 * predicted else 0.35 * reach
            if reach < LAST_REACH or predicted < LAST_GAIN:
                break
        return self._settle(best)

    def _restored(self, trial: Trial, linear: Callable[[Trial], Linear]) -> Trial:
        """Return a trial moved back to what is to be met, which curves away from a linear step."""
        for _ in range(CORRECTIONS):
            if not trial.valid:
                break
            here = linear(trial)
            active = here.is_equal | (here.values > 0)
            if here.violation() < MET:
                break
            back = np.linalg.pinv(here.slopes[active]) @ here.values[active]
            moved = self.at(trial.share - back)
            if not moved.valid or linear(moved).merit() >= here.merit():
                break
            trial = moved
        return trial

    def _cost(self, trial: Trial, which: int) -> float:
        return float(self.problem.costs(trial.values)[which])

    def _linear(
        self, trial: Trial, which: int | None, limits: dict[int, float], scale: float
    ) -> Linear:
        """Return cost, targets, bounds and limits at a trial, to first order."""
        problem = self.problem
        rows, values, is_equal = [], [], []

        def add(equal: bool, quantity: Named, sign: float, end: float, size: float) -> None:
            column = problem.names.index(quantity)
            values.append(sign * float(quantity.difference(trial.values[column], end)) / size)
            rows.append(sign * trial.jacobian[column] / size)
            is_equal.append(equal)

        for n in problem.smooth:
            bound = problem.goals.bounds[n]
            size = bound.scale(problem.exciter.l)
            if bound.is_target:
                add(True, bound.quantity, 1.0, bound.low, size)
                continue
            for sign, end in ((-1.0, bound.low), (1.0, bound.high)):
                if np.isfinite(end):
                    add(False, bound.quantity, sign, end - sign * problem.inside(n), size)
        for other, most in limits.items():
            objective = problem.goals.objectives[other]
            end, size = objective.sign * most, max(abs(most), 1e-12)
            add(False, objective.quantity, objective.sign, end, size)
        cost, gradient = 0.0, np.zeros(trial.share.size)
        if which is not None:
            objective = problem.goals.objectives[which]
            slope = trial.jacobian[problem.names.index(objective.quantity)]
            cost, gradient = self._cost(trial, which), objective.sign * slope
        slopes = np.array(rows).reshape(-1, trial.share.size)
        return Linear(
            cost / scale, gradient / scale, slopes, np.array(values), np.array(is_equal, bool)
        )

    def _valid(self) -> list[Trial]:
        return [trial for trial in self._tried.values() if trial.valid] or [self.last]

    def _settle(self, trial: Trial) -> Trial:
        self.last, self.state = trial, trial.state
        return trial

    def _kept(self, trial: Trial) -> np.ndarray:
        """Return the residuals that have derivatives."""
        n_bounds = len(self.problem.goals.bounds)
        n_curve = trial.values.size - len(self.problem.names)
        return np.array([*self.problem.smooth, *range(n_bounds, n_bounds + n_curve)], int)

    def _distance(self, trial: Trial) -> float:
        residuals = self.problem.residuals(trial.values)[self._kept(trial)]
        return float(np.linalg.norm(residuals))

    def _slopes(self, trial: Trial) -> np.ndarray:
        """Return the derivatives of the residuals; 0 of bounds that are kept."""
        problem = self.problem
        misses = problem.misses(trial.values)
        rows = []
        for n in problem.smooth:
            bound = problem.goals.bounds[n]
            slope = trial.jacobian[problem.names.index(bound.quantity)] / bound.scale(
                problem.exciter.l
            )
            rows.append(slope if bound.is_target or misses[n] else 0 * slope)
        rows += list(trial.jacobian[len(problem.names) :] / problem.exciter.l)
        return np.array(rows).reshape(-1, trial.share.size)

    @staticmethod
    def _inside(share: np.ndarray) -> np.ndarray:
        """Return a point moved off the ends of the ranges, where the search could not begin."""
        return np.clip(share, 1e-6, 1 - 1e-6)
