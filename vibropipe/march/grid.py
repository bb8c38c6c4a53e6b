"""The grid of steps in a forcing period, and the one-step map of either method on it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline
from vibropipe.physics.flow import (
    exact_map,
    exact_map_of_second,
    fill_basis,
    motion,
    new_basis,
    steps_for_exact,
)
from vibropipe.physics.frequency import Moment, Ramp, ramp_of
from vibropipe.physics.limits import MAX_TABLE
from vibropipe.physics.load import fastest_forcing, force_bounds, forcing_period
from vibropipe.physics.load_steps import (
    contribution_of_second,
    exact_factors,
    exact_factors_of_second,
    fill_sincos,
    force_contribution,
    mean_factors,
    mean_factors_of_second,
    sincos_at_step,
    sincos_tables,
    table_size,
)
from vibropipe.physics.newmark import newmark_map


class Instant(NamedTuple):
    """A time on a grid: at `theta`, in [0, 1), of step `step` of forcing period `period`."""

    period: int
    step: int
    theta: float


class StepGrid(NamedTuple):
    """One method on one row: a grid of steps and the one-step map.

    The steps divide the forcing period, so the phase at a step's start is exact at all times. One step is
    y1 = a11 y + a12 w + sigma p[step] + b1 load, w1 = a21 y + a22 w + sigma q[step] + b2 load.

    exact : 1 for the exact method, None for Newmark's; a type, so each compiles to its own code
    steps : steps per forcing period
    dt : length of a step in tau
    a11, a12, b1, a21, a22, b2 : the one-step map
    margin0, margin1 : margin0 + margin1 (|y - load| + |w|) bounds the distance of the motion from the cubic through a
        step's ends
    force : (p_s, p_c, q_s, q_c): factors of sin and cos at a step's start in p[step] and q[step]
    table_1, table_2 : (steps,) or (0,), exact method: p and q of every step. Newmark: sin and cos, the same for all
        rows of equal `steps`. Empty without force or where a period has too many steps
    basis : (COLUMNS, DEGREE + 1) or (0, 0), of `flow.fill_basis`; empty for Newmark's method
    second : the effect `second_harmonic`; a type
    force_2 : the factors of sin and cos of 2 nu tau, in the order of `force`
    """

    exact: int | None
    steps: int
    dt: float
    a11: float
    a12: float
    b1: float
    a21: float
    a22: float
    b2: float
    margin0: float
    margin1: float
    force: tuple[float, float, float, float]
    table_1: np.ndarray
    table_2: np.ndarray
    basis: np.ndarray
    second: int | None
    force_2: tuple[float, float, float, float]


class RampGrid(NamedTuple):
    """The exact method on a ramp for motions by pieces: each step is a "period", counted from the start of the ramp.

    Attributes are those of `StepGrid`, and the ramp.
    """

    exact: int
    steps: int
    dt: float
    ramp: Ramp


@jit
def margins(p, dt):
    """Return margin0 and margin1: bounds of the fourth derivative over two steps, times dt^4/384.

    That is the error of cubic Hermite interpolation. |z| and |z'| of a motion grow in two steps by at most twice the
    force times dt; each further derivative follows by eq. (5).
    """
    h, (force, force_rate, force_second) = p.h, force_bounds(p)
    growth = 2.0 * force * dt
    second0, second1 = force + (1.0 + h) * growth, 1.0 + h
    third0, third1 = force_rate + h * second0 + growth, h * second1 + 1.0
    fourth0, fourth1 = force_second + h * third0 + second0, h * third1 + second1
    share = 1.01 * dt**4 / 384.0
    return share * fourth0, share * fourth1


@jit_allocating
def exact_grid_with_steps(e, p, steps):
    """Return the grid of the exact method with a number of steps per forcing period.

    steps : at least `steps_for_exact`; another number gives the same motion with other rounding
    """
    size = table_size(e, steps)
    ps, qs, basis = np.empty(size), np.empty(size), new_basis(e.second_harmonic)
    step, force, force_2 = fill_tables(e, p, steps, ps, qs, basis)
    dt, (a11, a12, b1, a21, a22, b2) = forcing_period(p) / steps, step
    margin0, margin1 = margins(p, dt)
    return StepGrid(
        1, steps, dt, a11, a12, b1, a21, a22, b2, margin0, margin1, force, ps, qs, basis,
        e.second_harmonic, force_2,
    )  # fmt: skip


@jit_allocating
def new_grid_room(e):
    """Return arrays for the tables and the basis of grids of the exact method, one after another."""
    return np.empty(MAX_TABLE), np.empty(MAX_TABLE), new_basis(e.second_harmonic)


@jit
def grid_in_room(e, p, steps, room):
    """Return `exact_grid_with_steps` in the arrays of `new_grid_room`.

    For kernels that count no references: one that counts them would free the arrays of the grid after its last use.
    """
    size = table_size(e, steps)
    ps, qs, basis = room[0][:size], room[1][:size], room[2]
    step, force, force_2 = fill_tables(e, p, steps, ps, qs, basis)
    dt, (a11, a12, b1, a21, a22, b2) = forcing_period(p) / steps, step
    margin0, margin1 = margins(p, dt)
    return StepGrid(
        1, steps, dt, a11, a12, b1, a21, a22, b2, margin0, margin1, force, ps, qs, basis,
        e.second_harmonic, force_2,
    )  # fmt: skip


@jit
def fill_tables(e, p, steps, ps, qs, basis):
    """Fill the tables, (steps,) or (0,), and the basis of a grid of the exact method.

    Returns its `StepMap`, and `force` and `force_2` of a `StepGrid`.
    """
    dt = forcing_period(p) / steps
    fill_basis(basis, p.h, p.nu, dt, e.second_harmonic)
    step, (p1, p2, q1, q2) = exact_map(basis, dt)
    force = exact_factors(p, p1, p2, q1, q2)
    fill_sincos(ps, qs, steps)
    force_2 = (0.0, 0.0, 0.0, 0.0)
    if e.second_harmonic is not None:
        p1, p2, q1, q2 = exact_map_of_second(basis, dt)
        force_2 = exact_factors_of_second(p, p1, p2, q1, q2)
    for j in range(ps.size):
        s, c = ps[j], qs[j]
        ps[j], qs[j] = force_contribution(force, s, c)
        if e.second_harmonic is not None:
            second_y, second_w = contribution_of_second(force_2, s, c)
            ps[j] += second_y
            qs[j] += second_w
    return step, force, force_2


@jit_allocating
def exact_grid(e, p):
    """Return the grid of the exact method, with the fewest steps that it allows."""
    return exact_grid_with_steps(e, p, exact_steps(e, p))


@jit
def exact_steps(e, p):
    """Return the fewest steps of a forcing period that the exact method allows."""
    return steps_for_exact(p.nu, p.h, fastest_forcing(p, e.second_harmonic))


@jit
def newmark_coefficients(p, dt, second):
    """Return the `StepMap` of Newmark's method, and `force` and `force_2` of a `StepGrid`; second : the effect."""
    step, force_2 = newmark_map(p.h, dt), (0.0, 0.0, 0.0, 0.0)
    if second is not None:
        force_2 = mean_factors_of_second(p, step.b1, step.b2, dt)
    return step, mean_factors(p, step.b1, step.b2, dt), force_2


@jit_allocating
def newmark_grid(e, p, steps):
    """Return the grid of Newmark's method; steps : steps per forcing period."""
    sines, cosines = sincos_tables(e, steps)
    dt = forcing_period(p) / steps
    step, force, force_2 = newmark_coefficients(p, dt, e.second_harmonic)
    a11, a12, b1, a21, a22, b2 = step
    return StepGrid(
        None, steps, dt, a11, a12, b1, a21, a22, b2, 0.0, 0.0, force, sines, cosines,
        np.zeros((0, 0)), e.second_harmonic, force_2,
    )  # fmt: skip


@jit
def force_at_step(grid, step):
    """Return (p, q) of `StepGrid`: the contribution of the force to y and w over a step, for sigma = 1."""
    if grid.exact is not None and grid.table_1.size > 0:
        return grid.table_1[step], grid.table_2[step]
    s, c = sincos_at_step(grid.table_1, grid.table_2, grid.steps, step)
    force_y, force_w = force_contribution(grid.force, s, c)
    if grid.second is not None:
        second_y, second_w = contribution_of_second(grid.force_2, s, c)
        force_y += second_y
        force_w += second_w
    return force_y, force_w


@jit_inline
def whole_step(a11, a12, a21, a22, y, w, forcing_y, forcing_w):
    """Return (y, w) after a step; forcing_y, forcing_w : contributions of force and load.

    The forcing is added to the term of w first, so the latency from y to the next y is two operations.
    """
    return a11 * y + (a12 * w + forcing_y), a21 * y + (a22 * w + forcing_w)


@jit_inline
def evaluate(grid, c, theta):
    """Return (y, w) of the method's polynomial c at theta."""
    if grid.exact is not None:
        return motion(c, theta, grid.dt)
    return c[0] + theta * (c[1] + theta * c[2]), (c[1] + 2.0 * theta * c[2]) / grid.dt


@jit
def stays_between(grid, frame, departs, y, w, y1, w1, span):
    """Return whether a motion certainly touches no reachable support over `span`, judged from its two ends.

    The motion lies within a margin of the hull of Bezier points: those of the cubic through both ends (exact method),
    or of the quadratic that it is (Newmark).

    departs : 0 in flight. 1 if the mass leaves near = y = 0 with speed w: the cubic's first term, 3 b1 theta (1 -
        theta)^2, must then exceed the error of Hermite interpolation, 16 margin theta^2 (1 - theta)^2
    y, w, y1, w1 : motion at both ends
    span : time between the ends, in steps; at most 2

    Hull property: G. Farin, "Curves and Surfaces for Computer-Aided Geometric Design", Academic Press.
    """
    if grid.exact is not None:
        share = span * grid.dt / 3.0
        square = span * span
        margin = (grid.margin0 + grid.margin1 * (abs(y - frame.load) + abs(w))) * (square * square)
    else:
        share = span * grid.dt / 2.0
        margin = 0.0
    b1, b2 = y + share * w, y1 - share * w1
    if frame.to_far and not max(max(y, y1), max(b1, b2)) + margin < frame.far:
        return False
    if departs == 0:
        return not frame.to_near or min(min(y, y1), min(b1, b2)) - margin > frame.near
    return 3.0 * b1 > 16.0 * margin and b1 > 0.0 and b2 > 0.0 and y1 > 0.0


@jit_inline
def phase_at(grid, at):
    """Return the phase, in turns, of an `Instant` or a state; on a `RampGrid` the `Moment`."""
    return _phase_at(ramp_of(grid), grid, at)


@jit_inline
def _phase_at(ramp, grid, at):
    """Return `phase_at`; ramp : of the grid, as an argument, so that only one of both is compiled."""
    if ramp is not None:
        return Moment(ramp, turns_at(grid, at) * grid.dt, grid.dt)
    return (at.step + at.theta) / grid.steps


@jit_inline
def turns_at(grid, at):
    """Return the time of an `Instant` or a state, in forcing periods since tau = 0."""
    return at.period + (at.step + at.theta) / grid.steps


@jit_inline
def steps_until(grid, at, end):
    """Return the time from an `Instant` or a state to an `Instant`, in steps."""
    return (end.period - at.period) * grid.steps + (end.step - at.step) + (end.theta - at.theta)


@jit
def grid_time(turns, steps):
    """Return the `Instant` of a time in forcing periods, on a grid with `steps` steps per period."""
    period = math.floor(turns)
    at = (turns - period) * steps
    step = int(at)
    if step >= steps:
        return Instant(int(period) + 1, 0, 0.0)
    return Instant(int(period), step, at - step)
