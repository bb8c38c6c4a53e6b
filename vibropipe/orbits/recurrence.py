"""Near returns of a motion to where it was at the section, some forcing periods before.

The sections (x, x') at the periods 0 to k lie in two arrays from HISTORY_OFFSET on; before that lies infinity, which
nothing is near to.
"""

from __future__ import annotations

from vibropipe.compiler import jit

MAX_MULTIPLE = 32
HISTORY_OFFSET = 2 * MAX_MULTIPLE
# Share of the motion's size within which the section counts as nearly repeating.
RETURN_TOLERANCE = 1e-4
# An orbit of more than so many periods has nearly repeated once before, within so many times that share: a chaotic
# motion comes back by chance after many periods, and seldom twice.
MAX_UNCONFIRMED_MULTIPLE, CONFIRM_FACTOR = 2, 30.0


@jit
def may_repeat(xs, vs, k, size) -> bool:
    """Whether the section at period k nearly repeats any of the last: one look at all, which the vector units do."""
    now = HISTORY_OFFSET + k
    x, v, last_xs, last_vs = (
        xs[now],
        vs[now],
        xs[now - MAX_MULTIPLE : now],
        vs[now - MAX_MULTIPLE : now],
    )
    near = 0
    for i in range(MAX_MULTIPLE):
        near += abs(last_xs[i] - x) + abs(last_vs[i] - v) <= RETURN_TOLERANCE * size
    return near > 0


@jit
def _return_distance(xs, vs, k, m):
    """Distance |dx| + |dx'| of the section at period k from that m periods before."""
    now = HISTORY_OFFSET + k
    return abs(xs[now - m] - xs[now]) + abs(vs[now - m] - vs[now])


@jit
def nearly_repeats(xs, vs, k, m, size) -> bool:
    """Whether the section at period k nearly repeats that m periods before, and no chance return."""
    if not _return_distance(xs, vs, k, m) <= RETURN_TOLERANCE * size:
        return False
    return (
        m <= MAX_UNCONFIRMED_MULTIPLE
        or _return_distance(xs, vs, k - m, m) <= CONFIRM_FACTOR * RETURN_TOLERANCE * size
    )
