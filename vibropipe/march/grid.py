"""The grid of steps in a forcing period, and the one-step map of either method on it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_unfused
from vibropipe.physics.flow import (
    exact_basis,
    exact_map,
    motion,
    steps_for_exact,
)
from vibropipe.physics.load import (
    exact_factors,
    force_bounds,
    force_contribution,
    forcing_period,
    mean_factors,
    sincos_at_step,
    sincos_tables,
)
from vibropipe.physics.newmark import newmark_map


class Instant(NamedTuple):
    """A time on a grid: `theta`, in [0, 1), of step `step` of forcing period `period`."""

    period: int
    step: int
    theta: float


class StepGrid(NamedTuple):
    """One method on one row: `exact` is 1 or None (Newmark), a type, so each compiles to its own code.

    Steps are laid on the forcing period, so the phase at a step's start is known to the last bit for ever.
    y1 = a11 y + a12 w + sigma p[step] + b1 load; w1 = a21 y + a22 w + sigma q[step] + b2 load.
    margin0 + margin1 (|y - load| + |w|) bounds how far the motion leaves the cubic through a step's ends.
    force: the factors (p_s, p_c, q_s, q_c) of sin and cos at a step's start in p and q of the step. The tables
    hold p and q of every step, or sin and cos (Newmark: the same for all rows of as many steps); nothing where
    there is no force or a period has too many steps.
    basis (COLUMNS, ORDER + 1): `flow.exact_basis` (exact method only).
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


@jit
def _margins(p, dt):
    """Bounds of the fourth derivative over two steps, times dt^4/384 (the error of cubic Hermite interpolation).

    |z|, |z'| of a motion grow by at most twice the force times dt in two steps; each further derivative by eq. (5).
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
    """Grid of the exact method with so many steps per forcing period, no fewer than `steps_for_exact`: the
    same motion, rounded elsewhere."""
    dt = forcing_period(p) / steps
    basis = exact_basis(p.h, p.nu, dt)
    a11, a12, b1, p1, p2, a21, a22, b2, q1, q2 = exact_map(basis, dt)
    force = exact_factors(p, p1, p2, q1, q2)
    ps, qs = sincos_tables(e, steps)
    for j in range(ps.size):
        ps[j], qs[j] = force_contribution(force, ps[j], qs[j])
    margin0, margin1 = _margins(p, dt)
    return StepGrid(
        1, steps, dt, a11, a12, b1, a21, a22, b2, margin0, margin1, force, ps, qs, basis
    )


@jit_allocating
def exact_grid(e, p):
    """Grid of the exact method."""
    return exact_grid_with_steps(e, p, steps_for_exact(p.nu, p.h))


@jit
def newmark_coefficients(p, steps):
    """The numbers of Newmark's method on a grid, in the order of `StepGrid`: from dt to the factors of the force."""
    dt = forcing_period(p) / steps
    a11, a12, b1, a21, a22, b2 = newmark_map(p.h, dt)
    return dt, a11, a12, b1, a21, a22, b2, 0.0, 0.0, mean_factors(p, b1, b2, dt)


@jit_allocating
def newmark_grid(e, p, steps):
    """Grid of Newmark's method with `steps` steps per forcing period."""
    sines, cosines = sincos_tables(e, steps)
    dt, a11, a12, b1, a21, a22, b2, margin0, margin1, force = newmark_coefficients(p, steps)
    basis = np.zeros((0, 0))
    return StepGrid(
        None, steps, dt, a11, a12, b1, a21, a22, b2, margin0, margin1, force, sines, cosines, basis
    )


@jit
def force_at_step(grid, step):
    """(p, q): the force's part of a step of the one-step map, for sigma = 1."""
    if grid.exact is not None and grid.table_1.size > 0:
        return grid.table_1[step], grid.table_2[step]
    s, c = sincos_at_step(grid.table_1, grid.table_2, grid.steps, step)
    return force_contribution(grid.force, s, c)


@jit_unfused
def whole_step(a11, a12, a21, a22, y, w, part_y, part_w):
    """(y, w) after a step; part: of the force and the load. What does not wait for y comes first."""
    return a11 * y + (a12 * w + part_y), a21 * y + (a22 * w + part_w)


@jit
def evaluate(grid, c, theta):
    """(y, w) of the method's polynomial at theta."""
    if grid.exact is not None:
        return motion(c, theta, grid.dt)
    return c[0] + theta * (c[1] + theta * c[2]), (c[1] + 2.0 * theta * c[2]) / grid.dt


@jit
def stays_between(grid, frame, departs, y, w, y1, w1, span):
    """Certificate, from its two ends, that a motion over `span` of a step touches no support that it can reach.

    It lies within a margin of the hull of its Bezier points: of the cubic through the ends (exact method), or
    of the quadratic it is (Newmark). departs: 0 in flight; 1 it leaves near = y = 0 with speed w, and then
    the cubic's first term, 3 b1 theta (1 - theta)^2, must outweigh the error of Hermite interpolation,
    16 margin theta^2 (1 - theta)^2.

    References
    ----------
    The hull: G. Farin, "Curves and Surfaces for Computer-Aided Geometric Design", Academic Press.
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


@jit
def phase_at(grid, at):
    """Phase, in turns, of an `Instant` or a state."""
    return (at.step + at.theta) / grid.steps


@jit
def turns_at(grid, at):
    """Forcing periods since tau = 0 at an `Instant` or a state."""
    return at.period + (at.step + at.theta) / grid.steps


@jit
def grid_time(turns, steps):
    """The `Instant` of a time given in forcing periods, on a grid of so many steps in each."""
    period = math.floor(turns)
    at = (turns - period) * steps
    step = int(at)
    if step >= steps:
        return Instant(int(period) + 1, 0, 0.0)
    return Instant(int(period), step, at - step)
