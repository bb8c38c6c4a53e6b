"""The law of motion that settles from a given start: march, recognise an orbit, shoot at it, judge it.

A steady state is found, not waited for. The stroboscopic section is watched until it nearly repeats with
some period multiple m; shooting (`orbits.shooting`) then closes the orbit, and it counts only if it
is stable and as near as the contraction of its multipliers allows. A slow drift passes no such test, and an
orbit of multiple m is not taken for one of a smaller multiple, because that one is unstable.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating
from vibropipe.march.log import IMPACTS
from vibropipe.march.loop import OK
from vibropipe.march.state import State
from vibropipe.orbits.growth import LYAPUNOV_PERIODS, LYAPUNOV_THRESHOLD, perturbation_growth
from vibropipe.orbits.harmonics import ONE_PERIOD
from vibropipe.orbits.recurrence import HISTORY_OFFSET, MAX_MULTIPLE, may_repeat, nearly_repeats
from vibropipe.orbits.return_map import (
    LOG_FULL,
    at_period_zero,
    clear_log,
    floquet_multipliers,
    march_periods,
    state_xv,
)
from vibropipe.orbits.shooting import (
    CLOSURE_TOLERANCE,
    EVENTS_PER_PERIOD,
    Orbit,
    Shooting,
    motion_norm,
    shoot,
)
from vibropipe.orbits.window import WINDOW, add_period, close_window, open_window
from vibropipe.words.status import Status

# Share within which a closed orbit must repeat to be that of a divisor of its multiple.
DIVISOR_TOLERANCE = 1e-9
# An orbit further away than this many times the last change, stretched by 1/(1 - |multiplier|), is some other one.
# Non-normal derivatives make changes larger than multipliers tell.
NEWTON_REACH = 20.0
# Periods marched for one spent on orbits that could not be closed.
MARCH_TO_TRIAL_RATIO = 4
# Where the section nearly repeats about a stable orbit, no multiplier is beyond this. Chaotic motions pass by
# unstable orbits all the time.
MAX_TRIAL_MULTIPLIER = 2.0
# Forcing periods of more contacts than are kept, after which a row is left: no orbit of such periods can be told, and
# each of them takes as long as 100 others. A transient of so many impacts is over by then.
MAX_CROWDED = 32
# Growth of the section's amplitude from the second to the last quarter that counts as unbounded, where that
# from quarter to quarter lasts: a slow approach to an orbit grows too, but by less and less.
GROWTH_FACTOR, GROWTH_PERSISTENCE = 1.5, 0.9
PERIODIC, APERIODIC, UNBOUNDED, DRIFTING = 0, 1, 2, 3
MAX_PERIODS_STATUS = int(Status.MAX_PERIODS)


class SteadyState(NamedTuple):
    """The steady state of a motion.

    Attributes
    ----------
    kind : int
        PERIODIC, APERIODIC, UNBOUNDED or DRIFTING (still growing at the bound on periods, though damped).
    status : int
        `Status` of the march; LOG_FULL where the orbit has more contacts than are kept.
    m : int
        Period multiple; 0 where the motion found no orbit.
    state, end : State
        At period 0 of the orbit, and m periods later; of a motion without an orbit, where it was left.
    residual : float
        Of the return map, as a share of the motion's size.
    settled_after : int
        Forcing periods marched before the orbit was recognised.
    first, second : complex
        Floquet multipliers, the larger modulus first.
    """

    kind: int
    status: int
    m: int
    state: State
    end: State
    residual: float
    periods_marched: int
    first: complex
    second: complex


@jit
def settles_on(orbit) -> bool:
    """Whether the motion that was shot from settles on the orbit: it is stable, and near.

    A fixed point further away than the last change, stretched by 1/(1 - |multiplier|), is some other orbit. A
    motion that repeats as it stands is on its own orbit, stable or not.
    """
    if not orbit.is_closed:
        return False
    if orbit.iterations == 0:
        return True
    j11, j12, j21, j22 = orbit.derivative
    radius = abs(floquet_multipliers(j11, j12, j21, j22)[0])
    reach = NEWTON_REACH * orbit.first_change / (1.0 - radius) if radius < 1.0 else 0.0
    return radius < 1.0 and orbit.distance <= reach + CLOSURE_TOLERANCE * orbit.size


@jit
def reach_orbit(e, p, grid, state, m, within, closed, log, c):
    """(whether it settles on it, Orbit) of the motion at `state` and the orbit of m periods beside it. The return
    map must bring the state back to within the share `within` of the motion's size; `closed`: as of `Shooting`."""
    orbit = shoot(e, p, grid, state, m, Shooting(within, MAX_TRIAL_MULTIPLIER, closed), log, c)
    return settles_on(orbit), orbit


@jit
def reduce_multiple(e, p, grid, orbit, log, c):
    """(reached, Orbit): the same orbit closed over its least multiple, since a motion that spirals in can nearly
    repeat after m periods before it does after one. The log is left with the contacts of the orbit returned."""
    for m in range(1, orbit.m // 2 + 1):
        if orbit.m % m == 0:
            reached, least = reach_orbit(
                e, p, grid, orbit.state, m, DIVISOR_TOLERANCE, CLOSURE_TOLERANCE, log, c
            )
            if reached:
                return True, least
    if orbit.m == 1:
        return True, orbit
    reached, again = reach_orbit(
        e, p, grid, orbit.state, orbit.m, DIVISOR_TOLERANCE, CLOSURE_TOLERANCE, log, c
    )
    if reached:
        return True, again
    # An orbit closed as far as rounding lets it, not to CLOSURE_TOLERANCE: Newton's method may lose it again within
    # that rounding. It stands as it was found; one march more, of the same bits, brings its log back.
    return reach_orbit(e, p, grid, orbit.state, orbit.m, DIVISOR_TOLERANCE, orbit.residual, log, c)


@jit
def close_first_candidate(e, p, grid, state, xs, vs, k, size, log, c):
    """(periods tried, reached, Orbit): the orbit of the least multiple that the section at period k nearly repeats
    with and that the motion settles on."""
    orbit = Orbit(
        False, OK, 0, state, state, math.inf, (0.0, 0.0, 0.0, 0.0), 0, math.inf, math.inf, 0.0
    )
    tried = 0
    for m in range(1, min(k, MAX_MULTIPLE) + 1):
        if not nearly_repeats(xs, vs, k, m, size):
            continue
        tried += m
        reached, orbit = reach_orbit(e, p, grid, state, m, math.inf, CLOSURE_TOLERANCE, log, c)
        if reached:
            reached, orbit = reduce_multiple(e, p, grid, orbit, log, c)
            if reached:
                return tried, True, orbit
    return tried, False, orbit


@jit
def has_lossy_impact(p, log) -> bool:
    """Whether any impact of a log does."""
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        if (p.R1 if abs(log.support[i]) == 1 else p.R2) < 1.0:
            return True
    return False


@jit
def classify_aperiodic(p, log, xs, vs, k):
    """Kind of a motion without an orbit from its section at the periods 1 to k and its last contacts.

    By quarters: unbounded, or (damping bounds every motion, and so do impacts that lose speed) drifting, is what
    grows from the second to the last, and as fast as before.
    """
    early, middle, late = 0.0, 0.0, 0.0
    for i in range(1, k + 1):
        size = abs(xs[HISTORY_OFFSET + i]) + abs(vs[HISTORY_OFFSET + i])
        if 4 * i > k and 2 * i <= k:
            early = max(early, size)
        if 2 * i > k and 4 * i <= 3 * k:
            middle = max(middle, size)
        if 4 * i > 3 * k:
            late = max(late, size)
    if late > GROWTH_FACTOR * early:
        if p.h > 0.0 or has_lossy_impact(p, log):
            return DRIFTING
        if late - middle > GROWTH_PERSISTENCE * (middle - early):
            return UNBOUNDED
    return APERIODIC


@jit
def settled_on(orbit, settled_after):
    """The steady state of a motion that has settled on an orbit."""
    j11, j12, j21, j22 = orbit.derivative
    first, second = floquet_multipliers(j11, j12, j21, j22)
    return SteadyState(
        PERIODIC, orbit.status, orbit.m, orbit.state, orbit.end, orbit.residual, settled_after, first, second
    )  # fmt: skip


@jit_allocating
def find_steady_state(e, p, grid, state, log, c, max_periods, patience, window):
    """March from `state` until an orbit is reached.

    Parameters
    ----------
    state : State
        Where the motion starts.
    log, c
        Work space, as for `march`. The log is left with the contacts of the orbit.
    max_periods : int
        Forcing periods that are marched at most.
    patience : int
        Forcing periods after which a damped motion is left if small differences in it still grow fast.
    window : Window or None
        What a motion without an orbit shows in its last periods.

    Returns
    -------
    Settled
    """
    xs, vs = np.empty(HISTORY_OFFSET + max_periods + 1), np.empty(HISTORY_OFFSET + max_periods + 1)
    xs[:HISTORY_OFFSET] = vs[:HISTORY_OFFSET] = math.inf
    none = complex(math.nan, 0.0)
    state = at_period_zero(state)
    xs[HISTORY_OFFSET], vs[HISTORY_OFFSET] = state_xv(p, state)
    largest = abs(xs[HISTORY_OFFSET]) + abs(vs[HISTORY_OFFSET])
    trial_periods, crowded, is_whole = 0, 0, True
    a, b, growth = 1.0, 0.0, 0.0
    kind, limit = APERIODIC, min(patience, max_periods)
    shown_after = max(0, limit - WINDOW)
    for k in range(1, max_periods + 1):
        clear_log(log)
        start = at_period_zero(state)
        state, status = march_periods(e, p, grid, start, ONE_PERIOD, log, c, EVENTS_PER_PERIOD)
        crowded += status == LOG_FULL
        if (status != OK and status != LOG_FULL) or crowded == MAX_CROWDED:
            return SteadyState(APERIODIC, status, 0, state, state, math.inf, k, none, none)
        xs[HISTORY_OFFSET + k], vs[HISTORY_OFFSET + k] = state_xv(p, state)
        largest = max(largest, motion_norm(p, state, log))
        if window is not None and k > shown_after:
            if k == shown_after + 1:
                open_window(p, window, start)
                is_whole = True
            # A log that was emptied on the way has only the last contacts of the period.
            is_whole = is_whole and status == OK
            add_period(e, p, window, start, state, log, c)
        if k > patience - LYAPUNOV_PERIODS and k <= patience:
            a, b, grown = perturbation_growth(e, p, log, status == OK, start, state, a, b)
            growth += grown
        if k > MARCH_TO_TRIAL_RATIO * trial_periods and may_repeat(xs, vs, k, largest):
            tried, reached, orbit = close_first_candidate(
                e, p, grid, state, xs, vs, k, largest, log, c
            )
            if reached:
                return settled_on(orbit, k)
            trial_periods += tried
        if k == limit:
            kind = classify_aperiodic(p, log, xs, vs, k)
            if k == max_periods or (
                growth > LYAPUNOV_THRESHOLD and kind == APERIODIC and p.h > 0.0
            ):
                break
            limit, shown_after = max_periods, max(k, max_periods - WINDOW)
    if window is not None:
        close_window(p, window, state)
    status = MAX_PERIODS_STATUS if is_whole else LOG_FULL
    return SteadyState(kind, status, 0, at_period_zero(state), state, math.inf, k, none, none)
