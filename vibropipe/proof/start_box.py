"""All motions that begin at the section in a box of states, through their events and to a later section.

What depends on the start is enclosed by the mean value form: from its value at the centre and the balls of its
derivatives by the offsets c from there, each within -1 to 1. The time t of an event, where a gap g is 0, is enclosed by
Newton's method over balls [1]_: g(t_c) / g'(T) taken off t_c lies in T, so each start has exactly one such t in T.

References
----------
.. [1] R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, SIAM 2009, chapter 8.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from vibropipe.proof.balls import ZERO, arb, magnitude, total
from vibropipe.proof.equations import Flight
from vibropipe.proof.flights import Flights
from vibropipe.proof.law import Event, Kind, Piece
from vibropipe.proof.motion import MIN_SHARE, SHORTEST_OF_BOX, SIDES, FlightMotion

# Newton's steps at the centre, and attempts to enclose the time of an event, each with a larger radius.
NEWTON, ATTEMPTS, GROWTH = 8, 6, 1.5
# Shortest stretch of a short flight that is looked at, as a share of it.
SHORTEST_SHARE = 2.0**-8
# First radius of the time of an event at the centre, in forcing periods.
TINY = 2.0**-90


class Happening(NamedTuple):
    """An event of the motion from the centre, and about when it happens, in forcing periods."""

    time: float
    event: Event


class Moved(NamedTuple):
    """A quantity that depends on the start: at the centre, over the box, and its derivatives by the offsets."""

    centre: Any
    ball: Any
    slopes: Sequence[Any]

    @staticmethod
    def constant(value: Any) -> Moved:
        """Return a quantity that is the same for all starts."""
        return Moved(value, value, (ZERO, ZERO))

    @staticmethod
    def of(centre: Any, slopes: Sequence[Any], ball: Any = None) -> Moved:
        """Return a quantity from its derivatives; ball : what contains it, if something is known."""
        near = centre + arb(0, total(magnitude(a) for a in slopes))
        return Moved(centre, near if ball is None else near.intersection(ball), slopes)

    def times(self, factor: Any) -> Moved:
        """Return a multiple."""
        return Moved(self.centre * factor, self.ball * factor, [a * factor for a in self.slopes])


class _Departure(NamedTuple):
    """Where a flight begins: time in forcing periods, displacement from the origin of the piece, velocity."""

    time: Moved
    x: Moved
    v: Moved

    def slopes_at(self, piece: Flights, turns: Any) -> tuple[list[Any], list[Any]]:
        """Return the derivatives of x and x' by the offsets, `turns` after the start, at a time that is held."""
        flow, v = piece.flow(turns), self.v.ball
        a = piece.acceleration(self.time.ball, self.x.ball, v)
        x_t = -((flow.e11 * v + flow.e12 * a) * piece.period)
        v_t = -((flow.e21 * v + flow.e22 * a) * piece.period)
        by = list(zip(self.time.slopes, self.x.slopes, self.v.slopes, strict=True))
        return (
            [x_t * t + flow.e11 * x + flow.e12 * w for t, x, w in by],
            [v_t * t + flow.e21 * x + flow.e22 * w for t, x, w in by],
        )

    def at(self, piece: Flights, time: Any) -> tuple[Moved, Moved]:
        """Return displacement and velocity at a time."""
        slopes = self.slopes_at(piece, time - self.time.ball)
        ends = piece.fly(self.time.centre, time - self.time.centre, self.x.centre, self.v.centre)
        x, v = (Moved.of(end, each) for end, each in zip(ends, slopes, strict=True))
        return x, v


def image(
    model: Flights,
    centre: Sequence[Any],
    axes: Sequence[Sequence[Any]],
    piece: Piece,
    happened: Sequence[Happening],
    periods: int,
) -> tuple[Moved, Moved] | None:
    """Return the states at the section after some periods of all motions from a box; None if that is not proved.

    centre : balls x, x' of the centre, x from the equilibrium
    axes : what one unit of either offset adds to them
    piece : on which the motions begin
    happened : what the motion from the centre meets in turn; all from the box are shown to meet the same
    """  # fmt: skip
    section = Event(Kind.SECTION, 0, piece)
    x, v = (Moved.of(centre[n], [axis[n] for axis in axes]) for n in (0, 1))
    x = Moved(x.centre - model.on(piece).origin, x.ball - model.on(piece).origin, x.slopes)
    event, start = section, _Departure(Moved.constant(ZERO), x, v)
    for time, following in happened:
        met = _meet(model, event, start, following, time)
        if met is None:
            return None
        event, start = following, met
    on, end = model.on(event.after), arb(periods)
    turns = end - start.time.ball
    flight = Flight(event, section, start.time.ball, end, start.v.ball, turns)
    if not _stays(FlightMotion(model, flight, (start.x.ball, start.v.ball))):
        return None
    x, v = start.at(on, end)
    return Moved(x.centre + on.origin, x.ball + on.origin, x.slopes), v


def _meet(
    model: Flights, event: Event, start: _Departure, following: Event, guess: float
) -> _Departure | None:
    """Return the departures from the next event of a flight; None if it is not proved that all motions meet it."""
    on, support = model.on(event.after), following.support
    goal = ZERO if following.kind is Kind.LEAVES else model.position[support] - on.origin
    exact = _Departure(*(Moved.constant(each.centre) for each in start))
    near = _newton(on, exact, goal, guess)
    if near is None:
        return None
    centre = _enclosed(on, exact, goal, near)
    over = centre and _enclosed(on, start, goal, near, centre[0].ball)
    if not (centre and over):
        return None
    time, v = over[0], Moved.of(centre[1].ball, over[1].slopes, over[1].ball)
    side = SIDES[support] * (-1 if following.kind is Kind.LEAVES else 1)
    if not v.ball * side > 0:
        return None
    turns = _span(start.time, time)
    flight = Flight(event, following, start.time.ball, time.ball, v.ball, turns)
    motion = FlightMotion(model, flight, (start.x.ball, start.v.ball))
    is_sudden = event.kind is Kind.SECTION and not motion.least > 0
    if not (_falls(motion, support) if is_sudden else _stays(motion)):
        return None
    if following.kind is Kind.IMPACT:
        v = v.times(-model.restitution[support])
    at = ZERO if following.kind is Kind.ENTERS else model.position[support]
    return _Departure(time, Moved.constant(at), v)


def _stays(motion: FlightMotion) -> bool:
    """Return whether nothing happens on a flight; from a rigid support, at which starts may lie, it may depart."""
    if motion.flight.event.kind is Kind.SECTION:
        margins = motion.margins(motion.look(0.0, 0.0))
        touched = [key for key, margin in margins.items() if not margin.value > 0]
        motion.zero_at_start = touched[0] if len(touched) == 1 else ""
    return motion.leaves(min(SHORTEST_OF_BOX, motion.longest * SHORTEST_SHARE)) is False


def _falls(motion: FlightMotion, support: int) -> bool:
    """Return whether the mass nears a support all along a flight, which may be over at once."""
    margins = motion.margins(motion.look(0.0, motion.longest))
    return all(
        margin.slope < 0 if key == support else margin.value > 0 for key, margin in margins.items()
    )


def _span(start: Moved, end: Moved) -> Any:
    """Return the length of a flight, of which the balls of both times, which move together, may know less."""
    slopes = [b - a for a, b in zip(start.slopes, end.slopes, strict=True)]
    return Moved.of(end.centre - start.centre, slopes, end.ball - start.ball).ball


def _newton(on: Flights, start: _Departure, goal: Any, guess: float) -> Any:
    """Return about when the motion from the centre meets its next event, an exact number; None if it does not."""
    time = arb(guess)
    for _ in range(NEWTON):
        x, v = on.fly(start.time.centre, time - start.time.centre, start.x.centre, start.v.centre)
        if v.contains(0):
            return None
        step = ((x - goal) / (v * on.period)).mid()
        time = (time - step).mid()
        if abs(step) < TINY:
            return time
    return None


def _enclosed(
    on: Flights, start: _Departure, goal: Any, near: Any, centre: Any = None
) -> tuple[Moved, Moved] | None:
    """Return time and velocity of an event about a time; None if it is not proved that all motions have one there.

    centre : the time of the motion from the centre, a ball; None if there is no other one.
    """
    x, v = start.at(on, near)
    gap, middle = x.ball - goal, on.acceleration(near, x.ball, v.ball)
    if not gap.is_finite() or v.ball.contains(0):
        return None
    radius = magnitude(gap / (v.ball * on.period)) + arb(TINY)
    grows = on.rate_bound + on.stiffness * abs(v.ball)
    for _ in range(ATTEMPTS):
        radius = (radius * GROWTH).upper()
        r = (radius * on.period).upper()
        per_velocity = on.damping + on.stiffness * r
        share = 1 - per_velocity * r
        if not share > MIN_SHARE:
            return None
        bound = (abs(middle) + grows * r) / share
        rate = v.ball + arb(0, (bound * r).upper())
        if rate.contains(0):
            return None
        time = near - gap / (rate * on.period)
        if arb(near, radius).contains_interior(time):
            bend = middle + arb(0, ((grows + per_velocity * bound) * r).upper())
            return _with_slopes(on, start, time if centre is None else centre, time, rate, bend)
    return None


def _with_slopes(
    on: Flights, start: _Departure, centre: Any, time: Any, rate: Any, bend: Any
) -> tuple[Moved, Moved]:
    """Return time and velocity of an event over the box, with their derivatives.

    centre, time, rate, bend : balls of the time at the centre, and of time, velocity and acceleration over the box
    """
    met = Moved(centre, time, (ZERO, ZERO))
    turns = time - start.time.ball
    for _ in range(2):
        of_x, of_v = start.slopes_at(on, turns)
        slopes = [-(a / (rate * on.period)) for a in of_x]
        met = Moved.of(centre, slopes, time)
        turns = _span(start.time, met)
    of_rate = [a + bend * (on.period * t) for a, t in zip(of_v, slopes, strict=True)]
    return met, Moved(rate, rate, of_rate)
