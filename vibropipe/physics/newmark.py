"""Newmark's constant average acceleration (beta = 1/4, gamma = 1/2), the method of the paper.

Within a step the acceleration is its mean over the step, so the motion is a quadratic in time: the method's
own interpolation, on which impacts are located so that second order survives.

N. M. Newmark, "A method of computation for structural dynamics", Journal of the Engineering Mechanics Division,
ASCE 85 (EM3) (1959) 67-94.
"""

from __future__ import annotations

from vibropipe.compiler import jit


@jit
def mean_acceleration(y, w, force_mean, h, dt):
    """Mean acceleration of a step of length dt from (y, w) under the mean of the forces at its two ends.

    Averaging y'' = force - h y' - y over the step, with y' and y at its end written by the mean
    acceleration itself, leaves one linear equation for it. h: None where there is no damping.
    """
    if h is None:
        return (force_mean - 0.5 * dt * w - y) / (1.0 + 0.25 * dt * dt)
    return (force_mean - (h + 0.5 * dt) * w - y) / (1.0 + 0.5 * h * dt + 0.25 * dt * dt)


@jit
def newmark_map(h: float, dt: float):
    """The one-step map of the method in the form of `flow.exact_map`, with the mean force of the step as load:
    (a11, a12, b1, a21, a22, b2)."""
    m1 = mean_acceleration(1.0, 0.0, 0.0, h, dt)
    m2 = mean_acceleration(0.0, 1.0, 0.0, h, dt)
    m3 = mean_acceleration(0.0, 0.0, 1.0, h, dt)
    half = 0.5 * dt * dt
    return (1.0 + half * m1, dt + half * m2, half * m3, dt * m1, 1.0 + dt * m2, dt * m3)


@jit
def quadratic(c, y, w, force_start, force_end, h, span, dt) -> None:
    """Fill c[0..2] with the method's motion over a step of length span, as a polynomial in theta = t/dt."""
    mean = mean_acceleration(y, w, 0.5 * (force_start + force_end), h, span)
    c[0] = y
    c[1] = w * dt
    c[2] = 0.5 * dt * dt * mean


@jit
def step(y, w, force_start, force_end, h, dt):
    """(y, w) after one step of length dt."""
    mean = mean_acceleration(y, w, 0.5 * (force_start + force_end), h, dt)
    return y + dt * (w + 0.5 * dt * mean), w + dt * mean
