"""What a motion is held to where its numbers are not known in advance."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from vibropipe.lab.hard_cases.analytic import flight_error, violations
from vibropipe.lab.hard_cases.case import Solver, largest
from vibropipe.physics.exciter import Exciter


def flights_or_violations(
    solver: Solver, exciter: Exciter, tau_end: float, x0: float = 0.0, v0: float = 0.0
) -> float:
    """Error of all flights of a motion by the exact method; breaches of what Newmark's method must keep."""
    if solver.steps is None:
        return flight_error(exciter, solver.motion(exciter, tau_end, x0, v0), tau_end, x0, v0)
    return violations(exciter, solver.motion(exciter, tau_end, x0, v0, samples_per_period=32))


@largest
def flight_check(
    solver: Solver, tasks: Sequence[tuple[Exciter, float, float, float]]
) -> Iterator[float]:
    """Flights (exact) or breaches (newmark) of motions given by exciter, tau_end, x0, v0."""
    for task in tasks:
        yield flights_or_violations(solver, *task)
