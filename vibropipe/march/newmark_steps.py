"""Whole steps of Newmark's method: of one motion, and of a block of motions side by side.

Both take the same step, `grid.whole_step`, whose products and sums round one by one: the same motion to the
last bit. A block is one flat array with WIDTH numbers per field, so that its places differ by constants and
the compiler sees that no number written is read by another motion: then it uses the vector units.
"""

from __future__ import annotations

import math

from vibropipe.compiler import jit
from vibropipe.march.grid import stays_between, whole_step
from vibropipe.march.log import STEPS
from vibropipe.march.state import FLIGHT, State
from vibropipe.physics.contact import frame_at
from vibropipe.physics.load import load_contribution, sincos_at_step

WIDTH = 64
# Steps between two looks at a block: enough that its numbers are read from memory once and used often.
STRIDE = 8
# Fields of a block, by the place of their first number: the motion, its one-step map, sin and cos in the force's
# part of a step, the load's part; half a step; where a support may be near; until which step it goes by itself.
Y, W, A11, A12, A21, A22, P_S, P_C, P_L, Q_S, Q_C, Q_L, HALF, LOW, HIGH, UNTIL, PENDING = (
    WIDTH * field for field in range(17)
)
SIZE = 17 * WIDTH
# Rounding in the place of a motion, of the lengths that it is made of: in a block a support is looked for this
# much earlier.
SUPPORT_MARGIN = 2.0**-46


@jit
def coast_newmark(e, p, grid, state, end, counts):
    """Whole steps in flight while it is certified that no support is reached in them."""
    frame = frame_at(e, p, state.home)
    sigma, load_y, load_w = frame.sigma, grid.b1 * frame.load, grid.b2 * frame.load
    period, step, y, w = state.period, state.step, state.y, state.w
    made = 0
    while period < end.period or step < end.step:
        part_y, part_w = load_y, load_w
        if e.forcing is not None:
            s, c = sincos_at_step(grid.table_1, grid.table_2, grid.steps, step)
            part_y = load_contribution(sigma * grid.force[0], sigma * grid.force[1], load_y, s, c)
            part_w = load_contribution(sigma * grid.force[2], sigma * grid.force[3], load_w, s, c)
        y1, w1 = whole_step(grid.a11, grid.a12, grid.a21, grid.a22, y, w, part_y, part_w)
        if not stays_between(grid, frame, 0, y, w, y1, w1, 1.0):
            break
        y, w = y1, w1
        made += 1
        step += 1
        if step == grid.steps:
            step = 0
            period += 1
    counts[STEPS] += made
    return State(period, step, 0.0, state.home, y, w, FLIGHT, 0.0)


@jit
def load_lane(e, p, grid, home, y, w, until, block, i) -> None:
    """Put a motion in flight from `home` into place i of a block, to go by itself until a step."""
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
    """Let place i of a block lie still until a step."""
    for field in (Y, W, P_S, P_C, P_L, Q_S, Q_C, Q_L):
        block[field + i] = 0.0
    block[LOW + i], block[HIGH + i] = -math.inf, math.inf
    block[UNTIL + i] = until


@jit
def set_map(grid, block, i) -> None:
    """Write the one-step map of a motion into place i of a block."""
    block[A11 + i], block[A12 + i] = grid.a11, grid.a12
    block[A21 + i], block[A22 + i] = grid.a21, grid.a22
    block[HALF + i] = 0.5 * grid.dt


@jit
def load_sincos(sines, cosines, steps, at_step, sin_cos) -> None:
    """sin and cos at the starts of STRIDE steps from `at_step`, counted from tau = 0."""
    step = at_step % steps
    for k in range(STRIDE):
        sin_cos[2 * k], sin_cos[2 * k + 1] = sincos_at_step(sines, cosines, steps, step)
        step = 0 if step + 1 == steps else step + 1


@jit
def advance_block(block, sin_cos, end) -> int:
    """Take STRIDE steps, up to step `end`, with all motions of a block that may; returns how many may not.

    Those stay where they are, with PENDING set: a support may be met (its certificate is the hull of the Bezier
    points of every step), or the motion is to end or to be taken up on the way.
    """
    refused = 0
    for i in range(WIDTH):
        y, w = block[Y + i], block[W + i]
        lowest = highest = y
        for k in range(STRIDE):
            s, c = sin_cos[2 * k], sin_cos[2 * k + 1]
            part_y = load_contribution(block[P_S + i], block[P_C + i], block[P_L + i], s, c)
            part_w = load_contribution(block[Q_S + i], block[Q_C + i], block[Q_L + i], s, c)
            between = y + block[HALF + i] * w
            y, w = whole_step(
                block[A11 + i], block[A12 + i], block[A21 + i], block[A22 + i], y, w, part_y, part_w
            )
            lowest, highest = min(lowest, min(between, y)), max(highest, max(between, y))
        # The last y again: a number that is none stays one, but minimum and maximum may pass it by.
        inside = (lowest > block[LOW + i]) & (highest < block[HIGH + i]) & (abs(y) < math.inf)
        goes = inside & (end <= block[UNTIL + i])
        block[Y + i] = y if goes else block[Y + i]
        block[W + i] = w if goes else block[W + i]
        block[PENDING + i] = 0.0 if goes else 1.0
        refused += 0 if goes else 1
    return refused
