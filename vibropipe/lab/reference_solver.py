"""Reference solutions of eqs. (5), (6) with any effect, 40 digits, sharing no formula with other methods.

Each piece of motion is a power series about successive instants, and what ends it a zero of a series. No closed form of
a motion and no table is used.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from decimal import Context, Decimal, localcontext

from vibropipe.lab.power_series import (
    DIGITS,
    ONE,
    TWO,
    ZERO,
    Series,
    derivative,
    first_zero,
    series_of_waves,
    sine_series,
    value_at,
    waves_after,
)
from vibropipe.lab.reference_alone import MassAlone, ReferenceMotion
from vibropipe.physics.exciter import Exciter

# Hops of a chatter are followed down to this height, relative to l; the remaining ones are summed as a series.
MIN_HOP = Decimal("1e-32")
# Limit of events of a motion, which bounds the run time.
MAX_EVENTS = 200_000
# Direction of increasing penetration at each support.
SIDE = {1: 1, 2: -1}
# An event of what else moves (`MassAlone`), beside supports and the turn, 0, of the mass.
OTHER = -2
# The force of a support that only pushes falls to zero, or rises from it.
FORCE = -3
# Relative difference below which two velocities of a periodic motion are equal.
VELOCITY_TOLERANCE = Decimal("1e-34")


class ReferenceSolver(MassAlone):
    """Solver of one exciter; `run` marches from tau = 0."""

    def __init__(self, exciter: Exciter) -> None:
        self.nu, self.f, self.h = Decimal(exciter.nu), Decimal(exciter.f), Decimal(exciter.h)
        # supports at their positions in double precision, as in the other methods
        self.bound = {1: Decimal(exciter.upper), 2: Decimal(exciter.lower)}
        self.load, self.friction = Decimal(exciter.load), Decimal(exciter.friction)
        self.ratio = Decimal(exciter.friction_ratio)
        self.f2, self.phi2 = Decimal(exciter.f2), Decimal(exciter.phi2)
        self.restitution = {1: Decimal(exciter.R1), 2: Decimal(exciter.R2)}
        self.stiffness = {1: Decimal(exciter.k1), 2: Decimal(exciter.k2)}
        self.damping = {1: Decimal(exciter.h1), 2: Decimal(exciter.h2)}
        contacts = {1: (exciter.contact_1, exciter.h1), 2: (exciter.contact_2, exciter.h2)}
        self.pushes = {support for support, values in contacts.items() if min(values) > 0}
        self.half_distance = Decimal(exciter.l)
        self.fastest = self.nu * (TWO if exciter.f2 else ONE)
        self.reach = ONE / max(self.fastest, self.h, ONE)

    def run(self, x0: float, v0: float, times: Sequence[Decimal]) -> ReferenceMotion:
        """Solve the motion from (x0, v0) at tau = 0.

        times : ascending times at which states are returned; the last one ends the motion. A state at the time of an
            impact is the one after it
        Raises RuntimeError if the motion has more than MAX_EVENTS events.
        """
        with localcontext(Context(prec=DIGITS)):
            self.found, self.times_left = ReferenceMotion(), deque(times)
            self.tau, self.x, self.v = ZERO, Decimal(x0), Decimal(v0)
            sine, cosine = sine_series(self.phi2)
            self.parts = [(ZERO, self.f * self.nu, self.nu)]
            if self.f2:
                twice = TWO * self.nu
                self.parts.append((self.f2 * sine, twice * self.f2 * cosine, twice))
            self.touched = 1 if self.x >= self.bound[1] else 2 if self.x <= self.bound[2] else 0
            self.pressed, self.loose, self.direction, self.zeros = 0, 0, ZERO, 0
            self.switched = False
            self.last_contact: dict[int, tuple[Decimal, Decimal, int]] = {}
            self.begin()
            self.arrive() if self.touched else self.depart()
            for _ in range(MAX_EVENTS):
                if not self.times_left:
                    last = times[-1]
                    self.found.events = [e for e in self.found.events if e[0] <= last]
                    return self.found
                self.advance()
        raise RuntimeError(f"more than {MAX_EVENTS} events up to tau = {float(self.tau):g}")

    def repeat_cycle(self, support: int) -> None:
        """Skip whole cycles of a motion without force and loss.

        It repeats once it meets a support with the same velocity; the events of whole cycles up to the next requested
        time are copied, not marched.
        """
        earlier, count = self.last_contact.get(support), len(self.found.events)
        self.last_contact[support] = (self.tau, self.v, count)
        losses = self.f, self.f2, self.h, self.friction, *self.stiffness.values()
        lossless = not any(losses) and self.restitution[1] == self.restitution[2] == 1
        if earlier is None or not lossless or not self.times_left:
            return
        if abs(earlier[1] - self.v) > VELOCITY_TOLERANCE * abs(self.v):
            return
        round_trip = self.tau - earlier[0]
        rounds = int((self.times_left[0] - self.tau) / round_trip) - 1
        cycle = self.found.events[earlier[2] :]
        for k in range(1, rounds + 1):
            self.found.events += [(tau + k * round_trip, *others) for tau, *others in cycle]  # type: ignore[misc]
        self.tau += max(0, rounds) * round_trip
        self.last_contact.clear()

    def log(self, kind: str, support: int = 0, velocity: Decimal = ZERO) -> None:
        """Append an event."""
        self.found.events.append((self.tau, kind, support, velocity))

    def coefficients(self) -> tuple[Decimal, Decimal, Decimal]:
        """Return stiffness, damping and constant force of the piece, friction apart."""
        k, h = self.stiffness.get(self.pressed, ZERO), self.damping.get(self.pressed, ZERO)
        return ONE + k, self.h + h, self.load + k * self.bound.get(self.pressed, ZERO)

    @property
    def holds(self) -> Decimal:
        """The largest force that holds a mass without velocity."""
        return self.ratio * self.friction

    def force_at_rest(self) -> tuple[Decimal, Decimal]:
        """Return the force on the mass without velocity, friction apart, and its rate."""
        stiffness, _damping, constant = self.coefficients()
        value = sum((part[0] for part in self.parts), ZERO) + constant - stiffness * self.x
        return value, sum((part[1] for part in self.parts), ZERO)

    def arrive(self) -> None:
        """Go on from a support just touched: strike or rest on a rigid one, enter or leave a soft one."""
        support, side = self.touched, SIDE[self.touched]
        if self.stiffness[support] > 0:
            if self.v == 0:
                self.depart()
                return
            self.pressed, self.loose = support if side * self.v > 0 else 0, 0
            self.log("in" if self.pressed else "out", support, self.v)
            self.direction, self.zeros = ONE.copy_sign(self.v), 0
        elif self.sticks(support):
            self.v, self.direction = ZERO, ZERO
            self.log("rest", support)
            self.hold(rests=True)
        elif self.v == 0:
            self.direction, self.zeros = Decimal(-side), 1
        else:
            self.direction, self.zeros = ONE.copy_sign(self.v), 0

    def sticks(self, support: int) -> bool:
        """Reset the velocity at a rigid support; return whether the mass stays, its chatter completed."""
        side, d = SIDE[support], self.friction
        if side * self.v > 0:
            self.log("impact", support, self.v)
            before = self.v
            self.v *= -self.restitution[support]
            self.struck(before)
            self.repeat_cycle(support)
        elif self.v == 0 and self.tau > 0:
            self.log("graze", support)
        value, rate = self.force_at_rest()
        press = side * (value - self.h * self.v)
        if self.v == 0:
            return press >= -self.holds
        if (
            press <= self.holds
            or press - d <= 0
            or self.v * self.v > TWO * (press + d) * MIN_HOP * self.half_distance
        ):
            return False
        ratio = ((press - d) / (press + d)).sqrt()
        loss = ONE - self.restitution[support] * ratio
        if loss <= 0:
            return False
        duration = abs(self.v) / (press + d) * (ONE + ONE / ratio) / loss
        if duration * (abs(rate) + self.h * press) > (press - d) / 1000:
            return False
        if not self.goes_on(duration):
            return False
        self.pass_time(duration, [self.x])
        return True

    def depart(self) -> None:
        """Go on from where the velocity is zero, or the start: move either way, or be held."""
        if self.v != 0:
            self.direction, self.zeros = ONE.copy_sign(self.v), 0
            return
        value, rate = self.force_at_rest()
        if abs(value) > self.holds:
            self.direction, self.zeros = ONE.copy_sign(value), 1
        elif self.friction == value == 0 and rate != 0:
            self.direction, self.zeros = ONE.copy_sign(rate), 2
        else:
            self.direction = ZERO
            # Without friction it is an equilibrium.
            if self.friction > 0:
                self.log("stick")
            self.hold(rests=False)
            return
        self.press()

    def press(self) -> None:
        """Enter a soft support that is touched without velocity and moved into, or leave it."""
        support = self.touched
        if support and not self.pressed and self.direction == SIDE[support]:
            self.pressed = support
            self.log("in", support)

    def hold(self, rests: bool) -> None:
        """Hold the mass until the force exceeds what holds it, or the last requested time."""
        stiffness, _damping, constant = self.coefficients()
        ways = [-SIDE[self.touched]] if rests else [1, -1]
        while self.times_left:
            force = self.force_series(self.reach)
            force[0] += constant - stiffness * self.x
            zeros = []
            for way in ways:
                margin = [self.holds - way * force[0], *(-way * c for c in force[1:])]
                if margin[0] > 0 or margin[1] > 0:
                    zeros.append((first_zero(margin, self.reach, self.reach), way))
            crossings = [(t, way) for t, way in zeros if t is not None]
            stop = self.still_until()
            if stop is not None and stop < min(crossings, default=(self.reach, 0))[0]:
                self.pass_time(stop, [self.x])
                self.changes(rests)
                return
            if all(part[0] == part[1] == 0 for part in self.parts):
                self.pass_time(self.times_left[-1] - self.tau + ONE, [self.x])
                return
            span, way = min(crossings, default=(self.reach, 0))
            self.pass_time(span, [self.x])
            if way and self.times_left:
                if rests or self.friction > 0:
                    self.log("release" if rests else "slip", self.touched if rests else 0)
                self.direction, self.zeros = Decimal(way), 2 if self.ratio == 1 else 1
                if not rests:
                    self.press()
                return

    def force_series(self, reach: Decimal) -> Series:
        """Return the series of the force on the mass about the current time, accurate up to `reach`."""
        return series_of_waves(self.parts, reach)

    def pass_time(self, span: Decimal, x: Series) -> None:
        """Advance by `span` along a series of x, and record the states at requested times within it."""
        while self.times_left and self.times_left[0] < self.tau + span:
            t = self.times_left.popleft() - self.tau
            self.found.states.append((value_at(x, t), value_at(derivative(x), t)))
        self.tau += span
        self.parts = waves_after(self.parts, span)

    def advance(self) -> None:
        """Advance along one series: to the next event, or by its reach."""
        stiffness, damping, constant = self.coefficients()
        constant -= self.friction * self.direction
        reach = ONE / max(self.fastest, damping, stiffness.sqrt(), ONE)
        force, x, n, power = self.force_series(reach), [self.x, self.v], 0, ONE
        force[0] += constant
        while (
            n < 12
            or (abs(x[-1]) + abs(x[-2])) * power > Decimal(10) ** -DIGITS * self.half_distance
        ):
            applied = force[n] if n < len(force) else ZERO
            x.append(
                (applied - damping * (n + 1) * x[n + 1] - stiffness * x[n]) / ((n + 1) * (n + 2))
            )
            n, power = n + 1, power * reach
        if self.zeros == 2:
            x[2] = ZERO
        span, kind = reach, -1
        beyond = self.pressed or self.loose
        for support, side in SIDE.items():
            if (beyond and support != beyond) or self.pressed in self.pushes:
                continue
            way = -side if beyond else side
            gap = [way * (self.bound[support] - x[0]), *(-way * c for c in x[1:])]
            start = self.zeros + 1 if support == self.touched else 0
            t = first_zero(gap[start:], span, self.reach)
            span, kind = (span, kind) if t is None else (t, support)
        if self.friction > 0:
            t = first_zero(
                [self.direction * c for c in derivative(x)[self.zeros :]], span, self.reach
            )
            span, kind = (span, kind) if t is None else (t, 0)
        t = self.force_zero(x, span)
        span, kind = (span, kind) if t is None else (t, FORCE)
        t = self.other_event(x, span)
        span, kind = (span, kind) if t is None else (t, OTHER)
        self.pass_time(span, x)
        self.v = value_at(derivative(x), span)
        self.x = self.bound[kind] if kind > 0 else value_at(x, span)
        self.touched, self.zeros, self.switched = max(kind, 0), 0, kind == FORCE
        if kind > 0:
            self.arrive()
        elif kind == 0:
            self.v = ZERO
            self.log("turn")
            self.depart()
        elif kind == FORCE:
            self.log("unload" if self.pressed else "reload", self.pressed or self.loose, self.v)
            self.pressed, self.loose = self.loose, self.pressed
        elif kind == OTHER:
            self.otherwise()

    def force_zero(self, x: Series, span: Decimal) -> Decimal | None:
        """Return when the force of a support that only pushes falls to zero or rises from it, along a series of x."""
        support = self.pressed or self.loose
        if support not in self.pushes:
            return None
        way = SIDE[support] * (1 if self.pressed else -1)
        depth, rate = [x[0] - self.bound[support], *x[1:]], derivative(x)
        k, h = self.stiffness[support], self.damping[support]
        force = [way * (k * depth[n] + h * c) for n, c in enumerate(rate)]
        start = 1 if self.switched else self.zeros if support == self.touched else 0
        return first_zero(force[start:], span, self.reach)
