"""An orbit as a zero of the equations of its impacts, proved by Krawczyk's test.

The unknowns u are the times t_i of the impacts (in forcing periods) and the velocities v_i before them. Over a box of
exciters, p = p0 + sum D_j c_j with |c_j| <= 1, they are sought as u0 + S (c - c0) + w: with the derivative F_u over the
tube and C near its inverse, the slopes S = -C F_c follow the orbit, and

    K(W) = -C (F(u0, c0) + (F_c + F_u S) (c - c0)) + (I - C F_u) W  within the interior of W

proves that, for each exciter of the box, the equations have exactly one zero in the tube W [1]_, [2]_.

References
----------
.. [1] R. Krawczyk, Newton-Algorithmen zur Bestimmung von Nullstellen mit Fehlerschranken, Computing 4 (1969) 187-201.
.. [2] R. E. Moore, A test for existence of solutions to nonlinear systems, SIAM Journal on Numerical Analysis 14 (1977)
   611-615.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from vibropipe.proof.balls import (
    BITS,
    ONE,
    ZERO,
    Jet,
    Number,
    arb,
    arb_mat,
    hull,
    magnitude,
    seed,
    total,
)
from vibropipe.proof.flights import Flights

MAX_NEWTON, MAX_INFLATIONS = 30, 12
# Share of the scale below which Newton's steps and the first radius of existence are.
STEP, RADIUS = 2.0 ** (20 - BITS), 2.0 ** (40 - BITS)
# Least factor by which the radius of uniqueness is known.
UNIQUENESS_STEP = 1.05


class Law(NamedTuple):
    """The law of an orbit: its forcing periods and the supports it strikes in turn."""

    m: int
    supports: tuple[int, ...]


class Flight(NamedTuple):
    """A flight of an orbit: from a support, at a time with a velocity before the impact, to the next one."""

    support: int
    next_support: int
    start: Number
    end: Number
    velocity: Number


class Box:
    """Exciters p0 + sum D_j c_j: the offsets c_j from `low` to `high`, within -1 to 1.

    Parameters
    ----------
    nominal : mapping of str to ball
        p0, exact numbers.
    directions : sequence of mapping of str to ball
        D_j, by parameter; none of an exciter alone.
    low, high : sequence of float
        Exact in few bits, as halves of halves of the box are.
    """

    def __init__(
        self,
        nominal: Mapping[str, Any],
        directions: Sequence[Mapping[str, Any]] = (),
        low: Sequence[float] = (),
        high: Sequence[float] = (),
    ) -> None:
        self.nominal, self.directions, self.low, self.high = nominal, directions, low, high
        self.middle = [(a + b) / 2 for a, b in zip(low, high, strict=True)]
        self.offsets = [hull(a, b) - c for a, b, c in zip(low, high, self.middle, strict=True)]
        self.centre = self.at(self.middle)
        self.balls = self.at([hull(a, b) for a, b in zip(low, high, strict=True)])

    def at(self, c: Sequence[Any]) -> dict[str, Any]:
        """Return the parameters at an offset."""
        moves = list(zip(self.directions, c, strict=True))
        return {
            name: value + total(d[name] * x for d, x in moves if name in d)
            for name, value in self.nominal.items()
        }

    def jets(self, n: int) -> dict[str, Number]:
        """Return the parameters over the box as functions of the offsets, the first of n variables."""
        k = len(self.directions)
        return {
            name: Jet(ball, [*(d.get(name, ZERO) for d in self.directions), *[ZERO] * (n - k)])
            if any(name in d for d in self.directions)
            else ball
            for name, ball in self.balls.items()
        }


class Orbit:
    """An orbit over a box of exciters: its approximation at the centre, and what is proved of it.

    Parameters
    ----------
    box : Box
    law : Law
    guess : sequence of ball
        Times and velocities of the impacts, in their order.

    Attributes
    ----------
    u : list of ball
        Times and velocities at the centre, exact numbers, refined from the guess.
    scale : list of ball
        What the radii of unknowns are shares of: a forcing period, the largest velocity.
    moved : float
        How far the guess was off, as a share of the scale; inf if Newton's method failed.
    radius, held, unique : list of ball
        Once proved: radii of the tubes that the orbit lies in, that it was found in, and in which there is no other.
    share : list of float
        Of each direction, what the width of the box adds to the residual of Krawczyk's test.
    tube : list of ball
        Once proved: times and velocities over the box.
    """

    def __init__(self, box: Box, law: Law, guess: Sequence[Any]) -> None:
        self.box, self.law, self.n = box, law, len(law.supports)
        self.u = [arb(value).mid() for value in guess]
        speed = max((abs(v) for v in self.u[self.n :]), key=float)
        self.scale = [ONE] * self.n + [speed] * self.n
        self.share = [0.0] * len(box.directions)
        self.moved = self._refine()
        self.radius: list[Any] = []
        self.held: list[Any] = []
        self.tube: list[Any] = []

    def _refine(self) -> float:
        """Refine the centre by Newton's method, set C and S, and return how far the guess was off."""
        guess, centre = self.u, Box(self.box.centre)
        try:
            for _ in range(MAX_NEWTON):
                by_u, _by_c = derivatives(centre, self.law, self.u)
                self.inverse = arb_mat(by_u).mid().inv().mid()
                values = residual(centre.balls, self.law, self.u)
                step = self.inverse * arb_mat([[value.mid()] for value in values])
                self.u = [(a - step[i, 0]).mid() for i, a in enumerate(self.u)]
                if all(abs(step[i, 0]) < s * STEP for i, s in enumerate(self.scale)):
                    break
        except (ZeroDivisionError, ValueError):
            return math.inf
        if not all(a.is_finite() for a in self.u):
            return math.inf
        self.at_centre = residual(self.box.centre, self.law, self.u)
        # S and C may be any numbers; good ones make the tube narrow
        middle = Box(self.box.centre, self.box.directions, *[[0.0] * len(self.share)] * 2)
        _by_u, by_c = derivatives(middle, self.law, self.u)
        moved = self.inverse * arb_mat(by_c) * -1 if self.share else arb_mat(2 * self.n, 0)
        self.slopes = [[a.mid() for a in row] for row in moved.tolist()]
        off = [abs(a - b) / s for a, b, s in zip(self.u, guess, self.scale, strict=True)]
        return max(float(each.upper()) for each in off)

    def tube_of(self, radius: Sequence[Any], offsets: Sequence[Any] | None = None) -> list[Any]:
        """Return u0 + S (c - c0) + [-radius, radius] at offsets c - c0; over the box without them."""
        moves = self.box.offsets if offsets is None else offsets
        return [
            u + arb(0, r) + total(s * c for s, c in zip(slopes, moves, strict=True))
            for u, r, slopes in zip(self.u, radius, self.slopes, strict=True)
        ]

    def krawczyk(self, radius: Sequence[Any]) -> tuple[list[Any], bool]:
        """Return K of a tube, and whether it lies inside."""
        size, moves = len(radius), self.box.offsets
        by_u, by_c = derivatives(self.box, self.law, self.tube_of(radius))
        jacobian = arb_mat(by_u)
        values = [[value] for value in self.at_centre]
        if moves:
            drift = arb_mat(by_c) + jacobian * arb_mat(self.slopes)
            added = (self.inverse * drift).tolist()
            self.share = [
                max(
                    float(magnitude(row[j] * move) / s)
                    for row, s in zip(added, self.scale, strict=True)
                )
                for j, move in enumerate(moves)
            ]
            values = [
                [a[0] + total(s * c for s, c in zip(row, moves, strict=True))]
                for a, row in zip(values, drift.tolist(), strict=True)
            ]
        w = [arb(0, r) for r in radius]
        identity = arb_mat([[int(i == j) for j in range(size)] for i in range(size)])
        image = (identity - self.inverse * jacobian) * arb_mat([[a] for a in w])
        image -= self.inverse * arb_mat(values)
        k = [image[i, 0] for i in range(size)]
        inside = all(a.is_finite() and b.contains_interior(a) for a, b in zip(k, w, strict=True))
        return k, inside

    def prove(self) -> bool:
        """Prove that the orbit exists, by a radius that grows until K lies inside."""
        if self.moved == math.inf:
            return False
        radius = [(s * RADIUS).upper() for s in self.scale]
        for _ in range(MAX_INFLATIONS):
            k, inside = self.krawczyk(radius)
            if inside:
                break
            if not all(
                a.is_finite() and magnitude(a) < s for a, s in zip(k, self.scale, strict=True)
            ):
                return False
            grown = zip(k, self.scale, strict=True)
            radius = [(magnitude(a) * 1.25 + s * RADIUS).upper() for a, s in grown]
        else:
            return False
        self.radius, self.held = [magnitude(a) for a in k], radius
        self.tube = self.tube_of(self.radius)
        return True

    @functools.cached_property
    def unique(self) -> list[Any]:
        """Radii of the largest tube found in which Krawczyk's test holds; its shape follows the image of the last."""
        unique = self.held
        shares = [a / s for a, s in zip(unique, self.scale, strict=True)]
        size = max(shares, key=float)
        shape = [a / size for a in unique]
        if not self.box.directions:  # the radius of rounding says nothing of the shape
            size, shape = arb(2.0**-40), self.scale
        factor, found = 4.0, False
        while factor > UNIQUENESS_STEP:
            trial = [(a * size * factor).upper() for a in shape]
            k, inside = self.krawczyk(trial)
            if inside:
                unique, size, found = trial, size * factor, True
                images = [magnitude(a) / s for a, s in zip(k, self.scale, strict=True)]
                top = max(images, key=float)
                if float(top) > 0:
                    pairs = zip(k, self.scale, strict=True)
                    shape = [(magnitude(a) / top + s / 50).upper() for a, s in pairs]
            elif found or factor < 4.0:
                factor = factor**0.5
            else:
                break
        return unique

    def uniqueness_radius(self) -> Any:
        """Return a ball of the share of the scale within which there is certainly no other orbit of this law."""
        radii = zip(self.unique, self.radius, self.scale, strict=True)
        shares = [(a - b) / s for a, b, s in radii]
        return functools.reduce(lambda a, b: a.min(b), shares)


def end_of(model: Flights, flight: Flight) -> tuple[Number, Number]:
    """Return displacement and velocity at the end of a flight."""
    leaving = -(model.restitution[flight.support] * flight.velocity)
    turns = flight.end - flight.start
    return model.fly(flight.start, turns, model.position[flight.support], leaving)


def flights_of(law: Law, u: Sequence[Number]) -> Iterator[tuple[int, int, Flight]]:
    """Yield each flight with the indices of the impacts at its ends."""
    n = len(law.supports)
    for i in range(n):
        j = (i + 1) % n
        end = u[j] + law.m if j <= i else u[j]
        yield i, j, Flight(law.supports[i], law.supports[j], u[i], end, u[n + i])


def residual(p: Mapping[str, Any], law: Law, u: Sequence[Any]) -> list[Any]:
    """Return the equations: each flight ends at the next support with the next velocity."""
    model, rows, n = Flights(p), [], len(law.supports)
    for _i, j, flight in flights_of(law, u):
        x, v = end_of(model, flight)
        rows += [x - model.position[flight.next_support], v - u[n + j]]
    return rows


def derivatives(box: Box, law: Law, u: Sequence[Any]) -> tuple[list[list[Any]], list[list[Any]]]:
    """Return the derivatives of the equations over a box, by u and by the offsets."""
    n, k = len(law.supports), len(box.directions)
    model = Flights(box.jets(k + 3))
    by_u = [[ZERO] * (2 * n) for _ in range(2 * n)]
    by_c = []
    for i, j, flight in flights_of(law, u):
        jets = (seed(a, k + index, k + 3) for index, a in enumerate(flight[2:]))
        x, v = end_of(model, Flight(flight.support, flight.next_support, *jets))
        for row, value in ((2 * i, x - model.position[flight.next_support]), (2 * i + 1, v)):
            by_c.append(value.slopes[:k])
            for column, slope in zip((i, j, n + i), value.slopes[k:], strict=True):
                by_u[row][column] += slope
        by_u[2 * i + 1][n + j] -= 1
    return by_u, by_c
