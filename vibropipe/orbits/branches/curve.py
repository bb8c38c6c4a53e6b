"""Points of a branch of one impact sequence: the curve of the zeros of its equations."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from vibropipe.continuation.curve import FOLD, CompiledCurve, Zero
from vibropipe.continuation.curve import Point as Point
from vibropipe.orbits.branches.sequence import Sequence, parameters_at
from vibropipe.orbits.branches.steps import (
    DOUBLING,
    GAP,
    GAP_SIDE,
    SLOWEST,
    SPEED,
    TESTS,
    Sought,
    doubling_vector,
    new_room,
    solve,
)
from vibropipe.physics.contact import support_position
from vibropipe.physics.forced_flow import acceleration

# Largest value of a test function where it is located: larger ones are jumps. Those of long orbits are so steep that
# they differ from zero where their argument is known to rounding.
MAX_TEST_LEFT = {FOLD: 1e-3, DOUBLING: 1e-3, SPEED: 1e-6, GAP: 1e-6}
# A bifurcation is steep where DOUBLING changes by more than `STEEP` within a length on both sides. With its slope k,
# doubled orbits bifurcate again at a distance of 1 / k. Their equations are those of the parent but for its square, so
# that rounding blurs orbits by 1e-16 k and tests by 1e-16 k^2: what begins there cannot be followed from k = 1e6 on
# (`HIDDEN_LENGTH`). From k = 1e8 on (`UNRESOLVED_LENGTH`) a branch ends, before the rounding of a length reaches the
# distance of a fold from its flip, again 1 / k.
HIDDEN_LENGTH, UNRESOLVED_LENGTH, STEEP = 1e-7, 1e-9, 0.2


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


class Curve(CompiledCurve):
    """The branch of one impact sequence, on which points are found by continuation.

    Parameters
    ----------
    problem : Problem
    sequence : Sequence
    speed : float
        Scale of impact velocities, > 0.
    """

    # A `Sequence`, or the law of an orbit with other events.
    sequence: Any

    def __init__(self, problem: Problem, sequence: Sequence, speed: float) -> None:
        self.problem, self.sequence, self.speed = problem, sequence, speed
        self.periodic = range(len(sequence.supports))
        values = problem.values.reshape(1, -1).copy()
        sought = Sought(
            values, problem.along, sequence.span, sequence.mirrored, sequence.supports, new_room()
        )
        weights = weights_of(sequence, speed, [1.0 / (problem.high - problem.low)])
        super().__init__(weights, problem.max_length, solve, sought, TESTS)

    def with_sequence(self, sequence: Sequence) -> Curve:
        """Return the branch of another sequence."""
        return Curve(self.problem, sequence, self.speed)

    def point(self, u: np.ndarray, tangent: np.ndarray, tests: np.ndarray) -> Point:
        """Return a point of this branch."""
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

    def zero_of(self, point: Point, length: float, test: int) -> Zero | None:
        """Return where in a step a test function is zero; None if it cannot be located, or is a jump."""
        zero = super().zero_of(point, length, test)
        if zero is None or abs(zero[1].tests[test]) <= MAX_TEST_LEFT[test]:
            return zero
        return zero if self.is_steep(point, zero[0], UNRESOLVED_LENGTH) else None

    def is_steep(self, point: Point, at: float, within: float) -> bool:
        """Return whether DOUBLING changes by more than `STEEP` within a length of a place of a step."""
        before, after = self.advance(point, at - within), self.advance(point, at + within)
        return (
            before is not None
            and after is not None
            and abs(after.tests[DOUBLING] - before.tests[DOUBLING]) > STEEP
        )


def weights_of(sequence: Sequence, speed: float, further: Iterable[float]) -> np.ndarray:
    """Return the weights of times, velocities of a scale `speed`, and further unknowns."""
    n = len(sequence.supports)
    return np.concatenate([np.ones(n), np.full(n, 1.0 / speed), [*further]])


def is_no_motion(point: Point) -> bool:
    """Return whether a point is no motion: a flight beyond a support, or an impact away from it."""
    return not (point.tests[GAP] > 0.0 and point.tests[SPEED] > 0.0)
