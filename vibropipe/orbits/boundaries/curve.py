"""A boundary of one impact sequence: its points, the orbits on it, what meets it on the way, and where it ends."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from vibropipe.continuation.curve import CompiledCurve, Point, Zero
from vibropipe.continuation.follower import SAME_POINT, Follower
from vibropipe.continuation.path import Event, Mark, Path, Step, Wanted
from vibropipe.orbits.boundaries.system import (
    GRAZINGS,
    Sought,
    new_room,
    parameters_of_point,
    solve,
)
from vibropipe.orbits.branches.sequence import Sequence
from vibropipe.orbits.branches.symmetry import halves_agree
from vibropipe.orbits.law.problem import Problem
from vibropipe.orbits.law.steps import DOUBLING, GAP, GAP_SIDE, SLOWEST, SPEED, TESTS, UNIT
from vibropipe.orbits.law.tied import Tied
from vibropipe.physics.contact import support_position
from vibropipe.physics.effects import ALL_EFFECTS, Effects
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.forced_flow import acceleration

# Gap or impact speed next to which an orbit may touch twice at once, where the equations are singular.
NEAR_END = 1e-4
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


def weights_of(sequence: Sequence, speed: float, further: Iterable[float]) -> np.ndarray:
    """Return the weights of times, velocities of a scale `speed`, and further unknowns."""
    n = len(sequence.supports)
    return np.concatenate([np.ones(n), np.full(n, 1.0 / speed), [*further]])


class Touch(NamedTuple):
    """A flight that touches a support: its index and the support; (0, 0) where none does."""

    flight: int
    side: int


NO_TOUCH = Touch(0, 0)


class BoundaryCurve(CompiledCurve):
    """The boundary of one kind of one impact sequence, on which points are found by continuation.

    kind : a `Bifurcation`
    sequence : without impacts, the linear motion
    touch : of a grazing
    speed : scale of impact velocities, > 0
    """

    def __init__(self, box: Box, kind: int, sequence: Sequence, touch: Touch, speed: float) -> None:
        self.box, self.kind, self.touch = box, kind, touch
        self.sequence: Any = sequence
        self.speed = speed
        n, touches = len(sequence.supports), [1.0] * (kind == GRAZINGS)
        self.periodic = [*range(n), *([2 * n] if touches else [])]
        sought = Sought(
            box.values.reshape(1, -1).copy(), box.along, kind, sequence.span, sequence.mirrored,
            sequence.supports, *touch, new_room(),
        )  # fmt: skip
        weights = weights_of(sequence, speed, [*touches, *(1.0 / (box.high - box.low))])
        super().__init__(weights, box.max_length, solve, sought, TESTS)

    def passes(self, points: list[Point], u: np.ndarray) -> bool:
        """Return whether the boundary through some points in order passes through u."""
        change = np.array([each.u for each in points]) - u
        timed = [*self.periodic]
        if timed:
            change[:, timed] -= np.round(change[:, timed[:1]])
        nearest = int(np.abs(change * self.weights).max(axis=1).argmin())
        for k in range(max(0, nearest - 1), min(len(points), nearest + 2)):
            there = self.shifted(u, points[k].u)
            if self.weighted(there - points[k].u) > 4.0 * self.box.max_length:
                continue
            reached = self.advance(points[k], self.along_tangent(points[k], there))
            if reached is not None and self.weighted(reached.u - there) < SAME_POINT:
                return True
        return False

    def near_end(self, point: Point) -> str:
        """Return what a boundary meets next to a point from which no step succeeds, or ""."""
        return TOUCHES[self.kind] if min(point.tests[GAP], point.tests[SPEED]) < NEAR_END else ""

    def meeting_of(self, test: int, point: Point, beyond: Point) -> str:
        """Return what a boundary meets where its orbit touches a support, or an impact loses its speed."""
        n = len(self.sequence.supports)
        if test == GAP:
            if beyond.tests[GAP_SIDE] == 0 and n > 0:
                return "rest"
        else:
            i = int(point.tests[SLOWEST])
            support = int(self.sequence.supports[i])
            p = parameters_of_point(self.box.values.reshape(1, -1).copy(), self.box.along, point.u)
            pull = acceleration(p, support_position(p, support), point.u[n + i], point.u[i])
            if (pull > 0.0) == (support == 1):
                return "chatter"
        return TOUCHES[self.kind]

    def halves_at(self, point: Point) -> str:
        """Return how both halves of an orbit agree: as `halves_agree`."""
        return halves_agree(self.sequence, point.u, self.weights)


class Form(NamedTuple):
    """One way to write an orbit: another first impact, or its mirror image."""

    supports: np.ndarray
    touch: Touch
    u: np.ndarray


def forms(curve: BoundaryCurve, u: np.ndarray) -> Iterator[Form]:
    """Yield all ways to write the orbit u of a boundary; of a symmetric exciter also its mirror image."""
    sequence, touch, n = curve.sequence, curve.touch, len(curve.sequence.supports)
    touches = curve.kind == GRAZINGS
    sign = -1.0 if sequence.mirrored else 1.0
    for first in range(max(n, 1)):
        moved, supports, flight, side = u.copy(), sequence.supports.copy(), touch.flight, touch.side
        if first:
            moved[:n] = np.concatenate([u[first:n], u[:first] + sequence.span])
            moved[n : 2 * n] = np.concatenate([u[n + first : 2 * n], sign * u[n : n + first]])
            later = sequence.supports[:first]
            supports = np.concatenate(
                [sequence.supports[first:], 3 - later if sequence.mirrored else later]
            ).astype(np.int8)
            if touches:
                flight -= first
                if flight < 0:
                    flight += n
                    moved[2 * n] += sequence.span
                    side = 3 - side if sequence.mirrored else side
        yield Form(supports, Touch(flight, side), moved)
        if curve.box.symmetric:
            image = moved.copy()
            image[:n] += 0.5
            image[n : 2 * n] *= -1.0
            if touches:
                image[2 * n] += 0.5
            yield Form(
                (3 - supports).astype(np.int8), Touch(flight, 3 - side if touches else 0), image
            )


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
