"""The flights between rigid supports in closed form, over balls of parameters, times and velocities.

Displacements are counted from the equilibrium, which a constant load moves: x = y + load.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from vibropipe.proof.balls import (
    ONE,
    TURN,
    Number,
    ball_of,
    complex_of,
    entire,
    exp,
    imag_of,
    sin_cos,
    sinhc,
    sqrt,
    total,
)

# |h^2/4 - 1| below which the eigenvalues of the free motion count as equal: their root has no derivative at h = 2.
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
    """The equations of motion at parameters that are balls or jets.

    Parameters
    ----------
    p : mapping of str to ball or jet
        Values of all of `words.proofs.BOXED`.

    Attributes
    ----------
    position, restitution : dict of int to ball or jet
        Of each support, 1 and 2.
    forces : list of (int, complex ball or jet)
        Multiples of nu and amplitudes F: the force is the sum of Im(F exp(i k nu tau)).
    """

    def __init__(self, p: Mapping[str, Number]) -> None:
        self.nu, self.h, self.half = p["nu"], p["h"], p["h"] / 2
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
        self.square = self.half * self.half - 1
        self.is_double = not abs(ball_of(self.square)) > MIN_SQUARE
        self.is_slow = bool(ball_of(self.square) > 0)

    @property
    def force_bound(self) -> Number:
        """The largest |force| at any time."""
        return total(abs(ball_of(amplitude)) for _multiple, amplitude in self.forces)

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
        return FreeFlow(c + self.half * s, s, -s, c - self.half * s)

    def response(self, turns: Number, flow: FreeFlow, k: int = 1) -> tuple[Number, Number]:
        """Return displacement and velocity y, y' that the force exp(i k nu tau) causes from rest, after `turns`.

        Their steady part and the free motion would cancel near a resonance and widen balls; y is a divided difference
        of exp(s t) over i k nu and the eigenvalues, without large terms. Where these are nearly equal, no resonance is
        near.
        """
        t, zero = turns * self.period, self.nu * 0
        forced = complex_of(zero, self.nu * k)
        if self.is_double:
            stiffness = complex_of(1 - self.nu * self.nu * k * k, self.h * self.nu * k)
            y = (exp(forced * t) - flow.e11 - forced * flow.e12) / stiffness
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
        """Return x, x' after a flight of `turns` from a state at the time `start`, both in forcing periods."""
        flow = self.flow(turns)
        x1, v1 = flow.e11 * x + flow.e12 * v, flow.e21 * x + flow.e22 * v
        for k, amplitude in self.forces:
            y, rate = self.response(turns, flow, k)
            forcing = amplitude * self.turned(start, k)
            x1, v1 = x1 + imag_of(forcing * y), v1 + imag_of(forcing * rate)
        return x1, v1

    def turned(self, time: Number, k: int) -> Number:
        """Return exp(i k nu tau) at a time in forcing periods."""
        sine, cosine = sin_cos(time * TURN * k)
        return complex_of(cosine, sine)

    def force(self, time: Number) -> Number:
        """Return the force at a time in forcing periods."""
        return sum((imag_of(a * self.turned(time, k)) for k, a in self.forces), self.nu * 0)
