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

from vibropipe.compiler import jit
from vibropipe.march.log import IMPACTS, RESTS, allow_work, clear_log, is_spent
from vibropipe.march.loop import OK
from vibropipe.march.state import FLIGHT, State
from vibropipe.orbits.closing import close_first_candidate
from vibropipe.orbits.growth import (
    EXAMINED_PERIODS,
    EXPONENT_PERIODS,
    JUDGED_PERIODS,
    ROUNDING_GROWTH,
    add_divergence,
    add_growth,
    contraction,
    count_on_support_1,
    is_chaotic,
    no_divergence,
    no_growth,
    period_jacobian,
)
from vibropipe.orbits.harmonics import ONE_PERIOD
from vibropipe.orbits.housing import strobe_of
from vibropipe.orbits.housing_jacobian import coupling_of
from vibropipe.orbits.recurrence import (
    HISTORY_OFFSET,
    MAX_MULTIPLE,
    RETURN_TOLERANCE,
    ROUNDING_TOLERANCE,
    lies_on_orbit,
    may_repeat,
)
from vibropipe.orbits.return_map import (
    LOG_FULL,
    at_period_zero,
    march_periods,
    multipliers_of,
    state_xv,
)
from vibropipe.orbits.shooting import (
    EVENTS_PER_PERIOD,
    Shooting,
    count_as_grazings,
    motion_norm,
    shoot,
)
from vibropipe.orbits.undamped import goes_on_untouched
from vibropipe.orbits.verdict import (
    APERIODIC,
    DRIFTING,
    LONG_ORBIT_PATIENCE,
    PERIODIC,
    UNDAMPED,
    classify_aperiodic,
    is_undamped,
    long_multiple,
    next_limit,
    still_settles,
)
from vibropipe.orbits.window import WINDOW, record_period, write_sections
from vibropipe.orbits.window_means import close_window
from vibropipe.physics.limits import MAX_ROW_WORK
from vibropipe.physics.linear import undamped_multiple
from vibropipe.physics.load import largest_force
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
def settled_on(orbit, periods_marched, chaos):
    """Return the `SteadyState` of a motion that settled on an orbit after so many marched periods."""
    first, second, third = multipliers_of(orbit.derivative, orbit.coupling)
    return SteadyState(
        PERIODIC,
        orbit.status,
        orbit.m,
        orbit.state,
        orbit.end,
        orbit.residual,
        periods_marched,
        first,
        second,
        chaos,
        third,
    )


@jit
def find_steady_state(e, p, grid, state, log, c, max_periods, patience, window, sections):
    """March from a state until the motion settles on an orbit.

    A perturbation is followed over the JUDGED_PERIODS before a limit, until it shows chaos. The Lyapunov exponent has
    a perturbation of its own, which begins earlier: labels do not depend on the outputs.

    state : start of the motion
    log, c : work space, as for `march`. The log is left with the contacts of the orbit
    max_periods : largest number of forcing periods marched
    patience : forcing periods after which a damped motion may be left as chaotic
    window : Window or None, sums over the last periods of a motion without an orbit, and what is listed of them
    sections : tuple of ndarray, work space, `room.new_sections(max_periods)`

    Returns a `SteadyState`.
    """
    xs, vs, us = sections
    xs[:HISTORY_OFFSET] = vs[:HISTORY_OFFSET] = us[:HISTORY_OFFSET] = math.inf
    none = complex(math.nan, 0.0)
    state = at_period_zero(state)
    xs[HISTORY_OFFSET], vs[HISTORY_OFFSET] = state_xv(p, state)
    if us.size > 0:
        us[HISTORY_OFFSET] = strobe_of(p, state.housing, vs[HISTORY_OFFSET])
    norm = abs(xs[HISTORY_OFFSET]) + abs(vs[HISTORY_OFFSET])
    impacts, on_1 = 0, 0
    trial_periods, crowded, is_log_complete, largest = 0, 0, True, MAX_MULTIPLE
    repeats_in, untouched = 0, 0
    allow_work(log, MAX_ROW_WORK)
    if is_undamped(p):
        repeats_in = undamped_multiple(p)[0]
    divergence, origin = no_divergence(), state
    sums, is_measured = no_growth(), False if window is None else window.exponent.size > 0
    kind, is_seen_chaotic, k, limit = APERIODIC, False, 0, min(patience, max_periods)
    window_start, judged_from = max(0, limit - WINDOW), limit - JUDGED_PERIODS
    while k < limit:
        k += 1
        clear_log(log)
        start = at_period_zero(state)
        state, status = march_periods(e, p, grid, start, ONE_PERIOD, log, c, EVENTS_PER_PERIOD)
        crowded += status == LOG_FULL
        if is_spent(log):
            status = MAX_STEPS_STATUS
        if (status != OK and status != LOG_FULL) or crowded == MAX_CROWDED:
            return SteadyState(
                APERIODIC, status, 0, state, state, math.inf, k, none, none, NO_CHAOS, none
            )
        xs[HISTORY_OFFSET + k], vs[HISTORY_OFFSET + k] = state_xv(p, state)
        if us.size > 0:
            us[HISTORY_OFFSET + k] = strobe_of(p, state.housing, vs[HISTORY_OFFSET + k])
        norm = max(norm, motion_norm(p, state, log))
        count_as_grazings(log, norm)
        if is_undamped(p):
            untouched = 0 if is_touched(log, state) else untouched + 1
            x, v = state_xv(p, state)
            if untouched > 0 and goes_on_untouched(p, x, v, repeats_in, untouched):
                return SteadyState(
                    UNDAMPED, OK, 1, state, state, 0.0, k, none, none, NO_CHAOS, none
                )
        impacts, on_1 = impacts + log.counts[IMPACTS], on_1 + count_on_support_1(log)
        if window is not None and k > window_start:
            # A log that was emptied during the period holds only its last contacts.
            is_log_complete = status == OK and (is_log_complete or k == window_start + 1)
            record_period(e, p, window, start, state, log, c, k, window_start + 1, limit)
        is_judged = k > judged_from and not is_chaotic(divergence)
        is_counted = is_measured and k > limit - EXPONENT_PERIODS
        if is_judged or is_counted:
            jacobian = period_jacobian(e, p, log, status == OK, start, state)
            coupling = coupling_of(log.pieces)
            if is_judged:
                divergence = add_divergence(divergence, jacobian, coupling)
            if is_counted:
                sums = add_growth(sums, jacobian, coupling)
        if k > MARCH_TO_TRIAL_RATIO * trial_periods and may_repeat(sections, k, norm, largest):
            new_trials, is_reached, orbit = close_first_candidate(
                e, p, grid, state, sections, k, norm, largest, log, c
            )
            if is_reached:
                chaos = NO_CHAOS
                # The orbit is marched once more, for its contacts.
                allow_work(log, MAX_ROW_WORK)
                if k > EXAMINED_PERIODS:
                    chaos = transient_chaos(e, p, grid, origin, k, orbit, log, c)
                return settled_on(orbit, k, chaos)
            trial_periods += new_trials
        if k == limit:
            kind = classify_aperiodic(p, log, xs, vs, k)
            # Along a long orbit perturbations grow and shrink: growth over a part of it is no chaos.
            is_early = k <= LONG_ORBIT_PATIENCE * patience
            tolerance = RETURN_TOLERANCE if is_early else ROUNDING_TOLERANCE
            repeats = lies_on_orbit(sections, k, norm, tolerance)
            is_seen_chaotic = is_chaotic(divergence) and not repeats
            shrinking = contraction(p, k, on_1, impacts - on_1)
            limit = next_limit(p, kind, is_seen_chaotic, shrinking, k, patience, max_periods)
            if limit > k:
                window_start = max(k, limit - WINDOW)
                sums = no_growth() if k <= limit - EXPONENT_PERIODS else sums
                if is_seen_chaotic:
                    judged_from = limit - JUDGED_PERIODS
                else:
                    largest = long_multiple(log, k)
                if is_chaotic(divergence):
                    divergence = no_divergence()
    if window is not None:
        close_window(log.pieces, e, p, window, state, sums)
        write_sections(window, xs, vs, k)
    # Without damping, the derivatives at ever slower impacts grow where the motion does not.
    may_settle = kind == APERIODIC and (p.h == 0.0 or not is_seen_chaotic)
    # No motion without a force is aperiodic: it repeats after a period of its own, or has not come to rest.
    if may_settle and (largest_force(p) == 0.0 or still_settles(p, sections, k, norm)):
        kind, is_seen_chaotic = DRIFTING, False
    status = MAX_PERIODS_STATUS if is_log_complete else LOG_FULL
    chaos = CHAOS if is_seen_chaotic else NO_CHAOS
    return SteadyState(
        kind, status, 0, at_period_zero(state), state, math.inf, k, none, none, chaos, none
    )
