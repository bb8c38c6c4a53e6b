"""Margins of the motion of a piece where it turns: gaps, depths, speeds of sliding, and forces of supports."""

from __future__ import annotations

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.piece_log import (
    BEYOND,
    CAUSE,
    CONTACT,
    DIRECTION,
    FORM,
    HOME,
    HOUSING_SLIP,
    HOUSING_STOP,
    RELEASE,
    SLIP,
)
from vibropipe.orbits.law.flights import flight_of, force_on
from vibropipe.orbits.law.housing_margins import of_housing_step
from vibropipe.orbits.law.law import is_contact
from vibropipe.orbits.law.least import FORCE, GAP, LOWER, NO_SIDE, SLIDE, UPPER, note
from vibropipe.orbits.pieces import steps_of_span
from vibropipe.physics.contact import support_position
from vibropipe.physics.decay import ALIVE, decay_of, decayed_taylor
from vibropipe.physics.flow import DEGREE, REACH, displacement, velocity
from vibropipe.physics.friction import jumps_at_slip
from vibropipe.physics.load import forcing_period
from vibropipe.physics.piece import flight_over, flown
from vibropipe.physics.stiffness import damping_of, only_pushes, piece_taylor, stiffness_of

# Orders of the derivatives of a polynomial.
VELOCITY, ACCELERATION = map(np.int64, (1, 2))
# Parts of a step in which a turning point is sought, and the most steps of one polynomial each.
PARTS, MAX_STEPS = 4, 1024.0
# Steps of a contact above which it is looked at what is left of it, and of those at which it may be alive.
MANY_STEPS, MAX_DECAYING = 64.0, 512
# Secants and bisections for a turning point of a polynomial, and the share of its step at which it is found.
MAX_SECANTS, NARROW = 60, 1e-15


@jit
def of_motion(e, p, law, u, i, start, turns, c, margins) -> None:
    """Note gaps, depths and speeds of sliding of a piece where they turn."""
    flight = flight_of(e, p, law, i, start.t, turns)
    steps = steps_of_span(p, flight.stiffness, flight.damping, flight.t, e.second_harmonic)
    if e.soft is not None and steps > MANY_STEPS and law.codes[i, FORM] == CONTACT:
        w = of_decaying(e, p, law, u, i, start, flight, c, margins)
    else:
        w = of_steps(e, p, law, u, i, start, flight, min(steps, MAX_STEPS), c, margins)
    following = law.codes[(i + 1) % law.codes.shape[0], CAUSE]
    ends_sliding = is_contact(following) or following in (HOUSING_SLIP, HOUSING_STOP)
    if e.friction is not None and p.friction > 0.0 and ends_sliding:
        # The speed has no extremum there: the acceleration jumps, or the piece just ends.
        note(margins, SLIDE, law.codes[i, DIRECTION] * w, i, NO_SIDE, start.t + turns)


@jit
def of_steps(e, p, law, u, i, start, flight, steps, c, margins) -> float:
    """Note the margins of a piece in equal steps; return its velocity at the end."""
    period, second, y, w = forcing_period(p), e.second_harmonic, start.y, start.w
    dt, is_exact = flight.t / steps, steps < MAX_STEPS
    for step in range(int(steps)):
        at = start.t + step * dt / period
        force = force_on(e, p, law, i, at)
        if not is_exact:
            y, w = state_at(flight, start, p.nu, step * dt / period, second)
        piece_taylor(
            c, y, w, force, flight.load, flight.stiffness, flight.damping, p.nu, dt, second
        )
        y, w = of_polynomial(e, p, law, u, i, step, at, dt, c, margins)
    return w


@jit
def of_decaying(e, p, law, u, i, start, flight, c, margins) -> float:
    """Note the margins of a contact far faster than its piece, in steps as long as what is left of it allows.

    Returns its velocity at the end.
    """
    period, second, y, w = forcing_period(p), e.second_harmonic, start.y, start.w
    done, step = 0.0, 0
    while done < flight.t:
        at, rest = start.t + done / period, flight.t - done
        force = force_on(e, p, law, i, at)
        decay = decay_of(y, w, force, flight.load, flight.stiffness, flight.damping, p, second)
        dt = min(REACH / decay.rate, rest)
        if step >= MAX_DECAYING:
            # What stays alive is looked at in longer steps, each from its exact state.
            dt = max(dt, rest / max(MAX_STEPS - step, 1.0))
        if decay.kind == ALIVE:
            piece_taylor(
                c, y, w, force, flight.load, flight.stiffness, flight.damping, p.nu, dt, second
            )
        else:
            decayed_taylor(c, y, decay, p.nu, dt, second)
        y, w = of_polynomial(e, p, law, u, i, step, at, dt, c, margins)
        step += 1
        done = done + dt if dt < rest else flight.t
        if step > MAX_DECAYING:
            y, w = state_at(flight, start, p.nu, done / period, second)
    return w


@jit
def state_at(flight, start, nu, turns, second):
    """Return (y, w) on a piece some turns after its start."""
    part = flight_over(
        flight.stiffness, flight.damping, flight.load, flight.force, nu, turns, second
    )
    return flown(part, start.y, start.w)


@jit
def of_polynomial(e, p, law, u, i, step, at, dt, c, margins):
    """Note the margins of one step of a piece, whose polynomial is overwritten; return its end (y, w)."""
    if step == 0 and law.codes[i, CAUSE] in (SLIP, RELEASE):
        c[1] = 0.0  # without rounding
        if not jumps_at_slip(e, p):
            c[2] = 0.0
    of_step(e, p, law, i, at, dt, c, margins)
    if e.housing is not None:
        of_housing_step(e, p, law, u, i, step, at, dt, c, margins)
    y, w = displacement(c, DEGREE, 1.0), velocity(c, DEGREE, 1.0, dt)
    if e.no_pull is not None and is_beyond_one_that_pushes(e, p, law, i):
        of_force(p, law, i, at, dt, c, margins)
    return y, w


@jit
def is_beyond_one_that_pushes(e, p, law, i) -> bool:
    """Return whether the mass is, on piece i, beyond a soft support that only pushes."""
    home = law.codes[i, HOME]
    return law.codes[i, FORM] in (CONTACT, BEYOND) and only_pushes(e, p, home)


@jit
def of_force(p, law, i, at, dt, c, margins) -> None:
    """Note the force of a support that only pushes, or would pull, where it turns; c is left with its polynomial."""
    home, sign = law.codes[i, HOME], 1.0 if law.codes[i, FORM] == BEYOND else -1.0
    ratio = damping_of(p, home) / (stiffness_of(p, home) * dt)
    for n in range(DEGREE):
        c[n] += ratio * (n + 1) * c[n + 1]
    first = slope_of(c, VELOCITY, 0.0)
    for part in range(PARTS):
        low, high = part / PARTS, (part + 1) / PARTS
        last = slope_of(c, VELOCITY, high)
        if first * sign < 0.0 < last * sign:
            theta = turning_point(c, VELOCITY, low, high)
            value, time = displacement(c, DEGREE, theta), at + theta * dt / forcing_period(p)
            note(margins, GAP, sign * value, i, FORCE, time)
        first = last


@jit
def slope_of(c, order, theta) -> float:
    """Return the first or second derivative of a polynomial by theta."""
    total = 0.0
    for n in range(DEGREE, order - 1, -1):
        factor = n if order == 1 else n * (n - 1)
        total = total * theta + factor * c[n]
    return total


@jit
def slope_rest(c, order) -> float:
    """Return the largest sum, over a step, of all terms of `slope_of` but the first."""
    total = 0.0
    for n in range(DEGREE, order, -1):
        factor = n if order == 1 else n * (n - 1)
        total += factor * abs(c[n])
    return total


@jit
def turning_point(c, order, low, high) -> float:
    """Return where a derivative of a polynomial changes its sign, by secants and bisections."""
    first, last, theta = slope_of(c, order, low), slope_of(c, order, high), high
    for iteration in range(MAX_SECANTS):
        theta = (low * last - high * first) / (last - first)
        if iteration % 3 == 2 or not low < theta < high:
            theta = 0.5 * (low + high)
        slope = slope_of(c, order, theta)
        if slope == 0.0 or high - low < NARROW:
            break
        if slope * first > 0.0:
            low, first = theta, slope
        else:
            high, last = theta, slope
    return theta


@jit
def of_step(e, p, law, i, at, dt, c, margins) -> None:
    """Note the margins of one step of a piece, a polynomial, in parts in which its slope is monotonic."""
    direction, period = law.codes[i, DIRECTION], forcing_period(p)
    rubs = e.friction is not None and p.friction > 0.0 and direction != 0
    if not rubs and abs(c[1]) > slope_rest(c, VELOCITY):
        return  # the velocity keeps its sign
    first = slope_of(c, ACCELERATION, 0.0)
    parts = 1 if abs(2.0 * c[2]) > slope_rest(c, ACCELERATION) else PARTS
    for part in range(parts):
        low, high = part / parts, (part + 1) / parts
        last, middle = slope_of(c, ACCELERATION, high), high
        if first * last < 0.0:
            middle = turning_point(c, ACCELERATION, low, high)
            if rubs and first * direction < 0.0:
                speed = direction * velocity(c, DEGREE, middle, dt)
                note(margins, SLIDE, speed, i, NO_SIDE, at + middle * dt / period)
        of_part(e, p, law, i, at, dt, c, low, middle, margins)
        if middle < high:
            of_part(e, p, law, i, at, dt, c, middle, high, margins)
        first = last


@jit
def of_part(e, p, law, i, at, dt, c, low, high, margins) -> None:
    """Note the gap, or the depth in a contact, where a polynomial with a monotonic slope turns."""
    first, home = slope_of(c, VELOCITY, low), np.int64(law.codes[i, HOME])
    if not first * slope_of(c, VELOCITY, high) < 0.0:
        return
    theta = turning_point(c, VELOCITY, low, high)
    y, time = displacement(c, DEGREE, theta), at + theta * dt / forcing_period(p)
    if e.soft is not None and law.codes[i, FORM] == CONTACT:
        if first > 0.0:
            note(margins, GAP, -y, i, home, time)
    elif home == 0:
        side = UPPER if first > 0.0 else LOWER
        support = support_position(p, side)
        note(margins, GAP, support - y if side == 1 else y - support, i, side, time)
    elif first > 0.0:
        note(margins, GAP, 2.0 * p.l - y, i, 3 - home, time)
    else:
        note(margins, GAP, y, i, home, time)
