"""Newmark's method as a textbook loop in plain numba: the reference of the lane kernels."""

from __future__ import annotations

import math
from collections.abc import Callable

import numba


def newmark_loop(p: tuple[float, ...], steps: int, periods: int) -> tuple[float, float, int]:
    """March from rest by Newmark's method with impacts applied at the end of the step.

    Constant average acceleration is written as one linear map of x, v and the mean force of a step.

    Parameters
    ----------
    p : tuple of float
        nu, f, h, l (supports at -l and l) and R of both supports.
    steps, periods : int
        Steps per forcing period and number of forcing periods.

    Returns
    -------
    x, v : float
        State at the end.
    n_impacts : int
        Number of impacts.
    """
    nu, f, h, half_distance, R = p
    dt = 2.0 * math.pi / nu / steps
    divisor = 1.0 + 0.5 * h * dt + 0.25 * dt * dt
    a11, a12, b1 = (
        1.0 - 0.5 * dt * dt / divisor,
        dt - 0.5 * dt * dt * (h + 0.5 * dt) / divisor,
        0.5 * dt * dt / divisor,
    )
    a21, a22, b2 = -dt / divisor, 1.0 - dt * (h + 0.5 * dt) / divisor, dt / divisor
    x, v, n_impacts, force = 0.0, 0.0, 0, 0.0
    for n in range(1, periods * steps + 1):
        next_force = f * math.sin(nu * n * dt)
        mean = 0.5 * (force + next_force)
        x, v = a11 * x + a12 * v + b1 * mean, a21 * x + a22 * v + b2 * mean
        force = next_force
        if abs(x) >= half_distance and x * v > 0.0:
            x, v = math.copysign(half_distance, x), -R * v
            n_impacts += 1
    return x, v, n_impacts


textbook: Callable[..., tuple[float, float, int]] = numba.njit()(newmark_loop)
