"""The oracle: a second, slow and simple implementation of the model, event by event, in any precision.

It shares nothing with the package. Between events the motion is the textbook solution of
x'' + h x' + x = f sin(nu tau), evaluated directly at every instant. The first contact is
approached from the left by steps too short to reach a support, because |x''| has bounds:
the transient y has y''^2 + y'''^2 never growing (y'' is itself a free damped vibration), and inside
the supports |x| <= X, so d|v|/dtau <= -h |v| + X + |f|, so |v| never exceeds
max(|v now|, (X + |f|)/h), so |x''| never exceeds X + |f| + max(h |v now|, X + |f|).

The arithmetic is that of `textbook`: many digits by default, or plain doubles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import mpmath
from textbook import Flight, Parameters, digits

MAX_EVENTS = 20_000  # of one motion
GRAZING_DEPTH = 1e-14  # of the larger distance of a support from the equilibrium


class Impact(NamedTuple):
    tau: Any
    support: int
    before: Any
    after: Any


class Rest(NamedTuple):
    start: Any
    end: Any  # of the rest itself, even beyond tau_end; inf when never released
    support: int


class Grazing(NamedTuple):
    tau: Any
    support: int


@dataclass
class Motion:
    """A complete motion: its events, its end state, and its pieces, which give the state at any time."""

    impacts: list[Impact] = field(default_factory=list)
    rests: list[Rest] = field(default_factory=list)
    grazings: list[Grazing] = field(default_factory=list)
    pieces: list[tuple[Any, Any]] = field(default_factory=list)  # (from tau, tau -> (x, v))
    displacement_end: Any = None
    velocity_end: Any = None

    def state(self, tau: Any) -> tuple[Any, Any]:
        """Displacement and velocity at tau, after an event at tau."""
        piece = self.pieces[0][1]
        for start, later in self.pieces:
            if start > tau:
                break
            piece = later
        x, v = piece(tau)
        return x, v


def side_of(support: int) -> int:
    """+1 for support 1, -1 for support 2, 0 for none."""
    return (0, 1, -1)[support]


class Oracle:
    """One exciter, marched event by event; callers use `run` only.

    `nudge` changes nu, f, h, support 1, support 2, R1 and R2 by these relative amounts. The change of h is relative
    to the fastest rate and represents the rounding of each step: without force, from one support back to it, a motion
    is the same at every scale, so that equal changes of all lengths would have no effect.
    """

    def __init__(self, p: Parameters, context: Any = None, nudge: Sequence[Any] = (0,) * 7) -> None:
        self.c = c = digits(p) if context is None else context
        values = (p.nu, p.f, p.h, p.upper, p.lower, p.R1, p.R2)
        self.nu, self.f, self.h, upper, lower, R1, R2 = (
            c.mpf(value) * (1 + c.mpf(by)) for value, by in zip(values, nudge, strict=True)
        )
        self.h = c.mpf(p.h) + c.mpf(nudge[2]) * max(1, p.nu, p.h)
        self.bound, self.restitution = {1: upper, 2: lower}, {1: R1, 2: R2}
        self.half_distance, self.max_force = max(abs(upper), abs(lower)), abs(self.f)
        # A chatter is followed down to flights of this height (in half distances), then summed up.
        is_double = c is mpmath.fp
        self.last_height = c.mpf("1e-13" if is_double else "1e-25")
        self.shortest = c.mpf(1e-15) if is_double else c.mpf(10) ** (8 - c.dps)

    def run(self, tau_end: Any, x0: Any = 0.0, v0: Any = 0.0, tau_start: Any = 0.0) -> Motion:
        """The motion from (x0, v0) at tau_start; events at tau <= tau_end count."""
        c = self.c
        self.motion, self.tau_end = Motion(), c.mpf(tau_end)
        tau, x, v = c.mpf(tau_start), c.mpf(x0), c.mpf(v0)
        on = 1 if x == self.bound[1] else 2 if x == self.bound[2] else 0
        released = False
        for _ in range(MAX_EVENTS):
            if on and side_of(on) * v > 0:
                v = self.reset(on, tau, v)
            rest_start = self.rest_start(on, tau, v) if on and not released else None
            if rest_start is not None:
                tau, x, v = self.lie(on, rest_start)
                if tau > self.tau_end:
                    break
                released = True
                continue
            contact = self.fly(tau, x, v, on, released)
            if contact is None:
                break
            tau, on, x, v = contact
            released = False
        else:
            raise RuntimeError(f"more than {MAX_EVENTS} events")
        self.motion.displacement_end, self.motion.velocity_end = self.motion.state(self.tau_end)
        return self.motion

    def reset(self, on: int, tau: Any, v: Any) -> Any:
        after = -self.restitution[on] * v
        self.motion.impacts.append(Impact(tau, on, v, after))
        return after

    def pressing_force(self, on: int, tau: Any) -> Any:
        """Force that presses the resting mass into the support (negative: pulls it off)."""
        return side_of(on) * (self.f * self.c.sin(self.nu * tau) - self.bound[on])

    def rest_start(self, on: int, tau: Any, v: Any) -> Any:
        """Time from which the mass rests on its support, None if it flies on."""
        pressing_force, side, R = self.pressing_force(on, tau), side_of(on), self.restitution[on]
        if v == 0:
            if pressing_force == 0:  # balanced: what comes next decides
                slope = side * self.f * self.nu * self.c.cos(self.nu * tau)
                return tau if slope > 0 or (slope == 0 and side * self.bound[on] <= 0) else None
            return tau if pressing_force > 0 else None
        if pressing_force <= 0 or R == 1:
            return None
        # Series of hops under a constant force a: flights of 2 w/a, each R times as long as the previous one.
        left = 2 * abs(v) / (pressing_force * (1 - R))
        small = v**2 / (2 * pressing_force) <= self.last_height * self.half_distance
        steady = (
            left * (self.max_force * self.nu + self.h * pressing_force) <= pressing_force / 1000
        )
        return tau + left if small and steady else None

    def lie(self, on: int, start: Any) -> tuple[Any, Any, Any]:
        """Rest from `start` to the release; returns the state at the release."""
        end, x, v = self.release(on, start), self.bound[on], self.c.mpf(0)
        if start <= self.tau_end:
            self.motion.rests.append(Rest(start, end, on))
            self.motion.pieces.append((start, lambda tau: (x, v)))
        return end, x, v

    def release(self, on: int, start: Any) -> Any:
        """First time at or after start at which the pressing force falls below zero."""
        c, side = self.c, side_of(on)
        if self.nu == 0 or abs(self.bound[on]) >= self.max_force:
            return c.inf  # the force can never overcome the spring (a tie keeps it)
        # side f sin(phase) falls through side * bound once in a period
        falls_at = c.pi - c.asin(side * self.bound[on] / self.max_force)
        if side * self.f < 0:
            falls_at -= c.pi
        turns = c.ceil((self.nu * start - falls_at) / (2 * c.pi))
        return (falls_at + 2 * c.pi * turns) / self.nu

    def fly(self, tau: Any, x: Any, v: Any, on: int, released: bool) -> Any:
        """Next contact (tau, support, x, v) at or before tau_end, None if there is none."""
        flight = Flight(self.c, self.nu, self.f, self.h, (tau, x, v))
        self.motion.pieces.append((tau, flight))
        if on:
            tau += self.first_step(on, tau, v, released)
        before = None  # nearest support, speed towards it and tau of the previous step
        while tau <= self.tau_end:
            x, v, most = flight.look(tau)
            steps = [self.safe_step(k, x, v, min(most, self.max_acceleration(v))) for k in (1, 2)]
            near, step = (1, steps[0]) if steps[0] < steps[1] else (2, steps[1])
            closing = side_of(near) * v
            if before is not None and before[0] == near and before[1] > 0 >= closing:
                self.passed(flight, near, before[2], tau)
            before = near, closing, tau
            if step > self.shortest * max(1, abs(tau)):
                tau += step
                continue
            turning_time = self.grazes(near, tau, v)
            if turning_time is None:
                return tau, near, self.bound[near], v
            tau, before = (
                turning_time + self.first_step(near, turning_time, self.c.mpf(0), False),
                None,
            )
        return None

    def max_acceleration(self, v: Any) -> Any:
        """Bound of |x''| between the supports."""
        pull = self.half_distance + self.max_force
        return pull + max(self.h * abs(v), pull)

    def gap(self, support: int, x: Any) -> Any:
        return side_of(support) * (self.bound[support] - x)

    def safe_step(self, support: int, x: Any, v: Any, most: Any) -> Any:
        """Positive root of gap - closing s - most s^2/2; the support is not reached earlier."""
        gap, closing = self.gap(support, x), side_of(support) * v
        if gap <= 0:
            return self.c.mpf(0)
        root = self.c.sqrt(closing * closing + 2 * most * gap)
        return 2 * gap / (closing + root) if closing > 0 else (root - closing) / most

    def first_step(self, on: int, tau: Any, v: Any, released: bool) -> Any:
        """A step after which the gap of this support is certainly open and the other support not reached.

        It is the first non-zero derivative of the gap, divided by a bound of the next one.
        """
        a_most = self.max_acceleration(v)
        v_most = abs(v) + 2 * (self.half_distance + self.max_force)  # over the next unit of time
        j_most = self.h * a_most + v_most + self.max_force * self.nu
        if v != 0:
            step = abs(v) / a_most
        elif not released and self.pressing_force(on, tau) != 0:
            step = abs(self.pressing_force(on, tau)) / j_most
        else:
            slope = abs(self.f * self.nu * self.c.cos(self.nu * tau))
            next_most = self.h * j_most + a_most + self.max_force * self.nu**2
            step = slope / next_most if slope else self.c.sqrt(self.shortest)
        away = -side_of(on) * abs(v)
        return min(1, step, self.safe_step(3 - on, self.bound[on], away, a_most) / 2)

    def grazes(self, near: int, tau: Any, v: Any) -> Any:
        """Time of the turning point if the mass turns back within the grazing depth, else None."""
        away = self.h * v * side_of(near) - self.pressing_force(near, tau)
        if away <= 0 or v**2 / (2 * away) > GRAZING_DEPTH * self.half_distance:
            return None
        turning_time = tau + abs(v) / away
        self.motion.grazings.append(Grazing(turning_time, near))
        return turning_time

    def passed(self, flight: Flight, near: int, left: Any, right: Any) -> None:
        """Record a grazing if the motion turned back just short of the support."""
        for _ in range(60):
            middle = (left + right) / 2
            if side_of(near) * flight(middle)[1] > 0:
                left = middle
            else:
                right = middle
        if self.gap(near, flight(left)[0]) <= GRAZING_DEPTH * self.half_distance:
            self.motion.grazings.append(Grazing(left, near))
