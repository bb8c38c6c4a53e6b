"""Hard case: description, known property, measure and bound; and the solvers that are measured."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import wraps
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibropipe.lab.hard_cases.analytic import flight_error, violations
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.solve.motion.simulate import simulate
from vibropipe.solve.rows.steady import steady_state
from vibropipe.words.status import Status

if TYPE_CHECKING:
    import xarray as xr


# Steps per forcing period of Newmark's method: too coarse, usual, fine.
NEWMARK_STEPS = (8, 60, 2000)

Measure = Callable[["Solver"], float]
# What defines a motion: exciter, x0, v0 and its end, inf for a steady state.
Motion = tuple[Exciter, float, float, float]


@dataclass
class Solver:
    """A method that solves cases; `runs` collects status and number of impacts of each motion, by what defines it.

    steps : Newmark steps per forcing period, None for the exact method; simulate, steady_state : public functions used.
    """

    name: str
    steps: int | None = None
    simulate: Callable[..., xr.Dataset] = simulate
    steady_state: Callable[..., xr.Dataset] = steady_state
    runs: dict[Motion, tuple[Status, int]] = field(default_factory=dict)

    def motion(
        self, exciter: Exciter, tau_end: float, x0: float = 0.0, v0: float = 0.0, **settings: Any
    ) -> xr.Dataset:
        """Solve one motion, by default without samples."""
        options: dict[str, Any] = {"samples_per_period": 0, **settings}
        if self.steps is not None:
            options |= {"method": "newmark", "steps_per_period": self.steps}
        dataset = self.simulate(exciter, tau_end=tau_end, x0=x0, v0=v0, **options)
        return self._counted(dataset, (exciter, x0, v0, tau_end))

    def solve_steady(
        self, exciter: Exciter, x0: float = 0.0, v0: float = 0.0, **settings: Any
    ) -> xr.Dataset:
        """Return the steady state from a start."""
        dataset = self.steady_state(exciter, x0=x0, v0=v0, **settings)
        return self._counted(dataset, (exciter, x0, v0, math.inf))

    def _counted(self, dataset: xr.Dataset, motion: Motion) -> xr.Dataset:
        """Record status and number of impacts of a dataset; a motion that is solved again is counted once."""
        impacts = int(dataset.sizes.get("impact", 0))
        self.runs[motion] = Status(int(dataset["status"])), impacts
        return dataset


class Bound(NamedTuple):
    """Largest accepted measure.

    newmark : factor of (2 pi / steps)**order, the step in radians of the forcing; None for cases of periodic orbits,
    which are found without steps.
    """

    exact: float
    newmark: float | None
    order: int = 0

    def of(self, solver: Solver) -> float:
        """Return the bound for a solver, nan if the case does not apply to it."""
        if solver.steps is None:
            return self.exact
        if self.newmark is None:
            return math.nan
        return self.newmark * float(2 * math.pi / solver.steps) ** self.order


class Case(NamedTuple):
    """A hard case; `measure` returns a deviation >= 0, inf for a wrong outcome. Descriptions are text for readers."""

    name: str
    description: str
    expected: str
    measure: Measure
    bound: Bound


class Measured(NamedTuple):
    """Result of a case by a solver; `passed` is None where it does not apply; `motions` differ from each other."""

    measured: float
    bound: float
    passed: bool | None
    worst_status: Status
    motions: int
    impacts: int
    short_flight_motions: int


class WrongOutcomeError(Exception):
    """A required outcome of a case is missing, or an excluded one occurs."""


def expect(holds: bool) -> None:
    """Raise WrongOutcomeError, so that the measure becomes inf, unless the condition holds."""
    if not holds:
        raise WrongOutcomeError


def largest_error(errors: Callable[..., Iterator[float]]) -> Callable[..., float]:
    """Decorate a generator of errors: the measure is the largest of them, nan if one is nan."""

    @wraps(errors)
    def measure(*arguments: Any, **options: Any) -> float:
        return float(np.max([0.0, *errors(*arguments, **options)]))

    return measure


def count_wrong(wrong: Callable[..., Iterator[int]]) -> Callable[..., float]:
    """Decorate a generator of wrong answers: the measure is their sum."""

    @wraps(wrong)
    def measure(*arguments: Any, **options: Any) -> float:
        return float(sum(wrong(*arguments, **options)))

    return measure


def end_state(motion: xr.Dataset) -> tuple[float, float]:
    """Return (x, x') at the end of a motion."""
    return float(motion["displacement_end"]), float(motion["velocity_end"])


def solvers() -> list[Solver]:
    """Return the exact method and Newmark's with coarse to fine steps."""
    return [Solver("exact"), *(Solver(f"newmark {n}", n) for n in NEWMARK_STEPS)]


def evaluate_case(case: Case, solver: Solver) -> Measured:
    """Measure one case by one solver; nan, or an error that must not occur, does not pass."""
    bound = case.bound.of(solver)
    if math.isnan(bound):
        return Measured(math.nan, bound, None, Status.OK, 0, 0, 0)
    solver.runs.clear()
    try:
        measured = float(case.measure(solver))
    except (ParameterError, WrongOutcomeError):
        measured = math.inf
    runs = list(solver.runs.values())
    statuses, impacts = [status for status, _ in runs], [n for _, n in runs]
    return Measured(
        measured,
        bound,
        measured <= bound,
        max(statuses, default=Status.OK),
        len(statuses),
        sum(impacts),
        statuses.count(Status.SHORT_FLIGHTS),
    )


def flights_or_violations(
    solver: Solver, exciter: Exciter, tau_end: float, x0: float = 0.0, v0: float = 0.0
) -> float:
    """Return the error of all flights by the exact method, or the number of violations by Newmark's."""
    if solver.steps is None:
        return flight_error(exciter, solver.motion(exciter, tau_end, x0, v0), tau_end, x0, v0)
    return violations(exciter, solver.motion(exciter, tau_end, x0, v0, samples_per_period=32))


@largest_error
def flight_check(
    solver: Solver, tasks: Sequence[tuple[Exciter, float, float, float]]
) -> Iterator[float]:
    """Flight errors (exact) or violations (newmark) of motions given as exciter, tau_end, x0, v0."""
    for task in tasks:
        yield flights_or_violations(solver, *task)
