"""Where boundaries are sought, of which kinds, and following one: what meets it on the way, and where it ends."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibropipe.continuation.curve import Point, Zero
from vibropipe.continuation.follower import Follower
from vibropipe.continuation.path import Event, Mark, Path, Step, Wanted
from vibropipe.orbits.law.problem import Problem
from vibropipe.orbits.law.steps import DOUBLING, GAP, SPEED, UNIT
from vibropipe.orbits.law.tied import Tied
from vibropipe.physics.effects import ALL_EFFECTS, Effects
from vibropipe.physics.exciter import Parameters

if TYPE_CHECKING:
    from vibropipe.orbits.boundaries.law_curve import LawBoundary

# Kinds of boundaries, as `Bifurcation` numbers them, and curves on which a quantity has a value.
FOLDS, FLIPS, PITCHFORKS, GRAZINGS, LEVELS = range(5)
KINDS = {"fold": FOLDS, "flip": FLIPS, "pitchfork": PITCHFORKS, "grazing": GRAZINGS}
# Two impacts may begin at once: the equations are singular there. A boundary whose steps are as short as this, and that
# is `near_end`, has reached such a point.
SHORT_LENGTH = 1e-6
# Meetings with a support, by the kind of boundary.
TOUCHES = ("grazing_fold", "grazing_flip", "grazing_pitchfork", "double_grazing", "grazing")


class Box(NamedTuple):
    """Where boundaries are sought.

    values : (parameters,), parameters of the exciter, and the names of one's own that vary
    along : (2,) int, indices of the parameters that vary
    low, high : (2,), their ranges
    symmetric : whether the exciter is its own mirror image in the whole box
    max_length : largest weighted length of a step
    effects : of all exciters of the box
    tied : what follows both
    """

    values: np.ndarray
    along: np.ndarray
    low: np.ndarray
    high: np.ndarray
    symmetric: bool
    max_length: float
    effects: Effects = ALL_EFFECTS
    tied: Tied | None = None

    @property
    def names(self) -> tuple[str, str]:
        """Names of what varies."""
        names = Parameters._fields if self.tied is None else self.tied.names
        first, second = (names[index] for index in self.along)
        return first, second

    def problem(self, values: np.ndarray, index: int, at: tuple[float, ...]) -> Problem:
        """Return what is followed along one of both, from values at which the other is held."""
        tied = self.tied
        if tied is not None:
            along, other = self.names[index], self.names[1 - index]
            held = () if other in Parameters._fields else (other,)
            tied = Tied(tied.ties, (along,), held)
        return Problem(
            values, int(self.along[index]), self.low[index], self.high[index], at, self.symmetric,
            self.max_length, self.effects, tied=tied,
        )  # fmt: skip


class BoundaryFollower(Follower):
    """Follows a boundary of one kind of orbits of one law."""

    curve: LawBoundary
    ends = (SPEED, GAP)
    hinted = (GAP, SPEED)
    jumps = True  # the return map's derivative is infinite where an impact loses its speed
    max_points = 5_000
    crawl_length = 1e-5

    def __init__(self, curve: LawBoundary, start: Point) -> None:
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
        name = self.curve.meeting_of(test, zero[1])
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
