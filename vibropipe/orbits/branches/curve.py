"""Points of a branch of orbits that strike rigid supports, and how such a branch ends."""

from __future__ import annotations

from vibropipe.continuation.curve import Point
from vibropipe.orbits.law import least as of
from vibropipe.orbits.law.curve import LawCurve
from vibropipe.orbits.law.law import Law
from vibropipe.orbits.law.marching import Marcher
from vibropipe.orbits.law.problem import Problem, Scales
from vibropipe.orbits.law.steps import GAP, MARGIN, SPEED

# Index of l, the scale of displacements, among the parameters.
L = 3


class ImpactCurve(LawCurve):
    """The branch of one impact sequence.

    law : of impacts alone
    speed : scale of impact velocities, > 0
    """

    def __init__(self, problem: Problem, law: Law, speed: float) -> None:
        scales = Scales(float(problem.values[L]), speed)
        # An orbit of impacts alone has no rests.
        super().__init__(problem, law, scales, Marcher(problem.effects._replace(rest=None)))

    def with_sequence(self, sequence: Law) -> ImpactCurve:  # noqa: D102 - as LawCurve
        return ImpactCurve(self.problem, sequence, self.speed)

    def end_of(self, test: int, point: Point) -> tuple[str, str]:  # noqa: D102 - as LawZeros
        if test == GAP:
            return ("grazing", "gap") if int(point.tests[MARGIN]) == of.GAP else ("end", "rest")
        return ("end", "chatter") if self.is_pressed(point) else ("grazing", "speed")


def is_no_motion(point: Point) -> bool:
    """Return whether a point is no motion: a flight beyond a support, or an impact away from it."""
    return not (point.tests[GAP] > 0.0 and point.tests[SPEED] > 0.0)
