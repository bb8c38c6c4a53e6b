"""Whether an orbit is a motion: no flight leaves the supports before its end.

A flight falls away from its support as long as its velocity certainly has one sign, and approaches the next one
likewise; between these two stretches bisection keeps it clear of both supports. On each stretch |x''| is bounded by
Picard's inequality, and x, x' by their Taylor polynomials from its middle.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from vibropipe.proof.balls import arb, round_down, round_up
from vibropipe.proof.flights import Flights
from vibropipe.proof.orbit import Flight, Orbit, flights_of

# Shortest stretch that is looked at, in forcing periods: of one exciter and of a box, which is split instead.
SHORTEST, SHORTEST_OF_BOX = 2.0**-30, 2.0**-12
# Stretches of a flight that are looked at; h = 1000 takes some 1e4.
MAX_STRETCHES = 20_000
# More than phases are off by rounding, in forcing periods.
ROUNDING = 2.0**-40
# A stretch is too long for Picard's inequality where this share is not left.
MIN_SHARE = 0.25


class Stretch(NamedTuple):
    """What certainly holds on a stretch of a flight.

    Attributes
    ----------
    rate, acceleration : ball
        x' and x'' on it.
    below_1, above_2 : bool
        Whether it is clear of support 1, and of support 2.
    x, around : ball
        Displacement from the equilibrium in its middle, and on it.
    """

    rate: Any
    acceleration: Any
    below_1: bool
    above_2: bool
    x: Any
    around: Any

    def is_clear_of(self, support: int) -> bool:
        """Return whether the mass is certainly not at a support."""
        return self.below_1 if support == 1 else self.above_2


class FlightMotion:
    """The motion of a flight over the times since its departure, in forcing periods."""

    def __init__(self, model: Flights, flight: Flight) -> None:
        self.model, self.flight = model, flight
        self.x = model.position[flight.support]
        self.v = -(model.restitution[flight.support] * flight.velocity)
        duration = flight.end - flight.start
        self.least, self.longest = round_down(duration), round_up(duration)

    def look(self, low: float, high: float) -> Stretch:
        """Return what holds from `low` to `high`."""
        model, c = self.model, arb((low + high) / 2)
        x, v = model.fly(self.flight.start, c, self.x, self.v)
        r = ((arb(high) - c).max(c - arb(low)) * model.period).upper()
        share = 1 - (model.h + r) * r
        if not share > MIN_SHARE:
            unknown = arb(0, arb.pos_inf())
            return Stretch(unknown, unknown, False, False, x, unknown)
        bound = ((model.force_bound + abs(x) + (model.h + r) * abs(v)) / share).upper()
        around = x + v * arb(0, r) + arb(0, bound * r * r / 2)
        rate = v + arb(0, bound * r)
        time = self.flight.start + c + arb(0, r) / model.period
        acceleration = model.force(time) - around - model.h * rate
        below, above = around < model.position[1], around > model.position[2]
        return Stretch(rate, acceleration, bool(below), bool(above), x, around)

    def leaves(self, shortest: float, touch: Any = None) -> bool | None:
        """Return False: it certainly stays between the supports; True: it leaves; None: undecided.

        At the time `touch`, a ball, it is known to turn at a support, which is no impact.
        """
        if not self.least > 0:
            return True if self.longest < 0 else None
        first, last, count = self._monotone(shortest)
        stack = [(first, last)] if first < last else []
        while stack:
            low, high = stack.pop()
            count += 1
            stretch = self.look(low, high)
            if stretch.below_1 and stretch.above_2:
                continue
            if touch is not None and self._only_touches(low, high, touch):
                continue
            if low > 0 and high < self.least:
                x, (b1, b2) = stretch.x, (self.model.position[1], self.model.position[2])
                if x > b1 or x < b2:
                    return True
            if high - low < shortest or count > MAX_STRETCHES:
                return None
            middle = (low + high) / 2
            stack += [(low, middle), (middle, high)]
        return False

    def _only_touches(self, low: float, high: float, touch: Any) -> bool:
        """Return whether, between a stretch and a turn at a support, it curves away from that and nears no other."""
        around = self.look(min(low, round_down(touch)), max(high, round_up(touch)))
        curve = around.acceleration
        return bool((curve < 0 and around.above_2) or (curve > 0 and around.below_1))

    def _monotone(self, shortest: float) -> tuple[float, float, int]:
        """Return until when it certainly falls away, from when it certainly approaches, and the stretches looked at."""
        first, last, count = 0.0, self.longest, 0
        for departs in (True, False):
            support = self.flight.support if departs else self.flight.next_support
            towards = 1 if support == 1 else -1
            step = self.longest / 8
            while step > shortest and first < last and count < MAX_STRETCHES:
                low = first if departs else max(last - step, first)
                high = min(first + step, last) if departs else last
                stretch = self.look(low, high)
                count += 1
                moves = stretch.rate * towards < 0 if departs else stretch.rate * towards > 0
                # without restitution it departs at velocity 0, pulled away
                is_pulled = departs and low == 0.0 and stretch.acceleration * towards < 0
                if (moves or is_pulled) and stretch.is_clear_of(3 - support):
                    first, last, step = (
                        (high, last, 2 * step) if departs else (first, low, 2 * step)
                    )
                else:
                    step /= 4
        return first, last, count


def leaves_supports(orbit: Orbit) -> bool | None:
    """Return False: a proved orbit is a motion over all its box; True: nowhere in the box; None: undecided."""
    for support, v in zip(orbit.law.supports, orbit.tube[orbit.n :], strict=True):
        towards = v if support == 1 else -v
        if not towards > 0:
            return True if towards < 0 else None
    model = Flights(orbit.box.balls)
    shortest = SHORTEST_OF_BOX if orbit.box.directions else SHORTEST
    undecided = False
    for _i, _j, flight in flights_of(orbit.law, orbit.tube):
        verdict = FlightMotion(model, flight).leaves(shortest)
        if verdict:
            return True
        undecided = undecided or verdict is None
    return None if undecided else False


def displacement_bounds(orbit: Orbit, stretches: int) -> tuple[list[float], list[float]]:
    """Return bounds of the displacement of a proved motion over equal stretches of its orbit, from the section on.

    On each stretch they hold for every flight that may be under way, which ends at a support.
    """
    model, m = Flights(orbit.box.balls), orbit.law.m
    load = orbit.box.balls["load"]
    floor, ceiling = round_down(model.position[2] + load), round_up(model.position[1] + load)
    lows, highs = [math.inf] * stretches, [-math.inf] * stretches
    for _i, _j, flight in flights_of(orbit.law, orbit.tube):
        motion = FlightMotion(model, flight)
        earliest, latest = round_down(flight.start), round_up(flight.start)
        for n in range(stretches):
            first = math.floor(-(latest + motion.longest) / m)
            for turn in range(first, math.ceil(1 - earliest / m) + 1):
                low = max((n / stretches - turn) * m - latest - ROUNDING, 0.0)
                high = min(((n + 1) / stretches - turn) * m - earliest + ROUNDING, motion.longest)
                if low <= high:
                    x = motion.look(low, high).around + load
                    is_known = bool(x.is_finite())
                    lows[n] = min(lows[n], max(round_down(x), floor) if is_known else floor)
                    highs[n] = max(highs[n], min(round_up(x), ceiling) if is_known else ceiling)
    return lows, highs


def is_minimal(orbit: Orbit) -> bool | None:
    """Return whether the orbit repeats after no fewer forcing periods: True, False (it does) or None, undecided.

    An orbit of m periods that also is one of m/q, q prime, is its own image under a shift by m/q and by n/q impacts.
    """
    m, n, supports = orbit.law.m, orbit.n, orbit.law.supports
    for q in range(2, m + 1):
        if m % q or any(q % d == 0 for d in range(2, q)):
            continue
        if n % q or supports != supports[n // q :] + supports[: n // q]:
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
