"""All orbits with three impacts of one exciter, by branch and bound in the lengths of two flights.

Given the lengths s of the flights, each velocity is linear in the first one and in the parts of the force in and out of
phase, alpha + i beta = f exp(i 2 pi t_1), without a division. Four linear equations are left for v_1, alpha and beta:
three flights end at their supports, and the last velocity is the first. They have a solution with the given force only
where the determinant of all four vanishes and, with Cramer's rule for any three,

    G(s) = 0,   g_k(s) = N_alpha^2 + N_beta^2 - f^2 D^2 = 0.

A flight that returns to its support is divided by its length: where that is 0, no solution is made up. A box of s is
left out where one of these has no zero, or where an impact has a velocity away from its support; or it lies where a
proved orbit is the only one; or it is cut.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from vibropipe.proof.balls import BITS, ONE, ZERO, Box, Jet, Number, arb, ball_of, ctx, hull
from vibropipe.proof.every import CUT, Found, proved_orbit, strikes
from vibropipe.proof.law import Law
from vibropipe.proof.linear import Equations, determinant, minors
from vibropipe.proof.motion import is_no_motion
from vibropipe.proof.orbit import Orbit
from vibropipe.words.progress import Progress
from vibropipe.words.proofs import Why

# The search begins with so many intervals in either direction; boxes shorter than this, in forcing periods, are given
# up, and from the second size on an orbit is sought in them. Bits of their balls.
FIRST_INTERVALS, SHORTEST, SOUGHT, SEARCH_BITS = 16, 2.0**-30, 2.0**-5, 64
# Steps of the progress that is told.
STEPS = 1000
# Columns of v_1, alpha, beta and of the constant part in the equations.
V, ALPHA, BETA, ONE_COLUMN = range(4)
Row = Sequence[Number]


class Linear(NamedTuple):
    """The equations at some lengths, rows of (v_1, alpha, beta, 1) whose sum is 0, and the velocities as such rows."""

    rows: Sequence[Row]
    velocities: Sequence[Row]


class Pair(NamedTuple):
    """A box of the lengths of the first two flights."""

    low: tuple[float, float]
    high: tuple[float, float]

    @property
    def size(self) -> float:
        """Its longer side."""
        return max(b - a for a, b in zip(self.low, self.high, strict=True))

    @property
    def area(self) -> float:
        """Its area."""
        return math.prod(b - a for a, b in zip(self.low, self.high, strict=True))

    @property
    def balls(self) -> list[Any]:
        """Balls of both lengths."""
        return [hull(a, b) for a, b in zip(self.low, self.high, strict=True)]

    @property
    def middle(self) -> list[Any]:
        """The lengths in its middle, exact."""
        return [arb((a + b) / 2) for a, b in zip(self.low, self.high, strict=True)]

    def halves(self) -> list[Pair]:
        """Return it cut across its longer side."""
        axis = int(self.high[1] - self.low[1] > self.high[0] - self.low[0])
        cut = self.low[axis] + (self.high[axis] - self.low[axis]) * CUT

        def moved(ends: tuple[float, float]) -> tuple[float, float]:
            return (cut, ends[1]) if axis == 0 else (ends[0], cut)

        return [Pair(self.low, moved(self.high)), Pair(moved(self.low), self.high)]


def three_impacts(
    p: Mapping[str, Any],
    law: tuple[int, int, int],
    harmonics: int,
    limit: int,
    progress: Progress | None = None,
) -> Found:
    """Return all orbits of a law (m, 2, 1) or (m, 1, 2) of one exciter; arguments as of `every.all_orbits`.

    progress : called as progress(done, total), in shares of all lengths.
    """
    m, p1, _p2 = law
    search = _Search(Equations(p, m), Law.of_impacts(m, (1, 1, 2) if p1 == 2 else (2, 2, 1)))
    step = m / FIRST_INTERVALS
    corners = [(i, j) for i in range(FIRST_INTERVALS) for j in range(FIRST_INTERVALS - i)]
    stack = [Pair((i * step, j * step), ((i + 1) * step, (j + 1) * step)) for i, j in corners]
    found, looked, done = Found([], Why.NONE, 0), 0, 0.0
    whole = sum(box.area for box in stack)
    while stack and looked < limit:
        box = stack.pop()
        if sum(box.low) >= m:
            done += box.area
            continue
        looked += 1
        with ctx.workprec(SEARCH_BITS):
            has_none = search.has_none(box)
        if has_none or box.size < SHORTEST:
            done += box.area
            if progress is not None:
                progress(int(STEPS * done / whole), STEPS)
        if has_none:
            continue
        if box.size < SHORTEST:
            found.why = Why.EXISTENCE
        else:
            stack += box.halves()
    found.looked = looked
    if stack:
        found.why = Why.PARTS
    for orbit in search.motions:
        found.take(partial(proved_orbit, search.equations, search.law, orbit.u, harmonics))
    return found


class _Search:
    """The orbits that were found, and what excludes others from a box."""

    def __init__(self, equations: Equations, law: Law) -> None:
        self.equations, self.law = equations, law
        self.orbits: list[Orbit] = []
        self.motions: list[Orbit] = []

    def has_none(self, box: Pair) -> bool:
        """Return whether a box certainly has no orbit but those that were found, of which one may be found now."""
        s1, s2 = box.balls
        over = self.linear(Jet(s1, [ONE, ZERO]), Jet(s2, [ZERO, ONE]))
        middle = box.middle
        at = self.linear(*middle) if sum(map(float, middle)) < self.law.m else None
        off = [s - c for s, c in zip((s1, s2), middle, strict=True)]

        def is_never_zero(jet: Jet, value: Any) -> bool:
            if not jet.value.contains(0):
                return True
            moves = zip(jet.slopes, off, strict=True)
            return value is not None and not sum((a * b for a, b in moves), value).contains(0)

        if is_never_zero(_det4(over.rows), None if at is None else _det4(at.rows)):
            return True
        force, was_sought = self.equations.force, at is None or box.size >= SOUGHT
        for k in range(4):
            solved = _solved(over.rows, k)
            known = None if at is None else _excess(_solved(at.rows, k), force)
            if is_never_zero(_excess(solved, force), known):
                return True
            if not solved[0].value.contains(0):
                unknowns = self.unknowns([each.value for each in solved], over, s1, s2)
                if strikes(unknowns[3:], self.law.supports) is False:
                    return True
                if any(_is_within(unknowns, orbit) for orbit in self.orbits):
                    return True
                if at is not None and not was_sought:
                    was_sought, orbit = True, self.seek(at, k, middle)
                    if orbit is not None and _is_within(unknowns, orbit):
                        return True
        return False

    def linear(self, s1: Number, s2: Number) -> Linear:
        """Return the equations at lengths of the first two flights."""
        lengths, starts = [s1, s2, self.law.m - s1 - s2], [s1 * 0, s1, s1 + s2]
        velocity: Row = [ONE, ZERO, ZERO, ZERO]
        rows, velocities, supports = list[Row](), list[Row](), self.law.supports
        for i, (of, to) in enumerate(zip(supports, [*supports[1:], supports[0]], strict=True)):
            velocities.append(velocity)
            own, arriving = (
                [
                    row[0] * velocity[0],
                    *(row[0] * a + b for a, b in zip(velocity[1:], rest, strict=True)),
                ]
                for row, rest in (
                    (row, (row[1], row[2], -row[3]))
                    for row in self.equations.flight(starts[i], lengths[i], of, to)
                )
            )
            rows.append(self.per_length(own, arriving, lengths[i]) if of == to else own)
            velocity = arriving
        rows.append([velocity[0] - 1, *velocity[1:]])
        return Linear(rows, velocities)

    def per_length(self, row: Row, arriving: Row, length: Number) -> Row:
        """Return the row of a flight that returns to its support, divided by its length, which may be 0.

        The row is the integral of the velocity: over all lengths from 0 on, its mean, and half the slope of that.
        """
        if not ball_of(length).contains(0):
            return [each / length for each in row]
        period = self.equations.model.period
        return [
            Jet(each.value * period, [each.slopes[0] * period / 2, each.slopes[1] * period])
            if type(each) is Jet
            else each * period
            for each in arriving
        ]

    def unknowns(self, solved: Sequence[Any], linear: Linear, s1: Any, s2: Any) -> list[Any]:
        """Return times and velocities of the impacts from Cramer's determinants."""
        D, *w = solved
        v, alpha, beta = (each / D for each in w)
        first = self.equations.time_of(alpha, beta)
        velocities = []
        for row in linear.velocities:
            of_v, of_alpha, of_beta, rest = map(ball_of, row)
            velocities.append(of_v * v + of_alpha * alpha + of_beta * beta + rest)
        return [first, first + s1, first + s1 + s2, *velocities]

    def seek(self, at: Linear, k: int, middle: Sequence[Any]) -> Orbit | None:
        """Return an orbit that Newton's method finds from some lengths, proved and new; None without one."""
        solved = _solved(at.rows, k)
        if solved[0].contains(0):
            return None
        guess = [a.mid() for a in self.unknowns(solved, at, *middle)]
        if not all(a.is_finite() for a in guess):
            return None
        with ctx.workprec(BITS):
            orbit = Orbit(Box(self.equations.p), self.law, guess)
            if not (orbit.moved < SOUGHT and orbit.prove()):
                return None
            if not any(_is_within(orbit.tube, known) for known in self.orbits):
                self.orbits.append(orbit)
                if is_no_motion(orbit) is not True:
                    self.motions.append(orbit)
        return orbit


def _is_within(unknowns: Sequence[Any], orbit: Orbit) -> bool:
    """Return whether unknowns, moved by whole forcing periods, lie where an orbit is the only one."""
    n = orbit.n
    if not all(a.is_finite() for a in unknowns):
        return False
    turns = round(float((orbit.u[0] - unknowns[0]).mid()))
    moved = [a + turns if i < n else a for i, a in enumerate(unknowns)]
    return all(a.contains(b) for a, b in zip(orbit.tube_of(orbit.unique), moved, strict=True))


def _excess(solved: Sequence[Number], force: Any) -> Number:
    """Return N_alpha^2 + N_beta^2 - f^2 D^2."""
    D, _v, alpha, beta = solved
    return alpha * alpha + beta * beta - D * D * (force * force)


def _solved(rows: Sequence[Row], left_out: int) -> list[Number]:
    """Return D, N_v, N_alpha, N_beta of the equations without one."""
    three = [row for i, row in enumerate(rows) if i != left_out]
    replaced = [(V, ALPHA, BETA), (ONE_COLUMN, ALPHA, BETA), (V, ONE_COLUMN, BETA)]
    replaced.append((V, ALPHA, ONE_COLUMN))
    D, *others = (_det3(three, columns) for columns in replaced)
    return [D, *(-each for each in others)]


def _det3(rows: Sequence[Row], columns: Sequence[int]) -> Number:
    """Return the determinant of three columns of three rows."""
    (a, b, c), (i, j, k) = rows, columns
    first, second, third = (b[n] * c[q] - b[q] * c[n] for n, q in ((j, k), (i, k), (i, j)))
    return a[i] * first - a[j] * second + a[k] * third


def _det4(rows: Sequence[Row]) -> Number:
    """Return the determinant of four rows."""
    return determinant(minors(rows[0], rows[1]), minors(rows[2], rows[3]), range(4))
