"""The law of motion that settles from a given start: settle, recognise the orbit, close it by Newton.

A steady state is found, not waited for. The stroboscopic section is watched until it nearly repeats with
some period multiple m; Newton's method on the return map then closes the orbit, and it counts only if it
is stable and as near as the contraction of its multipliers allows. A slow drift passes no such test, and an
orbit of multiple m is not taken for one of a smaller multiple, because that one is unstable.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline
from vibropipe.march.log import IMPACTS
from vibropipe.march.loop import OK
from vibropipe.march.state import REST, State
from vibropipe.orbits.harmonics import ONE
from vibropipe.orbits.return_map import (
    LOG_FULL,
    at_period_zero,
    clear,
    derivative,
    difference,
    multipliers,
    newton_step,
    periods,
    section,
)
from vibropipe.orbits.window import WINDOW, add_period, close_window, open_window
from vibropipe.words.status import Status

MAX_MULTIPLE = 32
# Share of the motion's size within which the section counts as nearly repeating.
NEARLY = 1e-4
CLOSED = 1e-13
# An orbit of more than so many periods has nearly repeated once before, within so many times that share: a chaotic
# motion comes back by chance after many periods, and seldom twice.
SURE_MULTIPLE, BEFORE = 2, 30.0
# Place of the section at period 0 among those kept; before it lie places that nothing is near to.
ZERO = 2 * MAX_MULTIPLE
# Share within which a closed orbit must repeat to be that of a divisor of its multiple.
SAME = 1e-9
MAX_NEWTON = 12
# A fixed point further away than this many times the last change, stretched by 1/(1 - |multiplier|), is
# some other orbit. Non-normal derivatives make changes larger than multipliers tell.
REACH = 20.0
# A small difference that grows by this exponent over so many periods, the last of its patience, is that of a
# chaotic motion, or of one that will settle late: of 20,000 random rows 7 did after 300 periods.
FOLLOWED, CHAOTIC = 50, 6.0
# Periods marched for one spent on orbits that could not be closed.
PATIENT_TRIES = 4
# Where the section nearly repeats about a stable orbit, no multiplier is beyond this.
UNSTABLE = 2.0
# Forcing periods of more contacts than are kept, after which a row is left: no orbit of such periods can be told, and
# each of them takes as long as 100 others. A transient of so many impacts is over by then.
MAX_CROWDED = 32
# Growth of the section's amplitude from the second to the last quarter that counts as unbounded, where that
# from quarter to quarter lasts: a slow approach to an orbit grows too, but by less and less.
GROWTH, LASTING = 1.5, 0.9
PERIODIC, APERIODIC, UNBOUNDED, DRIFTING = 0, 1, 2, 3
MAX_PERIODS_STATUS = int(Status.MAX_PERIODS)
# A numpy integer: numba compiles a plain constant to code of its own, march and all.
EVENTS_PER_PERIOD = np.int64(100_000)


class Settled(NamedTuple):
    """kind: PERIODIC, APERIODIC, UNBOUNDED or DRIFTING (still growing at the bound on periods, though damped);
    state: at period 0 of the orbit; end: m periods later; residual: of the return map relative to the
    motion's size; first, second: Floquet multipliers."""

    kind: int
    status: int
    m: int
    state: State
    end: State
    residual: float
    settled_after: int
    first: complex
    second: complex


@jit_inline
def size_of(p, state, log):
    """Size of a marched motion: largest of |x|, |v| at its section and at its impacts."""
    x, v = section(p, state)
    size = abs(x) + abs(v)
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        size = max(size, abs(log.velocity[i]))
    return size


@jit
def close_orbit(e, p, grid, state, m, within, closed, log, c):
    """Newton on the return map over m periods; (found, Settled) with `found` False if it is not an orbit
    that the motion at `state` settles on. The map must bring the state back to within the share `within` of
    the motion's size at once: Newton's method only finishes what nearly repeats. It is closed where it brings
    it back to within the share `closed`, or can do no better."""
    z = at_period_zero(state)
    start = z
    first_change, residual, best = math.inf, math.inf, math.inf
    none = complex(math.nan, 0.0)
    for iteration in range(MAX_NEWTON):
        clear(log)
        end, status = periods(e, p, grid, z, m, log, c, EVENTS_PER_PERIOD * m)
        if status != OK and status != LOG_FULL:
            return False, Settled(APERIODIC, status, 0, z, z, math.inf, 0, none, none)
        dy, dw = difference(p, end, z)
        change = abs(dy) + abs(dw)
        size = size_of(p, z, log)
        residual = change / size if size > 0.0 else 0.0
        if iteration == 0:
            first_change = change
            if residual > within:
                break
        j11, j12, j21, j22 = derivative(e, p, log, z, end, m)
        same = (z.order == REST) == (end.order == REST)
        if same and (residual <= closed or (residual >= best and residual <= 1e3 * CLOSED)):
            first, second = multipliers(j11, j12, j21, j22)
            radius = abs(first)
            away = difference(p, z, start)
            distance = abs(away[0]) + abs(away[1])
            reach = REACH * first_change / (1.0 - radius) if radius < 1.0 else 0.0
            near = radius < 1.0 and distance <= reach + CLOSED * size
            # A motion that repeats as it stands is its own orbit, stable or not.
            if near or iteration == 0:
                return True, Settled(PERIODIC, status, m, z, end, residual, 0, first, second)
            return False, Settled(APERIODIC, OK, 0, z, z, residual, 0, first, second)
        if iteration == 0 and abs(multipliers(j11, j12, j21, j22)[0]) > UNSTABLE:
            # Chaotic motions pass by unstable orbits all the time.
            break
        if iteration > 2 and residual > 0.5 * best:
            # Newton's method near an orbit gains digits at every step; a chance return does not.
            break
        best = min(best, residual)
        z, inside = newton_step(p, z, end, j11, j12, j21, j22)
        if not inside:
            break
    return False, Settled(APERIODIC, OK, 0, z, z, residual, 0, none, none)


@jit
def with_least_multiple(e, p, grid, orbit, log, c):
    """(found, Settled): the same orbit closed over its least multiple, since a motion that spirals in can nearly
    repeat after m periods before it does after one. The log is left with the contacts of the orbit returned."""
    for m in range(1, orbit.m // 2 + 1):
        if orbit.m % m == 0:
            found, least = close_orbit(e, p, grid, orbit.state, m, SAME, CLOSED, log, c)
            if found:
                return True, least
    if orbit.m == 1:
        return True, orbit
    found, again = close_orbit(e, p, grid, orbit.state, orbit.m, SAME, CLOSED, log, c)
    if found:
        return True, again
    # An orbit closed as far as rounding lets it, not to CLOSED: Newton's method may lose it again within that
    # rounding. It stands as it was found; one march more, of the same bits, brings its log back.
    return close_orbit(e, p, grid, orbit.state, orbit.m, SAME, orbit.residual, log, c)


@jit
def _may_repeat(xs, vs, k, size) -> bool:
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
def _apart(xs, vs, k, m):
    """How far the section at period k is from that m periods before."""
    now = ZERO + k
    return abs(xs[now - m] - xs[now]) + abs(vs[now - m] - vs[now])


@jit
def close_repeated(e, p, grid, state, xs, vs, k, size, log, c):
    """(periods tried, found, Settled): the orbit of the least multiple that the section at period k nearly repeats
    with and that can be closed."""
    none = complex(math.nan, 0.0)
    orbit = Settled(APERIODIC, OK, 0, state, state, math.inf, 0, none, none)
    tried = 0
    for m in range(1, min(k, MAX_MULTIPLE) + 1):
        if not _apart(xs, vs, k, m) <= NEARLY * size:
            continue
        if m > SURE_MULTIPLE and not _apart(xs, vs, k - m, m) <= BEFORE * NEARLY * size:
            continue
        tried += m
        found, orbit = close_orbit(e, p, grid, state, m, math.inf, CLOSED, log, c)
        if found:
            found, orbit = with_least_multiple(e, p, grid, orbit, log, c)
            if found:
                return tried, True, orbit
    return tried, False, orbit


@jit
def loses_speed(p, log) -> bool:
    """Whether any impact of a log does."""
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        if (p.R1 if abs(log.support[i]) == 1 else p.R2) < 1.0:
            return True
    return False


@jit
def kind_of(p, log, xs, vs, k):
    """Kind of a motion without an orbit from its section at the periods 1 to k and its last contacts.

    By quarters: unbounded, or (damping bounds every motion, and so do impacts that lose speed) drifting, is what
    grows from the second to the last, and as fast as before.
    """
    early, middle, late = 0.0, 0.0, 0.0
    for i in range(1, k + 1):
        size = abs(xs[ZERO + i]) + abs(vs[ZERO + i])
        if 4 * i > k and 2 * i <= k:
            early = max(early, size)
        if 2 * i > k and 4 * i <= 3 * k:
            middle = max(middle, size)
        if 4 * i > 3 * k:
            late = max(late, size)
    if late > GROWTH * early:
        if p.h > 0.0 or loses_speed(p, log):
            return DRIFTING
        if late - middle > LASTING * (middle - early):
            return UNBOUNDED
    return APERIODIC


@jit_inline
def follow_growth(e, p, log, is_whole, start, end, a, b):
    """(a, b, growth) of a small difference (a, b) over a period, made of size 1 again; growth: logarithm of its
    size before. -inf where it is forgotten in a rest, or where the log is not whole."""
    if not is_whole:
        return a, b, -math.inf
    j11, j12, j21, j22 = derivative(e, p, log, start, end, ONE)
    a, b = j11 * a + j12 * b, j21 * a + j22 * b
    size = math.hypot(a, b)
    if not (size > 0.0 and size < math.inf):
        return 1.0, 0.0, -math.inf
    return a / size, b / size, math.log(size)


@jit_allocating
def settle_motion(e, p, grid, state, log, c, max_periods, patience, window):
    """March from `state` until an orbit is recognised and closed, at most max_periods forcing periods; a damped
    motion in which small differences still grow fast is left after `patience` periods.

    window: a `Window`, of what a motion without an orbit shows in its last periods, or None.
    """
    xs, vs = np.empty(ZERO + max_periods + 1), np.empty(ZERO + max_periods + 1)
    xs[:ZERO] = vs[:ZERO] = math.inf
    none = complex(math.nan, 0.0)
    state = at_period_zero(state)
    xs[ZERO], vs[ZERO] = section(p, state)
    largest = abs(xs[ZERO]) + abs(vs[ZERO])
    spent, crowded, is_whole = 0, 0, True
    a, b, growth = 1.0, 0.0, 0.0
    kind, ending = APERIODIC, min(patience, max_periods)
    shown_after = max(0, ending - WINDOW)
    for k in range(1, max_periods + 1):
        clear(log)
        start = at_period_zero(state)
        state, status = periods(e, p, grid, start, ONE, log, c, EVENTS_PER_PERIOD)
        crowded += status == LOG_FULL
        if (status != OK and status != LOG_FULL) or crowded == MAX_CROWDED:
            return Settled(APERIODIC, status, 0, state, state, math.inf, k, none, none)
        xs[ZERO + k], vs[ZERO + k] = section(p, state)
        largest = max(largest, size_of(p, state, log))
        if window is not None and k > shown_after:
            if k == shown_after + 1:
                open_window(p, window, start)
                is_whole = True
            # A log that was emptied on the way has only the last contacts of the period.
            is_whole = is_whole and status == OK
            add_period(e, p, window, start, state, log, c)
        if k > patience - FOLLOWED and k <= patience:
            a, b, grown = follow_growth(e, p, log, status == OK, start, state, a, b)
            growth += grown
        if k > PATIENT_TRIES * spent and _may_repeat(xs, vs, k, largest):
            tried, found, orbit = close_repeated(e, p, grid, state, xs, vs, k, largest, log, c)
            if found:
                return Settled(
                    PERIODIC, orbit.status, orbit.m, orbit.state, orbit.end, orbit.residual, k,
                    orbit.first, orbit.second,
                )  # fmt: skip
            spent += tried
        if k == ending:
            kind = kind_of(p, log, xs, vs, k)
            if k == max_periods or (growth > CHAOTIC and kind == APERIODIC and p.h > 0.0):
                break
            ending, shown_after = max_periods, max(k, max_periods - WINDOW)
    if window is not None:
        close_window(p, window, state)
    status = MAX_PERIODS_STATUS if is_whole else LOG_FULL
    return Settled(kind, status, 0, at_period_zero(state), state, math.inf, k, none, none)
