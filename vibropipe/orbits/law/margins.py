"""What an orbit keeps to while its law holds: margins, each positive, whose zeros are where other laws begin.

Newton's method also finds orbits that are none: flights through a support, sticks under a force beyond the friction.
"""

from __future__ import annotations

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.piece_log import (
    BEYOND,
    CAUSE,
    CONTACT,
    DIRECTION,
    FORM,
    HELD,
    HOME,
    LEAVE,
    RELEASE,
    RELOAD,
    REST_BEGINS,
    RESTING,
    SLIP,
    STICK,
    TURN,
    UNLOAD,
)
from vibropipe.orbits.law.flights import flight_of, force_on
from vibropipe.orbits.law.housing_margins import (
    of_housing_between,
    of_housing_event,
    of_housing_step,
)
from vibropipe.orbits.law.landing import LONG_HOP, landing_of
from vibropipe.orbits.law.law import SECTION, acts_in, ends_force, frame_before, is_contact
from vibropipe.orbits.law.least import (
    CHATTER,
    FORCE,
    GAP,
    HOLD,
    KINDS,
    LOWER,
    NO_SIDE,
    SLIDE,
    SPAN,
    SPEED,
    UPPER,
    VALUE,
    note,
)
from vibropipe.orbits.law.states import arrival, departure, hold_force
from vibropipe.orbits.pieces import steps_of_span
from vibropipe.physics.contact import support_position
from vibropipe.physics.flow import DEGREE, displacement, velocity
from vibropipe.physics.friction import hold_of, jumps_at_slip
from vibropipe.physics.load import forcing_period
from vibropipe.physics.piece import acceleration_of, flight_over, flown, force_at_end
from vibropipe.physics.stiffness import damping_of, only_pushes, piece_taylor, stiffness_of

# Orders of the derivatives of a polynomial.
VELOCITY, ACCELERATION = map(np.int64, (1, 2))
# Parts of a step in which a turning point is sought, bisections for it, and the most steps of one polynomial each.
PARTS, BISECTIONS, MAX_STEPS = 4, 40, 1024.0
# Secants and bisections for a turning point of a polynomial, and the share of its step at which it is found.
MAX_SECANTS, NARROW = 60, 1e-15
# Parts of a forcing period in which the largest force on a held mass is sought.
HELD_PARTS = 64


@jit
def fill_margins(e, p, law, u, c, margins) -> None:
    """Fill the margins of an orbit; those that nothing bounds are infinite.

    Parameters
    ----------
    p : Parameters
    law : Law
    u : (n, 2) float
    c : (DEGREE + 1,) float
        Work array.
    margins : (KINDS + 1, 4) float
        The last row is kept: see `least.TOUCH`.
    """
    margins[:KINDS] = 0.0
    margins[:KINDS, VALUE] = np.inf
    n = law.codes.shape[0]
    for i in range(n):
        of_event(e, p, law, u, i, margins)
        later = law.span if i == n - 1 else 0.0
        start, end = departure(e, p, law, i, u), arrival(e, p, law, (i + 1) % n, u)
        turns = end.t + later - start.t
        if law.codes[i, CAUSE] != SECTION:
            note(margins, SPAN, turns, i, NO_SIDE, start.t)
        if e.housing is not None:
            of_housing_event(e, p, law, u, i, start, margins)
        if not turns > 0.0:
            continue
        if e.rest is not None and law.codes[i, FORM] == RESTING:
            of_rest(e.rest, e, p, law, i, start, turns, margins)
        elif e.friction is not None and law.codes[i, FORM] == HELD:
            of_held(e.friction, e, p, law, i, start.y, start.t, turns, margins)
        else:
            of_motion(e, p, law, u, i, start, turns, c, margins)
        if e.housing is not None:
            of_housing_between(e, p, law, u, i, end, turns, margins)


@jit
def of_event(e, p, law, u, i, margins) -> None:
    """Note the margins of event i itself."""
    kind, home = law.codes[i, CAUSE], np.int64(law.codes[i, HOME])
    if kind == SECTION:
        return
    before = arrival(e, p, law, i, u)
    if is_contact(kind):
        frame = frame_before(law, i)
        approach = before.w if frame == 0 or frame != home else -before.w
        if frame == 0 and home == 2:
            approach = -approach
        if kind != REST_BEGINS:
            note(margins, SPEED, -approach if kind == LEAVE else approach, i, home, before.t)
        return
    if e.no_pull is not None and ends_force(kind):
        flight = flight_of(e, p, law, i, before.t, 0.0)
        a = acceleration_of(flight, force_at_end(flight), before.y, before.w)
        rate = before.w + damping_of(p, home) / stiffness_of(p, home) * a
        note(margins, SLIDE, rate if kind == UNLOAD else -rate, i, FORCE, before.t)
        if kind == RELOAD:
            # A mass that loses its speed in the air leaves the support.
            note(margins, SPEED, before.w, i, home, before.t)
        return
    if kind in (SLIP, RELEASE):
        _value, _stiffness, rate = hold_force(e, p, law, i - 1, before.t)
        note(margins, HOLD, law.codes[i, DIRECTION] * rate * p.nu, i, NO_SIDE, before.t)
        return
    if e.friction is None:
        return
    of_turning_point(e, p, law, i, before, margins)
    value, stiffness, _rate = hold_force(e, p, law, i, before.t)
    force = value - stiffness * before.y
    if kind == STICK:
        note(margins, HOLD, hold_of(e, p) - abs(force), i, NO_SIDE, before.t)
        if jumps_at_slip(e, p):
            # It must have lost its velocity against the friction that it slid with.
            came = law.codes[i - 1, DIRECTION]
            if i == 0 and law.mirrored == 1 and frame_before(law, i) == 0:
                came = -came
            note(margins, SLIDE, (p.friction - came * force) / p.nu, i, NO_SIDE, before.t)
    elif kind == TURN:
        note(margins, HOLD, law.codes[i, DIRECTION] * force - hold_of(e, p), i, NO_SIDE, before.t)


@jit
def of_turning_point(e, p, law, i, before, margins) -> None:
    """Note the distance from the supports at which friction turns or holds the mass; in a contact the depth."""
    frame, y = np.int64(frame_before(law, i)), before.y
    if e.soft is not None and acts_in(law, i):
        note(margins, GAP, -y, i, frame, before.t)
        return
    if frame == 0:
        note(margins, GAP, support_position(p, 1) - y, i, UPPER, before.t)
        note(margins, GAP, y - support_position(p, 2), i, LOWER, before.t)
        return
    note(margins, GAP, y, i, frame, before.t)
    note(margins, GAP, 2.0 * p.l - y, i, 3 - frame, before.t)


@jit
def of_held(effect, e, p, law, i, y, t, turns, margins) -> None:
    """Note by how much what holds a mass exceeds the force on it where the latter turns; None: no effect, none."""
    if effect is None:
        return
    parts = int(np.ceil(turns * HELD_PARTS)) + 1
    length = turns / parts
    for part in range(parts):
        low, high = t + part * length, t + (part + 1) * length
        _value, _stiffness, rate = hold_force(e, p, law, i, low)
        _value, _stiffness, later = hold_force(e, p, law, i, high)
        if not rate * later < 0.0:
            continue
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            _value, _stiffness, between = hold_force(e, p, law, i, middle)
            if between * rate > 0.0:
                low = middle
            else:
                high = middle
        value, stiffness, _rate = hold_force(e, p, law, i, low)
        force = value - stiffness * y
        if law.codes[i, FORM] == RESTING:
            note(margins, HOLD, hold_of(e, p) - force, i, NO_SIDE, low)
        else:
            note(margins, HOLD, hold_of(e, p) - abs(force), i, 1 if force > 0.0 else -1, low)


@jit
def of_rest(effect, e, p, law, i, start, turns, margins) -> None:
    """Note by how much a chatter lands before the release, and how short its first flight is that no event counts."""
    if effect is None:
        return
    landing, share = landing_of(e, p, law, i, start.t, start.w)
    note(margins, SPAN, turns - landing, i, CHATTER, start.t)
    note(margins, SPAN, LONG_HOP - share, i, CHATTER, start.t)
    if landing < turns:
        of_held(effect, e, p, law, i, 0.0, start.t + landing, turns - landing, margins)


@jit
def of_motion(e, p, law, u, i, start, turns, c, margins) -> None:
    """Note gaps, depths and speeds of sliding of a piece where they turn."""
    period = forcing_period(p)
    flight = flight_of(e, p, law, i, start.t, turns)
    second = e.second_harmonic
    steps = steps_of_span(p, flight.stiffness, flight.damping, abs(flight.t), second)
    steps = min(steps, MAX_STEPS)
    y, w = start.y, start.w
    dt = flight.t / steps
    is_exact = steps < MAX_STEPS
    for step in range(int(steps)):
        at = start.t + step * dt / period
        force = force_on(e, p, law, i, at)
        if not is_exact:
            part = flight_over(
                flight.stiffness,
                flight.damping,
                flight.load,
                flight.force,
                p.nu,
                step * dt / period,
                second,
            )
            y, w = flown(part, start.y, start.w)
        piece_taylor(
            c, y, w, force, flight.load, flight.stiffness, flight.damping, p.nu, dt, second
        )
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
    n = law.codes.shape[0]
    direction = law.codes[i, DIRECTION]
    if e.friction is not None and p.friction > 0.0 and is_contact(law.codes[(i + 1) % n, CAUSE]):
        note(margins, SLIDE, direction * w, i, NO_SIDE, start.t + turns)


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
