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
from vibropipe.physics.forcing import TWO_PI, sincos_turns
from vibropipe.physics.newmark import newmark_map

# Steps per forcing period up to which the force's part of each is tabulated.
MAX_TABLE = 8192


class Grid(NamedTuple):
    """One method on one row: `exact` is 1 or None (Newmark), a type, so each compiles to its own code.

    Steps are laid on the forcing period, so the phase at a step's start is known to the last bit for ever.
    y1 = a11 y + a12 w + sigma p[step] + b1 load; w1 = a21 y + a22 w + sigma q[step] + b2 load.
    margin0 + margin1 (|y - load| + |w|) bounds how far the motion leaves the cubic through a step's ends.
    force: the factors (p_s, p_c, q_s, q_c) of sin and cos at a step's start in p and q of the step. The tables
    hold p and q of every step, or sin and cos (Newmark: the same for all rows of as many steps); nothing where
    there is no force or a period has too many steps.
    basis (5, ORDER + 1): the polynomials of unit y, w, load, sigma f sin, sigma f cos (exact method only).
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
def _margins(h, nu, f, dt):
    """Bounds of the fourth derivative over two steps, times dt^4/384 (the error of cubic Hermite interpolation).

    From z'' + h z' + z = f sin: |z|, |z'| grow by at most 2 |f| dt in two steps; each further derivative by
    eq. (5).
    """
    size, growth = abs(f), 2.0 * abs(f) * dt
    second0, second1 = size + (1.0 + h) * growth, 1.0 + h
    third0, third1 = nu * size + h * second0 + growth, h * second1 + 1.0
    fourth0, fourth1 = nu * nu * size + h * third0 + second0, h * third1 + second1
    share = 1.01 * dt**4 / 384.0
    return share * fourth0, share * fourth1


@jit_unfused
def mixed(force, s, c):
    """(p, q) of a step from sin and cos at its start."""
    return force[0] * s + force[1] * c, force[2] * s + force[3] * c


@jit_allocating
def waves(e, steps):
    """sin and cos at the start of every step of a forcing period; empty without force, or where a table would
    not fit a cache."""
    size = steps if e.forcing is not None and steps <= MAX_TABLE else 0
    sines, cosines = np.empty(size), np.empty(size)
    for j in range(size):
        sines[j], cosines[j] = sincos_turns(j / steps)
    return sines, cosines


@jit_allocating
def exact_grid_of(e, p, steps):
    """Grid of the exact method with so many steps per forcing period, no fewer than `steps_for_exact`: the
    same motion, rounded elsewhere."""
    dt = TWO_PI / p.nu / steps
    basis = exact_basis(p.h, p.nu, dt)
    a11, a12, b1, p1, p2, a21, a22, b2, q1, q2 = exact_map(basis, dt)
    force = (p.f * p1, p.f * p2, p.f * q1, p.f * q2)
    ps, qs = waves(e, steps)
    for j in range(ps.size):
        ps[j], qs[j] = mixed(force, ps[j], qs[j])
    margin0, margin1 = _margins(p.h, p.nu, p.f, dt)
    return Grid(1, steps, dt, a11, a12, b1, a21, a22, b2, margin0, margin1, force, ps, qs, basis)


@jit_allocating
def exact_grid(e, p):
    """Grid of the exact method."""
    return exact_grid_of(e, p, steps_for_exact(p.nu, p.h))


@jit
def newmark_numbers(p, steps):
    """The numbers of Newmark's method on a grid, in the order of `Grid`: from dt to the factors of the force."""
    dt = TWO_PI / p.nu / steps
    a11, a12, b1, a21, a22, b2 = newmark_map(p.h, dt)
    # The mean of sin at both ends of a step, by sin and cos at its start.
    half_c, half_s = 0.5 + 0.5 * math.cos(p.nu * dt), 0.5 * math.sin(p.nu * dt)
    force = (b1 * p.f * half_c, b1 * p.f * half_s, b2 * p.f * half_c, b2 * p.f * half_s)
    return dt, a11, a12, b1, a21, a22, b2, 0.0, 0.0, force


@jit_allocating
def newmark_grid(e, p, steps):
    """Grid of Newmark's method with `steps` steps per forcing period."""
    sines, cosines = waves(e, steps)
    dt, a11, a12, b1, a21, a22, b2, margin0, margin1, force = newmark_numbers(p, steps)
    basis = np.zeros((0, 0))
    return Grid(
        None, steps, dt, a11, a12, b1, a21, a22, b2, margin0, margin1, force, sines, cosines, basis
    )


@jit
def wave_at(table_1, table_2, steps, step):
    """sin and cos at the start of a step, from Newmark's tables if there are any."""
    if table_1.size > 0:
        return table_1[step], table_2[step]
    return sincos_turns(step / steps)


@jit
def force_part(grid, step):
    """(p, q): the force's part of a step of the one-step map, for sigma = 1."""
    if grid.exact is not None and grid.table_1.size > 0:
        return grid.table_1[step], grid.table_2[step]
    s, c = wave_at(grid.table_1, grid.table_2, grid.steps, step)
    return mixed(grid.force, s, c)


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
def stays_between(grid, departs, y, w, y1, w1, span, load, near, far, to_near, to_far):
    """Certificate, from its two ends, that a motion over `span` of a step touches neither near nor far, of
    those that it can reach at all (to_near, to_far).

    It lies within a margin of the hull of its Bezier points: of the cubic through the ends (exact method), or
    of the quadratic it is (Newmark). departs: 0 in flight; 1 it leaves near = y = 0 with speed w, and then
    the cubic's first term, 3 b1 theta (1 - theta)^2, must outweigh the error of Hermite interpolation,
    16 margin theta^2 (1 - theta)^2.
    """
    if grid.exact is not None:
        share = span * grid.dt / 3.0
        square = span * span
        margin = (grid.margin0 + grid.margin1 * (abs(y - load) + abs(w))) * (square * square)
    else:
        share = span * grid.dt / 2.0
        margin = 0.0
    b1, b2 = y + share * w, y1 - share * w1
    if to_far and not max(max(y, y1), max(b1, b2)) + margin < far:
        return False
    if departs == 0:
        return not to_near or min(min(y, y1), min(b1, b2)) - margin > near
    return 3.0 * b1 > 16.0 * margin and b1 > 0.0 and b2 > 0.0 and y1 > 0.0


@jit
def locate(turns, steps):
    """(period, step, theta) of a time given in forcing periods."""
    period = math.floor(turns)
    at = (turns - period) * steps
    step = int(at)
    if step >= steps:
        return int(period) + 1, 0, 0.0
    return int(period), step, at - step
