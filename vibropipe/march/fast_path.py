"""Whole steps in flight, and the regular impact: one in a step, certified to be so from the ends of the step.

All other steps are left to `march.flight`, which handles every case and takes three times as long. Here the one-step
map takes the step as if the support were absent. The impact adds to its end the response to an impulse, so the motion
after it needs no polynomial. Without forcing no phase ties the steps to a grid: the next step begins at the impact.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.contacts import support_at
from vibropipe.march.grid import Instant, force_at_step, stays_between, whole_step
from vibropipe.march.log import COMPUTED, POLYNOMIALS, STEPS, is_full, log_impact
from vibropipe.march.state import (
    FLIGHT,
    LEAVES_BY_VELOCITY,
    State,
    departure_mode,
    is_watched,
    restitution_of,
)
from vibropipe.physics.contact import Frame, frame_at, reset
from vibropipe.physics.flow import combine, motion_with_curvature
from vibropipe.physics.limits import MAX_TABLE
from vibropipe.physics.load import force_at, no_force

# Error bounds of the slope and of the curvature of the cubic Hermite interpolant of a step, as multiples of the error
# bound of its value.
SLOPE_MARGIN = 3.1
CURVATURE_MARGIN = 32.0
# Smallest slope at either end of a gap, as a share of its mean slope, for which the inverse function is close to a
# cubic.
MIN_SLOPE_RATIO = 0.2
# Iterations of Halley's method; two are usual.
MAX_REFINEMENTS = 4
# Last correction of a root, in steps: its cube, and its square times the change of the acceleration, are below
# rounding.
REFINEMENT_TOLERANCE = 1e-8
# Latest impact in a step, in steps: the motion after a later one is too short to be certified against rounding.
MAX_IMPACT_THETA = 0.999
# Smallest rise of a departure in a step, as a share of the distance from the frame's reference to the support struck:
# a smaller rise loses digits in the change of frames.
MIN_DEPARTURE_RATIO = 1.0 / 64.0


@jit_inline
def crosses_once(grid, y, w, load, first, last, slope0, slope1, distance) -> bool:
    """Return whether a gap has exactly one root over a whole step and stays below `distance` before it.

    It falls throughout, if its slope is negative: the slope lies within a margin of the hull of the slopes at the ends
    and the Bezier point between them. Or it is concave, if the cubic is so at both ends by more than a margin.

    y, w, load : start of the step; first, last : gap at both ends; slope0, slope1 : its derivatives by theta there.
    """
    margin = grid.margin0 + grid.margin1 * (abs(y - load) + abs(w))
    if not (first > 0.0 and last < 0.0):
        return False
    fall = last - first
    if max(max(slope0, slope1), 3.0 * fall - slope0 - slope1) < -SLOPE_MARGIN * margin:
        return True
    curvature0 = 6.0 * fall - 4.0 * slope0 - 2.0 * slope1
    curvature1 = 2.0 * slope0 + 4.0 * slope1 - 6.0 * fall
    return (
        max(curvature0, curvature1) < -CURVATURE_MARGIN * margin
        and first + max(slope0, 0.0) < distance
    )


class GapEnds(NamedTuple):
    """The gap offset + sign y at both ends of a step, as if the support were absent, and its slopes there by theta."""

    sign: float
    offset: float
    first: float
    last: float
    slope0: float
    slope1: float


@jit_inline
def refine_root(e, p, grid, c, load, ends):
    """Return (theta, slope by theta) of the one root of a gap; theta = 2 if it does not converge to rounding.

    Halley's method starts from the cubic through both ends of the inverse of the gap or, for a gap that rises first or
    turns at the end, from the parabola through both ends.
    load : of the frame; c : polynomial of the step; ends : GapEnds
    """
    sign, offset, first, last, slope0, slope1 = ends
    change = last - first
    if slope0 < MIN_SLOPE_RATIO * change and slope1 < MIN_SLOPE_RATIO * change:
        s = -first / change
        r = 1.0 - s
        inverse_slope0, inverse_slope1 = change / slope0, change / slope1
        theta = s * s * (1.0 + 2.0 * r) + s * r * (r * inverse_slope0 - s * inverse_slope1)
    else:
        curvature_term = 4.0 * (change - slope0) * first
        theta = 2.0 * first / (math.sqrt(max(slope0 * slope0 - curvature_term, 0.0)) - slope0)
    for _ in range(MAX_REFINEMENTS):
        value, slope, curvature = motion_with_curvature(c, theta)
        if e.forcing is None:
            # By eq. (5), which without forcing is cheaper than the polynomial.
            curvature = grid.dt * (grid.dt * (load - value))
            if e.damping is not None:
                curvature -= p.h * grid.dt * slope
        value, slope, curvature = offset + sign * value, sign * slope, sign * curvature
        # One division only: divisions dominate the time of an impact.
        inverse = 1.0 / slope
        newton = -value * inverse
        # Halley's step, expanded to third order.
        step = newton * (1.0 - 0.5 * newton * (curvature * inverse))
        theta += step
        if abs(step) <= REFINEMENT_TOLERANCE:
            return theta, slope + step * curvature
    return 2.0, 0.0


@jit_inline
def frame_to_near(e, p, home):
    """Return `frame_at`, mirrored about the equilibrium if support 1 alone is present, so that it is the near one."""
    frame = frame_at(e, p, home)
    if e.support_2 is None and home == 0:
        reach = e.support_1 is not None
        frame = Frame(home, -1.0, frame.load, -frame.far, frame.far, reach, False)
    return frame


@jit_inline
def frame_sign(e, home):
    """Return the factor of y that `frame_to_near` applies: -1 where it mirrors the frame, else 1."""
    return -1.0 if e.support_2 is None and home == 0 else 1.0


class Struck(NamedTuple):
    """What `step_through_impact` has done.

    is_certified : otherwise nothing is logged
    frame : of the support struck
    theta : 0 for a state at the end of the step; without forcing that of the impact, where the state is then
    y, w : the state
    """

    is_certified: bool
    frame: Frame
    theta: float
    y: float
    w: float


@jit_inline
def step_through_impact(e, p, grid, frame, period, at, motion, log, c):
    """Take a step with exactly one regular impact and log it.

    period, at : start of the step, `at` in steps of the period; motion : (y, w, y1, w1), at both ends, as if the
    support were absent; c : work array (DEGREE + 1,). Returns a `Struck`.
    """
    y, w, y1, w1 = motion
    at_near = w1 < 0.0
    if e.support_1 is None or e.support_2 is None:
        # In either frame the only support is the near one.
        struck = 1 if e.support_2 is None else 2
        if not (at_near and frame.to_near):
            return Struck(False, frame, 0.0, y, w)
        at_near = True
    else:
        struck = support_at(frame.home, at_near)
    if is_watched(struck, e.watched):
        return Struck(False, frame, 0.0, y, w)
    sign, offset = (1.0, -frame.near) if at_near else (-1.0, frame.far)
    first, last = offset + sign * y, offset + sign * y1
    slope0, slope1 = sign * w * grid.dt, sign * w1 * grid.dt
    distance = frame.far - frame.near
    if not crosses_once(grid, y, w, frame.load, first, last, slope0, slope1, distance):
        return Struck(False, frame, 0.0, y, w)
    force = no_force()
    if e.forcing is not None:
        force = force_at(p, frame.sigma, at / grid.steps, e.second_harmonic)
    combine(e, grid.basis, c, y, w, frame.load, force)
    ends = GapEnds(sign, offset, first, last, slope0, slope1)
    theta, slope = refine_root(e, p, grid, c, frame.load, ends)
    if not theta < MAX_IMPACT_THETA:
        return Struck(False, frame, 0.0, y, w)
    per_step = 1.0 / grid.dt
    approach = -slope * per_step
    speed = reset(restitution_of(e, p, struck), approach)
    turn = (at + theta) / grid.steps
    next_frame = frame_to_near(e, p, struck)
    mode, _wait = departure_mode(e, p, grid, struck, speed, turn)
    if mode != LEAVES_BY_VELOCITY:
        return Struck(False, frame, 0.0, y, w)
    if e.forcing is None:
        # The next step begins at the impact.
        y1, w1 = 0.0, speed
    else:
        remaining = 1.0 - theta
        rise, rise_slope, _curvature = motion_with_curvature(grid.basis[1], remaining)
        velocity_jump = speed + approach
        y1, w1 = last + velocity_jump * rise, sign * w1 + (velocity_jump * per_step) * rise_slope
        if not (
            speed * grid.dt > MIN_DEPARTURE_RATIO * abs(offset)
            and stays_between(grid, next_frame, 1, 0.0, speed, y1, w1, remaining)
        ):
            return Struck(False, frame, 0.0, y, w)
    outward = 1.0 if struck == 1 else -1.0
    impulse = -outward * (approach + speed)
    log_impact(log, period + turn, struck, outward * approach, impulse)
    return Struck(True, next_frame, theta if e.forcing is None else 0.0, y1, w1)


@jit
def may_coast(e, state) -> bool:
    """Return whether `coast` can start from a state.

    With forcing: in flight at the start of a step. Without: in flight, or leaving a support by velocity, at any time.
    """
    if e.forcing is None:
        return state.mode <= LEAVES_BY_VELOCITY
    return state.mode == FLIGHT and state.theta == 0.0


@jit
def steps_left(grid, at, end):
    """Return the number of whole steps from an `Instant` to the end."""
    return (end.period - at.period) * grid.steps + (end.step - at.step) - (at.theta > end.theta)


@jit_inline
def step_forcing(e, grid, frame, step):
    """Return the contributions of constant load and force to y and w over a step of the one-step map."""
    forcing_y, forcing_w = grid.b1 * frame.load, grid.b2 * frame.load
    if e.forcing is not None:
        force_y, force_w = force_at_step(grid, step)
        forcing_y += frame.sigma * force_y
        forcing_w += frame.sigma * force_w
    return forcing_y, forcing_w


@jit_inline
def two_steps(e, grid, frame, step, y, w, forcing):
    """Return (y, w) after two whole steps; forcing : result of `step_forcing` of the first."""
    a11, a12, a21, a22 = grid.a11, grid.a12, grid.a21, grid.a22
    double_11, double_12 = a11 * a11 + a12 * a21, a11 * a12 + a12 * a22
    double_21, double_22 = a21 * a11 + a22 * a21, a21 * a12 + a22 * a22
    next_y, next_w = step_forcing(e, grid, frame, step + 1 if step + 1 < grid.steps else 0)
    forcing_y, forcing_w = whole_step(a11, a12, a21, a22, forcing[0], forcing[1], next_y, next_w)
    return whole_step(double_11, double_12, double_21, double_22, y, w, forcing_y, forcing_w)


@jit_inline
def coast(e, p, grid, state, end, log, c, events_left):
    """Take whole steps of the exact method in flight and through regular impacts, until another event may happen.

    A row with one support has long flights, so two steps at once are tried first; without forcing they are tried for a
    departure from a support too.
    state : one that `may_coast`; c : work array (DEGREE + 1,); events_left : largest number of impacts.
    Returns (state, impacts logged).
    """
    a11, a12, a21, a22 = grid.a11, grid.a12, grid.a21, grid.a22
    period, step, theta, sign = state.period, state.step, state.theta, frame_sign(e, state.home)
    y, w, departs = sign * state.y, sign * state.w, 0
    if e.forcing is None:
        departs = state.mode
    frame = frame_to_near(e, p, state.home)
    n_steps, n_impacts = 0, 0
    remaining = steps_left(grid, Instant(period, step, theta), end)
    while remaining > 0:
        forcing_y, forcing_w = step_forcing(e, grid, frame, step)
        tries_double = (
            e.support_1 is None or e.support_2 is None or (e.forcing is None and departs == 1)
        )
        if tries_double and remaining > 1:
            y1, w1 = two_steps(e, grid, frame, step, y, w, (forcing_y, forcing_w))
            if stays_between(grid, frame, departs, y, w, y1, w1, 2.0):
                y, w, departs = y1, w1, 0
                n_steps += 2
                remaining -= 2
                step += 2
                if step >= grid.steps:
                    step, period = step - grid.steps, period + 1
                continue
        y1, w1 = whole_step(a11, a12, a21, a22, y, w, forcing_y, forcing_w)
        if not stays_between(grid, frame, departs, y, w, y1, w1, 1.0):
            if n_impacts >= events_left or is_full(log):
                break
            is_regular, frame, wait, y1, w1 = step_through_impact(
                e, p, grid, frame, period, step + theta, (y, w, y1, w1), log, c
            )
            if not is_regular:
                break
            n_impacts += 1
            if e.forcing is None:
                y, w, departs = y1, w1, 1
                theta += wait
                if theta >= 1.0:
                    theta -= 1.0
                    step += 1
                    if step == grid.steps:
                        step, period = 0, period + 1
                remaining = steps_left(grid, Instant(period, step, theta), end)
                continue
        y, w, departs = y1, w1, 0
        n_steps += 1
        remaining -= 1
        step += 1
        if step == grid.steps:
            step, period = 0, period + 1
    log.counts[STEPS] += n_steps
    if e.forcing is not None and grid.steps > MAX_TABLE:
        log.counts[COMPUTED] += n_steps
    log.counts[POLYNOMIALS] += n_impacts
    sign = frame_sign(e, frame.home)
    mode = LEAVES_BY_VELOCITY if departs == 1 else FLIGHT
    return State(period, step, theta, frame.home, sign * y, sign * w, mode, 0.0, None), n_impacts
