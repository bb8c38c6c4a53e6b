"""What a march records: a log of contacts and, on request, samples of the motion."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline
from vibropipe.march.grid import evaluate
from vibropipe.march.piece_log import PieceLog, clear_pieces
from vibropipe.physics.contact import to_displacement, to_velocity
from vibropipe.physics.limits import COMPUTED_STEPS, MAX_MARCH_STEPS, POLYNOMIAL_STEPS

# Indices of `Log.counts`. COMPUTED counts those of the steps whose force is in no table; LIMIT is the work at which a
# march stops (`is_spent`), MOST the largest that may be allowed at a time, TOTAL the limit of all marches, 0 for any.
IMPACTS, RESTS, GRAZINGS, SAMPLES, STEPS, POLYNOMIALS, EVALUATIONS, SHORT_FLIGHTS, TAILS = range(9)
COMPUTED, LIMIT, MOST, TOTAL, COUNTS = 9, 10, 11, 12, 13


class Log(NamedTuple):
    """Contacts in order of time; times in forcing periods, velocities of x, impulses as changes of x'.

    position, velocity, impulse, support : of each impact: time, velocity before it, impulse, support (1 or 2). The tail
        of a chatter, completed in one piece, has support -1 or -2 and the impulse of all impacts that it replaces
    rest_start, rest_end, rest_support : of each rest
    grazing, grazing_support : of each grazing
    counts : (COUNTS,), numbers of entries and of operations, by the indices above. Entries beyond the capacity are
        counted only
    pieces, plain : linear pieces of a motion with soft supports or friction. One of both is None: numba then compiles
        one march
    """

    position: np.ndarray
    velocity: np.ndarray
    impulse: np.ndarray
    support: np.ndarray
    rest_start: np.ndarray
    rest_end: np.ndarray
    rest_support: np.ndarray
    grazing: np.ndarray
    grazing_support: np.ndarray
    counts: np.ndarray
    pieces: PieceLog | None = None
    plain: int | None = 1


class Samples(NamedTuple):
    """Arrays for the motion at the times start + i stride / per_period, in forcing periods.

    start_step, start_theta : the start, as a step counted from tau = 0 and a share of it.
    housing : velocity and displacement of a housing, (n, 2), or None.
    """

    displacement: np.ndarray
    velocity: np.ndarray
    stride: int
    per_period: int
    start_step: int
    start_theta: float
    housing: np.ndarray | None = None


@jit_inline
def work_of(log):
    """Return the work of all marches with a log, in steps."""
    computed = (COMPUTED_STEPS - 1) * log.counts[COMPUTED]
    return log.counts[STEPS] + computed + POLYNOMIAL_STEPS * log.counts[POLYNOMIALS]


@jit
def allow_work(log, work) -> None:
    """Allow the marches with a log some more work from now on, in steps, as far as `limit_work` lets it."""
    if log.counts[MOST] > 0:
        work = min(work, log.counts[MOST])
    log.counts[LIMIT] = work_of(log) + work
    if log.counts[TOTAL] > 0:
        log.counts[LIMIT] = min(log.counts[LIMIT], log.counts[TOTAL])


@jit
def limit_work(log, most, total) -> None:
    """Limit what `allow_work` allows at a time, and in all from now on, in steps; 0 is no limit."""
    log.counts[MOST] = most
    log.counts[TOTAL] = work_of(log) + total if total > 0 else 0


@jit
def work_left(log):
    """Return the work that the limit of all marches leaves, in steps: none, or less, beyond it."""
    return log.counts[TOTAL] - work_of(log) if log.counts[TOTAL] > 0 else MAX_MARCH_STEPS


@jit_inline
def is_spent(log) -> bool:
    """Return whether the marches with a log have done the work that they are allowed: any if that was never said."""
    return 0 < log.counts[LIMIT] < work_of(log)


@jit_allocating
def new_log(impacts, rests, pieces=None, plain=1):
    """Return an empty log.

    impacts : capacity for impacts
    rests : capacity for rests, and for grazings
    pieces, plain : as in `Log`
    """
    return Log(
        np.empty(impacts),
        np.empty(impacts),
        np.empty(impacts),
        np.empty(impacts, np.int8),
        np.empty(rests),
        np.empty(rests),
        np.empty(rests, np.int8),
        np.empty(rests),
        np.empty(rests, np.int8),
        np.zeros(COUNTS, np.int64),
        pieces,
        plain,
    )


@jit_inline
def clear_log(log) -> None:
    """Empty a log of contacts. The counts of steps and evaluations are kept."""
    log.counts[IMPACTS] = 0
    log.counts[RESTS] = 0
    log.counts[GRAZINGS] = 0
    log.counts[TAILS] = 0
    clear_pieces(log.pieces)


@jit_inline
def log_impact(log, position, support, velocity_before, impulse) -> None:
    """Append an impact, or the tail of a chatter.

    position : time in forcing periods
    support : 1 or 2; negative for a tail
    velocity_before, impulse : x' before the impact, and its change
    """
    n = log.counts[IMPACTS]
    if n < log.position.size:
        log.position[n] = position
        log.velocity[n] = velocity_before
        log.impulse[n] = impulse
        log.support[n] = support
    log.counts[IMPACTS] = n + 1
    if support < 0:
        log.counts[TAILS] += 1


@jit
def log_rest(log, start, end, support) -> None:
    """Append a rest that has ended."""
    n = log.counts[RESTS]
    if n < log.rest_start.size:
        log.rest_start[n] = start
        log.rest_end[n] = end
        log.rest_support[n] = support
    log.counts[RESTS] = n + 1


@jit
def log_grazing(log, position, support) -> None:
    """Append a grazing."""
    n = log.counts[GRAZINGS]
    if n < log.grazing.size:
        log.grazing[n] = position
        log.grazing_support[n] = support
    log.counts[GRAZINGS] = n + 1


@jit_inline
def is_full(log) -> bool:
    """Return whether one more entry of any kind might exceed the capacity."""
    return (
        log.counts[IMPACTS] + 1 >= log.position.size
        or log.counts[RESTS] + 1 >= log.rest_start.size
        or log.counts[GRAZINGS] + 1 >= log.grazing.size
    )


@jit_inline
def sample_place(samples, steps, i):
    """Return the place of sample i after the first, in whole steps and per_period-ths of one: no time drifts.

    steps : of a forcing period.
    """
    scaled = i * samples.stride * steps
    return scaled // samples.per_period, scaled % samples.per_period


@jit
def fill_samples(xs, vs, grid, c, parts, offset, sign) -> None:
    """Write samples on a polynomial, at the places on it that `vs` holds; x is offset + sign y."""
    # The compiler makes one loop of it that takes several samples at a time.
    for i in range(vs.size):
        y, w = evaluate(grid, c, vs[i])
        xs[i], vs[i] = offset + sign * y, sign * (w * parts)


@jit_inline
def record(samples, counts, p, grid, state, c, begin, until, parts) -> None:
    """Write the samples from `begin` to `until` steps after a state, on a polynomial from `begin` on.

    samples : None records nothing
    counts : counts[SAMPLES] grows by the samples written
    c : polynomial of the motion; None while the mass sticks to the support of the state
    begin, until : in steps
    parts : parts of a step that the polynomial is written in
    """
    if samples is not None:
        first = i = counts[SAMPLES]
        waited = samples.start_step - (state.period * grid.steps + state.step)
        step, left = sample_place(samples, grid.steps, i)
        more, more_left = sample_place(samples, grid.steps, 1)
        while i < samples.displacement.size:
            theta = samples.start_theta + left / samples.per_period
            after = (waited + step) + (theta - state.theta)
            if after > until:
                break
            samples.velocity[i] = (after - begin) * parts
            i += 1
            # as `sample_place` of i, without its divisions
            step, left = step + more, left + more_left
            if left >= samples.per_period:
                step, left = step + 1, left - samples.per_period
        counts[SAMPLES] = i
        xs, vs = samples.displacement[first:i], samples.velocity[first:i]
        if c is None:
            xs[:], vs[:] = to_displacement(p, state.home, 0.0), 0.0
        else:
            offset, sign = to_displacement(p, state.home, 0.0), to_velocity(state.home, 1.0)
            fill_samples(xs, vs, grid, c, parts, offset, sign)
