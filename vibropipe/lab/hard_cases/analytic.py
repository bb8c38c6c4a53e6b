"""Known properties of motions, computed without time marching: closed forms in numpy, independent of the kernels."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from vibropipe.physics.exciter import Exciter

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

# Terms of the series of the matrix exponential, enough for rounding at a norm below 1/2.
TERMS = 20
# Points of each flight at which it must lie between the supports.
POINTS_PER_FLIGHT = 8


def propagators(exciter: Exciter, spans: Floats) -> Floats:
    """Return exp(A span), the flow of eq. (5), by scaling and squaring of its Taylor series.

    spans : (n,) time spans, also negative ones
    Returns (n, 4, 4) propagators of the state (x, x', f sin(nu tau), f cos(nu tau)).
    """
    a = np.zeros((4, 4))
    a[0, 1], a[1, 0], a[1, 1], a[1, 2] = 1.0, -1.0, -exciter.h, 1.0
    a[2, 3], a[3, 2] = exciter.nu, -exciter.nu
    largest_norm = float(np.max(np.abs(spans), initial=0.0)) * max(2.0, 1.0 + exciter.h, exciter.nu)
    halvings = max(0, math.ceil(math.log2(largest_norm)) + 2) if largest_norm > 0.25 else 0
    small = a * (spans / 2.0**halvings)[:, None, None]
    power = np.broadcast_to(np.eye(4), small.shape)
    # exp(A) - 1 is squared, not exp(A): adding the identity would round off the small changes of a short span.
    series = np.zeros_like(small)
    for n in range(1, TERMS):
        power = power @ small / n
        series = series + power
    for _ in range(halvings):
        series = 2.0 * series + series @ series
    return np.eye(4) + series


def newmark_propagator(exciter: Exciter, steps: int) -> Floats:
    """Return one step of constant average acceleration for (x, x', f sin, f cos), shape (4, 4)."""
    dt, phase = 2.0 * math.pi / exciter.nu / steps, 2.0 * math.pi / steps
    force = np.array(
        [-1.0, -exciter.h - dt / 2.0, 0.5 * (1.0 + math.cos(phase)), 0.5 * math.sin(phase)]
    )
    acceleration = force / (1.0 + exciter.h * dt / 2.0 + dt * dt / 4.0)
    matrix = np.eye(4)
    matrix[0] += 0.5 * dt * dt * acceleration
    matrix[0, 1] += dt
    matrix[1] += dt * acceleration
    matrix[2:, 2:] = [[math.cos(phase), math.sin(phase)], [-math.sin(phase), math.cos(phase)]]
    return matrix


def linear_end(exciter: Exciter, periods: int, steps: int | None) -> tuple[float, float]:
    """Return (x, x') after whole forcing periods of the motion from rest without supports.

    steps : steps per forcing period of Newmark's method, whose own motion is returned; None for the exact one
    """
    if steps is None:
        propagator = propagators(exciter, np.array([2.0 * math.pi * periods / exciter.nu]))[0]
    else:
        propagator = np.linalg.matrix_power(newmark_propagator(exciter, steps), periods * steps)
    return float(propagator[0, 3] * exciter.f), float(propagator[1, 3] * exciter.f)


def effective_frequency(exciter: Exciter, steps: int | None) -> float:
    """Return the frequency at which a method responds to the force: nu, or (2/dt) tan(nu dt/2) for Newmark's.

    Constant average acceleration is the trapezoidal rule (bilinear transform), which warps frequencies in this way.
    """
    return exciter.nu if steps is None else exciter.nu * steps / math.pi * math.tan(math.pi / steps)


def response(exciter: Exciter, steps: int | None) -> complex:
    """Return the complex amplitude X of the method's steady linear motion x = Im(X exp(i nu tau))."""
    frequency = effective_frequency(exciter, steps)
    return exciter.f / complex((1.0 - frequency) * (1.0 + frequency), exciter.h * frequency)


def first_peak(exciter: Exciter, steps: int | None, v0: float = 0.0) -> tuple[float, float]:
    """Return time and height of the first peak of the motion from x = 0, without supports.

    With `steps`, of Newmark's own motion, a parabola in each step.
    """
    dt = 2.0 * math.pi / exciter.nu / (steps or 256)
    x, v, tau = 0.0, v0, 0.0
    step = (
        propagators(exciter, np.array([dt]))[0]
        if steps is None
        else newmark_propagator(exciter, steps)
    )
    for n in range(100_000):
        phase = 2.0 * math.pi / (steps or 256) * n
        load = exciter.f * np.array([math.sin(phase), math.cos(phase)])
        x1, v1 = (step @ np.array([x, v, *load]))[:2]
        if v > 0.0 >= v1:
            acceleration = (v1 - v) / dt
            if steps is not None:
                return tau + v / -acceleration, x + 0.5 * v * v / -acceleration
            return _peak_between(exciter, tau, x, v, load, dt)
        x, v, tau = float(x1), float(v1), tau + dt
    return math.inf, math.inf


def _peak_between(
    exciter: Exciter, tau: float, x: float, v: float, load: Floats, dt: float
) -> tuple[float, float]:
    """Return time and height of the peak within a step of the exact motion, by bisection of the velocity."""
    low, high = 0.0, dt
    state = np.array([x, v, *load])
    for _ in range(60):
        middle = 0.5 * (low + high)
        state_at_middle = propagators(exciter, np.array([middle]))[0] @ state
        low, high = (middle, high) if state_at_middle[1] > 0 else (low, middle)
    return tau + low, float((propagators(exciter, np.array([low]))[0] @ state)[0])


def flights(
    exciter: Exciter, motion: xr.Dataset, tau_end: float, x0: float, v0: float
) -> tuple[Floats, Floats]:
    """Return where each flight of a motion begins and ends.

    A flight begins with the start, an impact or a release, and ends with an impact or the end of the motion.

    motion : dataset of `simulate`
    tau_end, x0, v0 : end and start of the motion
    Returns starts and ends, (flights, 3) each: (tau, x, x') at the start and the end of each flight.
    """
    support_x = {1: exciter.upper, 2: exciter.lower}
    impact_x = [support_x[s] for s in motion["impact_support"].values.tolist()]
    impact_tau, before, after = (
        motion[name].values for name in ("impact_tau", "impact_velocity", "impact_velocity_after")
    )
    rests = rests_of(motion)
    departures = [(0.0, x0, v0), *zip(impact_tau.tolist(), impact_x, after.tolist(), strict=True)]
    departures += [(end, support_x[s], 0.0) for _, end, s in rests if end < tau_end]
    departures.sort(key=lambda item: item[0])
    arrivals = list(zip(impact_tau.tolist(), impact_x, before.tolist(), strict=True))
    if not any(start <= tau_end <= end for start, end, _ in rests):
        arrivals.append((tau_end, float(motion["displacement_end"]), float(motion["velocity_end"])))
    departed, ends = np.array(departures), np.array(arrivals).reshape(-1, 3)
    starts = departed[np.maximum(np.searchsorted(departed[:, 0], ends[:, 0]) - 1, 0)]
    return starts, ends


def add_force(exciter: Exciter, states: Floats) -> Floats:
    """Return states (tau, x, x') as (x, x', f sin, f cos)."""
    phases = exciter.nu * states[:, 0]
    return np.column_stack([states[:, 1:], exciter.f * np.sin(phases), exciter.f * np.cos(phases)])


def flight_error(
    exciter: Exciter, motion: xr.Dataset, tau_end: float, x0: float, v0: float
) -> float:
    """Return the largest deviation of the flights of a motion from the closed form, relative to its size.

    Each flight is propagated from its start; the deviation is that of its end, or the penetration of a support on the
    way. Arguments as of `flights`.
    """
    starts, ends = flights(exciter, motion, tau_end, x0, v0)
    if not ends.size:
        return 0.0
    sizes = np.abs(np.concatenate([starts, ends])[:, 1:]).max(axis=0) + 1e-300
    states = add_force(exciter, starts)
    propagator = propagators(exciter, (ends[:, 0] - starts[:, 0]) / POINTS_PER_FLIGHT)
    penetration = 0.0
    for _ in range(POINTS_PER_FLIGHT):
        states = np.einsum("nij,nj->ni", propagator, states)
        penetration = max(penetration, float((states[:, 0] - exciter.upper).max(initial=0.0)))
        penetration = max(penetration, float((exciter.lower - states[:, 0]).max(initial=0.0)))
    deviation = np.abs(states[:, :2] - ends[:, 1:]) / sizes
    return max(float(np.max(deviation)), penetration / float(sizes[0]))


def rests_of(motion: xr.Dataset) -> list[tuple[float, float, int]]:
    """Return the rests of a motion as (start, end, support)."""
    columns = (motion[name].values.tolist() for name in ("rest_start", "rest_end", "rest_support"))
    return list(zip(*columns, strict=True))


def violations(exciter: Exciter, motion: xr.Dataset) -> int:
    """Return the number of violations of properties that any method must keep, whatever its step.

    These are: finite numbers; samples and end between the supports; impacts in order of time, with approaching
    velocities, reset by eq. (6) to rounding.
    """
    x = np.append(motion["displacement"].values, float(motion["displacement_end"]))
    v = np.append(motion["velocity"].values, float(motion["velocity_end"]))
    before, after = motion["impact_velocity"].values, motion["impact_velocity_after"].values
    upper = motion["impact_support"].values == 1
    restitution = np.where(upper, exciter.R1, exciter.R2)
    rounding = 4.0 * np.finfo(float).eps * np.abs(before)
    is_violated = [
        ~np.isfinite(x) | ~np.isfinite(v),
        (x > exciter.upper) | (x < exciter.lower),
        np.diff(motion["impact_tau"].values) < 0,
        (before > 0) != upper,
        ~(np.abs(after + restitution * before) <= rounding),
    ]
    return int(sum(np.count_nonzero(mask) for mask in is_violated))
