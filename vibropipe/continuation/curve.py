"""A curve of zeros of n equations in n + 1 unknowns: its points, steps along it, and where on it a function is zero.

A step predicts along the tangent and corrects by Newton's method in the plane across it [1]_.

References
----------
.. [1] H. B. Keller, "Numerical solution of bifurcation and nonlinear eigenvalue problems", in: Applications of
   Bifurcation Theory, Academic Press (1977) 359-384.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibropipe.continuation.newton import (
    DONE,
    FAILED,
    MAX_CORRECTIONS,
    factorise,
    fill_tangent,
    new_work,
    predict,
    solve_factorised,
    verdict,
)

# Length of a step at which the zero of a test function is located: the parameter is then known to 1e-13 of its range.
LOCATED = 1e-13
MAX_LOCATIONS = 100
# Share of a step along two parameters, weighted, below which they do not change: a cusp.
NO_CHANGE = 1e-5
# The first test functions of all curves. FOLD: weighted component of the tangent along the last unknown. CROSSING:
# determinant of the equations bordered by the tangent, zero where curves cross; 0 where it is not asked for. Both
# change sign with the tangent.
FOLD, CROSSING, OWN_TESTS = range(3)
Zero = tuple[float, "Point"]
"""A place of a step: its length from the start of the step, and the point."""


class Point(NamedTuple):
    """A point of a curve: unknowns and tangent (size,), and test functions, FOLD and CROSSING first.

    curve : where a path goes on from curve to curve, the one that the point lies on
    """

    u: NDArray
    tangent: NDArray
    tests: NDArray
    curve: Any = None

    @property
    def value(self) -> float:
        """The last unknown, the parameter."""
        return float(self.u[-1])

    def reversed(self) -> Point:
        """Return the point with its tangent reversed."""
        tests = self.tests.copy()
        tests[:OWN_TESTS] = -tests[:OWN_TESTS]
        return self._replace(tangent=-self.tangent, tests=tests)


class Curve:
    """Zeros of n equations in n + 1 unknowns, of which the last ones are parameters.

    weights : (size,), of the unknowns in norms
    max_length : largest weighted length of a step
    fill : of the unknowns: returns the residual (n,) and its derivative (n, size), or None where there is none. Curves
        with a `step` and `finished`, or a `solve`, of their own do without
    tests : of the unknowns and that derivative: returns the test functions beside FOLD and CROSSING
    """

    # Unknowns that may all be moved by a whole number at once.
    periodic: Sequence[int] = ()
    weights: NDArray
    squares: NDArray
    max_length: float

    def __init__(
        self,
        weights: NDArray,
        max_length: float,
        fill: Callable[[NDArray], tuple[NDArray, NDArray] | None] | None = None,
        tests: Callable[[NDArray, NDArray], Sequence[float]] = lambda _u, _derivative: (),
    ) -> None:
        self.weights, self.squares = weights, weights**2
        self.max_length, self.fill, self.tests = max_length, fill, tests
        self.work = new_work(weights.size)

    def solve(self, u: NDArray, target: float) -> Point | None:
        """Correct u, in place, to the curve in the plane work.border . u = target; None if there is none.

        The tangent of the point is directed along the border.
        """
        previous = math.inf
        for _ in range(MAX_CORRECTIONS):
            step = self.step(u, target)
            change = math.inf if step is None else self.weighted(step)
            said = verdict(change, previous)
            if step is None or said == FAILED:
                return None
            u -= step
            if said == DONE:
                return self.finished(u)
            previous = change
        return None

    def step(self, u: NDArray, target: float) -> NDArray | None:
        """Return what a step of Newton's method takes from u in the plane of `solve`; None without equations there."""
        filled = self.fill(u) if self.fill is not None else None
        if filled is None:
            return None
        work = self.work
        work.rhs[:-1], work.matrix[:-1] = filled
        work.rhs[-1], work.matrix[-1] = work.border @ u - target, work.border
        factorise(work.matrix, work.pivots)
        solve_factorised(work.matrix, work.pivots, work.rhs)
        return work.rhs

    def finished(self, u: NDArray) -> Point | None:
        """Return a corrected point with its tangent and its test functions."""
        filled = self.fill(u) if self.fill is not None else None
        if filled is None:
            return None
        tangent = np.empty(u.size)
        fill_tangent(self.weights, self.work, tangent)
        bordered = np.vstack([filled[1], tangent * self.squares]) / self.weights
        first = tangent[-1] * self.weights[-1], np.linalg.det(bordered)
        return Point(u, tangent, np.array([*first, *self.tests(u, filled[1])]))

    def settle(self, u: NDArray, fixed: int = -1) -> Point | None:
        """Return the point near u with the unknown `fixed` (default: the last one) held; None if there is none."""
        u = np.array(u, float)
        held = float(u[fixed])
        self.work.border[:] = 0.0
        self.work.border[fixed] = 1.0
        point = self.solve(u, held)
        u[fixed] = held
        return point

    def advance(self, point: Point, length: float) -> Point | None:
        """Return the point a weighted length along the curve; None if the corrector does not converge."""
        u = np.empty(point.u.size)
        border = self.work.border
        target = predict(point.u, point.tangent, length, self.weights, border, u)
        return self.solve(u, target)

    def cosine(self, before: Point, after: Point) -> float:
        """Return the cosine of the angle between the tangents of two points."""
        return float(np.dot(self.squares * before.tangent, after.tangent))

    def weighted(self, change: NDArray) -> float:
        """Return the largest weighted change of the unknowns."""
        return float(np.abs(change * self.weights).max())

    def shifted(self, u: NDArray, near: NDArray) -> NDArray:
        """Return unknowns moved by a whole number to those near them."""
        moved = u.copy()
        times = [*self.periodic]
        if times:
            moved[times] += round(float(near[times[0]] - u[times[0]]))
        return moved

    def distance(self, first: Point, second: Point) -> float:
        """Return the largest weighted difference of two points, a whole number apart or not."""
        return self.weighted(self.shifted(first.u, second.u) - second.u)

    def along_tangent(self, start: Point, u: NDArray) -> float:
        """Return the weighted length along the tangent of a point at which the plane across it meets u."""
        return float(np.dot(self.squares * start.tangent, u - start.u))

    def zero_of(self, point: Point, length: float, test: int) -> Zero | None:
        """Return where in a step a test function is zero; None if it cannot be located."""
        return self.locate(point, (0.0, length), lambda each: float(each.tests[test]))

    def value_of(
        self, point: Point, ends: tuple[float, float], column: int, value: float
    ) -> Zero | None:
        """Return where between two lengths of a step an unknown has a value, which the point has exactly."""
        zero = self.locate(point, ends, lambda each: float(each.u[column] - value))
        if zero is None:
            return None
        length, crossing = zero
        exact = crossing.u.copy()
        exact[column] = value
        settled = self.settle(exact, column)
        if settled is None:
            return None
        return length, settled.reversed() if self.cosine(crossing, settled) < 0.0 else settled

    def cusp_of(self, point: Point, new: Point, length: float) -> Zero | None:
        """Return where in a step the last two unknowns, both parameters, turn back at once; None if they do not."""

        def change(each: Point) -> NDArray:
            return np.asarray(each.tangent[-2:] * self.weights[-2:])

        first = change(point)
        if np.dot(first, change(new)) >= 0.0:
            return None
        zero = self.locate(point, (0.0, length), lambda each: float(np.dot(first, change(each))))
        return zero if zero and np.abs(change(zero[1])).max() <= NO_CHANGE else None

    def locate(
        self, start: Point, ends: tuple[float, float], function: Callable[[Point], float]
    ) -> Zero | None:
        """Return where a function of the points is zero: length from `start`, and the point.

        None if a step fails or the function does not change sign between `ends`, lengths from `start`.

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
