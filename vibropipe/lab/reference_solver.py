"""The slow, obvious judge of the other methods: eqs. (5), (6) in 40 digits, sharing no formula with them.

The motion is a power series about ever new instants, the force carried along as a series of its own,
so no sine, no closed form and no table enters. Contacts are approached by steps too short to reach a
support, because the second derivative of a gap is bounded by its series. Arithmetic is the standard
library's `decimal`.
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
# A gap is closed when this share of the shortest time scale is left of the way to it.
CLOSE = Decimal("1e-36")
# Hops of a chatter are followed down to this height, in half distances of the supports, then summed up.
MIN_HOP = Decimal("1e-32")
MAX_EVENTS = 200_000
# The way out through each support.
SIDE = {1: 1, 2: -1}
# Velocities this near are the same.
SAME = Decimal("1e-34")

Series = list[Decimal]


@dataclass
class ReferenceMotion:
    """A motion to 20 digits and more: impacts (tau, support, before, after), rests (start, end or None,
    support), states (x, v) at the times asked for, and the last of them."""

    impacts: list[tuple[Decimal, int, Decimal, Decimal]] = field(default_factory=list)
    rests: list[tuple[Decimal, Decimal | None, int]] = field(default_factory=list)
    states: list[tuple[Decimal, Decimal]] = field(default_factory=list)


def period_of(nu: float) -> Decimal:
    """The forcing period 2 pi / nu of the double nu."""
    with localcontext(Context(prec=DIGITS)):
        return TWO * PI / Decimal(nu)


def value(series: Sequence[Decimal], t: Decimal) -> Decimal:
    """The series at t."""
    total = ZERO
    for coefficient in reversed(series):
        total = total * t + coefficient
    return total


def slope(series: Series) -> Series:
    """The derivative of a series."""
    return [n * coefficient for n, coefficient in enumerate(series)][1:]


class ReferenceSolver:
    """One exciter, marched from tau = 0 by `run`."""

    def __init__(self, exciter: Exciter) -> None:
        self.nu, self.f, self.h = Decimal(exciter.nu), Decimal(exciter.f), Decimal(exciter.h)
        # The supports lie where doubles put them.
        self.bound = {1: Decimal(exciter.upper), 2: Decimal(exciter.lower)}
        self.restitution = {1: Decimal(exciter.R1), 2: Decimal(exciter.R2)}
        self.half_distance = Decimal(exciter.l)
        self.reach = ONE / max(self.nu, self.h, ONE)

    def run(self, x0: float, v0: float, times: Sequence[Decimal]) -> ReferenceMotion:
        """The motion from (x0, v0) at tau = 0 to the last of the ascending `times`; an impact at a time comes
        before its state. RuntimeError beyond MAX_EVENTS contacts."""
        with localcontext(Context(prec=DIGITS)):
            self.truth, self.ahead = ReferenceMotion(), deque(times)
            self.tau, self.x, self.v = ZERO, Decimal(x0), Decimal(v0)
            self.force = (ZERO, self.f * self.nu)
            self.met: dict[int, tuple[Decimal, Decimal, int]] = {}
            on = 1 if self.x >= self.bound[1] else 2 if self.x <= self.bound[2] else 0
            for _ in range(MAX_EVENTS):
                if not self.ahead:
                    return self.truth
                released = on > 0 and self.meet(on)
                if released:
                    self.rest(on)
                on = self.fly(on, released)
        raise RuntimeError(f"more than {MAX_EVENTS} contacts up to tau = {float(self.tau):g}")

    def repeat(self, on: int) -> None:
        """Without force and loss a motion that meets a support as it did before goes on as it did then:
        whole rounds up to the next time asked for are written down without being marched."""
        earlier, count = self.met.get(on), len(self.truth.impacts)
        self.met[on] = (self.tau, self.v, count)
        lossless = self.f == self.h == 0 and self.restitution[1] == self.restitution[2] == 1
        if earlier is None or not lossless or abs(earlier[1] - self.v) > SAME * abs(self.v):
            return
        round_trip = self.tau - earlier[0]
        rounds = int((self.ahead[0] - self.tau) / round_trip) - 1
        made = self.truth.impacts[earlier[2] :]
        for k in range(1, rounds + 1):
            self.truth.impacts += [
                (tau + k * round_trip, side, before, after) for tau, side, before, after in made
            ]
        self.tau += max(0, rounds) * round_trip
        self.met.clear()

    def pressing_force(self, on: int) -> Decimal:
        """Force that presses the mass into the support it is on."""
        return SIDE[on] * (self.force[0] - self.bound[on] - self.h * self.v)

    def meet(self, on: int) -> bool:
        """Reset the velocity at a support; whether the mass then stays there, its chatter completed."""
        if SIDE[on] * self.v > 0:
            before, self.v = self.v, -self.restitution[on] * self.v
            self.truth.impacts.append((self.tau, on, before, self.v))
            self.repeat(on)
        pressing_force = self.pressing_force(on)
        if self.v == 0 or pressing_force <= 0 or self.restitution[on] == 1:
            return self.v == 0 and pressing_force >= 0
        left = TWO * abs(self.v) / (pressing_force * (ONE - self.restitution[on]))
        if self.v * self.v > TWO * pressing_force * MIN_HOP * self.half_distance:
            return False
        # The force may turn so soon that the hops are not a geometric series.
        if left * (abs(self.f) * self.nu + self.h * pressing_force) > pressing_force / 1000:
            return False
        self.v = ZERO
        self.pass_time(left, [self.x])
        return True

    def series(self) -> tuple[Series, Series]:
        """Series of the displacement and of the force about now; terms beyond the digits left out."""
        x, force = [self.x, self.v], [*self.force]
        square, power, n = self.nu * self.nu, self.reach * self.reach, 0
        while True:
            scale = (n + 1) * (n + 2)
            x.append((force[n] - self.h * (n + 1) * x[n + 1] - x[n]) / scale)
            force.append(-square * force[n] / scale)
            least = (abs(x[-1]) + abs(x[-2])) * power + (abs(force[-1]) + abs(force[-2])) * power
            if n > 8 and least <= self.half_distance.scaleb(-DIGITS):
                return x, force
            power *= self.reach
            n += 1

    def pass_time(self, span: Decimal, x: Series, force: Series | None = None) -> None:
        """Move on by `span` along a series, telling the states that fall in it."""
        while self.ahead and self.ahead[0] < self.tau + span:
            at = self.ahead.popleft() - self.tau
            self.truth.states.append((value(x, at), value(slope(x), at)))
        while span > 0:
            part = min(span, self.reach)
            if force is None or part < span:
                _x, force = self.series()
            self.force = value(force, part), value(slope(force), part)
            self.tau, span, force = self.tau + part, span - part, None

    def rest(self, on: int) -> None:
        """Lie on a support until it is pushed no more, or until all states are known."""
        start, side = self.tau, SIDE[on]
        while self.ahead:
            if side * self.bound[on] + abs(self.f) <= 0 or self.f == 0:
                # The force can never overcome the spring.
                self.pass_time(self.ahead[-1] - self.tau + ONE, [self.bound[on]])
                break
            _x, force = self.series()
            pressing_force = [side * (force[0] - self.bound[on]), *(side * c for c in force[1:])]
            found = self.first_zero(pressing_force, self.reach)
            self.pass_time(self.reach if found is None else found, [self.bound[on]], force)
            if found is not None:
                self.truth.rests.append((start, self.tau, on))
                return
        self.truth.rests.append((start, None, on))

    def fly(self, on: int, released: bool) -> int:
        """Fly to the next contact; its support, or 0 when all states are known before."""
        order = 0 if not on else 3 if released else 1 if self.v != 0 else 2
        while self.ahead:
            x, force = self.series()
            if order == 3:
                x[2] = ZERO
            span, support = self.reach, 0
            for other, side in SIDE.items():
                gap = [side * (self.bound[other] - x[0]), *(-side * c for c in x[1:])]
                at = self.first_zero(gap[order:] if other == on else gap, span)
                span, support = (span, support) if at is None else (at, other)
            self.pass_time(span, x, force)
            self.v = value(slope(x), span)
            self.x = self.bound[support] if support else value(x, span)
            if support:
                return support
            on, order = 0, 0
        return 0

    def first_zero(self, gap: Series, span: Decimal) -> Decimal | None:
        """The first time in (0, span] at which a series that starts positive falls through zero."""
        rate, second = slope(gap), ZERO
        for n in range(len(gap) - 1, 1, -1):
            second = second * span + n * (n - 1) * abs(gap[n])
        t = ZERO
        while t <= span:
            height, fall = value(gap, t), -value(rate, t)
            if height <= 0 and t > 0:
                return t
            # Below a parabola of the steepest curvature there is no zero.
            root = (fall * fall + TWO * second * height).sqrt() if height > 0 else abs(fall)
            if fall > 0:
                step = TWO * height / (fall + root)
            elif second:
                step = (root - fall) / second
            else:
                step = span
            if step <= CLOSE * self.reach + t * CLOSE:
                bend = value(slope(rate), t)
                if fall > 0 and fall * fall >= TWO * bend * height:
                    return t + step
                # It touches without falling through: on, to the other side of the touch.
                step = max(TWO * fall / bend if bend > 0 else step, CLOSE * self.reach) * TWO
            t += step
        return None
