"""Steady states by time marching and shooting.

Once the stroboscopic section of the transient nearly repeats after m forcing periods, Newton's method on the
m-period return map (`orbits.shooting`) closes the orbit. The orbit is accepted if it is stable and as close to the
transient as its multipliers imply, or if the motion already lies on it. A small change per period is no criterion:
slow drift shows it too. Motions without an orbit are classified (aperiodic, unbounded, drifting) and averaged over
the last `WINDOW` periods.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating
from vibropipe.march.log import IMPACTS
from vibropipe.march.loop import OK
from vibropipe.march.state import State
from vibropipe.orbits.closing import close_first_candidate
from vibropipe.orbits.growth import (
    EXPONENT_PERIODS,
    LYAPUNOV_PERIODS,
    LYAPUNOV_THRESHOLD,
    add_growth,
    no_growth,
    period_jacobian,
    perturbation_growth,
)
from vibropipe.orbits.harmonics import ONE_PERIOD
from vibropipe.orbits.recurrence import HISTORY_OFFSET, may_repeat
from vibropipe.orbits.return_map import (
    LOG_FULL,
    at_period_zero,
    clear_log,
    floquet_multipliers,
    march_periods,
    state_xv,
)
from vibropipe.orbits.shooting import EVENTS_PER_PERIOD, motion_norm
from vibropipe.orbits.window import (
    LISTED_PERIODS,
    WINDOW,
    add_period,
    close_window,
    list_impacts,
    open_window,
    write_sections,
)
from vibropipe.words.status import Status

# Least ratio of marched periods to periods spent on orbits that were not closed: bounds the cost of failed trials.
MARCH_TO_TRIAL_RATIO = 4
# Forcing periods with more contacts than the log holds before a row is given up. No orbit of such periods can be
# identified, and each takes as long as 100 others. A transient with that many impacts has decayed by then.
MAX_CROWDED = 32
# A motion is unbounded if its section grows by GROWTH_FACTOR from the second to the last quarter of the march and the
# last step from quarter to quarter is at least GROWTH_PERSISTENCE of the one before. A slow approach to an orbit also
# grows, but by less and less.
GROWTH_FACTOR, GROWTH_PERSISTENCE = 1.5, 0.9
PERIODIC, APERIODIC, UNBOUNDED, DRIFTING = 0, 1, 2, 3
MAX_PERIODS_STATUS = int(Status.MAX_PERIODS)


class SteadyState(NamedTuple):
    """The steady state of a motion.

    Attributes
    ----------
    kind : int
        PERIODIC, APERIODIC, UNBOUNDED or DRIFTING (damped, but still growing at the period limit).
    status : int
        `Status` of the march; LOG_FULL if the orbit has more contacts than the log holds.
    m : int
        Period multiple; 0 if the motion has no orbit.
    state, end : State
        State at period 0 of the orbit, and m periods later. Without an orbit: the last state of the march.
    residual : float
        Residual of the return map, relative to the norm of the motion.
    periods_marched : int
        Forcing periods marched before the orbit was recognised.
    first, second : complex
        Floquet multipliers, the larger modulus first; NaN without an orbit.
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
def has_lossy_impact(p, log) -> bool:
    """Return whether an impact of the log loses speed (R < 1)."""
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        if (p.R1 if abs(log.support[i]) == 1 else p.R2) < 1.0:
            return True
    return False


@jit
def classify_aperiodic(p, log, xs, vs, k):
    """Classify a motion without an orbit by the growth of its section over the quarters of the march.

    A motion that grows from the second to the last quarter is drifting if damping or lossy impacts bound it, and
    unbounded if it grows as fast as before. Any other motion is aperiodic.

    Parameters
    ----------
    p : Parameters
    log : Log
        Contacts of the last period.
    xs, vs : (HISTORY_OFFSET + n,) float
        Section (x, x') at the periods 0 to k, from HISTORY_OFFSET on.
    k : int
        Forcing periods marched.

    Returns
    -------
    int
        APERIODIC, UNBOUNDED or DRIFTING.
    """
    early, middle, late = 0.0, 0.0, 0.0
    for i in range(1, k + 1):
        norm = abs(xs[HISTORY_OFFSET + i]) + abs(vs[HISTORY_OFFSET + i])
        if 4 * i > k and 2 * i <= k:
            early = max(early, norm)
        if 2 * i > k and 4 * i <= 3 * k:
            middle = max(middle, norm)
        if 4 * i > 3 * k:
            late = max(late, norm)
    if late > GROWTH_FACTOR * early:
        if p.h > 0.0 or has_lossy_impact(p, log):
            return DRIFTING
        if late - middle > GROWTH_PERSISTENCE * (middle - early):
            return UNBOUNDED
    return APERIODIC


@jit
def settled_on(orbit, periods_marched):
    """Return the `SteadyState` of a motion that settled on an orbit after so many marched periods."""
    j11, j12, j21, j22 = orbit.derivative
    first, second = floquet_multipliers(j11, j12, j21, j22)
    return SteadyState(
        PERIODIC, orbit.status, orbit.m, orbit.state, orbit.end, orbit.residual, periods_marched, first, second
    )  # fmt: skip


@jit_allocating
def find_steady_state(e, p, grid, state, log, c, max_periods, patience, window):
    """March from a state until the motion settles on an orbit.

    Parameters
    ----------
    e : Effects
        Effects of the compiled kernel.
    p : Parameters
    grid : StepGrid
    state : State
        Start of the motion.
    log, c
        Work space, as for `march`. The log is left with the contacts of the orbit.
    max_periods : int
        Largest number of forcing periods marched.
    patience : int
        Forcing periods after which a damped motion is given up if small perturbations still grow fast.
    window : Window or None
        Sums over the last periods of a motion without an orbit, and what is listed of them.

    Returns
    -------
    SteadyState

    Notes
    -----
    A damped motion whose perturbations grew by more than exp(LYAPUNOV_THRESHOLD) over the LYAPUNOV_PERIODS before
    `patience` is left there as aperiodic, any other motion at `max_periods`. The Lyapunov exponent has a perturbation
    of its own, which begins earlier: labels do not depend on the outputs.
    """
    xs, vs = np.empty(HISTORY_OFFSET + max_periods + 1), np.empty(HISTORY_OFFSET + max_periods + 1)
    xs[:HISTORY_OFFSET] = vs[:HISTORY_OFFSET] = math.inf
    none = complex(math.nan, 0.0)
    state = at_period_zero(state)
    xs[HISTORY_OFFSET], vs[HISTORY_OFFSET] = state_xv(p, state)
    norm = abs(xs[HISTORY_OFFSET]) + abs(vs[HISTORY_OFFSET])
    trial_periods, crowded, is_log_complete = 0, 0, True
    dx, dv, growth = 1.0, 0.0, 0.0
    sums, is_measured = no_growth(), False if window is None else window.exponent.size > 0
    kind, limit = APERIODIC, min(patience, max_periods)
    window_start = max(0, limit - WINDOW)
    for k in range(1, max_periods + 1):
        clear_log(log)
        start = at_period_zero(state)
        state, status = march_periods(e, p, grid, start, ONE_PERIOD, log, c, EVENTS_PER_PERIOD)
        crowded += status == LOG_FULL
        if (status != OK and status != LOG_FULL) or crowded == MAX_CROWDED:
            return SteadyState(APERIODIC, status, 0, state, state, math.inf, k, none, none)
        xs[HISTORY_OFFSET + k], vs[HISTORY_OFFSET + k] = state_xv(p, state)
        norm = max(norm, motion_norm(p, state, log))
        if window is not None and k > window_start:
            if k == window_start + 1:
                open_window(p, window, start)
                is_log_complete = True
            # A log that was emptied during the period holds only its last contacts.
            is_log_complete = is_log_complete and status == OK
            add_period(e, p, window, start, state, log, c)
            list_start = max(window_start, limit - LISTED_PERIODS)
            if k > list_start:
                list_impacts(window, log, k - list_start - 1)
        is_judged = k > patience - LYAPUNOV_PERIODS and k <= patience
        if is_judged or (is_measured and k > limit - EXPONENT_PERIODS):
            jacobian = period_jacobian(e, p, log, status == OK, start, state)
            if is_judged:
                dx, dv, log_growth = perturbation_growth(jacobian, dx, dv)
                growth += log_growth
            if is_measured:
                sums = add_growth(sums, jacobian)
        if k > MARCH_TO_TRIAL_RATIO * trial_periods and may_repeat(xs, vs, k, norm):
            new_trials, is_reached, orbit = close_first_candidate(
                e, p, grid, state, xs, vs, k, norm, log, c
            )
            if is_reached:
                return settled_on(orbit, k)
            trial_periods += new_trials
        if k == limit:
            kind = classify_aperiodic(p, log, xs, vs, k)
            if k == max_periods or (
                growth > LYAPUNOV_THRESHOLD and kind == APERIODIC and p.h > 0.0
            ):
                break
            limit, window_start = max_periods, max(k, max_periods - WINDOW)
            sums = no_growth() if k <= limit - EXPONENT_PERIODS else sums
    if window is not None:
        close_window(p, window, state, sums)
        write_sections(window, xs, vs, k)
    status = MAX_PERIODS_STATUS if is_log_complete else LOG_FULL
    return SteadyState(kind, status, 0, at_period_zero(state), state, math.inf, k, none, none)
