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
    Piece,
    follow_contact,
    slides,
)
from vibropipe.march.piece_housing import keep_housing, largest_housing_speed, slip_offset
from vibropipe.march.piece_log import DEPTH, ELAPSED, FORCE, FORMS, extend_piece
from vibropipe.march.piece_state import is_unloaded
from vibropipe.march.state import FLIGHT, UNLOADED, State
from vibropipe.physics.contact import Frame, to_velocity
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
    step, (p1, p2, q1, q2) = exact_map(flow, dt)
    key[4], key[5], key[6], key[7], key[8] = step.a11, step.a12, step.b1, p1, p2
    key[9], key[10], key[11], key[12], key[13] = step.a21, step.a22, step.b2, q1, q2
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


class Track(NamedTuple):
    """A piece that is followed in steps of dt, `parts` of which make a step of the grid, in its frame."""

    frame: Frame
    piece: Piece
    parts: float
    dt: float


@jit_inline
def bounds_of(frame, piece):
    """Return the displacements between which no support is met, and the sign of y out of the near one."""
    if piece.in_contact or piece.lets_go:
        # The force of a support that only pushes ends before its contact does.
        return -math.inf if piece.in_contact and piece.lets_go else 0.0, math.inf, -1.0
    return frame.near if frame.to_near else -math.inf, frame.far if frame.to_far else math.inf, 1.0


@jit_inline
def may_happen(e, p, state, track, bounds, points, elapsed, departs):
    """Return what may happen in a step with `Points`, as a sum of MAY_NEAR to MAY_MOVE; elapsed : tau since `state`."""
    (near, far, out), (frame, piece, _parts, dt), may = bounds, track, 0
    if not keeps_off(points, out, near, departs):
        may |= MAY_NEAR
    if not keeps_off(points, -1.0, -far, False):
        may |= MAY_FAR
    if slides(e, p) and not keeps_direction(points, piece.direction):
        may |= MAY_TURN
    if e.no_pull is not None and piece.lets_go:
        k, h = stiffness_of(p, state.home), damping_of(p, state.home)
        if not keeps_pull(points, k, h / dt, -1.0 if piece.in_contact else 1.0):
            may |= MAY_PULL
    if not keeps_housing(state.housing, p, frame.sigma, points, elapsed, dt):
        may |= MAY_MOVE
    return may


@jit_inline
def turned_force(second, force, turn, double):
    """Return the `Force` a step later; turn, double : sine and cosine of what it turns by, and of twice that."""
    (sine, cosine), (sine_2, cosine_2) = turn, double
    after_s = force.sine * cosine + force.cosine * sine
    after_c = force.cosine * cosine - force.sine * sine
    if second is None:
        return Force(after_s, after_c, 0.0, 0.0)
    after_s2 = force.sine_2 * cosine_2 + force.cosine_2 * sine_2
    after_c2 = force.cosine_2 * cosine_2 - force.sine_2 * sine_2
    return Force(after_s, after_c, after_s2, after_c2)


@jit_inline
def contact_peaks(k, h, w, acceleration, w1, last) -> bool:
    """Return whether the depth or the force of a contact is largest inside a step, by w and y'' at its ends."""
    falls = k * w + h * acceleration < 0.0 and k * w1 + h * last > 0.0
    return (w < 0.0 and w1 > 0.0) or falls


@jit_inline
def note_contact(contact, force, depth, dt) -> None:
    """Add a step with monotonic force and depth to the record of a contact; force, depth : at its end."""
    contact[FORCE] = max(contact[FORCE], force)
    contact[DEPTH] = max(contact[DEPTH], depth)
    contact[ELAPSED] += dt


@jit_inline
def coast(e, p, grid, track, state, end, force, log, samples, c):
    """Take steps along a piece until an event may happen in the next one, or the end of the march does.

    force : `Force` at the state, with the factor of the piece.
    Returns (state, force, what may happen in the next step, MAY_NEAR to MAY_MOVE, steps taken).
    """
    frame, piece, parts, _dt = track
    home, sigma, second = state.home, frame.sigma, e.second_harmonic
    flow = log.pieces.flows[flow_index(home, piece)]
    key, more = flow[MAP], flow[SECOND_MAP]
    dt, stiffness, damping, load = key[3], piece.stiffness, piece.damping, piece.load
    a11, a12, b1, p1, p2 = key[4], key[5], key[6], key[7], key[8]
    a21, a22, b2, q1, q2 = key[9], key[10], key[11], key[12], key[13]
    turn = more[TURN_SINE], more[TURN_COSINE]
    double = double_angle(turn[0], turn[1])
    fixed = piece.factor * (more[MARGIN_FORCE] * abs(p.f) + more[MARGIN_SECOND] * abs(p.f2))
    level, third = load / stiffness, dt / 3.0
    bounds = bounds_of(frame, piece)
    departs = piece.gap_power == 1 and bounds[0] == 0.0
    k, h, contact = stiffness_of(p, home), damping_of(p, home), log.pieces.contact
    first = log.counts[SAMPLES]
    left = steps_until(grid, state, end) * parts - LAST_SHARE
    y, w, n, may = state.y, state.w, 0, ANY
    acceleration = load + (force.sine + force.sine_2) - damping * w - stiffness * y
    speed = speed_at(state.housing, p, sigma * w, 0.0)
    while n < MOST_STEPS and n + 1.0 <= left:
        y1 = a11 * y + (a12 * w + (b1 * load + (p1 * force.sine + p2 * force.cosine)))
        w1 = a21 * y + (a22 * w + (b2 * load + (q1 * force.sine + q2 * force.cosine)))
        if second is not None:
            y1 += more[0] * force.sine_2 + more[1] * force.cosine_2
            w1 += more[2] * force.sine_2 + more[3] * force.cosine_2
        margin = fixed + key[MARGIN_Y] * abs(y - level) + key[MARGIN_W] * abs(w)
        points = Points(y, y + third * w, y1 - third * w1, y1, margin)
        elapsed = n * dt
        may = may_happen(e, p, state, track, bounds, points, elapsed, departs)
        if may != 0:
            break
        may = ANY
        turned = turned_force(second, force, turn, double)
        last = load + (turned.sine + turned.sine_2) - damping * w1 - stiffness * y1
        peaks = speed_peaks(state.housing, p, sigma, acceleration, last)
        if piece.in_contact:
            peaks |= contact_peaks(k, h, w, acceleration, w1, last)
        if samples is not None or peaks:
            combine(e, flow, c, y, w, load, force)
        if piece.in_contact and peaks:
            follow_contact(p, home, contact, c, 1.0, dt, log.pieces.work)
        elif piece.in_contact:
            note_contact(contact, -(k * y1 + h * w1), -y1, dt)
        if peaks:
            then, motion = moved(p, state.housing, elapsed, 0.0, 0.0), log.pieces.housing
            speed = max(speed, largest_housing_speed(motion, p, sigma, then, c, dt, 1.0))
        speed = max(speed, speed_at(state.housing, p, sigma * w1, elapsed + dt))
        record(samples, log.counts, p, grid, state, c, n / parts, (n + 1) / parts, parts)
        y, w, force, acceleration, departs = y1, w1, turned, last, False
        n += 1
    if n == 0:
        return state, force, may, n
    steps = n // parts
    at = instant_after(grid, state, steps, (n - steps * parts) / parts)
    housing = moved(p, state.housing, n * dt, sigma * (y - state.y), to_velocity(home, w))
    keep_housing(log, samples, first, p, grid, state, housing, speed)
    extend_piece(log.pieces, n * dt, y, w)
    log.counts[STEPS], log.counts[COMPUTED] = log.counts[STEPS] + n, log.counts[COMPUTED] + n
    mode = UNLOADED if is_unloaded(e, state) else FLIGHT
    return State(at.period, at.step, at.theta, home, y, w, mode, 0.0, housing), force, may, n
