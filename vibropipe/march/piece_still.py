"""A mass that lies still along pieces: held by friction or within a step, or at rest on a rigid support."""

from __future__ import annotations

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.contacts import advance_rest
from vibropipe.march.grid import Instant, phase_at, steps_until
from vibropipe.march.log import SAMPLES, SHORT_FLIGHTS, STEPS, record
from vibropipe.march.piece_housing import keep_still_housing
from vibropipe.march.piece_log import ELAPSED, RELEASE, SLIP, STICK, TOUCH, extend_piece
from vibropipe.march.piece_state import coefficients, is_in_contact, net_force, resume, with_housing
from vibropipe.march.piece_transitions import begin
from vibropipe.march.state import (
    DOWN_BY_ACCELERATION,
    DOWN_BY_JERK,
    DOWN_BY_SNAP,
    LEAVES_BY_ACCELERATION,
    LEAVES_BY_JERK,
    LEAVES_BY_SNAP,
    REST,
    STUCK,
    State,
    advance_time,
    is_before,
)
from vibropipe.physics.contact import frame_at
from vibropipe.physics.friction import jumps_at_slip, slip_wait
from vibropipe.physics.housing import moved
from vibropipe.physics.load import NEVER
from vibropipe.words.status import Status

OK = int(Status.OK)


@jit_inline
def next_instant(grid, at, theta):
    """Return (period, step, theta) at theta of the step of `at`; theta = 1 is the start of the next step."""
    if theta < 1.0:
        return at.period, at.step, theta
    if at.step + 1 < grid.steps:
        return at.period, at.step + 1, 0.0
    return at.period + 1, 0, 0.0


@jit
def step_end(grid, at, end):
    """Return the `Instant` at which the step of the grid ends that a state is in, or `end` if that is earlier."""
    if at.period == end.period and at.step == end.step:
        return end
    period, step, theta = next_instant(grid, at, 1.0)
    return Instant(period, step, theta)


@jit
def hold(e, p, grid, state, end, log, samples, c):
    """Hold a mass that does not start to move within a step of the grid; return what `advance_piece` returns."""
    limit = end.theta if state.period == end.period and state.step == end.step else 1.0
    for n in range(1, c.size):
        c[n] = 0.0
    first, held = log.counts[SAMPLES], limit - state.theta
    record(samples, log.counts, p, grid, state, c, 0.0, held, 1)
    span = held * grid.dt
    housing = moved(p, state.housing, span, 0.0, 0.0)
    keep_still_housing(log, samples, first, p, grid, state, housing)
    extend_piece(log.pieces, span, state.y, 0.0)
    if is_in_contact(e, p, state):
        log.pieces.contact[ELAPSED] += span
    period, step, theta = next_instant(grid, state, limit)
    after = resume(e, p, grid, Instant(period, step, theta), state.home, state.y, housing)
    log.counts[STEPS] += 1
    if grid.exact is None:
        log.counts[SHORT_FLIGHTS] += 1
    begin(e, p, grid, log, STICK if after.mode == STUCK else TOUCH, after)
    return after, OK, False


@jit
def advance_held(e, p, grid, state, end, log, samples, c):
    """Skip a stick: return the state at its slip, or the held state at the end if that comes first."""
    frame = frame_at(e, p, state.home, state.housing)
    in_contact = is_in_contact(e, p, state)
    stiffness, _damping = coefficients(e, p, state.home, in_contact)
    pull = frame.load - stiffness * state.y
    wait, direction = slip_wait(e, p, frame.sigma, pull, phase_at(grid, state))
    at, slips = end, False
    if wait < NEVER:
        slip = advance_time(grid, state, wait)
        slips = is_before(slip, end)
        if slips:
            at = slip
    for n in range(1, c.size):
        c[n] = 0.0
    c[0] = state.y
    first, waited = log.counts[SAMPLES], steps_until(grid, state, at)
    record(samples, log.counts, p, grid, state, c, 0.0, waited, 1)
    span = waited * grid.dt
    housing = moved(p, state.housing, span, 0.0, 0.0)
    keep_still_housing(log, samples, first, p, grid, state, housing)
    extend_piece(log.pieces, span, state.y, 0.0)
    if in_contact:
        log.pieces.contact[ELAPSED] += span
    home, y = state.home, state.y
    if not slips:
        since = state.rest_start
        return State(at.period, at.step, at.theta, home, y, 0.0, STUCK, since, housing), False
    _value, rate, _scale = net_force(e, p, home, y, phase_at(grid, at), state.housing)
    by_jerk = rate * direction > 0.0
    mode = LEAVES_BY_JERK if by_jerk else LEAVES_BY_SNAP
    if direction < 0.0:
        mode = DOWN_BY_JERK if by_jerk else DOWN_BY_SNAP
    if jumps_at_slip(e, p):
        mode = LEAVES_BY_ACCELERATION if direction > 0.0 else DOWN_BY_ACCELERATION
    after = State(at.period, at.step, at.theta, home, y, 0.0, mode, 0.0, housing)
    after = with_housing(e, p, grid, after, housing)
    begin(e, p, grid, log, SLIP, after)
    return after, True


@jit
def advance_resting(e, p, grid, state, end, log, samples):
    """Skip a rest on a rigid support, as `advance_rest`, and log its pieces; return (state, whether released)."""
    first = log.counts[SAMPLES]
    after = advance_rest(e, p, grid, state, end, log, samples)
    keep_still_housing(log, samples, first, p, grid, state, after.housing)
    extend_piece(log.pieces, steps_until(grid, state, after) * grid.dt, 0.0, 0.0)
    if after.mode == REST:
        return after, False
    after = with_housing(e, p, grid, after, after.housing)
    begin(e, p, grid, log, RELEASE, after)
    return after, True
