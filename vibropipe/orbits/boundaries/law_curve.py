"""Boundaries of orbits by their laws: the equations of a law, and the condition that makes its orbit a bifurcation.

The condition of a fold, a flip or a pitchfork is that a determinant of the return map is zero; that of a grazing, that
the least gap of a flight is, or that an orbit turns on a support against friction.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from vibropipe.continuation.curve import Curve as Continued
from vibropipe.continuation.curve import Point
from vibropipe.march.piece_log import CAUSE, ENTER, HOME, IMPACT, REST_BEGINS, STICK, TURN
from vibropipe.orbits.boundaries.curve import FOLDS, GRAZINGS, TOUCHES, Box
from vibropipe.orbits.boundaries.touches import touch_beside
from vibropipe.orbits.branches.symmetry import halves_agree
from vibropipe.orbits.law import least as of
from vibropipe.orbits.law.curve import LawZeros
from vibropipe.orbits.law.determinants import condition, fill_slopes
from vibropipe.orbits.law.equations import new_blocks
from vibropipe.orbits.law.flights import gap_of_piece, gap_slopes
from vibropipe.orbits.law.law import Law
from vibropipe.orbits.law.marching import Marcher
from vibropipe.orbits.law.problem import Scales
from vibropipe.orbits.law.steps import DETERMINANT, GAP, MARGIN, N_TESTS, SPEED, TRACE

# Number of a point beside its tests: the time at which its orbit touches a support.
TOUCHED = N_TESTS
# Weighted step of the central differences of a condition. It affects the speed of convergence alone.
DIFFERENCE = 1e-6
# Gap, weighted, of a support that an orbit without contacts touches with the other.
AT_ONCE = 1e-12
# Weighted difference of the halves of an orbit next to which its equations are nearly those of its half.
NEAR_HALVES = 0.03
# Margin, weighted, next to which an orbit may meet two ends at once, where no step succeeds.
NEAR_END = 1e-3
# Condition, of scale 1, at unknowns that lie on a boundary.
ON_BOUNDARY = 1e-6
# Pieces of a flight, parted by events of a housing, on which a touch is sought.
MAX_MOVES = 3
# Steps between known points and another of the same parameters, and the longest, in those of a boundary.
MAX_STEPS, FAR, NEAREST = 6, 4.0, 4
# Weighted distance of parameters, and relative difference of trace and determinant, of points that are one.
SAME_PLACE, SAME_DERIVATIVE = 1e-6, 1e-4


class LawBoundary(LawZeros):
    """The boundary of one kind of orbits of one law.

    kind : a `Bifurcation`
    touch : (piece, support, time), of a grazing; the piece is the event of the turn where the orbit turns on the
        support. `curve.NO_TOUCH` else
    scales, marcher : as for `LawZeros`
    """

    def __init__(
        self,
        box: Box,
        kind: int,
        law: Law,
        touch: tuple[float, float, float],
        scales: Scales,
        marcher: Marcher,
    ) -> None:
        super().__init__(
            law, scales, marcher, box.values, box.along, box.low, box.high, box.max_length, box.tied
        )
        self.box, self.kind, self.touched = box, kind, touch
        self._slope: np.ndarray | None = None
        self._no_columns = new_blocks(len(law.codes), 0, marcher.effects.housing)
        kinds = law.codes[:, CAUSE]
        self.wrap = 1.0 if kind == FOLDS else -1.0
        self.impacts, self.slow = np.flatnonzero(kinds == IMPACT), -1
        self.is_turn = kind == GRAZINGS and kinds[int(touch[0])] in (TURN, STICK)
        # An orbit without contacts touches the nearer support, or both at once.
        grazes_alone = kind == GRAZINGS and not law.has_contacts
        self.touch = (of.ANY, 0.0, AT_ONCE * self.size) if grazes_alone else touch

    def with_sequence(self, sequence: Any) -> LawBoundary:  # noqa: D102 - as Curve
        return LawBoundary(self.box, self.kind, sequence, self.touched, self.scales, self.marcher)

    zero_of = Continued.zero_of

    def advance(self, point: Point, length: float) -> Point | None:  # noqa: D102 - as Curve
        self.touched = *self.touched[:2], float(point.tests[TOUCHED])
        return super().advance(point, length)

    def finished(self, u: np.ndarray) -> Point | None:  # noqa: D102 - as Curve
        point = super().finished(u)
        if point is None:
            return None
        return point._replace(tests=np.append(point.tests, self.touched[2]))

    def conditions(self, u: np.ndarray) -> list[tuple[float, np.ndarray]]:  # noqa: D102 - as LawZeros
        value = self._condition(u)
        if self._slope is None:
            self._slope = self._slopes(u)
        return [(value, self._slope)]

    def _slopes(self, u: np.ndarray) -> np.ndarray:
        """Return the derivatives of the condition, as central differences."""
        last, system, effects = self.width * len(self.sequence.codes), self.system, self.effects
        self.set_ends(u[last:])
        moving = system.values[0, system.along]
        all_u, steps = np.append(u[:last], moving), DIFFERENCE / self.weights
        if self.tied is not None:
            steps = np.append(steps, DIFFERENCE * np.maximum(1.0, np.abs(moving[self.n_free :])))
        if self.kind == GRAZINGS:
            piece, side, time = self.touched
            slope = gap_slopes(
                effects, system.values, system.along, self.sequence, all_u,
                int(piece), int(side), time, self.is_turn, steps,
            )  # fmt: skip
            slope /= self.size
        else:
            slope = np.zeros(all_u.size)
            self.marcher.rows += 2 * all_u.size * len(self.sequence.codes)
            fill_slopes(
                effects, system.values, system.along, self.sequence, all_u,
                self._no_columns, steps, self.wrap, self.slow, slope,
            )  # fmt: skip
        self.set_ends(u[last:])
        return self.through_ties(slope)

    def step(self, u: np.ndarray, target: float) -> np.ndarray | None:  # noqa: D102 - as Curve
        # The derivative of the last correction serves the tangent.
        self._slope = None
        return super().step(u, target)

    def _condition(self, u: np.ndarray) -> float:
        """Return what is zero at a bifurcation, at u, whose blocks are filled."""
        if self.kind == GRAZINGS:
            return self._gap(u) / self.size
        blocks, housing = self.system.blocks, self.effects.housing
        if len(self.impacts):
            sizes = np.abs(np.linalg.det(blocks.at[self.impacts]))
            self.slow = int(self.impacts[sizes.argmin()])
        return float(condition(blocks, self.wrap, self.slow, housing))

    def _gap(self, u: np.ndarray) -> float:
        """Return the least gap of the flight that touches a support, and note when it is there."""
        p, law, events = self.parameters_of(u), self.sequence, self.events_of(u)
        gap, is_own = math.nan, self.touch[0] == self.touched[0]
        for _ in range(MAX_MOVES):
            piece, side, time = int(self.touched[0]), int(self.touched[1]), self.touched[2]
            gap, time = gap_of_piece(self.effects, p, law, piece, events, side, time, self.is_turn)
            self.touched = piece, side, time
            beside = None if self.is_turn else touch_beside(law, events, piece, side, time)
            if beside is None:
                break
            self.touched = beside
        if is_own:
            self.touch = self.touched
        return gap

    def slope_at(self, u: np.ndarray) -> float:
        """Return the derivative of the first parameter by the second along the boundary, at unknowns on it, or NaN."""
        self._slope = None
        if not self._fill(u):
            return math.nan
        ((value, slope),) = self.conditions(u)
        if not abs(value) < ON_BOUNDARY:
            return math.nan
        rows = np.array([np.eye(u.size)[-1], slope])
        change, sign = self._solve(np.zeros_like(self.system.blocks.rest), rows, np.eye(2)[0])
        return float(change[-2]) if sign != 0.0 else math.nan

    def meeting_of(self, test: int, point: Point) -> str:
        """Return what a boundary meets where a margin is zero: a further touch of a support, or another change."""
        if test != SPEED:
            if int(point.tests[MARGIN]) == of.GAP:
                return TOUCHES[self.kind]
            return "change" if self.effects.has_pieces else "rest"
        if self.effects.has_pieces:
            return TOUCHES[self.kind]
        return "chatter" if self.is_pressed(point) else TOUCHES[self.kind]

    def near_end(self, point: Point) -> str:
        """Return what a boundary meets next to a point from which no step succeeds, or ""."""
        if point.tests[SPEED] < NEAR_END:
            return TOUCHES[self.kind]
        if point.tests[GAP] < NEAR_END and self.touch[0] != of.ANY:
            return self.meeting_of(GAP, point)
        symmetric = self.box.symmetric
        half = halves_agree(self.sequence, point.u, self.weights, symmetric, NEAR_HALVES)
        return f"degenerate_{half}" if half else ""

    def halves_at(self, point: Point) -> str:
        """Return how both halves of an orbit agree: as `halves_agree`."""
        return halves_agree(self.sequence, point.u, self.weights, self.box.symmetric)

    def passes(self, points: list[Point], point: Point) -> bool:
        """Return whether the boundary through some points passes through another, of the same events."""
        scale, tests = self.weights[-2:], [TRACE, DETERMINANT]
        distances = np.abs((np.array([each.u[-2:] for each in points]) - point.u[-2:]) * scale)
        for nearest in np.argsort(distances.max(axis=1))[:NEAREST]:
            here: Point | None = points[nearest]
            for _ in range(MAX_STEPS):
                assert here is not None
                change, along = (point.u[-2:] - here.u[-2:]) * scale, here.tangent[-2:] * scale
                length = float(change @ along) / max(float(along @ along), 1e-300)
                if abs(length) < 0.1 * SAME_PLACE:
                    break
                is_near = abs(length) < FAR * self.max_length
                here = self.advance(here, length) if is_near else None
                if here is None:
                    break
            if here is None:
                continue
            distance = np.abs((point.u[-2:] - here.u[-2:]) * scale).max()
            differ = np.abs(here.tests[tests] - point.tests[tests])
            alike = differ <= SAME_DERIVATIVE * (1.0 + np.abs(point.tests[tests]))
            if distance < SAME_PLACE and alike.all():
                return True
        return False

    def contacts(self) -> tuple[int, int]:
        """Return the number of contacts of the orbit with each support."""
        codes = self.sequence.codes
        homes = codes[np.isin(codes[:, CAUSE], (ENTER, IMPACT, REST_BEGINS)), HOME]
        first, second = int((homes == 1).sum()), int((homes == 2).sum())
        if self.sequence.mirrored:
            return first + second, first + second
        return first, second

    def fastest(self, point: Point) -> np.ndarray:
        """Return the largest speed at which an orbit arrives at each support; 0 where it does not."""
        codes, n, fastest = self.sequence.codes, len(self.sequence.codes), np.zeros(2)
        for i in np.flatnonzero(np.isin(codes[:, CAUSE], (ENTER, IMPACT, REST_BEGINS))):
            home, speed = int(codes[i, HOME]), abs(float(point.u[n + i]))
            for support in {home, 3 - home if self.sequence.mirrored else home}:
                fastest[support - 1] = max(fastest[support - 1], speed)
        return fastest
