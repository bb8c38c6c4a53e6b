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
    ball_of,
    hull,
    magnitude,
    total,
)
from vibropipe.proof.flights import Flights
from vibropipe.proof.law import Event, Kind, Law

MAX_NEWTON, MAX_INFLATIONS = 30, 12
# Share of the scale below which Newton's steps and the first radius of existence are.
STEP, RADIUS = 2.0 ** (20 - BITS), 2.0 ** (40 - BITS)
# Least factor by which the radius of uniqueness is known.
UNIQUENESS_STEP = 1.05


class Flight(NamedTuple):
    """A piece of an orbit: from an event, at a time with what it leaves free, to the next one.

    turns : its length in forcing periods, of which the balls of both times, which move together, may know less.
    """

    event: Event
    next_event: Event
    start: Number
    end: Number
    free: Number
    turns: Number


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

    @property
    def share(self) -> float:
        """Its share of the box with all offsets from -1 to 1."""
        return math.prod((b - a) / 2 for a, b in zip(self.low, self.high, strict=True))

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
        Times of the events and what each leaves free, in their order.

    Attributes
    ----------
    u : list of ball
        Times and what is free at the centre, exact numbers, refined from the guess.
    scale : list of ball
        What the radii of unknowns are shares of: a forcing period, the largest velocity, l of a displacement.
    moved : float
        How far the guess was off, as a share of the scale; inf if Newton's method failed.
    radius, held, unique : list of ball
        Once proved: radii of the tubes that the orbit lies in, that it was found in, and in which there is no other.
    share : list of float
        Of each direction, what the width of the box adds to the residual of Krawczyk's test.
    tube, lengths : list of ball
        Once proved: the unknowns over the box, and the lengths of the flights.
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


def scale_of(law: Law, u: Sequence[Any], length: Any) -> list[Any]:
    """Return what radii of unknowns are shares of: a forcing period, the largest velocity, a length."""
    n = len(law.events)
    frees = list(zip(law.events, u[n:], strict=True))
    speed = max((abs(v) for event, v in frees if event.kind.is_at_support), key=float)
    return [ONE] * n + [speed if event.kind.is_at_support else length for event, _ in frees]


def start_of(model: Flights, flight: Flight) -> tuple[Number, Number]:
    """Return displacement, from the origin of the piece, and velocity right after the event a flight begins with."""
    kind, support, _after = flight.event
    if kind is Kind.IMPACT:
        return model.position[support], -(model.restitution[support] * flight.free)
    if kind is Kind.ENTERS:
        return flight.free * 0, flight.free
    if kind is Kind.LEAVES:
        return model.position[support], flight.free
    return flight.free, flight.free * 0


def end_of(model: Flights, flight: Flight) -> tuple[Number, Number]:
    """Return displacement, from the origin of its piece, and velocity at the end of a flight."""
    piece, (x, v) = model.on(flight.event.after), start_of(model, flight)
    return piece.fly(flight.start, flight.turns, x, v)


def conditions(model: Flights, flight: Flight, x: Number, v: Number) -> tuple[Number, Number]:
    """Return what is 0 where a flight that ends in a state meets its next event, and what that event leaves free."""
    kind, support, after = flight.next_event
    if kind.is_at_support:
        return x if kind is Kind.LEAVES else x - model.position[support], v
    if kind is Kind.SLIPS:  # the friction no longer holds
        return model.on(after).acceleration(flight.end, x), x
    return v, x


def flights_of(
    law: Law, u: Sequence[Number], lengths: Sequence[Any] | None = None
) -> Iterator[tuple[int, int, Flight]]:
    """Yield each flight with the indices of the events at its ends; lengths : of the flights, if they are known."""
    n = len(law.events)
    for i in range(n):
        j = (i + 1) % n
        end = u[j] + law.m if j <= i else u[j]
        turns = end - u[i]
        if lengths is not None:
            turns = Jet(lengths[i], turns.slopes) if type(turns) is Jet else lengths[i]
        yield i, j, Flight(law.events[i], law.events[j], u[i], end, u[n + i], turns)


def residual(p: Mapping[str, Any], law: Law, u: Sequence[Any]) -> list[Any]:
    """Return the equations: each flight meets the next event with what that leaves free."""
    model, rows, n = Flights(p), [], len(law.events)
    for _i, j, flight in flights_of(law, u):
        met, free = conditions(model, flight, *end_of(model, flight))
        rows += [met, free - u[n + j]]
    return rows


class Gradient(NamedTuple):
    """Derivatives of a number at the end of a flight, by its start, its end, what is free at its start, and its phase.

    The last, by both times at once, is the sum of the first two, whose balls do not know how they cancel.
    """

    start: Any
    end: Any
    free: Any
    phase: Any

    def along(self, of_start: Any, of_end: Any, of_free: Any) -> Any:
        """Return the change of the number as start, end and what is free change."""
        apart = self.start * of_start + self.end * of_end
        at_once = self.phase * of_start + self.end * (of_end - of_start)
        of_times = apart.intersection(at_once) if apart.is_finite() else at_once
        return of_times + self.free * of_free


def derivatives(box: Box, law: Law, u: Sequence[Any], spread: Spread | None = None) -> Derivatives:
    """Return the derivatives of the equations over a box.

    spread : how far u lies from the centre of a tube, by which the states at the ends of flights are known better.
    """
    n, k = len(law.events), len(box.directions)
    model, over_box = Flights(box.balls), Flights(box.jets(k))
    found = Derivatives([], [], [[ZERO] * (2 * n) for _ in range(2 * n)], [], [])
    lengths = None if spread is None else spread.lengths
    for i, j, flight in flights_of(law, u, lengths):
        columns, kind = (i, j, n + i), flight.next_event.kind
        ends = end_of(over_box, flight)
        x1, v1 = map(ball_of, ends)
        found.ends.append((x1, v1))
        of_x, of_v = gradients(model, flight, x1, v1, has_phase=k > 0)
        if spread is not None and k > 0:
            near = [
                spread.narrowed(end, at, by, columns)
                for end, at, by in zip(ends, spread.ends[i], (of_x, of_v), strict=True)
            ]
            rates = end_rates(model, flight, *near)
            of_x, of_v = of_x._replace(end=rates[0]), of_v._replace(end=rates[1])
        if kind is Kind.SLIPS:
            slope = model.on(flight.next_event.after).stiffness
            rate = model.force_rate(flight.end) * model.period
            by = [-(slope * a) for a in of_x]
            of_met, of_free = Gradient(by[0], by[1] + rate, by[2], by[3] + rate), of_x
        else:
            of_met, of_free = (of_x, of_v) if kind.is_at_support else (of_v, of_x)
        pairs = zip((of_met, of_free), conditions(over_box, flight, *ends), (0, 1), strict=True)
        for gradient, value, is_free in pairs:
            found.values.append(ball_of(value) - u[n + j] * is_free)
            for column, slope in zip(columns, gradient, strict=False):
                found.by_u[2 * i + is_free][column] += slope
            own = [*value.slopes] if type(value) is Jet else [ZERO] * k
            found.by_c.append(own)
            if spread is not None:
                found.drift.append(
                    [
                        own[c]
                        + gradient.along(*(spread.slopes[column][c] for column in columns))
                        - spread.slopes[n + j][c] * is_free
                        for c in range(k)
                    ]
                )
        found.by_u[2 * i + 1][n + j] -= 1
    return found


class Derivatives(NamedTuple):
    """The equations and the states at the ends of flights, over a box, and the derivatives of the equations.

    by_u, by_c, drift : by u, by the offsets, and by these as u follows them.
    """

    values: list[Any]
    ends: list[tuple[Any, Any]]
    by_u: list[list[Any]]
    by_c: list[list[Any]]
    drift: list[list[Any]]


def end_rates(model: Flights, flight: Flight, x1: Any, v1: Any) -> tuple[Any, Any]:
    """Return the derivatives of x and x' at the end of a flight by that end; x1, v1 : balls of them."""
    piece, period = model.on(flight.event.after), model.period
    if piece.piece.is_held:
        return ZERO, ZERO
    return v1 * period, piece.acceleration(flight.end, x1, v1) * period


def gradients(
    model: Flights, flight: Flight, x1: Any, v1: Any, has_phase: bool
) -> tuple[Gradient, Gradient]:
    """Return the derivatives of x and x' at the end of a flight; x1, v1 : balls of them.

    has_phase : whether the derivatives by the phase are wanted; else they are 0.
    """
    piece = model.on(flight.event.after)
    if piece.piece.is_held:
        return Gradient(ZERO, ZERO, ONE, ZERO), Gradient(ZERO, ZERO, ZERO, ZERO)
    flow, period = piece.flow(flight.turns), model.period
    x0, v0 = start_of(model, flight)
    a0, (end_x, end_v) = piece.acceleration(flight.start, x0, v0), end_rates(model, flight, x1, v1)
    kind, support, _after = flight.event
    free_x, free_v = (flow.e12, flow.e22) if kind.is_at_support else (flow.e11, flow.e21)
    if kind is Kind.IMPACT:
        R = model.restitution[support]
        free_x, free_v = -(R * free_x), -(R * free_v)
    start_x = -((flow.e11 * v0 + flow.e12 * a0) * period)
    start_v = -((flow.e21 * v0 + flow.e22 * a0) * period)
    phase_x, phase_v = ZERO, ZERO
    if has_phase:
        phase_x, phase_v = piece.by_phase(flight.start, flight.turns, flow)
    return Gradient(start_x, end_x, free_x, phase_x), Gradient(start_v, end_v, free_v, phase_v)


class Spread(NamedTuple):
    """How the unknowns of a tube move with the offsets, and the states at the ends of the flights at its centre."""

    slopes: Sequence[Sequence[Any]]
    radius: Sequence[Any]
    offsets: Sequence[Any]
    lengths: Sequence[Any]
    ends: Sequence[tuple[Any, Any]]

    def narrowed(self, end: Number, at: Any, by_u: Gradient, columns: Sequence[int]) -> Any:
        """Return a number at the end of a flight over the tube by the mean value form, in which its parts cancel.

        end : as computed, with its slopes by the offsets; at : at the centre; by_u : derivatives by the unknowns.
        """
        if type(end) is not Jet:
            end = Jet(end, [ZERO] * len(self.offsets))
        off = zip(by_u, columns, strict=False)
        moved = at + total(slope * arb(0, self.radius[n]) for slope, n in off)
        for k, (offset, own) in enumerate(zip(self.offsets, end.slopes, strict=True)):
            moved = moved + (own + by_u.along(*(self.slopes[n][k] for n in columns))) * offset
        return moved.intersection(end.value) if moved.is_finite() else end.value
