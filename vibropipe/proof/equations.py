"""The equations of an orbit: each of its pieces meets the next event. Their derivatives over a box of exciters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from vibropipe.proof.balls import ONE, ZERO, Box, Jet, Number, arb, ball_of, total
from vibropipe.proof.flights import Flights
from vibropipe.proof.law import Event, Kind, Law


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
