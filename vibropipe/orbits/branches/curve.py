"""Points of a branch of one impact sequence: steps along it, and the places where a function of its points is zero."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vibropipe.orbits.branches.sequence import Sequence, parameters_at
from vibropipe.orbits.branches.steps import (
    CROSSING,
    FOLD,
    GAP,
    GAP_SIDE,
    SLOWEST,
    TESTS,
    Sought,
    Work,
    advance,
    doubling_vector,
    settle_at,
)
from vibropipe.physics.contact import support_position
from vibropipe.physics.flow import DEGREE
from vibropipe.physics.forced_flow import acceleration

# Length of a step at which the zero of a test function is located: the parameter is then known to 1e-13 of its range.
LOCATED = 1e-13
MAX_LOCATIONS = 100


class Problem(NamedTuple):
    """What is followed.

    Attributes
    ----------
    values : (7,) float
        Parameters of the exciter.
    along : int
        Index of the parameter that varies.
    low, high : float
        Its range.
    at : tuple of float
        Its values at which points are wanted.
    symmetric : bool
        Whether the exciter is its own mirror image over the whole range.
    max_length : float
        Largest weighted length of a step.
    """

    values: np.ndarray
    along: int
    low: float
    high: float
    at: tuple[float, ...]
    symmetric: bool
    max_length: float


class Point(NamedTuple):
    """A point of a branch: unknowns and tangent (2n + 1,), and test functions (TESTS,)."""

    u: np.ndarray
    tangent: np.ndarray
    tests: np.ndarray

    @property
    def value(self) -> float:
        """The parameter."""
        return float(self.u[-1])

    def reversed(self) -> Point:
        """Return the point with its tangent reversed."""
        tests = self.tests.copy()
        tests[FOLD], tests[CROSSING] = -tests[FOLD], -tests[CROSSING]
        return Point(self.u, -self.tangent, tests)


class Curve:
    """The branch of one impact sequence, on which points are found by continuation.

    Parameters
    ----------
    problem : Problem
    sequence : Sequence
    speed : float
        Scale of impact velocities, > 0.
    """

    # kernels of a step, and of a point with one unknown held
    _advance: Callable[..., int] = staticmethod(advance)
    _settle: Callable[..., int] = staticmethod(settle_at)
    sought: Any  # what they solve for

    def __init__(self, problem: Problem, sequence: Sequence, speed: float) -> None:
        self.problem = problem
        self._begin(sequence, speed, 2 * len(sequence.supports) + 1)
        self.weights[-1] = 1.0 / (problem.high - problem.low)
        self.squares = self.weights**2
        values = problem.values.reshape(1, -1).copy()
        self.sought = Sought(
            values, problem.along, sequence.span, sequence.mirrored, sequence.supports
        )

    def _begin(self, sequence: Sequence, speed: float, size: int) -> None:
        """Set the sequence, the weights of its velocities, and the work arrays of `size` unknowns."""
        n = len(sequence.supports)
        self.sequence, self.speed = sequence, speed
        self.weights = np.ones(size)
        self.weights[n : 2 * n] = 1.0 / speed
        rhs, above, below, border = np.zeros((4, size))
        matrix, pivots = np.zeros((size, size)), np.zeros(size, np.int64)
        none, c = np.zeros((0, 0)), np.zeros(DEGREE + 1)
        self.work = Work(matrix, pivots, rhs, above, below, border, none, c)

    def with_sequence(self, sequence: Sequence) -> Curve:
        """Return the branch of another sequence."""
        return Curve(self.problem, sequence, self.speed)

    def point(self, u: np.ndarray, tangent: np.ndarray, tests: np.ndarray) -> Point:
        """Return a point of this branch."""
        return Point(u, tangent, tests)

    def settle(self, u: np.ndarray, fixed: int = -1) -> Point | None:
        """Return the point near u with the unknown `fixed` (default: the last one) held; None if there is none."""
        u = np.array(u, float)
        tangent, tests = np.empty(u.size), np.empty(TESTS)
        held = u[fixed]
        index = fixed % u.size
        if self._settle(self.sought, index, self.weights, self.work, u, tangent, tests) < 0:
            return None
        u[fixed] = held
        return Point(u, tangent, tests)

    def advance(self, point: Point, length: float) -> Point | None:
        """Return the point a weighted length along the branch; None if the corrector does not converge."""
        size = point.u.size
        u, tangent, tests = np.empty(size), np.empty(size), np.empty(TESTS)
        iterations = self._advance(
            self.sought, point.u, point.tangent, length, self.weights, self.work, u, tangent, tests
        )
        if iterations < 0:
            return None
        return Point(u, tangent, tests)

    def end_of(self, test: int, point: Any) -> tuple[str, str]:
        """Return of which kind the event is at which the orbit ceases to be a motion, and the reason to end there."""
        if test == GAP:
            return ("end", "rest") if point.tests[GAP_SIDE] == 0 else ("grazing", "gap")
        n, i = len(self.sequence.supports), int(point.tests[SLOWEST])
        support = int(self.sequence.supports[i])
        p = parameters_at(
            self.problem.values.reshape(1, -1).copy(), self.problem.along, point.value
        )
        pull = acceleration(p, support_position(p, support), point.u[n + i], point.u[i])
        pressed = pull > 0.0 if support == 1 else pull < 0.0
        return ("end", "chatter") if pressed else ("grazing", "speed")

    def doubling_vector(self, point: Point) -> np.ndarray:
        """Return the perturbation (2n + 1,) that changes sign over the sequence, where DOUBLING is zero."""
        vector = np.zeros(point.u.size)
        doubling_vector(self.sought, point.u, self.work, vector)
        return vector

    def cosine(self, before: Point, after: Point) -> float:
        """Return the cosine of the angle between the tangents of two points."""
        return float(np.dot(self.squares * before.tangent, after.tangent))

    def distance(self, first: Point, second: Point) -> float:
        """Return the largest weighted difference of two points, whole forcing periods apart or not."""
        change = first.u - second.u
        n = len(self.sequence.supports)
        change[:n] -= round(change[0])
        return float(np.abs(change * self.weights).max())

    def locate(
        self, start: Point, ends: tuple[float, float], function: Callable[[Point], float]
    ) -> tuple[float, Point] | None:
        """Return where a function of the points is zero.

        Parameters
        ----------
        start : Point
        ends : (float, float)
            Lengths from `start` between which the function changes sign.
        function : callable
            Of a point.

        Returns
        -------
        (float, Point) or None
            Length from `start`, and the point; None if a step fails or the function does not change sign.

        References
        ----------
        M. Dowell, P. Jarratt, "A modified regula falsi method for computing the root of an equation", BIT 11 (1971)
        168-174; with a bisection whenever three of its steps do not halve the interval.
        """
        low, high = ends
        first, last = self.advance(start, low), self.advance(start, high)
        if first is None or last is None:
            return None
        f_low, f_high = function(first), function(last)
        if not f_low * f_high <= 0.0:
            return None
        best = min((abs(f_low), low, first), (abs(f_high), high, last), key=lambda each: each[0])
        side, width = 0, high - low
        for iteration in range(MAX_LOCATIONS):
            if best[0] == 0.0 or high - low <= LOCATED:
                break
            length = (low * f_high - high * f_low) / (f_high - f_low)
            if (iteration % 3 == 2 and high - low > 0.5 * width) or not low < length < high:
                length = 0.5 * (low + high)
            if iteration % 3 == 2:
                width = high - low
            point = self.advance(start, length)
            if point is None:
                return None
            value = function(point)
            if not math.isfinite(value):
                return None
            if abs(value) < best[0]:
                best = (abs(value), length, point)
            if (value > 0.0) == (f_low > 0.0):
                low, f_low = length, value
                f_high *= 0.5 if side == 1 else 1.0
                side = 1
            else:
                high, f_high = length, value
                f_low *= 0.5 if side == -1 else 1.0
                side = -1
        return best[1], best[2]
