"""Motions on a ramp by an ordinary integrator, from event to event: soft supports, friction, shaker.

Displacements, forces and the order of events are written from the equations alone; nothing of the march is used.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import vibropipe as vp


class Twin:
    """A motion of an exciter whose frequency goes to `nu_end` within `span`; what happens is in `events`.

    Where it is: `side` of the support that the mass is beyond (0 for none), whether that `pushes`, and the `direction`
    of sliding (0 where friction holds the mass).
    """

    def __init__(self, e: vp.Exciter, nu_end: float, span: float, start: float = 0.0) -> None:
        self.e, self.span = e, span
        self.numbers = e.numbers()
        self.change, self.turn = (nu_end - e.nu) / span, e.nu * start
        self.start = start
        self.fastest = max(e.nu, nu_end) * (2 if e.f2 else 1)
        self.side, self.pushes, self.direction = 0, False, 0
        self.events: dict[str, list[float]] = {}

    def force(self, s: float) -> float:
        """Return the force: a shaker u sin(phase) drives the mass with -u times its second derivative."""
        e, n, nu = self.e, self.numbers, self.e.nu + self.change * s
        phase = self.turn + e.nu * s + self.change * s * s / 2
        first = n.f * math.sin(phase)
        shaken = n.shaker * (nu**2 * math.sin(phase) - self.change * math.cos(phase))
        return first + shaken + n.f2 * math.sin(2 * phase + n.phi2)

    def support(self, x: float, v: float) -> float:
        """Return the force of the support that the mass is beyond, on the mass; negative from support 1."""
        e = self.e
        if self.side == 1:
            return -(e.k1 * (x - e.upper) + e.h1 * v)
        if self.side == 2:
            return -(e.k2 * (x - e.lower) + e.h2 * v)
        return 0.0

    def net(self, s: float, x: float, v: float) -> float:
        """Return the force on the mass without friction."""
        push = self.support(x, v) if self.pushes else 0.0
        return self.force(s) + self.e.load - x - self.e.h * v + push

    def rates(self, s: float, z: Any) -> list[float]:
        """Return the derivative of (x, x')."""
        x, v = z
        if self.is_stuck():
            return [0.0, 0.0]
        return [v, self.net(s, x, v) - self.e.friction * self.direction]

    def is_stuck(self) -> bool:
        """Return whether friction holds the mass."""
        return self.e.friction > 0 and self.direction == 0

    def watched(self) -> dict[str, Callable[[float, Any], float]]:
        """Return functions that fall to zero where something happens."""
        e = self.e
        found: dict[str, Callable[[float, Any], float]] = {}
        if not self.is_stuck():
            if self.side == 0:
                found["meets 1"] = lambda s, z: e.upper - z[0]
                found["meets 2"] = lambda s, z: z[0] - e.lower
            else:
                sign, wall = (1, e.upper) if self.side == 1 else (-1, e.lower)
                found["leaves"] = lambda s, z: sign * (z[0] - wall)
                if (e.contact_1, e.contact_2)[self.side - 1]:
                    out = -1 if self.pushes else 1
                    found["lets go"] = lambda s, z: out * sign * self.support(z[0], z[1])
            if e.friction > 0:
                found["turns"] = lambda s, z: self.direction * z[1]
        else:
            hold = e.friction * e.friction_ratio
            found["slips"] = lambda s, z: hold - abs(self.net(s, z[0], 0.0))
        return found

    def note(self, name: str, value: float) -> None:
        """Append a value to the list of a name."""
        self.events.setdefault(name, []).append(value)

    def goes_on(self, s: float, x: float) -> int:
        """Return the direction in which a mass without velocity goes on."""
        net = self.net(s, x, 0.0)
        return 0 if abs(net) <= self.e.friction * self.e.friction_ratio else int(np.sign(net))

    def strike(self, s: float, z: Any, side: int) -> Any:
        """Return the state after the mass meets a support."""
        e, (_x, v) = self.e, z
        self.note("impact_tau", s)
        self.note("impact_velocity", v)
        stiff, R = ((e.k1, e.R1), (e.k2, e.R2))[side - 1]
        if stiff > 0:
            self.side, self.pushes = side, True
            return z
        after = -R * v
        self.direction = int(np.sign(after))
        return [e.upper if side == 1 else e.lower, after]

    def follow(self, what: str, s: float, z: Any) -> Any:
        """Return the state after an event."""
        x, _v = z
        if what.startswith("meets"):
            return self.strike(s, z, int(what[-1]))
        if what == "leaves":
            self.side, self.pushes = 0, False
            self.note("left", s)
        if what == "lets go":
            self.pushes = not self.pushes
        if what in ("turns", "slips"):
            if what == "turns":
                self.note("turn_tau", s)
            self.direction = 0
            self.direction = self.goes_on(s, x)
            if what == "slips":
                self.direction = int(np.sign(self.net(s, x, 0.0)))
            return [x, 0.0]
        return z

    def log_changes(self, s: float, was_stuck: bool) -> None:
        """Note the end or the beginning of a stick at a time."""
        if was_stuck != self.is_stuck():
            self.note("stick_end" if was_stuck else "stick_start", s)

    def run(self, x: float, v: float, most: int = 40) -> Any:
        """March to the end or through `most` events; return (x, x') there."""
        e, s, z = self.e, 0.0, [x, v]
        self.side = 1 if x > e.upper else 2 if x < e.lower else 0
        self.pushes = self.side > 0
        self.direction = int(np.sign(v)) if v else self.goes_on(0.0, x)
        self.log_changes(0.0, False)
        for _ in range(most):
            k, h = ((0.0, 0.0), (e.k1, e.h1), (e.k2, e.h2))[self.side]
            rate = (h + e.h) / 2 + math.sqrt(((h + e.h) / 2) ** 2 + 1 + k)
            watched = self.watched()
            for each in watched.values():
                each.terminal, each.direction = True, -1  # type: ignore[attr-defined]
            run = solve_ivp(
                self.rates, (s, self.span), z, "DOP853", events=list(watched.values()),
                rtol=2.3e-14, atol=1e-16, max_step=0.12 / max(self.fastest, rate),
                first_step=min(0.1 * abs(z[1]) + 1e-9, self.span - s, 0.1 / max(self.fastest, rate)),
            )  # fmt: skip
            s, z = float(run.t[-1]), list(run.y[:, -1])
            if run.status != 1:
                break
            hit = next(i for i, times in enumerate(run.t_events) if times.size)
            was_stuck = self.is_stuck()
            z = self.follow(list(watched)[hit], s, z)
            if self.is_stuck():
                self.direction = self.goes_on(s, z[0])
            self.log_changes(s, was_stuck)
        self.end = s
        return z
