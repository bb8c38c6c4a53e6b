"""An orbit as a zero of the equations of its events, proved by Krawczyk's test.

The unknowns u are the times t_i of the events (in forcing periods) and what each leaves free: the velocity v_i before
it at a support, the displacement where friction turns or holds the mass. Over a box of exciters, p = p0 + sum D_j c_j
with |c_j| <= 1, they are sought as u0 + S (c - c0) + w: with the derivative F_u over the tube and C near its inverse,
the slopes S = -C F_c follow the orbit, and

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
from collections.abc import Sequence
from typing import Any

from vibropipe.proof.balls import BITS, Box, arb, arb_mat, magnitude, total
from vibropipe.proof.equations import Spread, derivatives, scale_of
from vibropipe.proof.law import Law

MAX_NEWTON, MAX_INFLATIONS = 30, 12
# Share of the scale below which Newton's steps and the first radius of existence are.
STEP, RADIUS = 2.0 ** (20 - BITS), 2.0 ** (40 - BITS)
# Least factor by which the radius of uniqueness is known.
UNIQUENESS_STEP = 1.05


class Orbit:
    """An orbit over a box of exciters: its approximation at the centre, and what is proved of it.

    guess : balls, times of the events and what each leaves free, in their order
    u : balls, times and what is free at the centre, exact numbers, refined from the guess
    scale : what the radii of unknowns are shares of: a forcing period, the largest velocity, l of a displacement
    moved : how far the guess was off, as a share of the scale; inf if Newton's method failed
    radius, held, unique : once proved: radii of the tubes that the orbit lies in, that it was found in, and in which
        there is no other
    share : of each direction, what the width of the box adds to the residual of Krawczyk's test
    tube, lengths : once proved: the unknowns over the box, and the lengths of the flights
    """

    def __init__(self, box: Box, law: Law, guess: Sequence[Any]) -> None:
        self.box, self.law, self.n = box, law, len(law.events)
        self.u = [arb(value).mid() for value in guess]
        self.scale = scale_of(law, self.u, box.centre["l"])
        self.share = [0.0] * len(box.directions)
        self.moved = self._refine()
        self.radius: list[Any] = []
        self.held: list[Any] = []
        self.tube: list[Any] = []
        self.lengths: list[Any] = []

    def _refine(self) -> float:
        """Refine the centre by Newton's method, set C and S, and return how far the guess was off."""
        guess, centre = self.u, Box(self.box.centre)
        try:
            for _ in range(MAX_NEWTON):
                found = derivatives(centre, self.law, self.u)
                self.inverse = arb_mat(found.by_u).mid().inv().mid()
                step = self.inverse * arb_mat([[value.mid()] for value in found.values])
                self.u = [(a - step[i, 0]).mid() for i, a in enumerate(self.u)]
                if all(abs(step[i, 0]) < s * STEP for i, s in enumerate(self.scale)):
                    break
        except (ZeroDivisionError, ValueError):
            return math.inf
        if not all(a.is_finite() for a in self.u):
            return math.inf
        # S and C may be any numbers; good ones make the tube narrow
        middle = Box(self.box.centre, self.box.directions, *[[0.0] * len(self.share)] * 2)
        found = derivatives(middle, self.law, self.u)
        self.at_centre, self.ends = found.values, found.ends
        moved = self.inverse * arb_mat(found.by_c) * -1 if self.share else arb_mat(2 * self.n, 0)
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

    def lengths_of(self, radius: Sequence[Any]) -> list[Any]:
        """Return the lengths of the flights over the box in such a tube."""
        lengths = []
        for i in range(self.n):
            j = (i + 1) % self.n
            length = self.u[j] - self.u[i] + (self.law.m if j <= i else 0)
            drifts = zip(self.slopes[i], self.slopes[j], self.box.offsets, strict=True)
            length = length + total((late - early) * c for early, late, c in drifts)
            lengths.append(length if i == j else length + arb(0, radius[i] + radius[j]))
        return lengths

    def krawczyk(self, radius: Sequence[Any]) -> tuple[list[Any], bool]:
        """Return K of a tube, and whether it lies inside."""
        size, moves = len(radius), self.box.offsets
        spread = Spread(self.slopes, radius, moves, self.lengths_of(radius), self.ends)
        found = derivatives(self.box, self.law, self.tube_of(radius), spread)
        jacobian = arb_mat(found.by_u)
        values = [[value] for value in self.at_centre]
        if moves:
            drift = arb_mat(found.drift)
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
        self.tube, self.lengths = self.tube_of(self.radius), self.lengths_of(self.radius)
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
