"""Reference solutions with soft supports, friction, a load and a second harmonic: 40 digits, sharing no formula.

Each piece of motion is a power series about successive instants, and what ends it a zero of a series, as in
`lab.reference_solver`, whose arithmetic and search for zeros are used.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from decimal import Context, Decimal, localcontext

from vibropipe.lab.reference_solver import (
    DIGITS,
    MAX_EVENTS,
    MIN_HOP,
    ONE,
    PI,
    SIDE,
    TWO,
    ZERO,
    ReferenceSolver,
    Series,
    derivative,
    value_at,
)
from vibropipe.physics.exciter import Exciter


@dataclass
class PieceMotion:
    """A motion to 20 digits or more.

    events : (tau, kind, support, velocity); kind is one of in, out, impact, turn, stick, slip, rest, release, graze.
    states : (x, v) at the requested times.
    """

    events: list[tuple[Decimal, str, int, Decimal]] = field(default_factory=list)
    states: list[tuple[Decimal, Decimal]] = field(default_factory=list)


def sine_series(phase: Decimal) -> tuple[Decimal, Decimal]:
    """Return sine and cosine of a phase, from their series."""
    phase = phase.remainder_near(TWO * PI)
    sine, cosine, term, n = ZERO, ZERO, ONE, 0
    while abs(term) > Decimal(10) ** (-DIGITS - 5) or n < 4:
        sign = -ONE if n % 4 > 1 else ONE
        sine, cosine = (sine + sign * term, cosine) if n % 2 else (sine, cosine + sign * term)
        n += 1
        term = term * phase / n
    return sine, cosine


class PieceReferenceSolver(ReferenceSolver):
    """Solver of one exciter with any effect; `run` marches from tau = 0."""

    def __init__(self, exciter: Exciter) -> None:
        super().__init__(exciter)
        self.stiffness = {1: Decimal(exciter.k1), 2: Decimal(exciter.k2)}
        self.damping = {1: Decimal(exciter.h1), 2: Decimal(exciter.h2)}
        self.load, self.friction = Decimal(exciter.load), Decimal(exciter.friction)
        self.second = Decimal(exciter.f2), Decimal(exciter.phi2)

    def run_pieces(self, x0: float, v0: float, times: Sequence[Decimal]) -> PieceMotion:
        """Solve the motion from (x0, v0) at tau = 0; `times`, ascending, are as for `ReferenceSolver.run`."""
        with localcontext(Context(prec=DIGITS)):
            self.found, self.times_left = PieceMotion(), deque(times)
            self.tau, self.x, self.v = ZERO, Decimal(x0), Decimal(v0)
            sine, cosine = sine_series(self.second[1])
            amplitude, nu = self.second[0], self.nu
            self.parts = [
                (ZERO, self.f * nu, nu),
                (amplitude * sine, TWO * nu * amplitude * cosine, TWO * nu),
            ]
            self.touched = 1 if self.x >= self.bound[1] else 2 if self.x <= self.bound[2] else 0
            self.pressed, self.direction, self.zeros = 0, ZERO, 0
            self.arrive() if self.touched else self.depart()
            for _ in range(MAX_EVENTS):
                if not self.times_left:
                    last = times[-1]
                    self.found.events = [e for e in self.found.events if e[0] <= last]
                    return self.found
                self.advance()
        raise RuntimeError(f"more than {MAX_EVENTS} events up to tau = {float(self.tau):g}")

    def log(self, kind: str, support: int = 0, velocity: Decimal = ZERO) -> None:
        """Append an event."""
        self.found.events.append((self.tau, kind, support, velocity))

    def coefficients(self) -> tuple[Decimal, Decimal, Decimal]:
        """Return stiffness, damping and constant force of the piece, friction apart."""
        k, h = self.stiffness.get(self.pressed, ZERO), self.damping.get(self.pressed, ZERO)
        return ONE + k, self.h + h, self.load + k * self.bound.get(self.pressed, ZERO)

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
            self.pressed = support if side * self.v > 0 else 0
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
            self.v *= -self.restitution[support]
        elif self.v == 0 and self.tau > 0:
            self.log("graze", support)
        value, rate = self.force_at_rest()
        press = side * (value - self.h * self.v)
        if self.v == 0:
            return press >= -d
        if press - d <= 0 or self.v * self.v > TWO * (press + d) * MIN_HOP * self.half_distance:
            return False
        ratio = ((press - d) / (press + d)).sqrt()
        loss = ONE - self.restitution[support] * ratio
        if loss <= 0:
            return False
        duration = abs(self.v) / (press + d) * (ONE + ONE / ratio) / loss
        if duration * (abs(rate) + self.h * press) > (press - d) / 1000:
            return False
        self.pass_pieces(duration, [self.x])
        return True

    def depart(self) -> None:
        """Go on from where the velocity is zero, or the start: move either way, or be held."""
        if self.v != 0:
            self.direction, self.zeros = ONE.copy_sign(self.v), 0
            return
        value, rate = self.force_at_rest()
        if abs(value) > self.friction:
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
        """Hold the mass until the force exceeds the friction, or the last requested time."""
        stiffness, _damping, constant = self.coefficients()
        ways = [-SIDE[self.touched]] if rests else [1, -1]
        while self.times_left:
            force = self.force_series(self.reach)
            force[0] += constant - stiffness * self.x
            zeros = []
            for way in ways:
                margin = [self.friction - way * force[0], *(-way * c for c in force[1:])]
                if margin[0] > 0 or margin[1] > 0:
                    zeros.append((self.first_zero(margin, self.reach), way))
            crossings = [(t, way) for t, way in zeros if t is not None]
            if all(part[0] == part[1] == 0 for part in self.parts):
                self.pass_pieces(self.times_left[-1] - self.tau + ONE, [self.x])
                return
            span, way = min(crossings, default=(self.reach, 0))
            self.pass_pieces(span, [self.x])
            if way and self.times_left:
                if rests or self.friction > 0:
                    self.log("release" if rests else "slip", self.touched if rests else 0)
                self.direction, self.zeros = Decimal(way), 2
                if not rests:
                    self.press()
                return

    def force_series(self, reach: Decimal) -> Series:
        """Return the series of the force about the current time, accurate up to `reach`."""
        total: Series = []
        for value, slope, nu in self.parts:
            series, n, power = [value, slope], 0, ONE
            while n < 12 or (abs(series[-1]) + abs(series[-2])) * power > Decimal(10) ** -DIGITS:
                series.append(-nu * nu * series[n] / ((n + 1) * (n + 2)))
                n, power = n + 1, power * reach
            total += [ZERO] * (len(series) - len(total))
            for n, c in enumerate(series):
                total[n] += c
        return total

    def pass_pieces(self, span: Decimal, x: Series) -> None:
        """Advance by `span` along a series of x, and record the states at requested times within it."""
        while self.times_left and self.times_left[0] < self.tau + span:
            t = self.times_left.popleft() - self.tau
            self.found.states.append((value_at(x, t), value_at(derivative(x), t)))
        self.tau += span
        turned = []
        for value, slope, nu in self.parts:
            sine, cosine = sine_series(nu * span)
            turned.append(
                (value * cosine + slope / nu * sine, slope * cosine - nu * value * sine, nu)
            )
        self.parts = turned

    def advance(self) -> None:
        """Advance along one series: to the next event, or by its reach."""
        stiffness, damping, constant = self.coefficients()
        constant -= self.friction * self.direction
        reach = ONE / max(TWO * self.nu, damping, stiffness.sqrt(), ONE)
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
        for support, side in SIDE.items():
            if self.pressed and support != self.pressed:
                continue
            way = -side if self.pressed else side
            gap = [way * (self.bound[support] - x[0]), *(-way * c for c in x[1:])]
            start = self.zeros + 1 if support == self.touched else 0
            t = self.first_zero(gap[start:], span)
            span, kind = (span, kind) if t is None else (t, support)
        if self.friction > 0:
            t = self.first_zero([self.direction * c for c in derivative(x)[self.zeros :]], span)
            span, kind = (span, kind) if t is None else (t, 0)
        self.pass_pieces(span, x)
        self.v = value_at(derivative(x), span)
        self.x = self.bound[kind] if kind > 0 else value_at(x, span)
        self.touched, self.zeros = max(kind, 0), 0
        if kind > 0:
            self.arrive()
        elif kind == 0:
            self.v = ZERO
            self.log("turn")
            self.depart()
