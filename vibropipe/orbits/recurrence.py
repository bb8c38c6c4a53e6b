"""Near returns of a motion to where it was at the section, some forcing periods before.

The sections (x, x') at the periods 0 to k lie in two arrays from ZERO on; before that lies infinity, which nothing is
near to.
"""

from __future__ import annotations

from vibropipe.compiler import jit

MAX_MULTIPLE = 32
ZERO = 2 * MAX_MULTIPLE
# Share of the motion's size within which the section counts as nearly repeating.
NEARLY = 1e-4
# An orbit of more than so many periods has nearly repeated once before, within so many times that share: a chaotic
# motion comes back by chance after many periods, and seldom twice.
SURE_MULTIPLE, BEFORE = 2, 30.0


@jit
def may_repeat(xs, vs, k, size) -> bool:
    """Whether the section at period k nearly repeats any of the last: one look at all, which the vector units do."""
    now = ZERO + k
    x, v, last_xs, last_vs = (
        xs[now],
        vs[now],
        xs[now - MAX_MULTIPLE : now],
        vs[now - MAX_MULTIPLE : now],
    )
    near = 0
    for i in range(MAX_MULTIPLE):
        near += abs(last_xs[i] - x) + abs(last_vs[i] - v) <= NEARLY * size
    return near > 0


@jit
def _return_distance(xs, vs, k, m):
    """Distance |dx| + |dx'| of the section at period k from that m periods before."""
    now = ZERO + k
    return abs(xs[now - m] - xs[now]) + abs(vs[now - m] - vs[now])


@jit
def nearly_repeats(xs, vs, k, m, size) -> bool:
    """Whether the section at period k nearly repeats that m periods before, and no chance return."""
    if not _return_distance(xs, vs, k, m) <= NEARLY * size:
        return False
    return m <= SURE_MULTIPLE or _return_distance(xs, vs, k - m, m) <= BEFORE * NEARLY * size
