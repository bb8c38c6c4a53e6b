"""Points of a boundary of orbits with soft supports or friction."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable
from typing import Any

import numpy as np

from vibropipe.continuation.curve import CompiledCurve, Point
from vibropipe.continuation.follower import SAME_POINT
from vibropipe.march.piece_log import (
    AT,
    CAUSE,
    ENTER,
    FORM,
    HELD,
    HOME,
    IMPACT,
    PIECES,
    SPAN,
    W_END,
    Y_END,
    new_piece_log,
)
from vibropipe.orbits.boundaries.curve import TOUCHES, BoundaryCurve, Box, Touch
from vibropipe.orbits.boundaries.pieces.flights import motion_within
from vibropipe.orbits.boundaries.pieces.law import (
    Law,
    contacts_of,
    events_of,
    without_start,
)
from vibropipe.orbits.boundaries.pieces.replay import gap_rate
from vibropipe.orbits.boundaries.pieces.system import Sought, fill_residuals, solve
from vibropipe.orbits.boundaries.system import GRAZINGS, parameters_of_point
from vibropipe.orbits.branches.sequence import Sequence
from vibropipe.orbits.branches.steps import DETERMINANT, GAP, SPEED, TESTS, TRACE
from vibropipe.orbits.branches.symmetry import EQUAL_HALVES
from vibropipe.orbits.law.marching import march_pieces
from vibropipe.physics.contact import to_displacement, to_velocity
from vibropipe.physics.flow import DEGREE

# Speed, as a share of the scale, below which a march only touches a support at a grazing.
TOUCHES_BELOW = 1e-3
# Length of a step within which the end of a boundary is located.
END_LENGTH = 1e-10
# Speed of a contact, weighted, or duration of a stick, in tau, next to which no step may succeed.
SLOW_END = 1e-2
# Weighted difference of the halves of an orbit next to which its equations are nearly those of its half: no step may
# succeed.
NEAR_HALVES = 0.03
# Points of a boundary, next to another in both parameters, from which that other is sought.
NEAREST = 4
# Steps to that other, and the longest one, in those of a boundary.
MAX_STEPS, FAR = 6, 4.0
# Difference of trace and determinant, relative, of points that are one.
SAME_DERIVATIVE = 1e-4


class PieceBoundary(BoundaryCurve):
    """The boundary of one kind of one sequence of events.

    Parameters
    ----------
    box : Box
    kind : int
        A `Bifurcation`.
    law : Law
    touch : Touch
        Of a grazing: the piece, counted from 1, and the support.
    size, speed : float
        Scales of displacement and velocity, > 0.
    effects : Effects
    march_room : tuple
        As for `march_orbit`.
    """

    def __init__(
        self,
        box: Box,
        kind: int,
        law: Law,
        touch: Touch,
        size: float,
        speed: float,
        effects: Any,
        march_room: tuple[Any, ...],
    ) -> None:
        self.box, self.kind, self.touch, self.law = box, kind, touch, law
        self.size, self.effects, self.march_room = size, effects, march_room
        self.sequence, self.speed = Sequence(law.m, law.mirrored, np.zeros(0, np.int8)), speed
        self.is_struck = int(law.codes[1, CAUSE]) in (ENTER, IMPACT)
        touches = kind == GRAZINGS
        self.periodic = [0, 2] if touches else [0]
        weights = [1.0, 1.0 / (speed if self.is_struck else size), *[1.0] * touches]
        ends = 1.0 / (box.high - box.low)
        pieces = new_piece_log(len(law.codes), DEGREE)
        pieces.codes[:] = law.codes
        sought = Sought(
            effects, box.values.reshape(1, -1).copy(), box.along, kind, law.mirrored, touch.flight,
            touch.side, law.span, size, speed, pieces, law.spans.copy(),
        )  # fmt: skip
        CompiledCurve.__init__(
            self, np.array([*weights, *ends]), box.max_length, solve, sought, TESTS
        )
        self.events = events_of(law.codes[1:], law.mirrored)

    def settle(self, u: np.ndarray, fixed: int = -1) -> Point | None:  # noqa: D102 - as Curve
        # Spans of the point last found are close to those sought, unless that was another part of the boundary.
        last = self.sought.guess.copy()
        point = super().settle(u, fixed)
        if point is None and (last != self.law.spans).any():
            self.sought.guess[:] = self.law.spans
            point = super().settle(u, fixed)
        return self._checked(point)

    def advance(self, point: Point, length: float) -> Point | None:  # noqa: D102 - as Curve
        self.sought.guess[:] = point.tests[TESTS:]
        return self._checked(super().advance(point, length))

    def _checked(self, point: Point | None) -> Point | None:
        """Return a point with the spans of its pieces, and with GAP -1 where a march finds other events."""
        if point is None:
            return None
        tests = np.append(point.tests, self.sought.guess)
        events = self.marched_events(point.u)
        if events != self.events:
            tests[GAP] = -1.0
        return Point(point.u, point.tangent, tests)

    def parameters(self, u: np.ndarray) -> Any:
        """Return the `Parameters` at u."""
        return parameters_of_point(self.sought.values, self.box.along, u)

    def flies(self, u: np.ndarray) -> bool:
        """Fly the orbit of some unknowns, its pieces as long as those last flown."""
        return bool(fill_residuals(self.sought, u, self.work.rhs))

    def replayed(self, point: Point) -> bool:
        """Fly the orbit of a point once more; its pieces are then those of `sought`."""
        self.sought.guess[:] = point.tests[TESTS:]
        return self.flies(point.u)

    def state_inside(self, u: np.ndarray) -> tuple[float, float, float]:
        """Return phase, displacement and velocity in the middle of the longest piece of the orbit last flown."""
        pieces = self.sought.pieces
        is_moving = pieces.codes[1:, FORM] != HELD
        i = 1 + int(np.argmax(pieces.values[1:, SPAN] * is_moving))
        p, half = self.parameters(u), 0.5 * float(pieces.values[i, SPAN])
        x, v = motion_within(self.effects, p, pieces, i, half)
        return float(pieces.values[i, AT]) + half * p.nu / (2.0 * np.pi), x, v

    def marched_events(self, u: np.ndarray) -> Counter[Hashable] | None:
        """Return the events that a march of the orbit last flown meets; None if it has rests or fails."""
        turns, x, v = self.state_inside(u)
        p = self.parameters(u)
        if not march_pieces(self.effects, p, turns, x, v, float(self.law.m), self.march_room):
            return None
        slow = TOUCHES_BELOW * self.speed if self.kind == GRAZINGS else 0.0
        codes = without_start(self.march_room[0].pieces, slow, p.friction > 0.0)
        return None if codes is None else events_of(codes)

    def passes(self, points: list[Point], point: Point) -> bool:  # type: ignore[override]
        """Return whether the boundary through some points passes through another, of the same events."""
        scale, tests = self.weights[-2:], [TRACE, DETERMINANT]
        distances = np.abs((np.array([each.u[-2:] for each in points]) - point.u[-2:]) * scale)
        for nearest in np.argsort(distances.max(axis=1))[:NEAREST]:
            here: Point | None = points[nearest]
            for _ in range(MAX_STEPS):
                assert here is not None
                change, along = (point.u[-2:] - here.u[-2:]) * scale, here.tangent[-2:] * scale
                length = float(change @ along) / max(float(along @ along), 1e-300)
                if abs(length) < 0.1 * SAME_POINT:
                    break
                here = (
                    self.advance(here, length) if abs(length) < FAR * self.box.max_length else None
                )
                if here is None:
                    break
            if here is None:
                continue
            distance = np.abs((point.u[-2:] - here.u[-2:]) * scale).max()
            differ = np.abs(here.tests[tests] - point.tests[tests])
            alike = differ <= SAME_DERIVATIVE * (1.0 + np.abs(point.tests[tests]))
            if distance < SAME_POINT and alike.all():
                return True
        return False

    def zero_of(self, point: Point, length: float, test: int) -> tuple[float, Point] | None:
        """Return where in a step a test function is zero; of GAP the last motion before."""
        if test != GAP:
            return super().zero_of(point, length, test)
        low, high, last = 0.0, length, point
        while high - low > END_LENGTH:
            middle = 0.5 * (low + high)
            trial = self.advance(point, middle)
            if trial is None:
                return None
            if trial.tests[GAP] > 0.0:
                low, last = middle, trial
            else:
                high = middle
        return low, last

    def near_end(self, point: Point) -> str:  # noqa: D102 - as BoundaryCurve
        if point.tests[SPEED] < SLOW_END:
            return TOUCHES[self.kind]
        is_held = self.law.codes[1:, FORM] == HELD
        spans = point.tests[TESTS + 1 :][is_held]
        if (spans < SLOW_END).any():
            return "change"
        half = self._halves(point, NEAR_HALVES)
        return f"degenerate_{half}" if half else ""

    def meeting_of(self, test: int, point: Point, beyond: Point) -> str:  # noqa: D102 - as BoundaryCurve
        if test == GAP and self.replayed(beyond):
            events = self.marched_events(beyond.u)
            if events is None:
                return "rest"
            if contacts_of(events) == self.contacts():
                return "change"
        return TOUCHES[self.kind]

    def halves_at(self, point: Point) -> str:  # noqa: D102 - as BoundaryCurve
        return self._halves(point, EQUAL_HALVES)

    def _halves(self, point: Point, tolerance: float) -> str:
        """Return how both halves of an orbit agree within a tolerance."""
        if self.law.mirrored or not (self.law.m % 2 == 0 or self.box.symmetric):
            return ""
        self.replayed(point)
        turns, x, v = self.state_inside(point.u)
        p, half = self.parameters(point.u), 0.5 * self.law.m
        if not march_pieces(self.effects, p, turns, x, v, half, self.march_room):
            return ""
        pieces, sign = self.march_room[0].pieces, 1.0 if self.law.m % 2 == 0 else -1.0
        last = int(pieces.counts[PIECES]) - 1
        home = int(pieces.codes[last, HOME])
        later = to_displacement(p, home, float(pieces.values[last, Y_END]))
        faster = to_velocity(home, float(pieces.values[last, W_END]))
        change = max(abs(sign * later - x) / self.size, abs(sign * faster - v) / self.speed)
        if change > tolerance:
            return ""
        return "flip" if sign > 0.0 else "pitchfork"

    def contacts(self) -> tuple[int, int]:
        """Return the number of contacts of the orbit with each support."""
        return contacts_of(self.events)

    def fastest(self) -> np.ndarray:
        """Return the largest speed at which the orbit last flown arrives at each support; 0 where it does not."""
        pieces, fastest = self.sought.pieces, np.zeros(2)
        for i in range(1, len(pieces.codes)):
            if pieces.codes[i, CAUSE] in (ENTER, IMPACT):
                home = int(pieces.codes[i, HOME])
                before = int(pieces.codes[i - 1, HOME])
                speed = -gap_rate(before, float(pieces.values[i - 1, W_END]), home)
                for support in {home, 3 - home if self.law.mirrored else home}:
                    fastest[support - 1] = max(fastest[support - 1], speed)
        return fastest

    def strobe(self, point: Point) -> tuple[float, float]:
        """Return (x, x') at the phase 0 of the force."""
        self.replayed(point)
        pieces, p = self.sought.pieces, self.parameters(point.u)
        shifts = [(0.0, 1.0)] + ([(-self.law.span, -1.0)] if self.law.mirrored else [])
        turns = 2.0 * np.pi / p.nu
        for i in range(1, len(pieces.codes)):
            begin, span = float(pieces.values[i, AT]), float(pieces.values[i, SPAN])
            for shift, sign in shifts:
                at = np.ceil(begin - shift) + shift
                if begin <= at <= begin + span / turns:
                    x, v = motion_within(self.effects, p, pieces, i, (at - begin) * turns)
                    return sign * x, sign * v
        return np.nan, np.nan
