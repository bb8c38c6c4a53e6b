"""Reference solutions of eqs. (5), (6) with 40 digits, sharing no formula with the other methods.

The motion is a power series about successive instants, and the force is carried along as a series of its own, so no
sine, closed form or table is used. A contact is approached by steps that cannot pass a support, since the second
derivative of a gap is bounded by its series. Arithmetic: `decimal` of the standard library.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from decimal import Context, Decimal, localcontext

from vibropipe.physics.exciter import Exciter

DIGITS = 40
PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494")
ZERO, ONE, TWO = Decimal(0), Decimal(1), Decimal(2)
# Time tolerance of a contact, relative to the shortest time scale: a few digits above rounding.
TIME_TOLERANCE = Decimal("1e-36")
# Hops of a chatter are followed down to this height, relative to l; the remaining ones are summed as a series.
MIN_HOP = Decimal("1e-32")
# Limit of contacts of a motion, which bounds the run time.
MAX_EVENTS = 200_000
# Direction of increasing penetration at each support.
SIDE = {1: 1, 2: -1}
# Relative difference below which two velocities of a periodic motion are equal.
VELOCITY_TOLERANCE = Decimal("1e-34")

Series = list[Decimal]


@dataclass
class ReferenceMotion:
    """A motion to 20 digits or more.

    impacts : (tau, support, velocity before, velocity after); rests : (start, end or None, support); states : (x, v) at
    the requested times.
    """

    impacts: list[tuple[Decimal, int, Decimal, Decimal]] = field(default_factory=list)
    rests: list[tuple[Decimal, Decimal | None, int]] = field(default_factory=list)
    states: list[tuple[Decimal, Decimal]] = field(default_factory=list)


def period_of(nu: float) -> Decimal:
    """Return the forcing period 2 pi / nu, with nu exactly the given double."""
    with localcontext(Context(prec=DIGITS)):
        return TWO * PI / Decimal(nu)


def value_at(series: Sequence[Decimal], t: Decimal) -> Decimal:
    """Return the value of a power series at t."""
    total = ZERO
    for coefficient in reversed(series):
        total = total * t + coefficient
    return total


def derivative(series: Series) -> Series:
    """Return the derivative of a power series."""
    return [n * coefficient for n, coefficient in enumerate(series)][1:]


def sine_and_cosine(angle: Decimal) -> tuple[Decimal, Decimal]:
    """Return sine and cosine by their series, for an angle of some radians."""
    sums, term, n = [ZERO, ZERO], ONE, 0
    while abs(term) > ONE.scaleb(-2 * DIGITS):
        sums[n % 2] += term if n % 4 < 2 else -term
        n += 1
        term *= angle / n
    return sums[1], sums[0]


class ReferenceSolver:
    """Solver of one exciter; `run` marches from tau = 0."""

    def __init__(self, exciter: Exciter) -> None:
        self.nu, self.f, self.h = Decimal(exciter.nu), Decimal(exciter.f), Decimal(exciter.h)
        # supports at their positions in double precision, as in the other methods
        self.bound = {1: Decimal(exciter.upper), 2: Decimal(exciter.lower)}
        self.load = Decimal(exciter.load)
        self.f2, self.phi2 = Decimal(exciter.f2), Decimal(exciter.phi2)
        self.restitution = {1: Decimal(exciter.R1), 2: Decimal(exciter.R2)}
        self.half_distance = Decimal(exciter.l)
        fastest = self.nu * (TWO if exciter.f2 else ONE)
        self.reach = ONE / max(fastest, self.h, ONE)

    def run(self, x0: float, v0: float, times: Sequence[Decimal]) -> ReferenceMotion:
        """Solve the motion from (x0, v0) at tau = 0.

        x0, v0 : displacement and velocity at the start
        times : ascending times at which states are returned; the last one ends the motion. A state at the time of an
            impact is the one after it
        Raises RuntimeError if the motion has more than MAX_EVENTS contacts.
        """
        with localcontext(Context(prec=DIGITS)):
            self.motion, self.times_left = ReferenceMotion(), deque(times)
            self.tau, self.x, self.v = ZERO, Decimal(x0), Decimal(v0)
            # value and rate of each harmonic of the force
            sine, cosine = sine_and_cosine(self.phi2)
            self.force = [(ZERO, self.f * self.nu)]
            if self.f2:
                self.force.append((self.f2 * sine, TWO * self.nu * self.f2 * cosine))
            self.last_contact: dict[int, tuple[Decimal, Decimal, int]] = {}
            support = 1 if self.x >= self.bound[1] else 2 if self.x <= self.bound[2] else 0
            for _ in range(MAX_EVENTS):
                if not self.times_left:
                    return self.motion
                released = support > 0 and self.resolve_contact(support)
                if released:
                    self.advance_rest(support)
                support = self.fly(support, released)
        raise RuntimeError(f"more than {MAX_EVENTS} contacts up to tau = {float(self.tau):g}")

    def repeat_cycle(self, support: int) -> None:
        """Skip whole cycles of a motion without force and loss.

        It repeats once it meets a support with the same velocity; the impacts of whole cycles up to the next requested
        time are copied, not marched.
        """
        earlier, count = self.last_contact.get(support), len(self.motion.impacts)
        self.last_contact[support] = (self.tau, self.v, count)
        lossless = (
            self.f == self.f2 == self.h == 0 and self.restitution[1] == self.restitution[2] == 1
        )
        if (
            earlier is None
            or not lossless
            or abs(earlier[1] - self.v) > VELOCITY_TOLERANCE * abs(self.v)
        ):
            return
        round_trip = self.tau - earlier[0]
        rounds = int((self.times_left[0] - self.tau) / round_trip) - 1
        cycle = self.motion.impacts[earlier[2] :]
        for k in range(1, rounds + 1):
            self.motion.impacts += [
                (tau + k * round_trip, side, before, after) for tau, side, before, after in cycle
            ]
        self.tau += max(0, rounds) * round_trip
        self.last_contact.clear()

    def pressing_force(self, support: int) -> Decimal:
        """Return the force that presses the mass into the support it touches."""
        force = sum((value for value, _rate in self.force), ZERO)
        return SIDE[support] * (force + self.pull(support) - self.h * self.v)

    def pull(self, support: int) -> Decimal:
        """Return the force of the spring and the load at a support."""
        return self.load - self.bound[support]

    def resolve_contact(self, support: int) -> bool:
        """Reset the velocity at a support; return whether the mass sticks, its chatter completed."""
        if SIDE[support] * self.v > 0:
            before, self.v = self.v, -self.restitution[support] * self.v
            self.motion.impacts.append((self.tau, support, before, self.v))
            self.repeat_cycle(support)
        pressing_force = self.pressing_force(support)
        if self.v == 0 or pressing_force <= 0 or self.restitution[support] == 1:
            return self.v == 0 and pressing_force >= 0
        duration = TWO * abs(self.v) / (pressing_force * (ONE - self.restitution[support]))
        if self.v * self.v > TWO * pressing_force * MIN_HOP * self.half_distance:
            return False
        # the force changes during the chatter, so that its hops are not a geometric series
        rate = (abs(self.f) + TWO * abs(self.f2)) * self.nu
        if duration * (rate + self.h * pressing_force) > pressing_force / 1000:
            return False
        self.v = ZERO
        self.pass_time(duration, [self.x])
        return True

    def series(self) -> tuple[Series, list[Series]]:
        """Return the series of displacement and of each harmonic of the force about the current time.

        They are truncated at rounding.
        """
        x, forces = [self.x, self.v], [[*part] for part in self.force]
        power, n = self.reach * self.reach, 0
        while True:
            scale = (n + 1) * (n + 2)
            constant = self.load if n == 0 else ZERO
            constant += sum((force[n] for force in forces), ZERO)
            x.append((constant - self.h * (n + 1) * x[n + 1] - x[n]) / scale)
            for k, force in enumerate(forces, 1):
                force.append(-((k * self.nu) ** 2) * force[n] / scale)
            tail = sum((abs(part[-1]) + abs(part[-2]) for part in (x, *forces)), ZERO) * power
            if n > 8 and tail <= self.half_distance.scaleb(-DIGITS):
                return x, forces
            power *= self.reach
            n += 1

    def pass_time(self, span: Decimal, x: Series, force: list[Series] | None = None) -> None:
        """Advance by `span` along a series and record the states at requested times within it."""
        while self.times_left and self.times_left[0] < self.tau + span:
            t = self.times_left.popleft() - self.tau
            self.motion.states.append((value_at(x, t), value_at(derivative(x), t)))
        while span > 0:
            step = min(span, self.reach)
            if force is None or step < span:
                _x, force = self.series()
            self.force = [
                (value_at(each, step), value_at(derivative(each), step)) for each in force
            ]
            self.tau, span, force = self.tau + step, span - step, None

    def advance_rest(self, support: int) -> None:
        """Stick to a support until the release or the last requested time."""
        start, side = self.tau, SIDE[support]
        while self.times_left:
            if (
                -side * self.pull(support) + abs(self.f) + abs(self.f2) <= 0
                or self.f == self.f2 == 0
            ):
                # the force cannot overcome the spring and the load
                self.pass_time(self.times_left[-1] - self.tau + ONE, [self.bound[support]])
                break
            _x, force = self.series()
            total = [sum(terms, ZERO) for terms in zip(*force, strict=True)]
            pressing_force = [
                side * (total[0] + self.pull(support)),
                *(side * c for c in total[1:]),
            ]
            release = self.first_zero(pressing_force, self.reach)
            self.pass_time(self.reach if release is None else release, [self.bound[support]], force)
            if release is not None:
                self.motion.rests.append((start, self.tau, support))
                return
        self.motion.rests.append((start, None, support))

    def fly(self, support: int, released: bool) -> int:
        """Advance in flight to the next contact; return its support, or 0 after the last requested time."""
        n_zeros = 0 if not support else 3 if released else 1 if self.v != 0 else 2
        while self.times_left:
            x, force = self.series()
            if n_zeros == 3:
                x[2] = ZERO
            span, contact = self.reach, 0
            for other, side in SIDE.items():
                gap = [side * (self.bound[other] - x[0]), *(-side * c for c in x[1:])]
                t = self.first_zero(gap[n_zeros:] if other == support else gap, span)
                span, contact = (span, contact) if t is None else (t, other)
            self.pass_time(span, x, force)
            self.v = value_at(derivative(x), span)
            self.x = self.bound[contact] if contact else value_at(x, span)
            if contact:
                return contact
            support, n_zeros = 0, 0
        return 0

    def first_zero(self, gap: Series, span: Decimal) -> Decimal | None:
        """Return the first time in (0, span] at which a series, positive at first, falls through zero."""
        rate, second = derivative(gap), ZERO
        for n in range(len(gap) - 1, 1, -1):
            second = second * span + n * (n - 1) * abs(gap[n])
        t = ZERO
        while t <= span:
            height, fall = value_at(gap, t), -value_at(rate, t)
            if height <= 0 and t > 0:
                return t
            # the series lies above a parabola of the largest curvature, which has no zero before `step`
            root = (fall * fall + TWO * second * height).sqrt() if height > 0 else abs(fall)
            if fall > 0:
                step = TWO * height / (fall + root)
            elif second:
                step = (root - fall) / second
            else:
                step = span
            if step <= TIME_TOLERANCE * self.reach + t * TIME_TOLERANCE:
                curvature = value_at(derivative(rate), t)
                if fall > 0 and fall * fall >= TWO * curvature * height:
                    return t + step
                # grazing: continue beyond the minimum
                step = (
                    max(
                        TWO * fall / curvature if curvature > 0 else step,
                        TIME_TOLERANCE * self.reach,
                    )
                    * TWO
                )
            t += step
        return None
