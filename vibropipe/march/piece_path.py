"""Steps along a linear piece by its one-step map, each certified to hold no event from its two ends.

A piece keeps its stiffness and damping wherever it begins, so the polynomials of unit motions on it (`Flow`) are made
once for an exciter. Over a step the motion lies within a margin of the cubic through both ends: bounds of its Bezier
points bound the gap, the velocity, the force of a support and the forces on a housing. Steps begin where the piece
begins, off the grid: none is divided to meet it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.fast_path import CURVATURE_MARGIN, SLOPE_MARGIN
from vibropipe.march.grid import Instant, steps_until
from vibropipe.march.log import COMPUTED, SAMPLES, STEPS, record
from vibropipe.march.piece_events import (
    ANY,
    MAY_FAR,
    MAY_MOVE,
    MAY_NEAR,
    MAY_PULL,
    MAY_TURN,
    follow_contact,
)
from vibropipe.march.piece_housing import keep_housing, largest_housing_speed, slip_offset
from vibropipe.march.piece_log import DEPTH, ELAPSED, FORCE, FORMS, extend_piece
from vibropipe.march.piece_state import is_unloaded
from vibropipe.march.state import FLIGHT, UNLOADED, State
from vibropipe.physics.contact import to_velocity
from vibropipe.physics.flow import combine, exact_map, exact_map_of_second
from vibropipe.physics.housing import STANDS, momentum_rate, momentum_share, moved
from vibropipe.physics.load import COLUMNS, COLUMNS_OF_SECOND, Force, double_angle, unit_load
from vibropipe.physics.stiffness import damping_of, piece_taylor, stiffness_of

# Rows of the numbers of a flow, after those of its basis, and their places: what it was made for, the one-step map,
# those of the second harmonic, the turn of the force, and the margin.
MAP, SECOND_MAP = COLUMNS + COLUMNS_OF_SECOND, COLUMNS + COLUMNS_OF_SECOND + 1
KEYS, MAP_SIZE = 4, 10
MARGIN_Y, MARGIN_W = KEYS + MAP_SIZE, KEYS + MAP_SIZE + 1
MARGIN_FORCE, MARGIN_SECOND, TURN_SINE, TURN_COSINE = 4, 5, 6, 7
# Steps after which the force is computed anew, and share of one that is left to the last step before the end.
MOST_STEPS, LAST_SHARE = 64, 1e-9


class Points(NamedTuple):
    """Bezier points of the cubic through both ends of a step, and how far the motion may be from it."""

    first: float
    second: float
    third: float
    last: float
    margin: float


@jit
def margin_of(column) -> float:
    """Return a bound of the distance of a polynomial on [0, 1] from the cubic through its ends: a 384th of y''''."""
    bound = 0.0
    for n in range(4, column.size):
        bound += n * (n - 1) * (n - 2) * (n - 3) * abs(column[n])
    return bound * (1.01 / 384.0)


@jit
def fill_flow(flow, p, stiffness, damping, dt, second) -> None:
    """Fill a flow, (ROWS, DEGREE + 1): a basis of `flow.fill_basis` for a piece, its one-step map and its margin."""
    for column in range(COLUMNS if second is None else MAP):
        load, force = unit_load(column)
        y, w = (1.0 if column == 0 else 0.0), (1.0 if column == 1 else 0.0)
        piece_taylor(flow[column], y, w, force, load, stiffness, damping, p.nu, dt, second)
    key, more = flow[MAP], flow[SECOND_MAP]
    key[0], key[1], key[2], key[3] = stiffness, damping, p.nu, dt
    key[4], key[5], key[6], key[7], key[8], key[9], key[10], key[11], key[12], key[13] = exact_map(
        flow, dt
    )
    key[MARGIN_Y], key[MARGIN_W] = margin_of(flow[0]), margin_of(flow[1])
    more[MARGIN_FORCE], more[MARGIN_SECOND] = margin_of(flow[3]) + margin_of(flow[4]), 0.0
    if second is not None:
        more[0], more[1], more[2], more[3] = exact_map_of_second(flow, dt)
        more[MARGIN_SECOND] = margin_of(flow[COLUMNS]) + margin_of(flow[COLUMNS + 1])
    more[TURN_SINE], more[TURN_COSINE] = math.sin(p.nu * dt), math.cos(p.nu * dt)


@jit_inline
def flow_index(home, piece):
    """Return the place of the flow of a piece in `PieceLog.flows`."""
    form = home if piece.in_contact else 0
    return form + FORMS // 2 if piece.factor > 1.0 else form


@jit_inline
def ensure_flow(flow, p, piece, dt, second) -> None:
    """Fill the flow of a piece with steps of dt where that was not done."""
    key = flow[MAP]
    is_there = key[0] == piece.stiffness and key[1] == piece.damping
    if not (is_there and key[2] == p.nu and key[3] == dt):
        fill_flow(flow, p, piece.stiffness, piece.damping, dt, second)


@jit_inline
def keeps_off(points, out, near, departs) -> bool:
    """Return whether out y stays above `near`; departs : whether it leaves near = 0 with a velocity at the start."""
    a, b, c, d = out * points.first, out * points.second, out * points.third, out * points.last
    margin = points.margin
    if departs:
        return 3.0 * b > 16.0 * margin and b > 0.0 and c > 0.0 and d > 0.0
    return min(min(a, b), min(c, d)) - margin > near


@jit_inline
def keeps_direction(points, direction) -> bool:
    """Return whether the velocity keeps a sign."""
    a, b = direction * (points.second - points.first), direction * (points.third - points.second)
    c = direction * (points.last - points.third)
    return 3.0 * min(min(a, b), c) > SLOPE_MARGIN * points.margin


@jit_inline
def keeps_pull(points, stiffness, damping, sign) -> bool:
    """Return whether stiffness y + damping y', of a step of length 1, keeps a sign."""
    a, b = 3.0 * (points.second - points.first), 3.0 * (points.third - points.second)
    c = 3.0 * (points.last - points.third)
    first = stiffness * points.first + damping * a
    second = stiffness * points.second + damping * (a + 2.0 * b) / 3.0
    third = stiffness * points.third + damping * (2.0 * b + c) / 3.0
    last = stiffness * points.last + damping * c
    least = min(min(sign * first, sign * second), min(sign * third, sign * last))
    return least > (stiffness + SLOPE_MARGIN * damping) * points.margin


@jit_inline
def keeps_housing(housing, p, sigma, points, elapsed, dt) -> bool:
    """Return whether a housing neither slips nor stops in a step that begins `elapsed` after its state."""
    if housing is None:
        return True
    a, b = 3.0 * (points.second - points.first), 3.0 * (points.third - points.second)
    c = 3.0 * (points.last - points.third)
    if housing.way == STANDS:
        square, offset = dt * dt, CURVATURE_MARGIN * points.margin
        low, high = 2.0 * sigma * (b - a), 2.0 * sigma * (c - b)
        return p.mass_ratio == 0.0 or (
            slip_offset(p, True) * square + min(low, high) > offset
            and slip_offset(p, False) * square - max(low, high) > offset
        )
    way, share = float(housing.way), momentum_share(p)
    rate = momentum_rate(p, housing.way)
    start, share_of_w = housing.momentum + rate * elapsed, share * sigma / dt
    least = min(
        way * (start - share_of_w * a),
        min(
            way * (start + 0.5 * rate * dt - share_of_w * b),
            way * (start + rate * dt - share_of_w * c),
        ),
    )
    return least > SLOPE_MARGIN * points.margin * share / dt


@jit_inline
def speed_peaks(housing, p, sigma, acceleration, last) -> bool:
    """Return whether the speed of a housing is largest inside a step, by the accelerations of y at its ends."""
    if housing is None:
        return False
    if housing.way == STANDS:
        return False
    way, share = float(housing.way), momentum_share(p) * sigma
    rate = momentum_rate(p, housing.way)
    return way * (rate - share * acceleration) > 0.0 and way * (rate - share * last) < 0.0


@jit_inline
def speed_at(housing, p, v, elapsed) -> float:
    """Return the speed of a housing some time after its state, at the velocity v of x; 0 without one."""
    if housing is None:
        return 0.0
    if housing.way == STANDS:
        return 0.0
    momentum = housing.momentum + momentum_rate(p, housing.way) * elapsed
    return housing.way * (momentum - momentum_share(p) * v)


@jit_inline
def instant_after(grid, at, steps, share):
    """Return the `Instant` whole steps and a share of a step after an `Instant` or a state."""
    theta = at.theta + share
    whole = math.floor(theta)
    step = at.step + steps + int(whole)
    return Instant(at.period + step // grid.steps, step % grid.steps, theta - whole)


@jit_inline
def coast(e, p, grid, frame, piece, flow, parts, state, end, force, log, samples, c):
    """Take steps along a piece until an event may happen in the next one, or the end of the march does.

    force : `Force` at the state, with the factor of the piece; parts : of a step of the grid, which a step here is.
    Returns (state, force, what may happen in the next step, MAY_NEAR to MAY_MOVE, steps taken).
    """
    home, sigma, second = state.home, frame.sigma, e.second_harmonic
    key, more = flow[MAP], flow[SECOND_MAP]
    dt, stiffness, damping, load = key[3], piece.stiffness, piece.damping, piece.load
    a11, a12, b1, p1, p2 = key[4], key[5], key[6], key[7], key[8]
    a21, a22, b2, q1, q2 = key[9], key[10], key[11], key[12], key[13]
    turn_sine, turn_cosine = more[TURN_SINE], more[TURN_COSINE]
    double_sine, double_cosine = double_angle(turn_sine, turn_cosine)
    fixed = piece.factor * (more[MARGIN_FORCE] * abs(p.f) + more[MARGIN_SECOND] * abs(p.f2))
    level, third = load / stiffness, dt / 3.0
    is_beyond = piece.in_contact or piece.lets_go
    near, far, out = -math.inf, math.inf, 1.0
    if is_beyond:
        # The force of a support that only pushes ends before its contact does.
        near, out = -math.inf if piece.in_contact and piece.lets_go else 0.0, -1.0
    else:
        if frame.to_near:
            near = frame.near
        if frame.to_far:
            far = frame.far
    departs = piece.gap_power == 1 and near == 0.0
    has_friction = e.friction is not None and p.friction > 0.0
    k, h, contact = stiffness_of(p, home), damping_of(p, home), log.pieces.contact
    pull_sign = -1.0 if piece.in_contact else 1.0
    first = log.counts[SAMPLES]
    left = steps_until(grid, state, end) * parts - LAST_SHARE
    y, w, n, may = state.y, state.w, 0, ANY
    s, cc, s2, c2 = force.sine, force.cosine, force.sine_2, force.cosine_2
    acceleration = load + (s + s2) - damping * w - stiffness * y
    speed = speed_at(state.housing, p, sigma * w, 0.0)
    while n < MOST_STEPS and n + 1.0 <= left:
        y1 = a11 * y + (a12 * w + (b1 * load + (p1 * s + p2 * cc)))
        w1 = a21 * y + (a22 * w + (b2 * load + (q1 * s + q2 * cc)))
        if second is not None:
            y1 += more[0] * s2 + more[1] * c2
            w1 += more[2] * s2 + more[3] * c2
        margin = fixed + key[MARGIN_Y] * abs(y - level) + key[MARGIN_W] * abs(w)
        points = Points(y, y + third * w, y1 - third * w1, y1, margin)
        elapsed, may = n * dt, 0
        if not keeps_off(points, out, near, departs):
            may |= MAY_NEAR
        if not keeps_off(points, -1.0, -far, False):
            may |= MAY_FAR
        if has_friction and not keeps_direction(points, piece.direction):
            may |= MAY_TURN
        if e.no_pull is not None and piece.lets_go and not keeps_pull(points, k, h / dt, pull_sign):
            may |= MAY_PULL
        if not keeps_housing(state.housing, p, sigma, points, elapsed, dt):
            may |= MAY_MOVE
        if may != 0:
            break
        may = ANY
        next_s, next_c = s * turn_cosine + cc * turn_sine, cc * turn_cosine - s * turn_sine
        next_s2, next_c2 = 0.0, 0.0
        if second is not None:
            next_s2 = s2 * double_cosine + c2 * double_sine
            next_c2 = c2 * double_cosine - s2 * double_sine
        last = load + (next_s + next_s2) - damping * w1 - stiffness * y1
        peaks = speed_peaks(state.housing, p, sigma, acceleration, last)
        if piece.in_contact:
            peaks |= (w < 0.0 and w1 > 0.0) or (
                k * w + h * acceleration < 0.0 and k * w1 + h * last > 0.0
            )
        if samples is not None or peaks:
            combine(e, flow, c, y, w, load, Force(s, cc, s2, c2))
        if piece.in_contact:
            if peaks:
                follow_contact(p, home, contact, c, 1.0, dt, log.pieces.work)
            else:
                contact[FORCE] = max(contact[FORCE], -(k * y1 + h * w1))
                contact[DEPTH] = max(contact[DEPTH], -y1)
                contact[ELAPSED] += dt
        if peaks:
            then = moved(p, state.housing, elapsed, 0.0, 0.0)
            within = largest_housing_speed(log.pieces.housing, p, sigma, then, c, dt, 1.0)
            speed = max(speed, within)
        speed = max(speed, speed_at(state.housing, p, sigma * w1, elapsed + dt))
        record(samples, log.counts, p, grid, state, c, n / parts, (n + 1) / parts, parts)
        y, w, s, cc, s2, c2, acceleration = y1, w1, next_s, next_c, next_s2, next_c2, last
        departs = False
        n += 1
    if n == 0:
        return state, force, may, n
    steps = n // parts
    at = instant_after(grid, state, steps, (n - steps * parts) / parts)
    housing = moved(p, state.housing, n * dt, sigma * (y - state.y), to_velocity(home, w))
    keep_housing(log, samples, first, p, grid, state, housing, speed)
    extend_piece(log.pieces, n * dt, y, w)
    log.counts[STEPS] += n
    log.counts[COMPUTED] += n
    mode = UNLOADED if is_unloaded(e, state) else FLIGHT
    after = State(at.period, at.step, at.theta, home, y, w, mode, 0.0, housing)
    return after, Force(s, cc, s2, c2), may, n
