"""The least margin of each kind that an orbit keeps to: its value, and where it is."""

from __future__ import annotations

import numpy as np

from vibropipe.compiler import jit

# Kinds of margins: the least speed at a support, span of a piece, excess of what holds or turns the mass, gap of a
# flight (or depth within a contact) where it turns, and speed of sliding; of a housing the excess of what holds or
# moves it, and its speed over c.
# They and sides are numpy integers because numba compiles another copy of a kernel for each literal constant.
SPEED, SPAN, HOLD, GAP, SLIDE, HOUSING_HOLD, HOUSING_SLIDE = map(np.int64, range(7))
KINDS = 7
NO_SIDE, UPPER, LOWER, CHATTER = np.int64(0), np.int64(1), np.int64(2), np.int64(-1)
# In place of a support: the force of one that only pushes, over its stiffness, touches zero.
FORCE = np.int64(3)
# Row of the span (negative if mirrored), piece, support and time at which the orbit touches a support, which is no
# margin; piece ANY: others may vanish with it, and count but for what is in place of the time.
TOUCH, ANY, NOWHERE = KINDS, -2.0, -1.0
# Time from there, in forcing periods, within which a gap is that of the touch.
TOUCHING = 1e-3
# Of each margin: its value, the event or piece, the support, and the time in forcing periods.
VALUE, AT, SIDE, TIME = range(4)


@jit
def note(margins, kind, value, i, side, time) -> None:
    """Keep a margin if it is the least of its kind."""
    if kind == GAP and margins[TOUCH, AT] != NOWHERE:
        if margins[TOUCH, AT] == ANY:
            value += margins[TOUCH, TIME]
        # A turn on the support is also the end of the piece before, of the first event a span later.
        away, span = time - margins[TOUCH, TIME], margins[TOUCH, VALUE]
        there = margins[TOUCH, SIDE]
        if abs(away) < TOUCHING and side == there:
            return
        if abs(away - abs(span)) < TOUCHING and side == (3.0 - there if span < 0.0 else there):
            return
    if value < margins[kind, VALUE] or value != value:
        margins[kind, VALUE], margins[kind, AT], margins[kind, SIDE] = value, i, side
        margins[kind, TIME] = time
