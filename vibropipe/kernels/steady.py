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

from vibropipe.jit import jit, jit_allocating
from vibropipe.kernels.march import OK
from vibropipe.kernels.orbit import (
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
from vibropipe.kernels.record import IMPACTS
from vibropipe.kernels.state import REST, State
from vibropipe.status import Status

MAX_MULTIPLE = 32
# Share of the motion's size within which the section counts as nearly repeating.
NEARLY = 1e-5
CLOSED = 1e-13
# Share within which a closed orbit must repeat to be that of a divisor of its multiple.
SAME = 1e-9
MAX_NEWTON = 12
# A fixed point further away than this many times the last change, stretched by 1/(1 - |multiplier|), is
# some other orbit. Non-normal derivatives make changes larger than multipliers tell.
REACH = 20.0
# Growth of the section's amplitude from the second to the last quarter that counts as unbounded, where that
# from quarter to quarter lasts: a slow approach to an orbit grows too, but by less and less.
GROWTH, LASTING = 1.5, 0.9
PERIODIC, APERIODIC, UNBOUNDED, DRIFTING = 0, 1, 2, 3
MAX_PERIODS_STATUS = int(Status.MAX_PERIODS)
# numpy integers: numba compiles a plain constant to code of its own, march and all.
EVENTS_PER_PERIOD = np.int64(100_000)
ONE = np.int64(1)


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


@jit
def size_of(p, state, log):
    """Size of a marched motion: largest of |x|, |v| at its section and at its impacts."""
    x, v = section(p, state)
    size = abs(x) + abs(v)
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        size = max(size, abs(log.velocity[i]))
    return size


@jit
def close_orbit(e, p, grid, state, m, within, log, c):
    """Newton on the return map over m periods; (found, Settled) with `found` False if it is not an orbit
    that the motion at `state` settles on. The map must bring the state back to within the share `within` of
    the motion's size at once: Newton's method only finishes what nearly repeats."""
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
        if same and (residual <= CLOSED or (residual >= best and residual <= 1e3 * CLOSED)):
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
    """The same orbit closed over its least multiple: a motion that spirals in can nearly repeat after m
    periods before it does after one. The log is left with the contacts of the orbit returned."""
    for m in range(1, orbit.m // 2 + 1):
        if orbit.m % m == 0:
            found, least = close_orbit(e, p, grid, orbit.state, m, SAME, log, c)
            if found:
                return least
    if orbit.m > 1:
        return close_orbit(e, p, grid, orbit.state, orbit.m, SAME, log, c)[1]
    return orbit


@jit
def _may_repeat(xs, vs, x, v, size) -> bool:
    """Whether the section nearly repeats any of those kept: one look at all, which the vector units do."""
    near = 0
    for i in range(MAX_MULTIPLE):
        near += abs(xs[i] - x) + abs(vs[i] - v) <= NEARLY * size
    return near > 0


@jit
def close_repeated(e, p, grid, state, xs, vs, k, size, log, c):
    """(tried, found, Settled): the orbit of the least multiple that the section at period k nearly repeats with
    and that can be closed."""
    none = complex(math.nan, 0.0)
    orbit = Settled(APERIODIC, OK, 0, state, state, math.inf, 0, none, none)
    x, v = section(p, state)
    tried = False
    for m in range(1, min(k, MAX_MULTIPLE) + 1):
        then = (k - m) % MAX_MULTIPLE
        if abs(xs[then] - x) + abs(vs[then] - v) <= NEARLY * size:
            tried = True
            found, orbit = close_orbit(e, p, grid, state, m, math.inf, log, c)
            if found:
                return True, True, with_least_multiple(e, p, grid, orbit, log, c)
    return tried, False, orbit


@jit_allocating
def settle_motion(e, p, grid, state, log, c, max_periods):
    """March from `state` until an orbit is recognised and closed, at most max_periods forcing periods."""
    xs, vs = np.full(MAX_MULTIPLE, math.inf), np.full(MAX_MULTIPLE, math.inf)
    none = complex(math.nan, 0.0)
    state = at_period_zero(state)
    xs[0], vs[0] = section(p, state)
    largest, early, middle, late = abs(xs[0]) + abs(vs[0]), 0.0, 0.0, 0.0
    next_try, failures = 1, 0
    for k in range(1, max_periods + 1):
        clear(log)
        state, status = periods(e, p, grid, state, ONE, log, c, EVENTS_PER_PERIOD)
        if status != OK and status != LOG_FULL:
            return Settled(APERIODIC, status, 0, state, state, math.inf, k, none, none)
        x, v = section(p, state)
        size = abs(x) + abs(v)
        largest = max(largest, size_of(p, state, log))
        if 4 * k > max_periods and 2 * k <= max_periods:
            early = max(early, size)
        if 2 * k > max_periods and 4 * k <= 3 * max_periods:
            middle = max(middle, size)
        if 4 * k > 3 * max_periods:
            late = max(late, size)
        if k >= next_try and _may_repeat(xs, vs, x, v, largest):
            tried, found, orbit = close_repeated(e, p, grid, state, xs, vs, k, largest, log, c)
            if found:
                return Settled(
                    PERIODIC, orbit.status, orbit.m, orbit.state, orbit.end, orbit.residual, k,
                    orbit.first, orbit.second,
                )  # fmt: skip
            if tried:
                failures += 1
                next_try = k + 1 + min(failures, 32)
        xs[k % MAX_MULTIPLE], vs[k % MAX_MULTIPLE] = x, v
    lasting = late - middle > LASTING * (middle - early)
    kind = APERIODIC
    if late > GROWTH * early:
        # Damping bounds every motion: a damped one that grows has only not settled yet.
        kind = DRIFTING if p.h > 0.0 else UNBOUNDED if lasting else APERIODIC
    return Settled(
        kind, MAX_PERIODS_STATUS, 0, at_period_zero(state), state, math.inf, max_periods, none, none
    )
