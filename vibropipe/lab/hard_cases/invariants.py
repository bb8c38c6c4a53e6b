"""What a motion is held to where its numbers are not known in advance."""

from __future__ import annotations

import math

from vibropipe.lab.hard_cases.analytic import breaches, flight_error
from vibropipe.lab.hard_cases.case import Solver
from vibropipe.physics.exciter import Exciter

# what a measure gives where something happens that must not, or does not that must
WRONG = math.inf
FLIGHTS = (
    "exact: each flight is the closed form from impact to impact; newmark: inside, reset by eq. (6)"
)


def flights_or_breaches(
    solver: Solver, p: Exciter, tau_end: float, x0: float = 0.0, v0: float = 0.0
) -> float:
    """Error of all flights of a motion by the exact method; breaches of what Newmark's method must keep."""
    if solver.steps is None:
        return flight_error(p, solver.motion(p, tau_end, x0, v0), tau_end, x0, v0)
    return breaches(p, solver.motion(p, tau_end, x0, v0, samples_per_period=32))
