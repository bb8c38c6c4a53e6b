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

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.log import IMPACTS, RESTS, allow_work, clear_log, is_spent
from vibropipe.march.loop import OK
from vibropipe.march.state import FLIGHT, State
from vibropipe.orbits.closing import close_first_candidate
from vibropipe.orbits.growth import (
    EXAMINED_PERIODS,
    EXPONENT_PERIODS,
    ROUNDING_GROWTH,
    add_divergence,
    is_chaotic,
    no_divergence,
    no_growth,
    period_jacobian,
)
from vibropipe.orbits.harmonics import ONE_PERIOD
from vibropipe.orbits.housing import strobe_of
from vibropipe.orbits.recurrence import HISTORY_OFFSET, may_repeat
from vibropipe.orbits.return_map import (
    LOG_FULL,
    at_period_zero,
    march_periods,
    multipliers_of,
    state_xv,
)
from vibropipe.orbits.shooting import EVENTS_PER_PERIOD, Shooting, shoot
from vibropipe.orbits.undamped import goes_on_untouched
from vibropipe.orbits.verdict import (
    APERIODIC,
    DRIFTING,
    PERIODIC,
    UNDAMPED,
    Course,
    Perturbations,
    course_after,
    first_limit,
    followed_on,
    is_undamped,
    judged_at_limit,
    settles_later,
)
from vibropipe.orbits.window import record_period, write_sections
from vibropipe.orbits.window_means import close_window
from vibropipe.physics.limits import MAX_ROW_WORK
from vibropipe.physics.linear import undamped_multiple
from vibropipe.words.regimes import Chaos
from vibropipe.words.status import Status

# Least ratio of marched periods to periods spent on orbits that were not closed: bounds the cost of failed trials.
MARCH_TO_TRIAL_RATIO = 4
# Forcing periods with more contacts than the log holds before a row is given up. No orbit of such periods can be
# identified, and each takes as long as 100 others. A transient with that many impacts has decayed by then.
MAX_CROWDED = 32
NO_CHAOS, TRANSIENT_CHAOS, CHAOS = int(Chaos.NONE), int(Chaos.TRANSIENT), int(Chaos.IN_WINDOW)
MAX_PERIODS_STATUS, MAX_STEPS_STATUS = int(Status.MAX_PERIODS), int(Status.MAX_STEPS)


class SteadyState(NamedTuple):
    """The steady state of a motion.

    kind : PERIODIC, UNDAMPED (an orbit in closed form, of `closed_form.solve_undamped` or a free vibration), APERIODIC,
        UNBOUNDED or DRIFTING (bounded, but still changing at the period limit)
    status : `Status` of the march; LOG_FULL if the orbit has more contacts than the log holds
    m : period multiple; 0 if the motion has no orbit
    state, end : state at period 0 of the orbit, and m periods later. Without an orbit: the last state of the march
    residual : residual of the return map, relative to the norm of the motion
    periods_marched : forcing periods marched before the orbit was recognised
    first, second, third : Floquet multipliers, the larger modulus first; NaN without an orbit. The third is one of a
        housing
    chaos : code of `Chaos`
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
    chaos: int
    third: complex


@jit
def is_touched(log, state) -> bool:
    """Return whether a support acted in a logged period, after which the motion is in `state`; a grazing does not."""
    return (
        log.counts[IMPACTS] + log.counts[RESTS] > 0
        or state.mode != FLIGHT
        or (state.home > 0 and state.y < 0.0)
    )


@jit
def transient_chaos(e, p, grid, origin, periods, orbit, log, c):
    """Return the code of `Chaos` of a motion from `origin` that settled on an orbit after so many forcing periods.

    The motion is marched again with a perturbation, by `shoot`, which stops after the first march: another copy of the
    march in this kernel makes all rows a tenth slower. The log is left with the contacts of the orbit.
    """
    divergence, chaos, state = no_divergence(), NO_CHAOS, origin
    for _ in range(periods):
        period = shoot(e, p, grid, state, ONE_PERIOD, Shooting(math.inf, -1.0, -1.0), log, c)
        state = period.end
        divergence = add_divergence(divergence, period.derivative, period.coupling)
        # A log that was emptied tells no derivative, so the perturbation begins anew.
        if period.status != OK:
            divergence = no_divergence()
        if divergence.growth > ROUNDING_GROWTH:
            chaos = TRANSIENT_CHAOS
            break
    shoot(e, p, grid, orbit.state, orbit.m, Shooting(math.inf, math.inf, math.inf), log, c)
    return chaos


@jit
def settled_on(e, p, grid, origin, orbit, k, log, c):
    """Return the `SteadyState` of a motion from `origin` that settled on an orbit after k forcing periods."""
    # The orbit is marched once more, for its contacts.
    allow_work(log, MAX_ROW_WORK)
    chaos = NO_CHAOS
    if k > EXAMINED_PERIODS:
        chaos = transient_chaos(e, p, grid, origin, k, orbit, log, c)
    first, second, third = multipliers_of(orbit.derivative, orbit.coupling)
    return SteadyState(
        PERIODIC, orbit.status, orbit.m, orbit.state, orbit.end, orbit.residual, k, first, second,
        chaos, third,
    )  # fmt: skip


@jit
def without_orbit(kind, status, state, end, k, chaos):
    """Return the `SteadyState` of a motion that was marched for k periods without an orbit, or is in closed form."""
    none, m, residual = complex(math.nan, 0.0), 0, math.inf
    if kind == UNDAMPED:
        m, residual = 1, 0.0
    return SteadyState(kind, status, m, state, end, residual, k, none, none, chaos, none)


@jit_inline
def keep_section(p, state, sections, k) -> None:
    """Keep the state at the end of period k."""
    xs, vs, us = sections
    n = HISTORY_OFFSET + k
    xs[n], vs[n] = state_xv(p, state)
    if us.size > 0:
        us[n] = strobe_of(p, state.housing, vs[n])


@jit_inline
def begin_sections(p, state, sections):
    """Keep the state at the start, before which there was none; return its `Course`."""
    for values in sections:
        values[:HISTORY_OFFSET] = math.inf
    keep_section(p, state, sections, 0)
    norm = abs(sections[0][HISTORY_OFFSET]) + abs(sections[1][HISTORY_OFFSET])
    return Course(0, norm, 0, 0)


@jit
def find_steady_state(e, p, grid, state, log, c, max_periods, patience, window, sections):
    """March from a state until the motion settles on an orbit.

    state : start of the motion
    log, c : work space, as for `march`. The log is left with the contacts of the orbit
    max_periods : largest number of forcing periods marched
    patience : forcing periods after which a damped motion may be left as chaotic
    window : Window or None, sums over the last periods of a motion without an orbit, and what is listed of them
    sections : tuple of ndarray, work space, `room.new_sections(max_periods)`

    Returns a `SteadyState`.
    """
    state = origin = at_period_zero(state)
    course, crowded, untouched, trials = begin_sections(p, state, sections), 0, 0, 0
    allow_work(log, MAX_ROW_WORK)
    repeats_in = undamped_multiple(p)[0] if is_undamped(p) else 0
    followed = Perturbations(no_divergence(), no_growth())
    is_measured = False if window is None else window.exponent.size > 0
    kind, is_seen_chaotic, is_log_complete = APERIODIC, False, True
    limit = first_limit(min(patience, max_periods))
    while course.periods < limit.periods:
        clear_log(log)
        start = at_period_zero(state)
        state, status = march_periods(e, p, grid, start, ONE_PERIOD, log, c, EVENTS_PER_PERIOD)
        crowded += status == LOG_FULL
        if is_spent(log):
            status = MAX_STEPS_STATUS
        k = course.periods + 1
        if (status != OK and status != LOG_FULL) or crowded == MAX_CROWDED:
            return without_orbit(APERIODIC, status, state, state, k, NO_CHAOS)
        keep_section(p, state, sections, k)
        course = course_after(p, log, state, course)
        if is_undamped(p):
            untouched = 0 if is_touched(log, state) else untouched + 1
            x, v = state_xv(p, state)
            if untouched > 0 and goes_on_untouched(p, x, v, repeats_in, untouched):
                return without_orbit(UNDAMPED, OK, state, state, k, NO_CHAOS)
        first = limit.window_start + 1
        if window is not None and k >= first:
            # A log that was emptied during the period holds only its last contacts.
            is_log_complete = status == OK and (is_log_complete or k == first)
            record_period(e, p, window, start, state, log, c, k, first, limit.periods)
        is_judged = k > limit.judged_from and not is_chaotic(followed.divergence)
        is_counted = is_measured and k > limit.periods - EXPONENT_PERIODS
        if is_judged or is_counted:
            jacobian = period_jacobian(e, p, log, status == OK, start, state)
            followed = followed_on(log, jacobian, is_judged, is_counted, followed)
        if k > MARCH_TO_TRIAL_RATIO * trials and may_repeat(
            sections, k, course.norm, limit.largest
        ):
            new_trials, is_reached, orbit = close_first_candidate(
                e, p, grid, state, sections, k, course.norm, limit.largest, log, c
            )
            if is_reached:
                return settled_on(e, p, grid, origin, orbit, k, log, c)
            trials += new_trials
        if k == limit.periods:
            kind, is_seen_chaotic, limit, followed = judged_at_limit(
                p, log, sections, course, followed, limit, patience, max_periods
            )
    if window is not None:
        close_window(log.pieces, e, p, window, state, followed.sums)
        write_sections(window, sections[0], sections[1], course.periods)
    if settles_later(p, kind, is_seen_chaotic, sections, course):
        kind, is_seen_chaotic = DRIFTING, False
    status = MAX_PERIODS_STATUS if is_log_complete else LOG_FULL
    chaos = CHAOS if is_seen_chaotic else NO_CHAOS
    return without_orbit(kind, status, at_period_zero(state), state, course.periods, chaos)
