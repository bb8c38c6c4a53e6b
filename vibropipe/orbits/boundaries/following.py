"""Following a boundary: what meets it on the way, and where it ends."""

from __future__ import annotations

from vibropipe.continuation.curve import Point, Zero
from vibropipe.continuation.follower import Follower
from vibropipe.continuation.path import Event, Mark, Path, Step, Wanted
from vibropipe.orbits.boundaries.curve import BoundaryCurve
from vibropipe.orbits.boundaries.system import GRAZINGS
from vibropipe.orbits.law.steps import DOUBLING, GAP, SPEED, UNIT

# Two impacts may begin at once: the equations are singular there. A boundary whose steps are as short as this, and that
# is `near_end`, has reached such a point.
SHORT_LENGTH = 1e-6


class BoundaryFollower(Follower):
    """Follows a boundary of one kind of one impact sequence."""

    curve: BoundaryCurve
    ends = (SPEED, GAP)
    hinted = (GAP, SPEED)
    max_points = 5_000
    crawl_length = 1e-5

    def __init__(self, curve: BoundaryCurve, start: Point) -> None:
        super().__init__(curve, start)
        self.turns = (UNIT, DOUBLING) if curve.kind == GRAZINGS else ()
        self.wanted = [
            Wanted(index - 2, float(limit[index]), "box", side)
            for index in (0, 1)
            for limit, side in ((curve.box.low, -1.0), (curve.box.high, 1.0))
        ]

    def name_of(self, test: int, step: Step, zero: Zero) -> tuple[str, str]:  # noqa: D102 - as Follower
        if test == UNIT:
            return "grazing_fold", ""
        if test == DOUBLING:
            return "grazing_pitchfork" if self.curve.sequence.mirrored else "grazing_flip", ""
        name = self.curve.meeting_of(test, zero[1], step.new)
        return name, name

    def marks_of_its_own(self, step: Step) -> list[Mark]:  # noqa: D102 - as Follower
        zero = None if self.curve.kind == GRAZINGS else self.curve.cusp_of(*step)
        if zero is None:
            return []
        # At a degenerate bifurcation doubled orbits shrink to their parent, and go back with their halves exchanged.
        half = self.curve.halves_at(zero[1])
        name = f"degenerate_{half}" if half else "cusp"
        return [Mark(*zero, name, name if half else "")]

    def why_stuck(self, point: Point, length: float) -> str:  # noqa: D102 - as Follower
        name = self.curve.near_end(point) if length < SHORT_LENGTH else ""
        return name or super().why_stuck(point, length)

    def why_crawling(self, point: Point) -> str:  # noqa: D102 - as Follower
        return self.curve.near_end(point) or "lost"


def followed(follower: BoundaryFollower) -> Path:
    """Follow a boundary from a point along its tangent until it leaves the box or the orbit ceases to be a motion."""
    path = follower.follow()
    if path.end != "closed" and not (path.events and path.events[-1].reason):
        path.events.append(Event(path.end, path.end, len(path.points) - 1))
    return path
