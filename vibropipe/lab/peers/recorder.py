"""What a run of another package has to know beside its equation: impacts, its linear piece, and the work done."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from vibropipe.lab.work_precision_methods import (
    SAMPLES,
    BenchmarkMotion,
    MethodResult,
    failed,
)
from vibropipe.words.measurements import Outcome

# Largest work per forcing period: evaluations of the equation, or steps of heyoka. It is counted, not timed, so that
# the same runs are stopped on every machine.
MAX_WORK = 10_000
# Work of a restart after an event, in evaluations of the equation.
RESTART = 100
# Largest penetration of a rigid support, relative to l; beyond it an impact was missed.
MAX_PENETRATION = 1e-3
# What is added to a velocity, or to the gap of a soft support, that is zero where a piece begins and again where it
# ends: the event function then begins on its own side of zero, and both packages find its zero in a first step, too.
# The time of the event moves by as much over its rate, below what is compared.
OFFSET = 1e-14


class WorkError(Exception):
    """The work that a run may do is used up."""


def sample_times(motion: BenchmarkMotion) -> np.ndarray:
    """Return the times of the samples (SAMPLES,) in the last period, followed by the end."""
    period = motion.exciter.period
    return (motion.periods - 1 + np.arange(SAMPLES + 1) / SAMPLES) * period


class Recorder:
    """Record of a run: its impacts, the linear piece it is on and, if `bounded`, the work it may still do.

    pressed : the soft support that acts on the mass; 0 if none
    direction : sign of the velocity, or of the velocity that the mass is about to have; 0 if friction holds it
    """

    def __init__(self, motion: BenchmarkMotion, *, bounded: bool = True) -> None:
        e = motion.exciter
        self.exciter, self.impacts = e, list[tuple[float, int, float]]()
        self.restitution = {1: e.R1, 2: e.R2}
        self.bound = {1: e.upper, 2: e.lower}
        self.stiffness, self.damping = {1: e.k1, 2: e.k2}, {1: e.h1, 2: e.h2}
        self.work_left = MAX_WORK * motion.periods if bounded else math.inf
        x, v = motion.x0, motion.v0
        support = 1 if x >= e.upper else 2 if x <= e.lower else 0
        self.pressed = support if self.is_soft(support) and x != self.bound[support] else 0
        self.direction = 1.0
        self.go_on(0.0, x, v)
        if self.is_soft(support) and not self.pressed and (self.direction > 0) == (support == 1):
            self.pressed = support

    def is_soft(self, support: int) -> bool:
        """Return whether a support is soft; 0 is none."""
        return self.stiffness.get(support, 0.0) > 0.0

    def spend(self, work: int = 1) -> bool:
        """Count work; return whether any is left."""
        self.work_left -= work
        return self.work_left > 0

    def coefficients(self) -> tuple[float, float, float]:
        """Return stiffness, damping and constant force of the piece."""
        k, h = self.stiffness.get(self.pressed, 0.0), self.damping.get(self.pressed, 0.0)
        constant = k * self.bound.get(self.pressed, 0.0) - self.exciter.friction * self.direction
        return 1.0 + k, self.exciter.h + h, constant

    def force_at(self, tau: float) -> float:
        """Return the periodic force."""
        e = self.exciter
        force = e.f * math.sin(e.nu * tau)
        return force + e.f2 * math.sin(2 * e.nu * tau + e.phi2) if e.f2 else force

    def force_at_rest(self, tau: float, x: float) -> float:
        """Return the force on the mass without velocity, friction apart."""
        k = self.stiffness.get(self.pressed, 0.0)
        return self.force_at(tau) - x - k * (x - self.bound.get(self.pressed, 0.0))

    def go_on(self, tau: float, x: float, v: float) -> None:
        """Set the direction in which the mass goes on from a state; without velocity it may be held."""
        if v == 0.0:
            v = self.force_at_rest(tau, x)
            if self.exciter.friction > 0.0 and abs(v) <= self.exciter.friction:
                v = 0.0
        self.direction = math.copysign(1.0, v) if v else 0.0

    def is_held(self) -> bool:
        """Return whether friction holds the mass."""
        return self.direction == 0.0 and self.exciter.friction > 0.0

    def release(self, tau: float, x: float) -> None:
        """Let a held mass go as the force pulls it."""
        self.direction = math.copysign(1.0, self.force_at_rest(tau, x))
        self.work_left -= RESTART

    def turn(self, tau: float, x: float) -> None:
        """Let a mass go on that has lost its velocity."""
        self.go_on(tau, x, 0.0)
        self.work_left -= RESTART

    def meet(self, tau: float, support: int, velocity: float) -> float:
        """Strike a rigid support, enter a soft one or leave it; return the velocity after it."""
        self.work_left -= RESTART
        if self.pressed == support:
            self.pressed = 0
            return velocity
        self.impacts.append((tau, support, velocity))
        if self.is_soft(support):
            self.pressed = support
            return velocity
        after = -self.restitution[support] * velocity
        self.direction = math.copysign(1.0, after)
        return after

    def result(self, samples: Any, end: Any, work: tuple[float, float, float]) -> MethodResult:
        """Return the result of a run; its outcome reports nan and penetration of a rigid support."""
        tau, support, velocity = np.array(self.impacts or np.empty((0, 3))).T
        x = np.append(samples, end[0])
        if not np.isfinite([*x, end[1]]).all():
            return failed(Outcome.DID_NOT_END)
        depths = {1: x.max() - self.bound[1], 2: self.bound[2] - x.min()}
        depth = max((depths[i] for i in depths if not self.is_soft(i)), default=0.0)
        fell = depth > MAX_PENETRATION * self.exciter.l
        return MethodResult(
            Outcome.FELL_THROUGH if fell else Outcome.OK,
            (float(end[0]), float(end[1])),
            tau,
            support,
            velocity,
            samples,
            work,
        )
