"""Whether an orbit is a motion: no piece leaves what it holds within before its end.

In flight the mass keeps off both supports, in contact it is beyond its own; with friction the velocity keeps its sign,
or the forces stay below the friction. Each such margin is positive on a piece, but for the one that is 0 at an event:
it rises after it, or falls before it, as long as its derivative certainly has one sign. Between these two stretches
bisection keeps all margins positive. On a stretch of half length r about its middle c, with x''' = F' - K x' - H x'',

    |x''| <= A,   A (1 - H r - K r^2) = |x''(c)| + r (max |F'| + K |x'(c)|)

and x, x' lie about their Taylor polynomials from c.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

from vibropipe.proof.balls import ZERO, arb, round_down, round_up
from vibropipe.proof.equations import Flight, flights_of, start_of
from vibropipe.proof.flights import Flights
from vibropipe.proof.law import Event, Kind, Law, Piece
from vibropipe.proof.orbit import Orbit

# Shortest stretch that is looked at, in forcing periods: of one exciter and of a box, which is split instead.
SHORTEST, SHORTEST_OF_BOX = 2.0**-30, 2.0**-12
# Stretches of a flight that are looked at; h = 1000 takes some 1e4.
MAX_STRETCHES = 20_000
# More than phases are off by rounding, in forcing periods.
ROUNDING = 2.0**-40
# A stretch is too long for Picard's inequality where this share is not left.
MIN_SHARE = 0.25
# Directions in which the supports lie, and the names of margins that friction asks for.
SIDES = {1: 1, 2: -1}
VELOCITY, HOLD = "velocity", "hold"


class Stretch(NamedTuple):
    """What certainly holds on a stretch of a flight.

    x, v : balls, displacement from the origin of the piece and velocity in its middle
    around, rate, acceleration, jerk : x, x', x'' and, with friction, the derivative of that; of a mass that is held as
        if there were no friction
    """

    x: Any
    v: Any
    around: Any
    rate: Any
    acceleration: Any
    jerk: Any


class Margin(NamedTuple):
    """What is positive on a piece: balls of its value, of two derivatives, and of its value in the middle."""

    value: Any
    slope: Any
    bend: Any
    middle: Any


class FlightMotion:
    """The motion of a flight over the times since its departure, in forcing periods; start : if it is at no event."""

    def __init__(
        self, model: Flights, flight: Flight, start: tuple[Any, Any] | None = None
    ) -> None:
        self.flight, self.model = flight, model.on(flight.event.after)
        self.x, self.v = start_of(model, flight) if start is None else start
        self.least, self.longest = round_down(flight.turns), round_up(flight.turns)
        self.zero_at_start = _margin_at(flight.event, self.model.piece)
        self.zero_at_end = _margin_at(flight.next_event, self.model.piece)

    def look(self, low: float, high: float) -> Stretch:
        """Return what holds from `low` to `high`."""
        model, c = self.model, arb((low + high) / 2)
        r = ((arb(high) - c).max(c - arb(low)) * model.period).upper()
        if model.piece.is_held:
            times = self.flight.start + c + arb(0, r) / model.period
            push = model.acceleration(times, self.x)
            return Stretch(self.x, ZERO, self.x, ZERO, push, model.force_rate(times))
        x, v = model.fly(self.flight.start, c, self.x, self.v)
        per_velocity = model.damping + model.stiffness * r
        share = 1 - per_velocity * r
        if not share > MIN_SHARE:
            unknown = arb(0, arb.pos_inf())
            return Stretch(x, v, unknown, unknown, unknown, unknown)
        middle = model.acceleration(self.flight.start + c, x, v)
        grows = model.rate_bound + model.stiffness * abs(v)
        bound = ((abs(middle) + grows * r) / share).upper()
        around = x + v * arb(0, r) + arb(0, bound * r * r / 2)
        rate = v + arb(0, bound * r)
        acceleration = middle + arb(0, ((grows + per_velocity * bound) * r).upper())
        jerk = ZERO
        if model.piece.way:
            times = self.flight.start + c + arb(0, r) / model.period
            jerk = model.force_rate(times) - model.stiffness * rate - model.damping * acceleration
        return Stretch(x, v, around, rate, acceleration, jerk)

    def margins(self, at: Stretch) -> dict[int | str, Margin]:
        """Return what is positive on a stretch: gaps, by their supports, and what friction asks for."""
        model, piece, found = self.model, self.model.piece, dict[int | str, Margin]()
        for support, side in SIDES.items():
            if support == piece.contact:
                way, gaps = -side, (at.around * side, at.x * side)
            else:
                b = model.position[support] - model.origin
                way, gaps = side, ((b - at.around) * side, (b - at.x) * side)
            found[support] = Margin(gaps[0], at.rate * -way, at.acceleration * -way, gaps[1])
        if piece.is_held:
            for way in (1, -1):
                rest = model.p["friction"] - at.acceleration * way
                # its ball on the whole stretch, in place of one in the middle
                found[f"{HOLD} {way}"] = Margin(rest, at.jerk * -way, ZERO, rest)
        elif piece.way:
            found[VELOCITY] = Margin(
                at.rate * piece.way,
                at.acceleration * piece.way,
                at.jerk * piece.way,
                at.v * piece.way,
            )
        return found

    def leaves(self, shortest: float, touch: Any = None) -> bool | None:
        """Return False: all margins certainly stay positive; True: one does not; None: undecided.

        At the time `touch`, a ball, it is known to turn at a support, which is no impact.
        """
        if not self.least > 0:
            return True if self.longest < 0 else None
        first, last, count = self._monotone(shortest)
        stack = [(first, last)] if first < last else []
        while stack:
            low, high = stack.pop()
            count += 1
            margins = self.margins(self.look(low, high)).values()
            if all(margin.value > 0 for margin in margins):
                continue
            if touch is not None and self._only_touches(low, high, touch):
                continue
            is_inside = low > 0 and high < self.least
            if is_inside and any(margin.middle < 0 for margin in margins):
                return True
            if high - low < shortest or count > MAX_STRETCHES:
                return None
            middle = (low + high) / 2
            stack += [(low, middle), (middle, high)]
        return False

    def _only_touches(self, low: float, high: float, touch: Any) -> bool:
        """Return whether, between a stretch and a turn at a support, it curves away from that and nears no other."""
        gaps = self.margins(self.look(min(low, round_down(touch)), max(high, round_up(touch))))
        return any(bool(gaps[s].bend > 0 and gaps[3 - s].value > 0) for s in SIDES)

    def _monotone(self, shortest: float) -> tuple[float, float, int]:
        """Return until when what is 0 at the start rises, from when what is 0 at the end falls, and the looks taken."""
        first, last, count = 0.0, self.longest, 0
        for departs in (True, False):
            zero = self.zero_at_start if departs else self.zero_at_end
            step = self.longest / 8
            while step > shortest and first < last and count < MAX_STRETCHES:
                low = first if departs else max(last - step, first)
                high = min(first + step, last) if departs else last
                margins = self.margins(self.look(low, high))
                count += 1
                is_kept = all(each.value > 0 for key, each in margins.items() if key != zero)
                if zero in margins:
                    slope = margins[zero].slope if departs else -margins[zero].slope
                    # without restitution, or where friction lets go, it departs at slope 0 and is pulled away
                    is_pulled = departs and low == 0.0 and bool(margins[zero].bend > 0)
                    is_kept = is_kept and (bool(slope > 0) or is_pulled)
                if is_kept:
                    first, last, step = (
                        (high, last, 2 * step) if departs else (first, low, 2 * step)
                    )
                else:
                    step /= 4
        return first, last, count


def _margin_at(event: Event, piece: Piece) -> int | str:
    """Return which margin of a piece is 0 at an event with which it begins or ends; none at the section."""
    if event.kind is Kind.SECTION:
        return ""
    if event.kind.is_at_support:
        return event.support
    return f"{HOLD} {event.after.way}" if piece.is_held else VELOCITY


def _signs(model: Flights, before: Piece, flight: Flight) -> Iterator[Any]:
    """Yield what is positive at the event with which a flight begins; before : the piece that ends there."""
    (kind, support, after), time, free = flight.event, flight.start, flight.free
    if kind.is_at_support:
        yield free * (-SIDES[support] if kind is Kind.LEAVES else SIDES[support])
    elif kind is Kind.SLIPS:
        yield model.force_rate(time) * after.way
    else:
        yield model.on(before).acceleration(time, free) * -before.way
        push = model.on(after).acceleration(time, free)
        yield push * after.way if kind is Kind.TURNS else model.p["friction"] - abs(push)


def leaves_law(
    model: Flights,
    law: Law,
    tube: Sequence[Any],
    lengths: Sequence[Any] | None,
    shortest: float,
    touches: Mapping[int, Any] = MappingProxyType({}),
) -> bool | None:
    """Return False: events and what is between them are certainly those of the law; True: not; None: undecided.

    lengths : as of `flights_of`; touches : times after their start at which flights are known to turn at a support,
    which is no impact.
    """
    flights = [(i, flight) for i, _j, flight in flights_of(law, tube, lengths)]
    for i, flight in flights:
        for sign in _signs(model, law.events[i - 1].after, flight):
            if not sign > 0:
                return True if sign < 0 else None
    undecided = False
    for i, flight in flights:
        verdict = FlightMotion(model, flight).leaves(shortest, touches.get(i))
        if verdict:
            return True
        undecided = undecided or verdict is None
    return None if undecided else False


def is_no_motion(orbit: Orbit) -> bool | None:
    """Return False: a proved orbit is a motion over all its box; True: nowhere in the box; None: undecided."""
    shortest = SHORTEST_OF_BOX if orbit.box.directions else SHORTEST
    return leaves_law(Flights(orbit.box.balls), orbit.law, orbit.tube, orbit.lengths, shortest)


def displacement_bounds(orbit: Orbit, stretches: int) -> tuple[list[float], list[float]]:
    """Return bounds of the displacement of a proved motion over equal stretches of its orbit, from the section on.

    On each stretch they hold for every flight that may be under way, which ends at a support.
    """
    model, m = Flights(orbit.box.balls), orbit.law.m
    p, load = orbit.box.balls, orbit.box.balls["load"]
    floor = round_down(model.position[2] + load) if p["k2"].is_zero() else -math.inf
    ceiling = round_up(model.position[1] + load) if p["k1"].is_zero() else math.inf
    lows, highs = [math.inf] * stretches, [-math.inf] * stretches
    for _i, _j, flight in flights_of(orbit.law, orbit.tube, orbit.lengths):
        motion = FlightMotion(model, flight)
        earliest, latest = round_down(flight.start), round_up(flight.start)
        for n in range(stretches):
            first = math.floor(-(latest + motion.longest) / m)
            for turn in range(first, math.ceil(1 - earliest / m) + 1):
                low = max((n / stretches - turn) * m - latest - ROUNDING, 0.0)
                high = min(((n + 1) / stretches - turn) * m - earliest + ROUNDING, motion.longest)
                if low <= high:
                    x = motion.look(low, high).around + (motion.model.origin + load)
                    is_known = bool(x.is_finite())
                    lows[n] = min(lows[n], max(round_down(x), floor) if is_known else floor)
                    highs[n] = max(highs[n], min(round_up(x), ceiling) if is_known else ceiling)
    return lows, highs


def is_minimal(orbit: Orbit) -> bool | None:
    """Return whether the orbit repeats after no fewer forcing periods: True, False (it does) or None, undecided.

    An orbit of m periods that also is one of m/q, q prime, is its own image under a shift by m/q and by n/q impacts.
    """
    m, n, events = orbit.law.m, orbit.n, orbit.law.events
    for q in range(2, m + 1):
        if m % q or any(q % d == 0 for d in range(2, q)):
            continue
        if n % q or events != events[n // q :] + events[: n // q]:
            continue
        by, image = n // q, []
        for i in range(n):
            j = (i + by) % n
            image.append(orbit.tube[j] + (m if j < i else 0) - arb(m) / q)
        image += [orbit.tube[n + (i + by) % n] for i in range(n)]
        if all(a.overlaps(b) for a, b in zip(image, orbit.tube, strict=True)):
            return None if not _is_unique(orbit, image) else False
    return True


def _is_unique(orbit: Orbit, other: list[Any]) -> bool:
    """Return whether other unknowns lie where the orbit is the only one."""
    return all(a.contains(b) for a, b in zip(orbit.tube_of(orbit.unique), other, strict=True))
