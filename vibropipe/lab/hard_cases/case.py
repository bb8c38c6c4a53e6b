"""What a hard case is: what is asked, what must hold, how it is measured, and by which solvers."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import wraps
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.solve.motion import simulate
from vibropipe.solve.steady import steady_state
from vibropipe.words.status import Status

if TYPE_CHECKING:
    import xarray as xr

NEWMARK_STEPS = (8, 60, 2000)

Measure = Callable[["Solver"], float]


@dataclass
class Solver:
    """One way to solve a case; `runs` keeps the status and the number of impacts of each motion it has solved.

    steps: Newmark steps per forcing period, None for the exact method. simulate, steady_state: the faces.
    """

    name: str
    steps: int | None = None
    simulate: Callable[..., xr.Dataset] = simulate
    steady_state: Callable[..., xr.Dataset] = steady_state
    runs: list[tuple[Status, int]] = field(default_factory=list)

    def motion(
        self, exciter: Exciter, tau_end: float, x0: float = 0.0, v0: float = 0.0, **more: Any
    ) -> xr.Dataset:
        """One motion by this solver, without samples unless they are asked for."""
        options: dict[str, Any] = {"samples_per_period": 0, **more}
        if self.steps is not None:
            options |= {"method": "newmark", "steps_per_period": self.steps}
        return self._counted(self.simulate(exciter, tau_end=tau_end, x0=x0, v0=v0, **options))

    def solve_steady(self, exciter: Exciter, x0: float = 0.0, v0: float = 0.0) -> xr.Dataset:
        """The steady state from a start."""
        return self._counted(self.steady_state(exciter, x0=x0, v0=v0))

    def _counted(self, found: xr.Dataset) -> xr.Dataset:
        self.runs.append((Status(int(found["status"])), int(found.sizes.get("impact", 0))))
        return found


class Bound(NamedTuple):
    """How large the measured value may be.

    newmark: times (2 pi/steps)^order, the step in radians of the forcing; None where closed orbits are asked,
    which are found by no step.
    """

    exact: float
    newmark: float | None
    order: int = 0

    def of(self, solver: Solver) -> float:
        """The bound for one solver, nan where the case is not for it."""
        if solver.steps is None:
            return self.exact
        if self.newmark is None:
            return math.nan
        return self.newmark * float(2 * math.pi / solver.steps) ** self.order


class Case(NamedTuple):
    """asked and known are text for people; measure gives one number >= 0, inf where what happens is wrong."""

    name: str
    description: str
    expected: str
    measure: Measure
    bound: Bound


class Measured(NamedTuple):
    """What came of one case by one solver; passed is None where the case is not for it."""

    measured: float
    bound: float
    passed: bool | None
    worst_status: Status
    motions: int
    impacts: int
    short_flight_motions: int


class WrongOutcomeError(Exception):
    """Something happens in a case that must not, or does not that must."""


def expect(holds: bool) -> None:
    """End the measure of a case with inf unless something holds."""
    if not holds:
        raise WrongOutcomeError


def largest(errors: Callable[..., Iterator[float]]) -> Callable[..., float]:
    """Make the measure that is the largest of all errors yielded; nan if one is."""

    @wraps(errors)
    def measure(*given: Any, **named: Any) -> float:
        return float(np.max([0.0, *errors(*given, **named)]))

    return measure


def count(wrong: Callable[..., Iterator[int]]) -> Callable[..., float]:
    """Make the measure that is the sum of all wrong answers yielded."""

    @wraps(wrong)
    def measure(*given: Any, **named: Any) -> float:
        return float(sum(wrong(*given, **named)))

    return measure


def end_state(motion: xr.Dataset) -> tuple[float, float]:
    """(x, x') at the end of a motion."""
    return float(motion["displacement_end"]), float(motion["velocity_end"])


def solvers() -> list[Solver]:
    """The exact method, and Newmark's at steps from coarse to fine."""
    return [Solver("exact"), *(Solver(f"newmark {n}", n) for n in NEWMARK_STEPS)]


def evaluate_case(case: Case, solver: Solver) -> Measured:
    """Measure one case by one solver; nan, or an error where none is allowed, does not pass."""
    bound = case.bound.of(solver)
    if math.isnan(bound):
        return Measured(math.nan, bound, None, Status.OK, 0, 0, 0)
    solver.runs.clear()
    try:
        measured = float(case.measure(solver))
    except (ParameterError, WrongOutcomeError):
        measured = math.inf
    statuses, impacts = [status for status, _ in solver.runs], [n for _, n in solver.runs]
    return Measured(
        measured,
        bound,
        measured <= bound,
        max(statuses, default=Status.OK),
        len(statuses),
        sum(impacts),
        statuses.count(Status.SHORT_FLIGHTS),
    )
