"""Measure of motions without known numbers: deviation of flights, or violated invariants."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from vibropipe.lab.hard_cases.analytic import flight_error, violations
from vibropipe.lab.hard_cases.case import Solver, largest_error
from vibropipe.physics.exciter import Exciter


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
