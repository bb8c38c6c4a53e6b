"""The motion on linear pieces in closed form, over balls of parameters, times and states.

Displacements are counted from the equilibrium, which a constant load moves: x = y + load. On a piece z = y - origin,
and
    z'' + H z' + K z = F(tau) + push

with K = 1, H = h, the origin 0 and no push in flight; in contact with a soft support at b, K = 1 + k_i, H = h + h_i,
the origin b and the push -b; sliding, less the friction in the direction of the velocity.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from vibropipe.proof.balls import (
    ONE,
    TURN,
    ZERO,
    Number,
    ball_of,
    complex_of,
    entire,
    exp,
    imag_of,
    real_of,
    sin_cos,
    sinhc,
    sqrt,
    total,
)
from vibropipe.proof.law import FREE, Piece

# |H^2/4 - K|, as a share of K, below which the eigenvalues of the free motion count as equal: their root has no
# derivative where it is 0.
MIN_SQUARE = 0.0625


class FreeFlow(NamedTuple):
    """The flow matrix E of the free motion over some time: (x, x') = E (x0, x0')."""

    e11: Number
    e12: Number
    e21: Number
    e22: Number


def _is_zero(value: Number) -> bool:
    """Return whether a parameter is exactly 0 over the box."""
    return type(value) is type(ONE) and value.is_zero()


class Flights:
    """The equations of motion on a piece at parameters that are balls or jets.

    p : balls or jets, values of all of `words.proofs.BOXED`
    position, restitution : balls or jets of each support, 1 and 2
    origin, stiffness, damping, push : balls or jets of the piece: where z is 0, K, H and the constant force
    forces : multiples of nu and amplitudes F: the force is the sum of Im(F exp(i k nu tau))
    """

    def __init__(self, p: Mapping[str, Number], piece: Piece = FREE) -> None:
        self.p, self.piece, self.nu = p, piece, p["nu"]
        self.position = {1: p["delta"] + p["l"] - p["load"], 2: p["delta"] - p["l"] - p["load"]}
        self.restitution = {1: p["R1"], 2: p["R2"]}
        self.period = TURN / self.nu
        force = p["f"]
        if not _is_zero(p["shaker"]):
            force = p["shaker"] * (self.nu * self.nu) + force
        self.forces = [(1, complex_of(force, force * 0))]
        if not _is_zero(p["f2"]):
            sine, cosine = sin_cos(p["phi2"])
            self.forces.append((2, complex_of(p["f2"] * cosine, p["f2"] * sine)))
        self.origin, self.stiffness, self.damping, self.push = ZERO, ONE, p["h"], ZERO
        if piece.contact:
            k, h = (p[f"{name}{piece.contact}"] for name in "kh")
            self.origin, self.stiffness, self.damping = (
                self.position[piece.contact],
                k + 1,
                p["h"] + h,
            )
            self.push = -self.origin
        if piece.way:
            self.push = self.push - p["friction"] * piece.way
        self.half = self.damping / 2
        self.square = self.half * self.half - self.stiffness
        self.is_double = not abs(ball_of(self.square)) > ball_of(self.stiffness) * MIN_SQUARE
        self.is_slow = bool(ball_of(self.square) > 0)
        self._others: dict[Piece, Flights] = {}

    def on(self, piece: Piece) -> Flights:
        """Return the equations of motion of the same exciter on a piece."""
        if piece == self.piece:
            return self
        if piece not in self._others:
            self._others[piece] = Flights(self.p, piece)
        return self._others[piece]

    @property
    def rate_bound(self) -> Number:
        """The largest derivative of the force by tau at any time."""
        return total(abs(ball_of(amplitude)) * self.nu * k for k, amplitude in self.forces)

    def flow(self, turns: Number) -> FreeFlow:
        """Return the free flow over a time in forcing periods."""
        t = turns * self.period
        decay = exp(-(self.half * t))
        if self.is_double:
            s, c = entire(self.square * t * t)
            s = s * t
        elif self.is_slow:
            rate = sqrt(self.square)
            up, down = exp(rate * t), exp(-(rate * t))
            s, c = (up - down) / (2 * rate), (up + down) / 2
        else:
            omega = sqrt(-self.square)
            s, c = sin_cos(omega * t)
            s = s / omega
        s, c = decay * s, decay * c
        return FreeFlow(c + self.half * s, s, -(self.stiffness * s), c - self.half * s)

    def response(self, turns: Number, flow: FreeFlow, k: int = 1) -> tuple[Number, Number]:
        """Return displacement and velocity y, y' that the force exp(i k nu tau) causes from rest, after `turns`.

        Their steady part and the free motion would cancel near a resonance and widen balls; y is a divided difference
        of exp(s t) over i k nu and the eigenvalues, without large terms. Where these are nearly equal, no resonance is
        near.
        """
        t, zero = turns * self.period, self.nu * 0
        forced = complex_of(zero, self.nu * k)
        if self.is_double:
            y = (exp(forced * t) - flow.e11 - forced * flow.e12) / self.resistance(k)
        else:
            root = sqrt(self.square if self.is_slow else -self.square)
            near, far = (
                complex_of(root * sign - self.half, zero)
                if self.is_slow
                else complex_of(-self.half, root * sign)
                for sign in (1, -1)
            )
            first = exp((forced + near) * t / 2) * sinhc((forced - near) * t / 2) * t
            y = (first - flow.e12) / (forced - far)
        return y, forced * y + flow.e12

    def fly(self, start: Number, turns: Number, x: Number, v: Number) -> tuple[Number, Number]:
        """Return z, z' after `turns` on the piece from a state at the time `start`, both in forcing periods."""
        if self.piece.is_held:
            return x, v * 0
        flow, has_push = self.flow(turns), self.piece != FREE
        centre = self.push / self.stiffness if has_push else ZERO
        if has_push:
            x = x - centre
        x1, v1 = flow.e11 * x + flow.e12 * v, flow.e21 * x + flow.e22 * v
        for k, amplitude in self.forces:
            y, rate = self.response(turns, flow, k)
            forcing = amplitude * self.turned(start, k)
            x1, v1 = x1 + imag_of(forcing * y), v1 + imag_of(forcing * rate)
        return x1 + centre if has_push else x1, v1

    def by_phase(self, start: Number, turns: Number, flow: FreeFlow) -> tuple[Number, Number]:
        """Return the derivatives of z, z' at the end by both times at once, in forcing periods: of the force alone."""
        x, v = self.nu * 0, self.nu * 0
        for k, amplitude in self.forces:
            y, rate = self.response(turns, flow, k)
            forcing = amplitude * self.turned(start, k) * (TURN * k)
            x, v = x + real_of(forcing * y), v + real_of(forcing * rate)
        return x, v

    def resistance(self, k: int) -> Number:
        """Return K - w^2 + i H w at w = k nu: the force exp(i w tau) per displacement that it sustains."""
        w = self.nu * k
        return complex_of(self.stiffness - w * w, self.damping * w)

    def turned(self, time: Number, k: int) -> Number:
        """Return exp(i k nu tau) at a time in forcing periods."""
        sine, cosine = sin_cos(time * TURN * k)
        return complex_of(cosine, sine)

    def force(self, time: Number) -> Number:
        """Return the force at a time in forcing periods."""
        return sum((imag_of(a * self.turned(time, k)) for k, a in self.forces), self.nu * 0)

    def force_rate(self, time: Number) -> Number:
        """Return the derivative of the force by tau."""
        rates = (real_of(a * self.turned(time, k)) * (self.nu * k) for k, a in self.forces)
        return sum(rates, self.nu * 0)

    def acceleration(self, time: Number, x: Number, v: Number = ZERO) -> Number:
        """Return z'' of a state on the piece; of a mass that is held, that without the friction."""
        return self.force(time) + self.push - self.stiffness * x - self.damping * v
