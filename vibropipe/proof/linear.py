"""The equations of orbits with one or two impacts, linear in velocities and force.

Given the length s of the flight from the impact on support 1 to that on support 2, the equations are linear in both
velocities and in the parts of the force in and out of phase, alpha + i beta = f exp(i 2 pi t_1). By Cramer's rule they
have a solution with the given force only where

    g(s) = N_alpha^2 + N_beta^2 - f^2 D^2 = 0,  0 < s < m.

With one impact, or with strikes half an orbit apart on supports that mirror each other, s is known, and the velocity is
a root of a quadratic, as in docs/closed-forms.md.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

from vibropipe.proof.balls import ONE, TURN, Jet, Number, arb, imag_of, real_of
from vibropipe.proof.flights import Flights
from vibropipe.words.proofs import Why


class UndecidedError(Exception):
    """A ball contains 0 where its sign is needed."""

    def __init__(self, why: Why = Why.EXISTENCE) -> None:
        super().__init__(why.reason)
        self.why = why


class Equations:
    """The equations of orbits of one exciter, linear in velocities and force."""

    def __init__(self, p: Mapping[str, Any], m: int) -> None:
        self.p, self.m, self.model = p, m, Flights(p)
        self.force = real_of(self.model.forces[0][1])

    def flight(self, start: Number, turns: Number, of: int, to: int) -> list[list[Number]]:
        """Return the rows of a flight for x and x' at its end: (of v before, of alpha, of beta, right-hand side)."""
        model, flow = self.model, self.model.flow(turns)
        b, R = model.position[of], model.restitution[of]
        rows = []
        sides = ((flow.e11, flow.e12, model.position[to]), (flow.e21, flow.e22, turns * 0))
        for response, (e1, e2, end) in zip(model.response(turns, flow), sides, strict=True):
            turned = model.turned(start, 1) * response
            rows.append([-(e2 * R), imag_of(turned), real_of(turned), end - e1 * b])
        return rows

    def cramer(self, s: Number) -> list[Number]:
        """Return D, N_v1, N_v2, N_alpha, N_beta of the orbit whose flight from support 1 to 2 has the length s."""
        zero, one = s * 0, s * 0 + 1
        rows = []
        for (x, v), is_first in (
            (self.flight(zero, s, 1, 2), True),
            (self.flight(s, self.m - s, 2, 1), False),
        ):
            for row, of_next in ((x, zero), (v, -one)):
                own, *forcing = row
                rows.append([*((own, of_next) if is_first else (of_next, own)), *forcing])
        return _determinants(rows)

    def g(self, s: Number) -> Number:
        """Return g(s)."""
        D, _, _, alpha, beta = self.cramer(s)
        return alpha * alpha + beta * beta - D * D * (self.force * self.force)

    def g_halved(self, s: Any) -> Any:
        """Return a ball of g / (s - m/2)^2 on an interval with m/2, where D and all N are 0."""
        D, _, _, alpha, beta = (jet.slopes[0] for jet in self.cramer(Jet(s, [ONE])))
        return alpha * alpha + beta * beta - D * D * (self.force * self.force)

    def one_flight(self, turns: Any, of: int, to: int) -> list[list[Any]]:
        """Return (velocity, time) of impacts that repeat after one flight, mirrored if it ends at the other support.

        Raises UndecidedError if the equations are singular, or a root is double.
        """
        sign = 1 if of == to else -1
        (x_v, a, b, x_0), (v_v, c, d, v_0) = self.flight(arb(0), turns, of, to)
        v_v = v_v - sign  # the flight ends with the velocity before it, or its mirror image
        D = a * d - b * c
        if D.contains(0):
            raise UndecidedError
        # alpha, beta = k0 + k1 v
        alpha = ((x_0 * d - v_0 * b) / D, (v_v * b - x_v * d) / D)
        beta = ((a * v_0 - c * x_0) / D, (c * x_v - a * v_v) / D)
        square = alpha[1] * alpha[1] + beta[1] * beta[1]
        half = alpha[0] * alpha[1] + beta[0] * beta[1]
        rest = alpha[0] * alpha[0] + beta[0] * beta[0] - self.force * self.force
        inside = half * half - square * rest
        if inside < 0:
            return []
        if not (inside > 0 and square > 0):
            raise UndecidedError
        found = []
        for root in (inside.sqrt(), -inside.sqrt()):
            v = (root - half) / square
            time = self.time_of(alpha[0] + alpha[1] * v, beta[0] + beta[1] * v)
            found.append([v, time])
        return found

    def time_of(self, alpha: Any, beta: Any) -> Any:
        """Return the time of the first impact, in forcing periods, from f exp(i 2 pi t)."""
        x, y = alpha / self.force, beta / self.force
        # about the direction of the middle, for no ball to lie across the cut of the angle
        c, s = x.mid(), y.mid()
        return (arb.atan2(s, c) + arb.atan2(y * c - x * s, x * c + y * s)) / TURN

    def is_mirrored_alone(self) -> bool:
        """Return whether strikes half an orbit apart are each other's mirror images: v_1 + v_2 can only be 0."""
        flow, R = self.model.flow(arb(self.m) / 2), self.model.restitution[1]
        return not ((flow.e12 * R).contains(0) and (1 + R * flow.e22).contains(0))

    def has_mirrored(self) -> bool:
        """Return whether strikes half an orbit apart mirror each other: of an exciter that is its own mirror image."""
        p = self.p
        is_mirrored = (p["delta"] - p["load"]).is_zero() and (p["R1"] - p["R2"]).is_zero()
        return bool(self.m % 2 == 1 and is_mirrored)


Minors = dict[tuple[int, int], Number]


def minors(a: Sequence[Number], b: Sequence[Number]) -> Minors:
    """Return the determinants of any two columns of two rows."""
    pairs = itertools.combinations(range(len(a)), 2)
    found = {(i, j): a[i] * b[j] - a[j] * b[i] for i, j in pairs}
    return found | {(j, i): -value for (i, j), value in found.items()}


def determinant(upper: Minors, lower: Minors, c: Sequence[int]) -> Number:
    """Return the determinant of four columns of four rows, by the minors of two and two of them."""
    pairs = (((0, 1), (2, 3), 1), ((0, 2), (1, 3), -1), ((0, 3), (1, 2), 1),
             ((1, 2), (0, 3), 1), ((1, 3), (0, 2), -1), ((2, 3), (0, 1), 1))  # fmt: skip
    terms = (upper[c[i], c[j]] * lower[c[k], c[n]] * sign for (i, j), (k, n), sign in pairs)
    return sum(terms, next(iter(upper.values())) * 0)


def _determinants(rows: Sequence[Sequence[Number]]) -> list[Number]:
    """Return det and Cramer's numerators of four equations (coefficients of four unknowns, right-hand side)."""
    upper, lower = minors(rows[0], rows[1]), minors(rows[2], rows[3])
    columns = [0, 1, 2, 3]
    return [
        determinant(upper, lower, [4 if c == n else c for c in columns]) for n in (-1, *columns)
    ]
