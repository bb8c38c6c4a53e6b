"""Near returns of the stroboscopic section to its state some forcing periods before.

Three arrays hold the sections (x, x', X') at the periods 0 to k, from HISTORY_OFFSET on. The entries before are
infinite, so that no section is near them. X' is the velocity of a housing, which friction may change slowly
and evenly while the mass repeats; without a housing the array is empty.
"""

from __future__ import annotations

from vibropipe.compiler import jit

# Largest period multiple of an orbit, in forcing periods, and of one that is sought where a motion has not settled for
# long and is not chaotic.
MAX_MULTIPLE, MAX_LONG_MULTIPLE = 32, 256
# Entries before period 0: a return is compared with the one before it, two multiples back.
HISTORY_OFFSET = 2 * MAX_MULTIPLE
# Largest distance of a near return, relative to the norm of the motion, and of one to rounding, as of a motion that
# forgets in each rest what was before.
RETURN_TOLERANCE, ROUNDING_TOLERANCE = 1e-4, 1e-9
# A return after more than MAX_UNCONFIRMED_MULTIPLE periods counts only if the return before it was within
# CONFIRM_FACTOR times the tolerance: a chaotic motion returns by chance after many periods, but seldom twice.
MAX_UNCONFIRMED_MULTIPLE, CONFIRM_FACTOR = 2, 30.0
# Periods in a row that are near those before on a long orbit. Of chaotic motions each further one is rarer by about
# their contraction of areas.
REPEATED_PERIODS = 4


@jit
def may_repeat(sections, k, norm, largest) -> bool:
    """Return whether the section at period k is near any of the last `largest` sections.

    The loop has no branch, so that it is vectorised; `nearly_repeats` then examines each multiple.

    sections : tuple of (HISTORY_OFFSET + n,), sections (x, x', X')
    k : forcing periods marched
    largest : largest period multiple, at most MAX_MULTIPLE or k/2
    """
    xs, vs, us = sections
    now = HISTORY_OFFSET + k
    x, v = xs[now], vs[now]
    last_xs, last_vs = xs[now - largest : now], vs[now - largest : now]
    n_near = 0
    if us.size > 0:
        for i in range(now - largest, now):
            distance = abs(xs[i] - x) + abs(vs[i] - v) + abs(us[i] - us[now])
            n_near += distance <= RETURN_TOLERANCE * norm
        return n_near > 0
    for i in range(largest):
        n_near += abs(last_xs[i] - x) + abs(last_vs[i] - v) <= RETURN_TOLERANCE * norm
    return n_near > 0


@jit
def _return_distance(sections, k, m):
    """Return the distance |dx| + |dx'| + |dX'| between the sections at the periods k and k - m."""
    xs, vs, us = sections
    now = HISTORY_OFFSET + k
    distance = abs(xs[now - m] - xs[now]) + abs(vs[now - m] - vs[now])
    if us.size > 0:
        distance += abs(us[now - m] - us[now])
    return distance


@jit
def nearly_repeats(sections, k, m, norm) -> bool:
    """Return whether the section at period k nearly repeats that at k - m, and not by chance.

    sections : tuple of (HISTORY_OFFSET + n,), sections (x, x', X')
    k, m : forcing periods marched, and the period multiple
    """
    if not _return_distance(sections, k, m) <= RETURN_TOLERANCE * norm:
        return False
    return (
        m <= MAX_UNCONFIRMED_MULTIPLE
        or _return_distance(sections, k - m, m) <= CONFIRM_FACTOR * RETURN_TOLERANCE * norm
    )


@jit
def lies_on_orbit(sections, k, norm, tolerance) -> bool:
    """Return whether the last sections up to period k are near those of up to MAX_LONG_MULTIPLE periods before.

    sections : tuple of (HISTORY_OFFSET + n,), sections (x, x', X')
    k : forcing periods marched
    tolerance : largest distance of a return, relative to it
    """
    for m in range(1, min(MAX_LONG_MULTIPLE, k - REPEATED_PERIODS) + 1):
        repeated = 0
        while repeated < REPEATED_PERIODS and (
            _return_distance(sections, k - repeated, m) <= tolerance * norm
        ):
            repeated += 1
        if repeated == REPEATED_PERIODS:
            return True
    return False
