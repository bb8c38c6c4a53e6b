"""The return map over m forcing periods: its value by marching, its Jacobian from flow and saltation matrices."""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.grid import Instant
from vibropipe.march.log import GRAZINGS, IMPACTS, RESTS, TAILS, clear_log
from vibropipe.march.loop import OK, march
from vibropipe.march.piece_state import initial_piece_state, piece_state
from vibropipe.march.state import FLIGHT, REST, STUCK, State, restitution_of
from vibropipe.orbits.housing import momentum_difference, shifted
from vibropipe.orbits.housing_jacobian import (
    eigenvalues_of_three,
    has_coupling,
    jacobian_with_housing,
    solve_with_coupling,
)
from vibropipe.orbits.pieces import jacobian_of_pieces
from vibropipe.physics.contact import frame_at, support_position, to_displacement, to_velocity
from vibropipe.physics.flow import free_flow
from vibropipe.physics.load import force_times, forcing_period
from vibropipe.physics.saltation import product, saltation_matrix
from vibropipe.physics.stiffness import is_soft
from vibropipe.words.status import Status

LOG_FULL = int(Status.LOG_FULL)


@jit
def at_period_zero(state):
    """Return the state with its time shifted to the first forcing period."""
    return State(
        0,
        state.step,
        state.theta,
        state.home,
        state.y,
        state.w,
        state.mode,
        state.rest_start - state.period,
        state.housing,
    )


@jit_inline
def march_periods(e, p, grid, state, m, log, c, max_events):
    """March over m forcing periods, emptying the log whenever it is full.

    e, p, grid, state, log, c : as for `march`
    m : number of forcing periods
    max_events : largest number of events, counted over all fillings of the log

    Returns the state after m periods, and a `Status`; LOG_FULL if the log was emptied, so that it holds only the last
    contacts.
    """
    overflow = False
    until = state.period + m
    # `until - until` instead of 0: numba compiles another copy of the march for a literal.
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
    """Return (x, x') of a state, in the fixed frame."""
    return to_displacement(p, state.home, state.y), to_velocity(state.home, state.w)


@jit
def gap_difference(e, p, after, before):
    """Return the difference (dy, dw) of two states in the frame of `before`, without cancellation near its support."""
    if after.home == before.home:
        return after.y - before.y, after.w - before.w
    frame = frame_at(e, p, before.home)
    x, v = state_xv(p, after)
    # y = sigma (x - x_ref) and load = -sigma x_ref.
    return (frame.sigma * x + frame.load) - before.y, frame.sigma * v - before.w


@jit
def momentum_change(e, p, after, before) -> float:
    """Return the difference of the momenta of two states in the frame of `before`; 0 without a housing."""
    return momentum_difference(frame_at(e, p, before.home), after.housing, before.housing)


@jit
def flow_jacobian(e, p, t):
    """Return the Jacobian (e11, e12, e21, e22) of the flow between impacts over the time t (in tau)."""
    if e.damping is None:
        return math.cos(t), math.sin(t), -math.sin(t), math.cos(t)
    return free_flow(p.h, t)


@jit_inline
def return_map_jacobian(e, p, log, start, end, m):
    """Compute the Jacobian of the return map over m periods along a marched orbit.

    It is the product of the flow matrices of the flights and the saltation matrices of the logged impacts [1]_, [2]_.
    After a rest it is zero: the motion no longer depends on the start.

    log : contacts from `start` to `end`; positions in forcing periods after `start`
    start, end : states before and after the m periods

    Returns the derivative (j11, j12, j21, j22) of (x, x') at `end` by (x, x') at `start`.

    .. [1] P. C. Müller, Calculation of Lyapunov exponents for dynamic systems with discontinuities, Chaos, Solitons
       & Fractals 5 (1995) 1671.
    .. [2] R. I. Leine, H. Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, Springer 2004.
    """
    if log.pieces is not None:
        if log.pieces.housing is not None:
            return jacobian_with_housing(e, p, log.pieces)
        return jacobian_of_pieces(e, p, log.pieces)
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
            force = force_times(p, 1.0, log.position[i], e.second_harmonic) - x
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
def multipliers_of(derivative, coupling):
    """Return the three Floquet multipliers of a derivative with its coupling, the larger modulus first.

    Without a coupling the third is 0.
    """
    if has_coupling(coupling):
        return eigenvalues_of_three(derivative, coupling)
    j11, j12, j21, j22 = derivative
    first, second = floquet_multipliers(j11, j12, j21, j22)
    return first, second, complex(0.0, 0.0)


@jit
def floquet_multipliers(j11, j12, j21, j22):
    """Return the Floquet multipliers, the eigenvalues of the Jacobian of the return map.

    Returns the one of larger modulus first.
    """
    half_trace = 0.5 * (j11 + j22)
    determinant = j11 * j22 - j12 * j21
    # (j11 - j22)^2/4 + j12 j21 equals half_trace^2 - determinant but cancels less.
    discriminant = 0.25 * (j11 - j22) * (j11 - j22) + j12 * j21
    if discriminant < 0.0:
        root = math.sqrt(-discriminant)
        return complex(half_trace, root), complex(half_trace, -root)
    large = half_trace + math.copysign(math.sqrt(discriminant), half_trace)
    small = determinant / large if large != 0.0 else 0.0
    if abs(small) > abs(large):
        # Both eigenvalues and the determinant are rounding only, for example with R = 0.
        small = math.copysign(large, small)
    return complex(large, 0.0), complex(small, 0.0)


@jit_inline
def newton_step(pieces, e, p, grid, state, after, derivative, coupling):
    """Compute the next iterate of Newton's method for a fixed point of the return map.

    pieces : PieceLog or None, `log.pieces`
    state, after : the current iterate and its image
    derivative : Jacobian (j11, j12, j21, j22) of the return map; if it is zero the image is the next iterate
    coupling : the rest of it, where a housing may slide

    Returns the next iterate, the current one if there is none, and whether the iterate exists and lies between the
    supports.
    """
    j11, j12, j21, j22 = derivative
    is_zero = j11 == 0.0 and j12 == 0.0 and j21 == 0.0 and j22 == 0.0
    if is_zero and not has_coupling(coupling):
        return at_period_zero(after), True
    dy, dw = gap_difference(e, p, after, state)
    if pieces is not None and e.housing is not None:
        dp = momentum_change(e, p, after, state)
        dy, dw, dp, determinant = solve_with_coupling(derivative, coupling, dy, dw, dp)
        if determinant == 0.0:
            return state, False
        return iterate_of_pieces(e, p, grid, state, after, state.y + dy, state.w + dw, dp)
    a11, a22 = 1.0 - j11, 1.0 - j22
    determinant = a11 * a22 - j12 * j21
    if determinant == 0.0:
        return state, False
    y = state.y + (a22 * dy + j12 * dw) / determinant
    w = state.w + (j21 * dy + a11 * dw) / determinant
    if pieces is not None:
        return iterate_of_pieces(e, p, grid, state, after, y, w, 0.0)
    frame = frame_at(e, p, state.home)
    if not (y > frame.near and y < frame.far and abs(w) < math.inf):
        return state, False
    return State(0, 0, 0.0, state.home, y, w, FLIGHT, 0.0, state.housing), True


@jit
def iterate_of_pieces(e, p, grid, state, after, y, w, dp):
    """Return what `newton_step` does for an iterate (y, w) that soft supports may hold beyond them, or friction still.

    A state that is held, and is so again after the orbit, stays without velocity: only its displacement is sought.
    dp : change of the momentum of both bodies.
    """
    if not (abs(y) < math.inf and abs(w) < math.inf):
        return state, False
    if state.mode == STUCK and after.mode == STUCK:
        w = 0.0
    frame, at = frame_at(e, p, state.home), Instant(0, 0, 0.0)
    x, v = to_displacement(p, state.home, y), to_velocity(state.home, w)
    housing = shifted(p, frame, state.housing, after.housing, v, dp)
    if y > frame.near and y < frame.far:
        return piece_state(e, p, grid, at, state.home, y, w, housing), True
    beyond = 1 if x >= support_position(p, 1) else 2
    return initial_piece_state(e, p, grid, at, x, v, housing), is_soft(e, p, beyond)
