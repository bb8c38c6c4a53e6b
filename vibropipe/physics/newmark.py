"""Newmark's method with constant average acceleration (beta = 1/4, gamma = 1/2), the method of the paper.

Within a step the acceleration is its mean over the step, so the motion is quadratic in time. Impacts are located on
this interpolant of the method, which preserves its second order.

References
----------
N. M. Newmark, "A method of computation for structural dynamics", Journal of the Engineering Mechanics Division,
ASCE 85 (EM3) (1959) 67-94.
"""

from __future__ import annotations

from vibropipe.compiler import jit
from vibropipe.physics.flow import StepMap


@jit
def mean_acceleration(y, w, force_mean, h, dt):
    """Return the mean acceleration of a step from (y, w).

    The mean of y'' = force - h y' - y over the step, with y' and y at its end expressed by the mean acceleration, is
    one linear equation for it.

    force_mean : mean of the forces at both ends; h : damping, None where it is absent; dt : length of the step.
    """
    if h is None:
        return (force_mean - 0.5 * dt * w - y) / (1.0 + 0.25 * dt * dt)
    return (force_mean - (h + 0.5 * dt) * w - y) / (1.0 + 0.5 * h * dt + 0.25 * dt * dt)


@jit
def newmark_map(h: float, dt: float):
    """Return the `StepMap` of a step of length dt, whose load is the mean force of the step; h : damping."""
    m1 = mean_acceleration(1.0, 0.0, 0.0, h, dt)
    m2 = mean_acceleration(0.0, 1.0, 0.0, h, dt)
    m3 = mean_acceleration(0.0, 0.0, 1.0, h, dt)
    half = 0.5 * dt * dt
    return StepMap(1.0 + half * m1, dt + half * m2, half * m3, dt * m1, 1.0 + dt * m2, dt * m3)


@jit
def quadratic(c, y, w, force_start, force_end, h, span, dt) -> None:
    """Fill c, shape (3,), with the motion over a step of length span, as a polynomial in theta = t/dt."""
    mean = mean_acceleration(y, w, 0.5 * (force_start + force_end), h, span)
    c[0] = y
    c[1] = w * dt
    c[2] = 0.5 * dt * dt * mean


@jit
def step(y, w, force_start, force_end, h, dt):
    """Return (y, w) after one step.

    y, w : state at the start
    force_start, force_end : force and constant load at both ends
    h : damping; None where it is absent
    dt : length of the step in tau
    """
    mean = mean_acceleration(y, w, 0.5 * (force_start + force_end), h, dt)
    return y + dt * (w + 0.5 * dt * mean), w + dt * mean
