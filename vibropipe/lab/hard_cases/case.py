"""What a hard case is: what is asked, what must hold, how it is measured, and by which solvers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.solve.motion import simulate
from vibropipe.solve.steady import steady_state
from vibropipe.words.status import Status

if TYPE_CHECKING:
    import xarray as xr

NEWMARK_STEPS = (8, 60, 2000)


@dataclass
class Solver:
    """One way to solve a case; counts what it has done.

    steps: Newmark steps per forcing period, None for the exact method. simulate, steady_state: the faces.
    """

    name: str
    steps: int | None = None
    simulate: Callable[..., xr.Dataset] = simulate
    steady_state: Callable[..., xr.Dataset] = steady_state
    motions: int = 0
    impacts: int = 0
    short_flights: int = 0
    statuses: list[Status] = field(default_factory=list)

    def motion(
        self, p: Exciter, tau_end: float, x0: float = 0.0, v0: float = 0.0, **more: Any
    ) -> xr.Dataset:
        """One motion by this solver, without samples unless they are asked for."""
        asked: dict[str, Any] = {"samples_per_period": 0, **more}
        if self.steps is not None:
            asked |= {"method": "newmark", "steps_per_period": self.steps}
        found = self.simulate(p, tau_end=tau_end, x0=x0, v0=v0, **asked)
        self._count(found)
        return found

    def settled(self, p: Exciter, x0: float = 0.0, v0: float = 0.0) -> xr.Dataset:
        """The steady state from a start."""
        found = self.steady_state(p, x0=x0, v0=v0)
        self._count(found)
        return found

    def begin(self) -> None:
        """Count from zero again."""
        self.motions = self.impacts = self.short_flights = 0
        self.statuses = []

    def _count(self, found: xr.Dataset) -> None:
        self.motions += 1
        self.impacts += int(found.sizes.get("impact", 0))
        status = Status(int(found["status"]))
        self.short_flights += status == Status.SHORT_FLIGHTS
        self.statuses.append(status)


Measure = Callable[[Solver], float]


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
    asked: str
    known: str
    measure: Measure
    bound: Bound


class Measured(NamedTuple):
    """What came of one case by one solver; passed is None where the case is not for it."""

    measured: float
    bound: float
    passed: bool | None
    status: Status
    motions: int
    impacts: int
    short_flights: int


def solvers() -> list[Solver]:
    """The exact method, and Newmark's at steps from coarse to fine."""
    return [Solver("exact"), *(Solver(f"newmark {n}", n) for n in NEWMARK_STEPS)]


def judge(case: Case, solver: Solver) -> Measured:
    """Measure one case by one solver; nan, or an error where none is allowed, does not pass."""
    bound = case.bound.of(solver)
    solver.begin()
    if math.isnan(bound):
        return Measured(math.nan, bound, None, Status.OK, 0, 0, 0)
    try:
        measured = float(case.measure(solver))
    except ParameterError:
        measured = math.inf
    return Measured(
        measured,
        bound,
        measured <= bound,
        max(solver.statuses, default=Status.OK),
        solver.motions,
        solver.impacts,
        solver.short_flights,
    )
