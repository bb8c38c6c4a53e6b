"""Points of a branch of orbits by linear pieces: zeros of the return map less its start, in (x, x', parameter).

The map is smooth while the same events begin its pieces, and continuous where they change; only an impact on a rigid
support begins with an infinite derivative. Newton's method takes the derivative of the pieces that it finds.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibropipe.continuation.curve import CROSSING, FOLD
from vibropipe.continuation.newton import CONVERGED, MAX_CHANGE, MAX_CORRECTIONS, STALLED
from vibropipe.orbits.branches.curve import Curve, Point, Problem
from vibropipe.orbits.branches.pieces.return_map import (
    BEST,
    BEST_MARGIN,
    BY_PARAMETER,
    BY_SECTION,
    LAW,
    MARGIN,
    N_RESULTS,
    V,
    X,
    differentiate,
    fixed_point_jacobian,
    returned,
)
from vibropipe.orbits.branches.sequence import Sequence, parameters_at
from vibropipe.orbits.branches.steps import (
    DETERMINANT,
    DOUBLING,
    GAP,
    GAP_FLIGHT,
    GAP_SIDE,
    GAP_TIME,
    SPEED,
    TESTS,
    TRACE,
    UNIT,
)
from vibropipe.orbits.sensitivity.errors import SAMPLES, ULP
from vibropipe.orbits.sensitivity.pieces.columns import SAMPLE, PieceVariations
from vibropipe.physics.derivatives import ALL_DIFFERENTIATED
from vibropipe.physics.effects import Effects
from vibropipe.physics.exciter import Parameters

# Numbers of a point, in place of where the flights of an impact sequence turn: `return_map.LAW`, and the phase of the
# section in turns, and of the one that it should be moved to.
PIECES, SECTION, BETTER = GAP_FLIGHT, GAP_TIME, GAP_SIDE
UNKNOWNS = 3
# Distance of the section from the next event, in forcing periods, below which it is moved to where it is larger by a
# factor: the section of an orbit bends, or jumps, where an event passes it.
MIN_MARGIN, GAIN = 0.02, 2.0
# Sections are at multiples of this share of a period, which numbers have exactly.
SECTIONS = 64
# Length of a step that gives the tangent at another section.
TANGENT_LENGTH = 1e-7
# Largest residual of a point, in parts of what rounding explains: that of its section and of all pieces, carried to
# the end of the orbit. Of orbits it is up to 11; where Newton's method alternates next to a grazing, 100 to 1e7.
MAX_RESIDUAL = 32.0
# Largest number of corrections of an orbit at another section, and largest share of its equations that is left out in
# them: at a fold they are singular.
MAX_CLOSINGS, SINGULAR = 4, 1e-6
# Derivative of the return map beyond which a point must also be found at phase 0, where its outputs begin.
STEEP_MAP = 1e3
# Friction at which the equations of a smaller one, 0 included, are taken. Marches without friction know no turns: what
# begins the pieces would change where friction ends, and the end of the branch be no place on it. No sum rounds it in.
MIN_FRICTION = 1e-100


class PieceCurve(Curve):
    """The branch of orbits of m periods of an exciter with soft supports or friction.

    Parameters
    ----------
    problem : Problem
    m : int
        Period multiple.
    size, speed : float
        Scales of displacement and velocity, > 0.
    effects : Effects
    march_room : tuple
        As for `march_orbit`.
    room : PieceVariations
    """

    def __init__(
        self,
        problem: Problem,
        m: int,
        size: float,
        speed: float,
        effects: Effects,
        march_room: tuple[Any, ...],
        room: PieceVariations,
    ) -> None:
        self.problem, self.sequence = problem, Sequence(m, 0, np.zeros(0, np.int8))
        self.size, self.speed, self.effects = size, speed, effects
        self.march_room, self.room = march_room, room
        self.weights = np.array([1.0 / size, 1.0 / speed, 1.0 / (problem.high - problem.low)])
        self.squares = self.weights**2
        self.values = problem.values.reshape(1, -1).copy()
        name = Parameters._fields[problem.along]
        self.column = ALL_DIFFERENTIATED.index(name)
        self.least = MIN_FRICTION if name == "friction" else -math.inf
        self.section, self.result = 0.0, np.empty(N_RESULTS)

    def of_multiple(self, m: int) -> PieceCurve:
        """Return the branch of orbits of another period multiple."""
        shared = self.effects, self.march_room, self.room
        other = PieceCurve(self.problem, m, self.size, self.speed, *shared)
        other.section = self.section
        return other

    def settle(self, u: NDArray, fixed: int = -1) -> Point | None:
        """Return the point near u, at the section last used, with the unknown `fixed` held; None if there is none."""
        u, border = np.array(u, float), np.zeros(UNKNOWNS)
        border[fixed] = 1.0
        held = u[fixed]
        matrix = self._correct(u, border, held)
        if matrix is None:
            return None
        u[fixed] = held
        return self._point(u, matrix)

    def advance(self, point: Point, length: float) -> Point | None:  # noqa: D102 - as Curve
        self.section = float(point.tests[SECTION])
        u, border = point.u + length * point.tangent, point.tangent * self.squares
        matrix = self._correct(u, border, float(border @ u))
        return None if matrix is None else self._point(u, matrix)

    def distance(self, first: Point, second: Point) -> float:  # noqa: D102 - as Curve
        state = self.state_at(second, float(first.tests[SECTION]))
        return float(np.abs((first.u - np.append(state, second.value)) * self.weights).max())

    def differentiate(self, u: NDArray) -> NDArray | None:
        """Return the return map and its derivatives at u, as `return_map.differentiate` finds them; None if not."""
        problem, value, result = self.problem, float(u[-1]), self.result
        reach = problem.high - problem.low
        # Far beyond the range parameters may have no motion, as negative frequencies.
        is_in_reach = problem.low - reach < value < problem.high + reach
        if not (is_in_reach and np.isfinite(u).all()):
            return None
        begin = np.array([u[0], u[1], max(value, self.least)])
        is_smooth = differentiate(
            self.effects, self.values, problem.along, self.column, begin, self.sequence.m,
            self.section, self.march_room, self.room, result,
        )  # fmt: skip
        if not is_smooth or not np.isfinite(result).all():
            return None
        if value < self.least:
            # Steps and Newton's method pass the end of a branch: beyond it the equations go on along their slope.
            result[X], result[V] = result[[X, V]] + (value - self.least) * result[BY_PARAMETER]
        return result

    def tangent_at(self, u: NDArray) -> NDArray | None:
        """Return the unit tangent, up the parameter, of the zeros of the equations at u; None if there is none."""
        result = self.differentiate(u)
        if result is None:
            return None
        equations = fixed_point_jacobian(result)
        try:
            tangent = np.append(np.linalg.solve(equations, -result[BY_PARAMETER]), 1.0)
        except np.linalg.LinAlgError:
            return None
        return tangent / np.linalg.norm(tangent * self.weights)

    def state_at(self, point: Point, section: float) -> NDArray:
        """Return (x, x') of an orbit at another section, marched on from its own."""
        x, v, value = point.u.tolist()
        begin = float(point.tests[SECTION])
        turns = (section - begin) % self.sequence.m
        if turns == 0.0:
            return point.u[:2].copy()
        p = parameters_at(self.values, self.problem.along, value)
        x, v, _is_marched = returned(self.effects, p, begin, x, v, turns, self.march_room)
        return np.array([x, v])

    def state_at_start(self, point: Point) -> NDArray | None:
        """Return (x, x') of an orbit at phase 0, corrected where the way there has lost digits; None if there is none.

        A motion that all but grazes a support needs these digits a phase later: it would not return.
        """
        begin, own = np.append(self.state_at(point, 0.0), point.value), self.section
        if point.tests[SECTION] == 0.0:
            return begin[:2]
        self.section, is_closed = 0.0, False
        for _ in range(MAX_CLOSINGS):
            result = self.differentiate(begin)
            is_closed = result is not None and self._closes(begin, result)
            if result is None or is_closed:
                break
            equations = fixed_point_jacobian(result)
            residual = result[[X, V]] - begin[:2]
            begin[:2] -= np.linalg.lstsq(equations, residual, rcond=SINGULAR)[0]
        self.section = own
        return begin[:2] if is_closed else None

    def halves_difference(self, point: Point) -> float:
        """Return the weighted difference of an orbit from itself, or its mirror image, half an orbit later."""
        begin = float(point.tests[SECTION])
        later = self.state_at(point, begin + 0.5 * self.sequence.m)
        if self.halves == "pitchfork":
            later = -later
        return float(np.abs((later - point.u[:2]) * self.weights[:2]).max())

    @property
    def halves(self) -> str:
        """How the halves of an orbit could agree: "flip", "pitchfork", or "" where they cannot."""
        if self.sequence.m % 2 == 0:
            return "flip"
        return "pitchfork" if self.problem.symmetric else ""

    def better_section(self) -> float:
        """Return the section that the orbit just differentiated should have: its own, unless an event is close."""
        result = self.result
        if not result[MARGIN] < min(MIN_MARGIN, result[BEST_MARGIN] / GAIN):
            return self.section
        return round(float(result[BEST]) * SECTIONS) / SECTIONS % self.sequence.m

    def recut(self, point: Point) -> Point:
        """Return a point at a section farther from all events, if its own is close to one and another is better."""
        section = float(point.tests[BETTER])
        if section == point.tests[SECTION]:
            return point
        ahead = self.advance(point, TANGENT_LENGTH)
        if ahead is None:
            return point
        moved, beside = (
            np.append(self.state_at(each, section), each.value) for each in (point, ahead)
        )
        border = (beside - moved) / TANGENT_LENGTH * self.squares
        self.section = section
        matrix = self._correct(moved, border, float(border @ moved))
        cut = None if matrix is None else self._point(moved, matrix)
        if cut is None:
            return point
        # The parameter is the same, to the last bit: it may be the limit of its range.
        cut.u[-1] = point.u[-1]
        return cut

    def _correct(self, u: NDArray, border: NDArray, target: float) -> NDArray | None:
        """Correct u, in place, to the orbit in the plane border . u = target; return the last system of equations."""
        previous, law, matrix = math.inf, math.nan, np.empty((UNKNOWNS, UNKNOWNS))
        is_done = False
        for _ in range(MAX_CORRECTIONS + 1):
            result = self.differentiate(u)
            if result is None:
                return None
            if is_done:
                return matrix if self._closes(u, result) else None
            matrix[:2, :2] = fixed_point_jacobian(result)
            matrix[:2, 2], matrix[2] = result[BY_PARAMETER], border
            residual = np.array([result[X] - u[0], result[V] - u[1], border @ u - target])
            try:
                step = np.linalg.solve(matrix, residual)
            except np.linalg.LinAlgError:
                return None
            change = float(np.abs(step * self.weights).max())
            if not change < MAX_CHANGE:
                return None
            u -= step
            # Next to a change of the pieces, iterates may alternate between both sides: that is no rounding.
            stalls = change <= STALLED and change >= 0.8 * previous and result[LAW] == law
            is_done = change <= CONVERGED or stalls
            previous, law = change, result[LAW]
        return None

    def _closes(self, u: NDArray, result: NDArray) -> bool:
        """Return whether the return map at u, just differentiated, is u but for rounding."""
        carried = np.abs(self.room.ends[:, SAMPLE : SAMPLE + SAMPLES]).max(axis=1)
        section = ULP * (np.abs(result[BY_SECTION].reshape(2, 2)) + np.eye(2)) @ np.abs(u[:2])
        bound = MAX_RESIDUAL * float(((carried + section) * self.weights[:2]).max())
        residual = float((np.abs(result[[X, V]] - u[:2]) * self.weights[:2]).max())
        return residual <= bound

    def _point(self, u: NDArray, matrix: NDArray) -> Point | None:
        """Return a corrected point with its tangent, which points along the border, and its test functions."""
        try:
            tangent = np.linalg.solve(matrix, np.array([0.0, 0.0, 1.0]))
        except np.linalg.LinAlgError:
            return None
        tangent /= np.linalg.norm(tangent * self.weights)
        bordered = matrix / self.weights
        bordered[2] = tangent * self.weights
        bordered /= np.linalg.norm(bordered, axis=1, keepdims=True)
        derivative = matrix[:2, :2] + np.eye(2)
        trace, determinant = float(np.trace(derivative)), float(np.linalg.det(derivative))
        tests = np.zeros(TESTS)
        tests[FOLD] = tangent[-1] * self.weights[-1]
        tests[DOUBLING] = (1.0 + trace + determinant) / (1.0 + abs(trace) + abs(determinant))
        # No flight of an impact sequence is beyond a support, and no impact has lost its speed.
        tests[GAP] = tests[SPEED] = tests[UNIT] = 1.0
        tests[TRACE], tests[DETERMINANT] = trace, determinant
        tests[CROSSING] = np.linalg.det(bordered)
        tests[PIECES], tests[SECTION] = self.result[LAW], self.section
        tests[BETTER] = self.better_section()
        point = Point(u, tangent, tests)
        is_steep = np.abs(matrix[:2, :2]).max() > STEEP_MAP
        return None if is_steep and self.state_at_start(point) is None else point
