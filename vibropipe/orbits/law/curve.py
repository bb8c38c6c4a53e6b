"""Points of a branch of orbits of one law: zeros of its equations, stable or not, with the margins that they keep."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from vibropipe.continuation.curve import FOLD, Curve, Point, Zero
from vibropipe.march.piece_log import (
    CAUSE,
    FORM,
    HOME,
    HOUSING_SLIP,
    HOUSING_STOP,
    RESTING,
    STICK,
    TURN,
)
from vibropipe.orbits.law import least as of
from vibropipe.orbits.law.elimination import Border, no_border, solve_cyclic
from vibropipe.orbits.law.equations import SHORTEST, new_blocks
from vibropipe.orbits.law.flights import momentum_within, state_within
from vibropipe.orbits.law.law import SECTION, WAY, Law, width_of
from vibropipe.orbits.law.marching import Marcher
from vibropipe.orbits.law.problem import Problem, Scales
from vibropipe.orbits.law.steps import (
    DOUBLING,
    GAP,
    N_TESTS,
    PAIR,
    SLOW_EVENT,
    SPEED,
    System,
    fill_at,
    fill_tests,
    new_through,
    solve,
)
from vibropipe.orbits.law.tied import Tied
from vibropipe.orbits.row import row_parameters
from vibropipe.physics.contact import to_displacement, to_velocity
from vibropipe.physics.derivatives import ALL_DIFFERENTIATED, gap_acceleration
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.housing import momentum_share
from vibropipe.physics.load import forcing_period
from vibropipe.words.parameters import THROUGH_OTHERS

# Largest value of a test function where it is located: larger ones are jumps. Those of long orbits are so steep that
# they differ from zero where their argument is known to rounding.
MAX_TEST_LEFT = {FOLD: 1e-3, DOUBLING: 1e-3, PAIR: 1e-3, SPEED: 1e-6, GAP: 1e-6}
# A bifurcation is steep where DOUBLING changes by more than `STEEP` within a length on both sides. With its slope k,
# doubled orbits bifurcate again at a distance of 1 / k. Their equations are those of the parent but for its square, so
# that rounding blurs orbits by 1e-16 k and tests by 1e-16 k^2: what begins there cannot be followed from k = 1e6 on
# (`HIDDEN_LENGTH`). From k = 1e8 on (`UNRESOLVED_LENGTH`) a branch ends, before the rounding of a length reaches the
# distance of a fold from its flip, again 1 / k.
HIDDEN_LENGTH, UNRESOLVED_LENGTH, STEEP = 1e-7, 1e-9, 0.2
# Number of a parameter by which equations have no derivative but through others; columns of those that act so.
BY_NONE = -1
ACTING = [Parameters._fields.index(name) for name, acts in THROUGH_OTHERS.items() if acts]
# Iterations towards the vector that an orbit is doubled along.
ITERATIONS = 3
# No touch of a support: see `least.TOUCH`.
NO_TOUCH = of.NOWHERE, 0.0, 0.0


def _column(index: int) -> int:
    """Return the number of the derivatives by a parameter, or by a name of one's own, which has none."""
    name = Parameters._fields[index] if index < len(Parameters._fields) else ""
    is_known = name in ALL_DIFFERENTIATED and name not in THROUGH_OTHERS
    return ALL_DIFFERENTIATED.index(name) if is_known else BY_NONE


class LawZeros(Curve):
    """Zeros of the equations of one law, and of further conditions.

    Unknowns are the times of all events, what is free of the state before each, and parameters.

    marcher : marches motions of the exciters
    values : (parameters,), of the exciter
    along : (k,) int, indices of those that vary
    low, high : (k,), their ranges
    max_length : largest weighted length of a step
    tied : what follows them
    """

    # Where the orbit touches a support, which is no end of its law: piece, support, time.
    touch: tuple[float, float, float] = NO_TOUCH

    def __init__(
        self,
        law: Law,
        scales: Scales,
        marcher: Marcher,
        values: np.ndarray,
        along: np.ndarray,
        low: np.ndarray,
        high: np.ndarray,
        max_length: float,
        tied: Tied | None = None,
    ) -> None:
        law = Law(np.ascontiguousarray(law.codes), float(law.span), int(law.mirrored))
        self.sequence, self.scales, self.marcher = law, scales, marcher
        self.effects = marcher.effects
        self.size, self.speed = size, speed = scales
        n, kinds = len(law.codes), law.codes[:, CAUSE]
        self.width = width = width_of(self.effects.housing)
        weights = np.full(width * n, 1.0 / speed)
        weights[:n] = 1.0
        weights[n : 2 * n][np.isin(kinds, (TURN, STICK, HOUSING_STOP))] = 1.0 / size
        self.periodic = range(n)
        if kinds[0] == SECTION:
            weights[0], self.periodic = 1.0 / size, ()
        super().__init__(np.append(weights, 1.0 / (high - low)), max_length)
        # The cyclic system is eliminated in place of a dense matrix.
        self.work = self.work._replace(matrix=np.zeros((0, 0)))
        # Where nothing follows, no more is filled than without ties.
        self.tied, self.n_free = tied if tied is not None and tied.following else None, len(along)
        moving = along if self.tied is None else np.append(along, self.tied.places)
        columns = np.array([_column(index) for index in moving])
        is_acted = any(values[k] != 0.0 or k in moving for k in ACTING)
        least, most = (
            np.resize(ends, moving.size) for ends in (2.0 * low - high, 2.0 * high - low)
        )
        margins = np.zeros((of.KINDS + 1, 4))
        margins[of.TOUCH] = law.span * (-1.0 if law.mirrored else 1.0), *NO_TOUCH
        self.system = System(
            self.effects, law, values.reshape(1, -1).copy(), moving, columns, least, most,
            np.zeros((n, width)), new_blocks(n, moving.size, self.effects.housing),
            margins, size, speed, new_through(n, is_acted, self.effects.housing),
        )  # fmt: skip
        # Derivatives by the parameters that vary, with those of what follows.
        self.by = self.system.blocks.by

    def point(self, u: np.ndarray, tangent: np.ndarray, tests: np.ndarray) -> Point:
        """Return a point of this branch."""
        return Point(u, tangent, tests, self)

    def is_pressed(self, point: Point) -> bool:
        """Return whether the slowest impact on a rigid support is pressed on it, and rests where it has no speed."""
        n, i = len(self.sequence.codes), int(point.tests[SLOW_EVENT])
        p, support = self.parameters_of(point.u), int(self.sequence.codes[i, HOME])
        w, second = to_velocity(support, point.u[n + i]), self.effects.second_harmonic
        return bool(gap_acceleration(p, support, point.u[i], 0.0, w, second) < 0.0)

    def parameters_of(self, u: np.ndarray) -> Any:
        """Return the `Parameters` at some unknowns."""
        self.set_ends(u[self.width * len(self.sequence.codes) :])
        return row_parameters(self.system.values, 0)

    def stated(self, ends: np.ndarray) -> np.ndarray:
        """Return the parameters (parameters,), as they are stated, at values of those that vary."""
        values = self.system.values[0].copy()
        self._fill_ends(values, ends)
        return values[: len(Parameters._fields)]

    def set_ends(self, ends: np.ndarray) -> None:
        """Set the parameters that vary, and what follows them."""
        self._fill_ends(self.system.values[0], ends)

    def _fill_ends(self, values: np.ndarray, ends: np.ndarray) -> None:
        values[self.system.along[: self.n_free]] = ends
        if self.tied is not None:
            self.tied.fill(values)

    def events_of(self, u: np.ndarray) -> np.ndarray:
        """Return the unknowns as an array (n, w)."""
        n, width = len(self.sequence.codes), self.width
        return np.ascontiguousarray(u[: width * n].reshape(width, n).T)

    def step(self, u: np.ndarray, target: float) -> np.ndarray | None:  # noqa: D102 - as Curve
        self.marcher.rows += len(self.sequence.codes)
        if not self._fill(u):
            return None
        rows, values = self._rows(u)
        values[0] = float(rows[0] @ u) - target
        step, sign = self._solve(self.system.blocks.rest, rows, values)
        return None if sign == 0.0 else step

    def _rows(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the normal of the plane and the derivatives of the conditions, and the values of the latter."""
        further = self.conditions(u)
        rows = np.array([self.work.border, *(slope for _value, slope in further)])
        return rows, np.array([0.0, *(value for value, _slope in further)])

    def conditions(self, u: np.ndarray) -> list[tuple[float, np.ndarray]]:
        """Return values and derivatives of what else is zero at u, whose blocks are filled."""
        return []

    def nearest(self, u: np.ndarray) -> Point | None:
        """Return the point that Newton's method finds near u, across the branch; None if there is none."""
        for fixed in (-1, *range(len(self.sequence.codes))):
            border = np.zeros(len(u))
            border[fixed] = 1.0
            if not self._fill(u):
                return None
            tangent, sign = self._solve(
                np.zeros_like(self.system.blocks.rest), border[np.newaxis], np.ones(1)
            )
            norm = float(np.linalg.norm(tangent * self.weights))
            if sign != 0.0 and 0.0 < norm < math.inf:
                return self.advance(self.point(u, tangent / norm, np.zeros(0)), 0.0)
        return None

    def state_at(self, point: Point, visit: float = 0) -> np.ndarray:
        """Return the state after some whole periods from the phase 0 of the force, counted from the equilibrium.

        (x, x') and, of a housing, its velocity.
        """
        law, u = self.sequence, self.events_of(point.u)
        n, p = len(law.codes), self.parameters_of(point.u)
        if law.codes[0, CAUSE] == SECTION:
            state = np.append(point.u[:2], np.zeros(self.width - 2))
            state[0] += to_displacement(p, int(law.codes[0, HOME]), 0.0)
            return state
        for i in range(n):
            last = float(u[i + 1, 0]) if i + 1 < n else float(u[0, 0]) + law.span
            # An orbit comes to this phase once; its mirror image half an orbit earlier.
            for later, sign in ((0.0, 1.0), (-law.span, -1.0))[: 1 + law.mirrored]:
                at = visit + later
                at += law.m * math.ceil((u[i, 0] - at) / law.m)
                if at <= last:
                    rests = law.codes[i, FORM] == RESTING
                    to = float(u[i, 0]) if rests else at
                    y, w = state_within(self.effects, p, law, i, u, to)
                    home = int(law.codes[i, HOME])
                    x = to_displacement(p, home, float(y))
                    state = np.array([x, to_velocity(home, float(w))])
                    if self.width > 2:
                        state = np.append(state, self._housing_at(p, i, u, to, state[1]))
                    if rests:
                        # What is left of the chatter, and the rest after it, are those of a march.
                        begin = float(u[i, 0])
                        after = self.marcher.after(p, state, at - begin, begin)
                        state = np.full(self.width, math.nan) if after is None else after
                    return sign * state
        return np.full(self.width, math.nan)

    def _housing_at(self, p: Any, i: int, u: np.ndarray, at: float, v: float) -> float:
        """Return the velocity of a housing on piece i at a time, with that of x there."""
        if not self.sequence.codes[i, WAY]:
            return 0.0
        q = to_velocity(
            int(self.sequence.codes[i, HOME]),
            float(momentum_within(self.effects, p, self.sequence, i, u, at)),
        )
        return momentum_share(p) * (q - v)

    def _fill(self, u: np.ndarray) -> bool:
        """Fill the blocks at u; return whether they are finite."""
        if not np.isfinite(u).all():
            return False
        if self.tied is None:
            return bool(fill_at(self.system, u))
        last, k, system = self.width * len(self.sequence.codes), self.n_free, self.system
        self.set_ends(u[last:])
        moving = system.values[0, system.along]
        reach = np.where(moving[k:] == 0.0, 1.0, np.abs(moving[k:]))
        system.least[k:], system.most[k:] = moving[k:] - reach, moving[k:] + reach
        if not fill_at(system, np.append(u[:last], moving)):
            return False
        self.by = system.blocks.by @ self._by_free()
        return True

    def _by_free(self) -> np.ndarray:
        """Return the derivatives of all parameters that move by those that are free."""
        assert self.tied is not None
        return np.vstack([np.eye(self.n_free), self.tied.slopes(self.system.values[0])])

    def through_ties(self, slopes: np.ndarray) -> np.ndarray:
        """Return derivatives by the unknowns from those by events and all parameters that move."""
        if self.tied is None:
            return slopes
        last = self.width * len(self.sequence.codes)
        return np.append(slopes[:last], slopes[last:] @ self._by_free())

    def _solve(
        self, rest: np.ndarray, rows: np.ndarray, targets: np.ndarray
    ) -> tuple[np.ndarray, float]:
        """Return the solution of the equations at the blocks with further rows, and the sign of the determinant."""
        n, w, blocks = len(self.sequence.codes), self.width, self.system.blocks
        x, q = np.zeros((n, w)), np.zeros(self.n_free)
        borders = np.ascontiguousarray(rows[:, : w * n].reshape(-1, w, n).transpose(0, 2, 1))
        corner = np.ascontiguousarray(rows[:, w * n :])
        further = Border(self.by, borders, corner, targets)
        sign, _log = solve_cyclic(
            blocks.before, blocks.at, rest, 1.0, further, x, q, self.effects.housing
        )
        return np.concatenate([x.T.ravel(), q]), sign

    def finished(self, u: np.ndarray) -> Point | None:  # noqa: D102 - as Curve
        if not self._fill(u):
            return None
        rows, _values = self._rows(u)
        along = np.eye(len(rows))[0]
        tangent, sign = self._solve(np.zeros_like(self.system.blocks.rest), rows, along)
        norm = float(np.linalg.norm(tangent * self.weights))
        if sign == 0.0 or not 0.0 < norm < math.inf:
            return None
        tangent /= norm
        tests = np.zeros(N_TESTS)
        tests[FOLD] = tangent[-1] * self.weights[-1]
        self.system.margins[of.TOUCH, 1:] = self.touch
        fill_tests(self.system, self.system.blocks.polynomial, tests)
        return Point(u, tangent, tests, self)

    def zero_of(self, point: Point, length: float, test: int) -> Zero | None:
        """Return where in a step a test function is zero; None if it cannot be located, or is a jump."""
        zero = super().zero_of(point, length, test)
        if zero is None or abs(zero[1].tests[test]) <= MAX_TEST_LEFT[test]:
            return zero
        return zero if self.is_steep(point, zero[0], UNRESOLVED_LENGTH) else None

    def is_born(self, point: Point) -> bool:
        """Return whether a slip of the housing is so short that its equations are those of a longer one."""
        law, n = self.sequence, len(self.sequence.codes)
        u, shortest = point.u[:n], SHORTEST / forcing_period(self.parameters_of(point.u))
        for i in range(n):
            if law.codes[i, CAUSE] == HOUSING_STOP and law.codes[i - 1, CAUSE] == HOUSING_SLIP:
                span = u[i] - u[i - 1] + (law.span if i == 0 else 0.0)
                if span < shortest:
                    return True
        return False

    def is_steep(self, point: Point, at: float, within: float) -> bool:
        """Return whether DOUBLING changes by more than `STEEP` within a length of a place of a step."""
        before, after = self.advance(point, at - within), self.advance(point, at + within)
        return (
            before is not None
            and after is not None
            and abs(after.tests[DOUBLING] - before.tests[DOUBLING]) > STEEP
        )

    def end_of(self, test: int, point: Point) -> tuple[str, str]:
        """Return of which kind the event is at which the orbit ceases to be a motion, and the reason to end there."""
        return "change", "speed" if test == SPEED else "gap"

    def doubling_vector(self, point: Point) -> np.ndarray:
        """Return the perturbation (w n + 1,) that changes sign over the law, where DOUBLING is zero."""
        n, w, blocks = len(self.sequence.codes), self.width, self.system.blocks
        self._fill(point.u)
        rest, x = np.ones((n, w)), np.zeros((n, w))
        for _ in range(ITERATIONS):
            solve_cyclic(
                blocks.before, blocks.at, rest, -1.0, no_border(n, w), x, np.zeros(0),
                self.effects.housing,
            )  # fmt: skip
            rest = x / np.abs(x).max()
        return np.append(rest.T.ravel(), 0.0)


class LawCurve(LawZeros):
    """The branch of orbits of one law along one parameter; law, scales, marcher : as for `LawZeros`."""

    def __init__(self, problem: Problem, law: Law, scales: Scales, marcher: Marcher) -> None:
        along, low, high = (np.array([each]) for each in (problem.along, problem.low, problem.high))
        super().__init__(
            law, scales, marcher, problem.values, along, low, high, problem.max_length, problem.tied
        )
        self.problem = problem

    def solve(self, u: np.ndarray, target: float) -> Point | None:  # noqa: D102 - as Curve
        if self.tied is not None:
            return super().solve(u, target)
        tangent, tests = np.empty(u.size), np.empty(N_TESTS)
        fills = solve(self.system, u, target, self.weights, self.work.border, tangent, tests)
        self.marcher.rows += abs(fills) * len(self.sequence.codes)
        return Point(u, tangent, tests, self) if fills > 0 else None

    def with_sequence(self, sequence: Law) -> LawCurve:
        """Return the branch of another law."""
        return LawCurve(self.problem, sequence, self.scales, self.marcher)

    def parameters(self, value: float) -> Any:
        """Return the `Parameters` at a value of the one that varies."""
        return self.problem.parameters_at(value)
