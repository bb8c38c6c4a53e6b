"""How a motion without an orbit is classified, and how long it is followed.

A chaotic motion may be a transient: its perturbations grow as on an attractor, and only its end tells. The longer it
lasts, the less likely is an end, and the likelier the less the motion contracts areas (then many orbits coexist) or
where a motion without impacts exists. A motion is therefore left as chaotic (`next_limit`) after a number of periods
that depends on both, and one that is not chaotic is followed further, until it closes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.log import IMPACTS
from vibropipe.orbits.growth import (
    EXPONENT_PERIODS,
    JUDGED_PERIODS,
    Divergence,
    GrowthSums,
    add_divergence,
    add_growth,
    contraction,
    count_on_support_1,
    is_chaotic,
    no_divergence,
    no_growth,
)
from vibropipe.orbits.housing_jacobian import coupling_of
from vibropipe.orbits.recurrence import (
    HISTORY_OFFSET,
    MAX_LONG_MULTIPLE,
    MAX_MULTIPLE,
    RETURN_TOLERANCE,
    ROUNDING_TOLERANCE,
    lies_on_orbit,
)
from vibropipe.orbits.shooting import count_as_grazings, motion_norm
from vibropipe.orbits.window import WINDOW
from vibropipe.physics.contact import support_position
from vibropipe.physics.housing import runs_away
from vibropipe.physics.linear import (
    FREQUENCY_ROUNDING,
    is_resonant,
    settles_without_impact,
    stays_off_supports,
    steady_at,
)
from vibropipe.physics.load import largest_force

# A motion is unbounded if its section grows by GROWTH_FACTOR from the second to the last quarter of the march and the
# last step from quarter to quarter is at least GROWTH_PERSISTENCE of the one before. A slow approach to an orbit also
# grows, but by less and less.
GROWTH_FACTOR, GROWTH_PERSISTENCE = 1.5, 0.9
# Area contraction per forcing period, as a logarithm, below which chaos lasts longer as a transient: a motion that
# contracts less is followed longer in proportion. Of 20,000 random rows that are chaotic after 200 periods 41 settle
# later; 27 with this.
USUAL_CONTRACTION = 2.3
# Longest march, as a multiple of the largest number of periods, of a damped motion that is not chaotic and has not
# closed, or is chaotic beside a motion without impacts, on which three of four such motions settle.
PURSUIT = 5
# Forcing periods, as a multiple of the patience, within which a chaotic motion that seems to repeat has to close; one
# that repeats to rounding may do so later.
LONG_ORBIT_PATIENCE = 3
# Sizes of a motion at which a support that it does not strike is as good as absent.
FAR = 1e3
PERIODIC, APERIODIC, UNBOUNDED, DRIFTING, UNDAMPED = range(5)


@jit
def is_undamped(p) -> bool:
    """Return whether a motion between supports loses no energy: without damping, friction and a housing."""
    return p.h == 0.0 and p.friction == 0.0 and p.mass_ratio == 0.0


@jit
def has_lossy_impact(p, log) -> bool:
    """Return whether friction, a soft support, a housing or an impact of the log (R < 1) may take energy."""
    if p.friction > 0.0 or p.h1 > 0.0 or p.h2 > 0.0 or p.mass_ratio > 0.0:
        return True
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        if (p.R1 if abs(log.support[i]) == 1 else p.R2) < 1.0:
            return True
    return False


@jit
def _half_swing(stiffness):
    """Return the time of half a large swing beyond a struck support, in units of pi: 0 beyond a rigid one."""
    return 1.0 / math.sqrt(1.0 + stiffness) if stiffness > 0.0 else 0.0


@jit
def _is_whole(number) -> bool:
    """Return whether a number > 0 is whole within rounding, and not 0."""
    whole = math.floor(number + 0.5)
    return whole >= 1.0 and abs(number - whole) <= FREQUENCY_ROUNDING * number


@jit
def grows_without_bound(p, log, norm) -> bool:
    """Return whether a lossless motion that grows is at the resonance of the large motions that it leads to.

    A large motion takes no note of where the supports are: each half of its swing takes pi, or less in a support that
    it strikes. Its period is then that of the force or of its second harmonic, or several of these. Between two rigid
    supports there is no resonance. A support that the motion does not strike is as good as absent if it is `FAR`.

    log : contacts of the last period
    norm : largest |x| + |x'| of the motion
    """
    upper, lower = 1.0, 1.0
    strikes_upper, strikes_lower = False, False
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        if abs(log.support[i]) == 1:
            upper, strikes_upper = _half_swing(p.k1), True
        else:
            lower, strikes_lower = _half_swing(p.k2), True
    if not strikes_upper and support_position(p, 1) < FAR * norm:
        return False
    if not strikes_lower and -support_position(p, 2) < FAR * norm:
        return False
    if not (strikes_upper or strikes_lower):
        return is_resonant(p)
    swings = 0.5 * p.nu * (upper + lower)
    return (p.f != 0.0 and _is_whole(swings)) or (p.f2 != 0.0 and _is_whole(2.0 * swings))


@jit
def classify_aperiodic(p, log, xs, vs, k):
    """Classify a motion without an orbit by the growth of its section over the quarters of the march.

    One in a housing that the constant force drives against all friction is unbounded, by the law of momentum. An
    undamped motion that certainly reaches no support has two frequencies: it is aperiodic. Any other one that grows
    from the second to the last quarter is drifting if damping or lossy impacts bound it. It is unbounded if it grows as
    fast as before and is at resonance (`grows_without_bound`); off that it is drifting, since it is a beat. Any other
    motion is aperiodic.

    log : contacts of the last period
    xs, vs : (HISTORY_OFFSET + n,), section (x, x') at the periods 0 to k, from HISTORY_OFFSET on
    k : forcing periods marched

    Returns APERIODIC, UNBOUNDED or DRIFTING.
    """
    last = HISTORY_OFFSET + k
    if runs_away(p):
        return UNBOUNDED
    if is_undamped(p) and stays_off_supports(p, xs[last], vs[last], 0.0):
        return APERIODIC
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
            return UNBOUNDED if grows_without_bound(p, log, late) else DRIFTING
    return APERIODIC


@jit
def still_settles(p, sections, k, norm) -> bool:
    """Return whether a motion that loses energy nearly repeats, but has not settled: it may on what is not like it.

    p, k : as for `classify_aperiodic`; sections : as for `recurrence`; norm : norm of the motion.
    """
    xs, vs, _ = sections
    last = HISTORY_OFFSET + k
    if is_undamped(p):
        if stays_off_supports(p, xs[last], vs[last], 0.0):
            return False
        if p.R1 == 1.0 and p.R2 == 1.0 and p.h1 == 0.0 and p.h2 == 0.0:
            return False
    return lies_on_orbit(sections, k, norm, RETURN_TOLERANCE)


@jit
def next_limit(p, kind, is_seen_chaotic, shrinking, k, patience, max_periods):
    """Return the number of forcing periods up to which a motion without an orbit is followed.

    kind : APERIODIC, UNBOUNDED or DRIFTING
    is_seen_chaotic : whether the motion is chaotic as far as is known
    shrinking : contraction of areas per forcing period (`contraction`)
    k : forcing periods marched
    patience, max_periods : as for `find_steady_state`

    Returns the limit; k where the motion is left.
    """
    goal, longest = max_periods, max_periods
    if kind == APERIODIC and p.h > 0.0:
        x, v = steady_at(p, 0.0)
        if not is_seen_chaotic:
            longest *= PURSUIT if k >= max_periods else 1
            goal = k + WINDOW
        elif settles_without_impact(p, x, v):
            longest *= PURSUIT
            goal = 2 * k
        else:
            goal = int(min(float(longest), patience * max(1.0, USUAL_CONTRACTION / shrinking)))
    if k >= min(goal, longest):
        return k
    # No window is shorter than WINDOW.
    limit = max(goal, k + WINDOW)
    return longest if limit + WINDOW > longest else limit


@jit
def long_multiple(log, k):
    """Return the largest period multiple sought after k periods, whose impacts the log holds if they go on alike."""
    fits = log.position.size // (log.counts[IMPACTS] + 1)
    return max(MAX_MULTIPLE, min(MAX_LONG_MULTIPLE, min(k // 2, fits)))


class Limit(NamedTuple):
    """Until when a motion is marched, and which of its last periods are looked at.

    periods : forcing periods after which it is left
    window_start, judged_from : periods after which its window begins, and a perturbation is followed
    largest : largest period multiple that is sought
    """

    periods: int
    window_start: int
    judged_from: int
    largest: int


@jit_inline
def first_limit(periods):
    """Return the `Limit` of a motion that begins."""
    return Limit(periods, max(0, periods - WINDOW), periods - JUDGED_PERIODS, MAX_MULTIPLE)


@jit
def later_limit(limit, periods, log, k, is_seen_chaotic):
    """Return the `Limit` of a motion that goes on after period k."""
    judged_from, largest = limit.judged_from, limit.largest
    if is_seen_chaotic:
        judged_from = periods - JUDGED_PERIODS
    else:
        largest = long_multiple(log, k)
    return Limit(periods, max(k, periods - WINDOW), judged_from, largest)


class Perturbations(NamedTuple):
    """Two perturbations of a motion: labels do not depend on the outputs.

    divergence : that by which it is judged, until it shows chaos
    sums : that of the Lyapunov exponent, which begins earlier
    """

    divergence: Divergence
    sums: GrowthSums


@jit_inline
def followed_on(log, jacobian, is_judged, is_counted, followed):
    """Return `Perturbations` a logged period later."""
    (divergence, sums), coupling = followed, coupling_of(log.pieces)
    if is_judged:
        divergence = add_divergence(divergence, jacobian, coupling)
    if is_counted:
        sums = add_growth(sums, jacobian, coupling)
    return Perturbations(divergence, sums)


class Course(NamedTuple):
    """What a motion has done: forcing periods marched, its norm, its impacts, and those on support 1."""

    periods: int
    norm: float
    impacts: int
    on_1: int


@jit_inline
def course_after(p, log, state, course):
    """Return the `Course` a logged period later; impacts that are rounding become grazings of the log."""
    norm = max(course.norm, motion_norm(p, state, log))
    count_as_grazings(log, norm)
    impacts, on_1 = course.impacts + log.counts[IMPACTS], course.on_1 + count_on_support_1(log)
    return Course(course.periods + 1, norm, impacts, on_1)


@jit
def judged_at_limit(p, log, sections, course, followed, limit, patience, max_periods):
    """Return what a motion without an orbit is at a limit.

    Returns its kind, whether it is seen to be chaotic, the `Limit` until which it goes on, which may be the same, and
    `Perturbations`.
    """
    k, (divergence, sums) = course.periods, followed
    kind = classify_aperiodic(p, log, sections[0], sections[1], k)
    # Along a long orbit perturbations grow and shrink: growth over a part of it is no chaos.
    is_early = k <= LONG_ORBIT_PATIENCE * patience
    tolerance = RETURN_TOLERANCE if is_early else ROUNDING_TOLERANCE
    repeats = lies_on_orbit(sections, k, course.norm, tolerance)
    is_seen_chaotic = is_chaotic(divergence) and not repeats
    shrinking = contraction(p, k, course.on_1, course.impacts - course.on_1)
    until = next_limit(p, kind, is_seen_chaotic, shrinking, k, patience, max_periods)
    if until > k:
        limit = later_limit(limit, until, log, k, is_seen_chaotic)
        if k <= until - EXPONENT_PERIODS:
            sums = no_growth()
        if is_chaotic(divergence):
            divergence = no_divergence()
    return kind, is_seen_chaotic, limit, Perturbations(divergence, sums)


@jit_inline
def settles_later(p, kind, is_seen_chaotic, sections, course) -> bool:
    """Return whether a motion that was left as aperiodic may settle later."""
    if kind != APERIODIC or (p.h > 0.0 and is_seen_chaotic):
        # Without damping, the derivatives at ever slower impacts grow where the motion does not.
        return False
    # No motion without a force is aperiodic: it repeats after a period of its own, or has not come to rest.
    return largest_force(p) == 0.0 or still_settles(p, sections, course.periods, course.norm)
