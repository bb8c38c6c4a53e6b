"""Whole steps in flight, and the usual impact: one in a step, met on the only way to it and left unhindered.

What is not certified to be of this kind goes by `march.flight`, which can do everything and takes thrice as
long. Here the step is taken by the one-step map as if the support were not there; the impact adds to its end
the response to an impulse, so the motion after it needs no polynomial of its own. Without a force no phase ties
steps to a grid: there the next one begins at the impact.
"""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.contacts import support_at
from vibropipe.march.grid import Instant, force_at_step, stays_between
from vibropipe.march.log import POLYNOMIALS, STEPS, is_full, log_impact
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
from vibropipe.physics.load import Force, force_at

# A cubic through both ends of a step errs in its slope by at most so many times its error in place.
SLOPE_MARGIN = 3.1
# And in its curvature by at most so many times.
CURVATURE_MARGIN = 32.0
# The inverse of a gap that begins or ends with less than this share of its mean slope is no cubic.
MIN_SLOPE_RATIO = 0.2
MAX_REFINEMENTS = 4
# A correction whose cube, and whose square times the change of the acceleration, is below rounding.
REFINEMENT_TOLERANCE = 1e-8
# Impacts this near the end of a step leave a departure too short to be told from rounding.
MAX_IMPACT_THETA = 0.999
# A departure that rises in a step by less than this share of the distance between the frame and the support
# struck would lose digits to it.
MIN_DEPARTURE_RATIO = 1.0 / 64.0


@jit_inline
def crosses_once(grid, y, w, load, first, last, slope0, slope1, distance) -> bool:
    """Whether a gap surely closes once over a whole step from `first` > 0 to `last` < 0 and stays below `distance`
    before; slopes by theta.

    It falls all the way: its slope lies within a margin of the hull of the cubic's, its slopes at the ends and
    the Bezier point between them. Or it is concave: so is the cubic, by as much at both ends.
    """
    margin = grid.margin0 + grid.margin1 * (abs(y - load) + abs(w))
    if not (first > 0.0 and last < 0.0):
        return False
    fall = last - first
    if max(max(slope0, slope1), 3.0 * fall - slope0 - slope1) < -SLOPE_MARGIN * margin:
        return True
    curvature0, curvature1 = (
        6.0 * fall - 4.0 * slope0 - 2.0 * slope1,
        2.0 * slope0 + 4.0 * slope1 - 6.0 * fall,
    )
    return (
        max(curvature0, curvature1) < -CURVATURE_MARGIN * margin
        and first + max(slope0, 0.0) < distance
    )


@jit_inline
def refine_root(e, p, grid, c, load, sign, offset, first, last, slope0, slope1):
    """(theta, slope there) of the one root of a gap; theta = 2 if it was not found to rounding.

    By Halley's method, two evaluations as a rule, from the cubic through both ends of the inverse of the gap;
    of one that rises first or turns at the end, from the parabola through both ends.
    """
    change = last - first
    if slope0 < MIN_SLOPE_RATIO * change and slope1 < MIN_SLOPE_RATIO * change:
        s = -first / change
        r = 1.0 - s
        begins, ends = change / slope0, change / slope1
        theta = s * s * (1.0 + 2.0 * r) + s * r * (r * begins - s * ends)
    else:
        curvature_term = 4.0 * (change - slope0) * first
        theta = 2.0 * first / (math.sqrt(max(slope0 * slope0 - curvature_term, 0.0)) - slope0)
    for _ in range(MAX_REFINEMENTS):
        value, slope, curvature = motion_with_curvature(c, theta)
        if e.forcing is None:
            # By eq. (5), which without a force takes less than the polynomial.
            curvature = grid.dt * (grid.dt * (load - value))
            if e.damping is not None:
                curvature -= p.h * grid.dt * slope
        value, slope, curvature = offset + sign * value, sign * slope, sign * curvature
        # One division: the chain of an impact is as long as its divisions.
        inverse = 1.0 / slope
        newton = -value * inverse
        # Halley's step to the order that counts.
        step = newton * (1.0 - 0.5 * newton * (curvature * inverse))
        theta += step
        if abs(step) <= REFINEMENT_TOLERANCE:
            return theta, slope + step * curvature
    return 2.0, 0.0


@jit_inline
def frame_to_near(e, p, home):
    """`frame_at`, but with support 1 alone the equilibrium's is turned round, so that the one support stands near."""
    frame = frame_at(e, p, home)
    if e.support_2 is None and home == 0:
        reach = e.support_1 is not None
        frame = Frame(home, -1.0, frame.load, -frame.far, frame.far, reach, False)
    return frame


@jit_inline
def frame_sign(e, home):
    """-1 where `frame_to_near` turns the frame round, else 1."""
    return -1.0 if e.support_2 is None and home == 0 else 1.0


@jit_inline
def step_through_impact(e, p, grid, frame, period, at, y, w, y1, w1, log, c):
    """(whether so, frame, theta, y, w) of a step from `at` (in steps) with one plain impact, which is logged: the
    motion at its end or, without forcing, at the impact, theta later.

    y, w, y1, w1: at the ends of the step, as if there were no support.
    """
    at_near = w1 < 0.0
    if e.support_1 is None or e.support_2 is None:
        # Seen from either frame, the one support there is stands near.
        struck = 1 if e.support_2 is None else 2
        if not (at_near and frame.to_near):
            return False, frame, 0.0, y, w
        at_near = True
    else:
        struck = support_at(frame.home, at_near)
    if is_watched(struck, e.watched):
        return False, frame, 0.0, y, w
    sign, offset = (1.0, -frame.near) if at_near else (-1.0, frame.far)
    first, last = offset + sign * y, offset + sign * y1
    slope0, slope1 = sign * w * grid.dt, sign * w1 * grid.dt
    distance = frame.far - frame.near
    if not crosses_once(grid, y, w, frame.load, first, last, slope0, slope1, distance):
        return False, frame, 0.0, y, w
    force = Force(0.0, 0.0)
    if e.forcing is not None:
        force = force_at(p, frame.sigma, at / grid.steps)
    combine(e, grid.basis, c, y, w, frame.load, force)
    theta, slope = refine_root(e, p, grid, c, frame.load, sign, offset, first, last, slope0, slope1)
    if not theta < MAX_IMPACT_THETA:
        return False, frame, 0.0, y, w
    per_step = 1.0 / grid.dt
    approach = -slope * per_step
    speed = reset(restitution_of(e, p, struck), approach)
    turn = (at + theta) / grid.steps
    new = frame_to_near(e, p, struck)
    mode, _wait = departure_mode(e, p, grid, struck, speed, turn)
    if mode != LEAVES_BY_VELOCITY:
        return False, frame, 0.0, y, w
    if e.forcing is None:
        # No grid of phases to come back to: the next step begins here.
        y1, w1 = 0.0, speed
    else:
        left = 1.0 - theta
        rise, rise_slope, _curvature = motion_with_curvature(grid.basis[1], left)
        kick = speed + approach
        y1, w1 = last + kick * rise, sign * w1 + (kick * per_step) * rise_slope
        if not (
            speed * grid.dt > MIN_DEPARTURE_RATIO * abs(offset)
            and stays_between(grid, new, 1, 0.0, speed, y1, w1, left)
        ):
            return False, frame, 0.0, y, w
    outward = 1.0 if struck == 1 else -1.0
    impulse = -outward * (approach + speed)
    log_impact(log, period + turn, struck, outward * approach, impulse)
    return True, new, theta if e.forcing is None else 0.0, y1, w1


@jit
def may_coast(e, state) -> bool:
    """Whether `coast` can go on from here: in flight at the start of a step or, as without forcing any instant
    is as good, in flight or off a support at any time."""
    if e.forcing is None:
        return state.mode <= LEAVES_BY_VELOCITY
    return state.mode == FLIGHT and state.theta == 0.0


@jit
def steps_left(grid, at, end):
    """Whole steps from an `Instant` to the end."""
    return (end.period - at.period) * grid.steps + (end.step - at.step) - (at.theta > end.theta)


@jit_inline
def step_forcing(e, grid, frame, step):
    """The parts of the load and of the force in a step of the one-step map."""
    part_y, part_w = grid.b1 * frame.load, grid.b2 * frame.load
    if e.forcing is not None:
        force_y, force_w = force_at_step(grid, step)
        part_y += frame.sigma * force_y
        part_w += frame.sigma * force_w
    return part_y, part_w


@jit_inline
def apply_map(a11, a12, a21, a22, y, w, part_y, part_w):
    """(y, w) after a step; the parts first: the chain from y to the next y is then two operations long."""
    return a11 * y + (a12 * w + part_y), a21 * y + (a22 * w + part_w)


@jit_inline
def coast(e, p, grid, state, end, log, c, events_left):
    """(state, impacts made) after whole steps of the exact method in flight and through plain impacts, `events_left` of
    them at most, up to the step in which something else may happen.

    With one support alone flights are long: two steps at once are tried first, and without a force off a support.
    """
    a11, a12, a21, a22 = grid.a11, grid.a12, grid.a21, grid.a22
    double_step_11, double_step_12 = a11 * a11 + a12 * a21, a11 * a12 + a12 * a22
    double_step_21, double_step_22 = a21 * a11 + a22 * a21, a21 * a12 + a22 * a22
    period, step, theta, sign = state.period, state.step, state.theta, frame_sign(e, state.home)
    y, w, departs = sign * state.y, sign * state.w, 0
    if e.forcing is None:
        departs = state.mode
    frame = frame_to_near(e, p, state.home)
    made, struck = 0, 0
    left = steps_left(grid, Instant(period, step, theta), end)
    while left > 0:
        part_y, part_w = step_forcing(e, grid, frame, step)
        long = e.support_1 is None or e.support_2 is None or (e.forcing is None and departs == 1)
        if long and left > 1:
            second = step + 1 if step + 1 < grid.steps else 0
            later_y, later_w = step_forcing(e, grid, frame, second)
            later_y, later_w = apply_map(a11, a12, a21, a22, part_y, part_w, later_y, later_w)
            y1, w1 = apply_map(
                double_step_11,
                double_step_12,
                double_step_21,
                double_step_22,
                y,
                w,
                later_y,
                later_w,
            )
            if stays_between(grid, frame, departs, y, w, y1, w1, 2.0):
                y, w, departs = y1, w1, 0
                made += 2
                left -= 2
                step += 2
                if step >= grid.steps:
                    step, period = step - grid.steps, period + 1
                continue
        y1, w1 = apply_map(a11, a12, a21, a22, y, w, part_y, part_w)
        if not stays_between(grid, frame, departs, y, w, y1, w1, 1.0):
            if struck >= events_left or is_full(log):
                break
            plain, frame, wait, y1, w1 = step_through_impact(
                e, p, grid, frame, period, step + theta, y, w, y1, w1, log, c
            )
            if not plain:
                break
            struck += 1
            if e.forcing is None:
                y, w, departs = y1, w1, 1
                theta += wait
                if theta >= 1.0:
                    theta -= 1.0
                    step += 1
                    if step == grid.steps:
                        step, period = 0, period + 1
                left = steps_left(grid, Instant(period, step, theta), end)
                continue
        y, w, departs = y1, w1, 0
        made += 1
        left -= 1
        step += 1
        if step == grid.steps:
            step, period = 0, period + 1
    log.counts[STEPS] += made
    log.counts[POLYNOMIALS] += struck
    sign = frame_sign(e, frame.home)
    mode = LEAVES_BY_VELOCITY if departs == 1 else FLIGHT
    return State(period, step, theta, frame.home, sign * y, sign * w, mode, 0.0), struck
