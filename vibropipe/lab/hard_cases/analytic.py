"""What is known of a motion without marching it: closed forms, in plain numpy, apart from the kernels."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from vibropipe.physics.exciter import Exciter

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

TERMS = 20  # of the exponential's series, for a matrix of norm below 1/2
INSIDE = 8  # looks into each flight


def propagators(exciter: Exciter, spans: Floats) -> Floats:
    """exp(A span) of (x, x', f sin, f cos) by eq. (5), shape (spans, 4, 4): series, then squarings."""
    a = np.zeros((4, 4))
    a[0, 1], a[1, 0], a[1, 1], a[1, 2] = 1.0, -1.0, -exciter.h, 1.0
    a[2, 3], a[3, 2] = exciter.nu, -exciter.nu
    longest = float(np.max(np.abs(spans), initial=0.0)) * max(2.0, 1.0 + exciter.h, exciter.nu)
    halvings = max(0, math.ceil(math.log2(longest)) + 2) if longest > 0.25 else 0
    small = a * (spans / 2.0**halvings)[:, None, None]
    power = np.broadcast_to(np.eye(4), small.shape)
    # exp(A) - 1 is what is squared: the part that a short span leaves unchanged rounds nothing off.
    rest = np.zeros_like(small)
    for n in range(1, TERMS):
        power = power @ small / n
        rest = rest + power
    for _ in range(halvings):
        rest = 2.0 * rest + rest @ rest
    return np.eye(4) + rest


def newmark_propagator(exciter: Exciter, steps: int) -> Floats:
    """One step of constant average acceleration for (x, x', f sin, f cos), shape (4, 4)."""
    dt, turn = 2.0 * math.pi / exciter.nu / steps, 2.0 * math.pi / steps
    force = np.array(
        [-1.0, -exciter.h - dt / 2.0, 0.5 * (1.0 + math.cos(turn)), 0.5 * math.sin(turn)]
    )
    pull = force / (1.0 + exciter.h * dt / 2.0 + dt * dt / 4.0)
    one = np.eye(4)
    one[0] += 0.5 * dt * dt * pull
    one[0, 1] += dt
    one[1] += dt * pull
    one[2:, 2:] = [[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]]
    return one


def linear(exciter: Exciter, periods: int, steps: int | None) -> tuple[float, float]:
    """(x, x') after whole forcing periods of the motion from rest that meets no support, as the method has it."""
    if steps is None:
        whole = propagators(exciter, np.array([2.0 * math.pi * periods / exciter.nu]))[0]
    else:
        whole = np.linalg.matrix_power(newmark_propagator(exciter, steps), periods * steps)
    return float(whole[0, 3] * exciter.f), float(whole[1, 3] * exciter.f)


def effective_frequency(exciter: Exciter, steps: int | None) -> float:
    """The frequency at which a method answers the force: nu, or (2/dt) tan(nu dt/2) by Newmark's.

    Constant average acceleration is the trapezoidal rule, which bends the axis of frequencies so.
    """
    return exciter.nu if steps is None else exciter.nu * steps / math.pi * math.tan(math.pi / steps)


def transfer(exciter: Exciter, steps: int | None) -> complex:
    """Complex amplitude of the settled linear motion x = Im(X exp(i nu tau)), as the method has it."""
    rate = effective_frequency(exciter, steps)
    return exciter.f / complex((1.0 - rate) * (1.0 + rate), exciter.h * rate)


def first_peak(exciter: Exciter, steps: int | None, v0: float = 0.0) -> tuple[float, float]:
    """Time and height of the first peak of the motion from x = 0, were no support there.

    With `steps`, of Newmark's own motion, a parabola in every step.
    """
    dt = 2.0 * math.pi / exciter.nu / (steps or 256)
    x, v, tau = 0.0, v0, 0.0
    step = (
        propagators(exciter, np.array([dt]))[0]
        if steps is None
        else newmark_propagator(exciter, steps)
    )
    for n in range(100_000):
        angle = 2.0 * math.pi / (steps or 256) * n
        load = exciter.f * np.array([math.sin(angle), math.cos(angle)])
        x1, v1 = (step @ np.array([x, v, *load]))[:2]
        if v > 0.0 >= v1:
            pull = (v1 - v) / dt
            if steps is not None:
                return tau + v / -pull, x + 0.5 * v * v / -pull
            return _peak_between(exciter, tau, x, v, load, dt)
        x, v, tau = float(x1), float(v1), tau + dt
    return math.inf, math.inf


def _peak_between(
    exciter: Exciter, tau: float, x: float, v: float, load: Floats, dt: float
) -> tuple[float, float]:
    """The peak inside a step of the exact motion: bisection on the velocity."""
    low, high = 0.0, dt
    state = np.array([x, v, *load])
    for _ in range(60):
        middle = 0.5 * (low + high)
        at = propagators(exciter, np.array([middle]))[0] @ state
        low, high = (middle, high) if at[1] > 0 else (low, middle)
    return tau + low, float((propagators(exciter, np.array([low]))[0] @ state)[0])


def flights(
    exciter: Exciter, motion: xr.Dataset, tau_end: float, x0: float, v0: float
) -> tuple[Floats, Floats]:
    """(tau, x, x') where each flight of a motion begins and where it ends, two arrays of shape (flights, 3).

    A flight begins with the start, an impact or a release, and ends with an impact or the end.
    """
    support_x = {1: exciter.upper, 2: exciter.lower}
    struck = [support_x[s] for s in motion["impact_support"].values.tolist()]
    taus, before, after = (
        motion[name].values for name in ("impact_tau", "impact_velocity", "impact_velocity_after")
    )
    rests = rests_of(motion)
    leave = [(0.0, x0, v0), *zip(taus.tolist(), struck, after.tolist(), strict=True)]
    leave += [(end, support_x[s], 0.0) for _, end, s in rests if end < tau_end]
    leave.sort(key=lambda item: item[0])
    meet = list(zip(taus.tolist(), struck, before.tolist(), strict=True))
    if not any(start <= tau_end <= end for start, end, _ in rests):
        meet.append((tau_end, float(motion["displacement_end"]), float(motion["velocity_end"])))
    began, arrived = np.array(leave), np.array(meet).reshape(-1, 3)
    came = began[np.maximum(np.searchsorted(began[:, 0], arrived[:, 0]) - 1, 0)]
    return came, arrived


def with_force(exciter: Exciter, states: Floats) -> Floats:
    """States (tau, x, x') as (x, x', f sin, f cos)."""
    turned = exciter.nu * states[:, 0]
    return np.column_stack([states[:, 1:], exciter.f * np.sin(turned), exciter.f * np.cos(turned)])


def flight_error(
    exciter: Exciter, motion: xr.Dataset, tau_end: float, x0: float, v0: float
) -> float:
    """How far the flights of a motion are from the closed form, relative to the motion's size.

    Each is propagated from where it begins: it must arrive where it ends, and stay between the supports.
    """
    came, arrived = flights(exciter, motion, tau_end, x0, v0)
    if not arrived.size:
        return 0.0
    sizes = np.abs(np.concatenate([came, arrived])[:, 1:]).max(axis=0) + 1e-300
    states = with_force(exciter, came)
    part = propagators(exciter, (arrived[:, 0] - came[:, 0]) / INSIDE)
    beyond = 0.0
    for _ in range(INSIDE):
        states = np.einsum("nij,nj->ni", part, states)
        beyond = max(beyond, float((states[:, 0] - exciter.upper).max(initial=0.0)))
        beyond = max(beyond, float((exciter.lower - states[:, 0]).max(initial=0.0)))
    miss = np.abs(states[:, :2] - arrived[:, 1:]) / sizes
    return max(float(np.max(miss)), beyond / float(sizes[0]))


def rests_of(motion: xr.Dataset) -> list[tuple[float, float, int]]:
    """Rests of a motion as (start, end, support)."""
    columns = (motion[name].values.tolist() for name in ("rest_start", "rest_end", "rest_support"))
    return list(zip(*columns, strict=True))


def violations(exciter: Exciter, motion: xr.Dataset) -> int:
    """How often a motion breaks what any method must keep, whatever its step.

    Finite numbers; samples and end between the supports; impacts in order, at approaching velocities, reset by
    eq. (6) to the last bits.
    """
    x = np.append(motion["displacement"].values, float(motion["displacement_end"]))
    v = np.append(motion["velocity"].values, float(motion["velocity_end"]))
    before, after = motion["impact_velocity"].values, motion["impact_velocity_after"].values
    upper = motion["impact_support"].values == 1
    restitution = np.where(upper, exciter.R1, exciter.R2)
    rounding = 4.0 * np.finfo(float).eps * np.abs(before)
    wrong = [
        ~np.isfinite(x) | ~np.isfinite(v),
        (x > exciter.upper) | (x < exciter.lower),
        np.diff(motion["impact_tau"].values) < 0,
        (before > 0) != upper,
        ~(np.abs(after + restitution * before) <= rounding),
    ]
    return int(sum(np.count_nonzero(found) for found in wrong))
