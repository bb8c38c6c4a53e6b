"""Whole steps of Newmark's method: of one motion, and of a block of motions side by side.

Both take the same step, `grid.whole_step`: the motions agree bit for bit. A block is one flat array with WIDTH numbers
per field. Fields then lie at constant offsets, so the compiler can prove that no number written is read by another
motion, and vectorises the loop.
"""

from __future__ import annotations

import math

from vibropipe.compiler import jit
from vibropipe.march.grid import stays_between, whole_step
from vibropipe.march.log import STEPS
from vibropipe.march.state import FLIGHT, State
from vibropipe.physics.contact import frame_at
from vibropipe.physics.load_steps import contribution_of_second, load_contribution, sincos_at_step

# Motions in a block: a multiple of every vector width.
WIDTH = 64
# Steps of a block between two checks: enough to use each number several times once it is loaded from memory.
STRIDE = 8
# Fields of a block, by the index of their first number: the motion; its one-step map; factors of sin, of cos and the
# constant load in the forcing of y (P) and w (Q); half a step; limits of y beyond which a support may be met; the
# last step of the motion in the block; whether the motion is to be advanced by the caller.
Y, W, A11, A12, A21, A22, P_S, P_C, P_L, Q_S, Q_C, Q_L, HALF, LOW, HIGH, UNTIL, PENDING = (
    WIDTH * field for field in range(17)
)
SIZE = PENDING + WIDTH
# Rounding of y, as a share of the lengths that it is computed from: the limits LOW and HIGH lie inside the supports
# by as much.
SUPPORT_MARGIN = 2.0**-46


@jit
def coast_newmark(e, p, grid, state, end, counts):
    """Take whole steps in flight while each is certified to reach no support; add them to counts[STEPS].

    state : in flight at the start of a step. Returns the state at the start of the first step not taken, or of that of
    `end`.
    """
    frame = frame_at(e, p, state.home)
    sigma, load_y, load_w = frame.sigma, grid.b1 * frame.load, grid.b2 * frame.load
    period, step, y, w = state.period, state.step, state.y, state.w
    n_steps = 0
    while period < end.period or step < end.step:
        forcing_y, forcing_w = load_y, load_w
        if e.forcing is not None:
            s, c = sincos_at_step(grid.table_1, grid.table_2, grid.steps, step)
            forcing_y = load_contribution(
                sigma * grid.force[0], sigma * grid.force[1], load_y, s, c
            )
            forcing_w = load_contribution(
                sigma * grid.force[2], sigma * grid.force[3], load_w, s, c
            )
            if e.second_harmonic is not None:
                second_y, second_w = contribution_of_second(grid.force_2, s, c)
                forcing_y += sigma * second_y
                forcing_w += sigma * second_w
        y1, w1 = whole_step(grid.a11, grid.a12, grid.a21, grid.a22, y, w, forcing_y, forcing_w)
        if not stays_between(grid, frame, 0, y, w, y1, w1, 1.0):
            break
        y, w = y1, w1
        n_steps += 1
        step += 1
        if step == grid.steps:
            step = 0
            period += 1
    counts[STEPS] += n_steps
    return State(period, step, 0.0, state.home, y, w, FLIGHT, 0.0)


@jit
def load_lane(e, p, grid, home, y, w, until, block, i) -> None:
    """Load a motion in flight into lane i of a block.

    Parameters
    ----------
    e, p, grid, home : Effects, Parameters, StepGrid, int
    y, w : float
        State in the frame of `home`.
    until : float
        Step, counted from tau = 0, at which the motion leaves the block.
    block : ndarray, shape (SIZE,)
    i : int
    """
    frame = frame_at(e, p, home)
    sigma, near, far = frame.sigma, frame.near, frame.far
    block[Y + i], block[W + i] = y, w
    block[P_L + i], block[Q_L + i] = grid.b1 * frame.load, grid.b2 * frame.load
    block[P_S + i], block[P_C + i] = sigma * grid.force[0], sigma * grid.force[1]
    block[Q_S + i], block[Q_C + i] = sigma * grid.force[2], sigma * grid.force[3]
    if e.forcing is None:
        block[P_S + i] = block[P_C + i] = block[Q_S + i] = block[Q_C + i] = 0.0
    length = abs(near) + abs(far) + abs(block[P_L + i]) + grid.dt * abs(block[Q_L + i])
    length += abs(block[P_S + i]) + abs(block[P_C + i])
    length += grid.dt * (abs(block[Q_S + i]) + abs(block[Q_C + i]))
    block[LOW + i] = near + SUPPORT_MARGIN * length if frame.to_near else -math.inf
    block[HIGH + i] = far - SUPPORT_MARGIN * length if frame.to_far else math.inf
    block[UNTIL + i] = until


@jit
def park_lane(until, block, i) -> None:
    """Let lane i of a block stand still until a step."""
    for field in (Y, W, P_S, P_C, P_L, Q_S, Q_C, Q_L):
        block[field + i] = 0.0
    block[LOW + i], block[HIGH + i] = -math.inf, math.inf
    block[UNTIL + i] = until


@jit
def set_map(grid, block, i) -> None:
    """Write the one-step map of a grid into lane i of a block."""
    block[A11 + i], block[A12 + i] = grid.a11, grid.a12
    block[A21 + i], block[A22 + i] = grid.a21, grid.a22
    block[HALF + i] = 0.5 * grid.dt


@jit
def load_sincos(sines, cosines, steps, at_step, sin_cos) -> None:
    """Write sin and cos at the starts of STRIDE steps into sin_cos, shape (2 STRIDE,).

    sines, cosines : `sincos_tables`; steps : per forcing period; at_step : first step, counted from tau = 0.
    """
    step = at_step % steps
    for k in range(STRIDE):
        sin_cos[2 * k], sin_cos[2 * k + 1] = sincos_at_step(sines, cosines, steps, step)
        step = 0 if step + 1 == steps else step + 1


@jit
def advance_block(block, sin_cos, end) -> int:
    """Take STRIDE steps, up to step `end`, with all motions of a block that allow it.

    The others keep their state and have PENDING set: a support may be met (the hull of the Bezier points of some step
    reaches it), or the motion leaves the block before `end`.

    Returns
    -------
    int
        Number of motions pending.
    """
    n_pending = 0
    for i in range(WIDTH):
        y, w = block[Y + i], block[W + i]
        lowest = highest = y
        for k in range(STRIDE):
            s, c = sin_cos[2 * k], sin_cos[2 * k + 1]
            forcing_y = load_contribution(block[P_S + i], block[P_C + i], block[P_L + i], s, c)
            forcing_w = load_contribution(block[Q_S + i], block[Q_C + i], block[Q_L + i], s, c)
            between = y + block[HALF + i] * w
            y, w = whole_step(
                block[A11 + i],
                block[A12 + i],
                block[A21 + i],
                block[A22 + i],
                y,
                w,
                forcing_y,
                forcing_w,
            )
            lowest, highest = min(lowest, min(between, y)), max(highest, max(between, y))
        # The last y is tested too: nan persists in it, but minimum and maximum may skip nan.
        inside = (lowest > block[LOW + i]) & (highest < block[HIGH + i]) & (abs(y) < math.inf)
        advances = inside & (end <= block[UNTIL + i])
        block[Y + i] = y if advances else block[Y + i]
        block[W + i] = w if advances else block[W + i]
        block[PENDING + i] = 0.0 if advances else 1.0
        n_pending += 0 if advances else 1
    return n_pending
