"""Newmark's method as a textbook has it, in plain numba: what marching in lanes is measured against."""

from __future__ import annotations

import math
from collections.abc import Callable

import numba


def newmark_loop(p: tuple[float, ...], steps: int, periods: int) -> tuple[float, float, int]:
    """(x, v) and the number of impacts after whole forcing periods from rest; p: nu, f, h, l, R of both supports.

    Constant average acceleration written as one linear map of x, v and the mean force of a step, and a reset at
    the end of the step that has passed a support.
    """
    nu, f, h, half, R = p
    dt = 2.0 * math.pi / nu / steps
    d = 1.0 + 0.5 * h * dt + 0.25 * dt * dt
    a11, a12, b1 = (
        1.0 - 0.5 * dt * dt / d,
        dt - 0.5 * dt * dt * (h + 0.5 * dt) / d,
        0.5 * dt * dt / d,
    )
    a21, a22, b2 = -dt / d, 1.0 - dt * (h + 0.5 * dt) / d, dt / d
    x, v, struck, force = 0.0, 0.0, 0, 0.0
    for n in range(1, periods * steps + 1):
        next_force = f * math.sin(nu * n * dt)
        mean = 0.5 * (force + next_force)
        x, v = a11 * x + a12 * v + b1 * mean, a21 * x + a22 * v + b2 * mean
        force = next_force
        if abs(x) >= half and x * v > 0.0:
            x, v = math.copysign(half, x), -R * v
            struck += 1
    return x, v, struck


textbook: Callable[..., tuple[float, float, int]] = numba.njit()(newmark_loop)
