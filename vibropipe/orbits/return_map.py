"""The return map over m forcing periods: its value by marching, its derivative by flows and saltations."""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.grid import Instant
from vibropipe.march.log import GRAZINGS, IMPACTS, RESTS, TAILS
from vibropipe.march.loop import OK, march
from vibropipe.march.state import FLIGHT, REST, State, restitution_of
from vibropipe.physics.contact import frame_at, support_position, to_displacement, to_velocity
from vibropipe.physics.flow import free_flow
from vibropipe.physics.load import force_times, forcing_period
from vibropipe.physics.saltation import product, saltation_matrix
from vibropipe.words.status import Status

LOG_FULL = int(Status.LOG_FULL)


@jit_inline
def clear_log(log) -> None:
    """Empty a log; the counts of work go on."""
    log.counts[IMPACTS] = 0
    log.counts[RESTS] = 0
    log.counts[GRAZINGS] = 0
    log.counts[TAILS] = 0


@jit
def at_period_zero(state):
    """The same state with its time shifted to the first forcing period."""
    return State(
        0,
        state.step,
        state.theta,
        state.home,
        state.y,
        state.w,
        state.mode,
        state.rest_start - state.period,
    )


@jit_inline
def march_periods(e, p, grid, state, m, log, c, max_events):
    """(state, status) after m forcing periods; status LOG_FULL when the log had no room for all contacts.

    The march goes on with an emptied log, so counts and list are then those of the last part only; max_events
    are those of all parts.
    """
    overflow = False
    until = state.period + m
    # Not a plain 0: numba would compile a march of its own for it.
    end = Instant(until, until - until, 0.0)
    while True:
        state, status = march(e, p, grid, state, end, log, None, c, max_events)
        if status != LOG_FULL:
            break
        overflow = True
        max_events -= log.counts[IMPACTS] + log.counts[RESTS] + log.counts[GRAZINGS]
        clear_log(log)
    return state, LOG_FULL if overflow and status == OK else status


@jit
def state_xv(p, state):
    """(x, v) of a state."""
    return to_displacement(p, state.home, state.y), to_velocity(state.home, state.w)


@jit
def gap_difference(e, p, after, before):
    """(dy, dw) between two states in the frame of `before`, exact near its support."""
    if after.home == before.home:
        return after.y - before.y, after.w - before.w
    frame = frame_at(e, p, before.home)
    x, v = state_xv(p, after)
    # y = sigma (x - x_ref) and load = -sigma x_ref.
    return (frame.sigma * x + frame.load) - before.y, frame.sigma * v - before.w


@jit
def flow_jacobian(e, p, t):
    """Derivative of the flow between impacts over a time t."""
    if e.damping is None:
        return math.cos(t), math.sin(t), -math.sin(t), math.cos(t)
    return free_flow(p.h, t)


@jit_inline
def return_map_jacobian(e, p, log, start, end, m):
    """Derivative (j11, j12, j21, j22) of the return map over m periods along a marched orbit.

    The product of free flows and saltation matrices over the logged impacts; zero after a rest, which
    forgets where the mass came from.
    """
    if log.counts[RESTS] > 0 or log.counts[TAILS] > 0 or start.mode == REST or end.mode == REST:
        return 0.0, 0.0, 0.0, 0.0
    period = forcing_period(p)
    j11, j12, j21, j22 = 1.0, 0.0, 0.0, 1.0
    position = 0.0
    for i in range(min(log.counts[IMPACTS], log.position.size)):
        e11, e12, e21, e22 = flow_jacobian(e, p, (log.position[i] - position) * period)
        j11, j12, j21, j22 = product(e11, e12, e21, e22, j11, j12, j21, j22)
        x = support_position(p, log.support[i])
        before = log.velocity[i]
        force = -x
        if e.forcing is not None:
            force = force_times(p, 1.0, log.position[i]) - x
        restitution = restitution_of(e, p, log.support[i])
        drag = 0.0
        if e.damping is not None:
            drag = p.h * before
        s11, s12, s21, s22 = saltation_matrix(
            restitution, before, force - drag, force + restitution * drag
        )
        j11, j12, j21, j22 = product(s11, s12, s21, s22, j11, j12, j21, j22)
        position = log.position[i]
    e11, e12, e21, e22 = flow_jacobian(e, p, (m - position) * period)
    return product(e11, e12, e21, e22, j11, j12, j21, j22)


@jit
def floquet_multipliers(j11, j12, j21, j22):
    """Floquet multipliers: eigenvalues of the derivative, the larger modulus first, as complex numbers."""
    half = 0.5 * (j11 + j22)
    determinant = j11 * j22 - j12 * j21
    # (j11 - j22)^2/4 + j12 j21 keeps what half^2 - determinant cancels.
    square = 0.25 * (j11 - j22) * (j11 - j22) + j12 * j21
    if square < 0.0:
        root = math.sqrt(-square)
        return complex(half, root), complex(half, -root)
    large = half + math.copysign(math.sqrt(square), half)
    small = determinant / large if large != 0.0 else 0.0
    if abs(small) > abs(large):
        # Both are none but for rounding, as where R = 0, and so is the determinant.
        small = math.copysign(large, small)
    return complex(large, 0.0), complex(small, 0.0)


@jit
def newton_step(e, p, state, after, j11, j12, j21, j22):
    """The next guess for a fixed point of the return map, and whether it lies between the supports."""
    if j11 == 0.0 and j12 == 0.0 and j21 == 0.0 and j22 == 0.0:
        return at_period_zero(after), True
    dy, dw = gap_difference(e, p, after, state)
    a11, a22 = 1.0 - j11, 1.0 - j22
    determinant = a11 * a22 - j12 * j21
    if determinant == 0.0:
        return state, False
    y = state.y + (a22 * dy + j12 * dw) / determinant
    w = state.w + (j21 * dy + a11 * dw) / determinant
    frame = frame_at(e, p, state.home)
    if not (y > frame.near and y < frame.far and abs(w) < math.inf):
        return state, False
    return State(0, 0, 0.0, state.home, y, w, FLIGHT, 0.0), True
