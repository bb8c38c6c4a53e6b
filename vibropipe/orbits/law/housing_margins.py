"""What a housing keeps to while a law holds: the forces that hold or move it, and the velocity of its sliding."""

from __future__ import annotations

from vibropipe.compiler import jit
from vibropipe.march.piece_log import (
    CAUSE,
    CONTACT,
    DIRECTION,
    FORM,
    HELD,
    HOME,
    HOUSING_SLIP,
    HOUSING_STOP,
    IMPACT,
    RESTING,
)
from vibropipe.orbits.law.law import SECTION, WAY, way_before
from vibropipe.orbits.law.least import HOUSING_HOLD, HOUSING_SLIDE, LOWER, NO_SIDE, UPPER, note
from vibropipe.orbits.law.momentum import momentum_rate
from vibropipe.orbits.law.sliding import way_of
from vibropipe.orbits.law.states import momentum_after, momentum_before, reference_of, sign_of
from vibropipe.physics.flow import DEGREE
from vibropipe.physics.housing import ground_friction, total_load
from vibropipe.physics.load import constant_load, force_at, force_slope, force_value, forcing_period
from vibropipe.physics.stiffness import damping_of, stiffness_of

# Parts of a step in which a force or a speed has one extremum, and bisections for it.
PARTS, BISECTIONS = 4, 50


@jit
def push_on_housing(e, p, law, i, t, y, w):
    """Return the force on a held housing in a state of piece i, its friction apart, and its rate, along x."""
    if law.codes[i, FORM] in (HELD, RESTING):
        return total_load(p), 0.0
    home, second = law.codes[i, HOME], e.second_harmonic
    sigma, stiffness, damping = sign_of(home), 1.0, p.h
    if e.soft is not None and law.codes[i, FORM] == CONTACT:
        stiffness, damping = stiffness + stiffness_of(p, home), damping + damping_of(p, home)
    force = force_at(p, sigma, t, second)
    pulls = constant_load(sigma, reference_of(p, home)) + force_value(force, second)
    pulls -= stiffness * y + damping * w + p.friction * law.codes[i, DIRECTION]
    rate = p.nu * force_slope(force, second) - stiffness * w - damping * pulls
    return total_load(p) - sigma * pulls, -sigma * rate


@jit
def note_hold(p, i, push, time, margins) -> None:
    """Note by how much the friction exceeds the force on a held housing."""
    note(margins, HOUSING_HOLD, p.housing_friction_1 - push, i, UPPER, time)
    note(margins, HOUSING_HOLD, push + p.housing_friction_2, i, LOWER, time)


@jit
def of_housing_event(e, p, law, u, i, start, margins) -> None:
    """Note the margins of a housing just after event i, whose piece begins in a state."""
    kind, way, before = law.codes[i, CAUSE], way_of(law, i), way_before(law, i)
    if kind == SECTION:
        return
    push, rate = push_on_housing(e, p, law, i, start.t, start.y, start.w)
    if way == 0:
        note_hold(p, i, push, start.t, margins)
    elif kind == HOUSING_SLIP:
        note(margins, HOUSING_HOLD, way * rate, i, NO_SIDE, start.t)
    elif kind == IMPACT:
        speed = law.codes[i, WAY] * (momentum_after(e, p, law, i, u).q - start.w)
        note(margins, HOUSING_SLIDE, speed, i, UPPER, start.t)
    elif kind == HOUSING_STOP or before == 0:
        excess = way * (push - ground_friction(p, way))
        note(margins, HOUSING_HOLD, excess, i, NO_SIDE, start.t)


@jit
def of_housing_between(e, p, law, u, i, end, turns, margins) -> None:
    """Note the margins of a housing at the end of piece i, which another event than its own ends."""
    following = (i + 1) % law.codes.shape[0]
    kind, way = law.codes[following, CAUSE], way_before(law, following)
    if kind == SECTION:
        return
    time = end.t + law.span if following == 0 else end.t
    if way != 0 and kind != HOUSING_STOP:
        speed = way * (momentum_before(e, p, law, following, u).q - end.w)
        note(margins, HOUSING_SLIDE, speed, i, LOWER, time)
    elif way == 0 and kind != HOUSING_SLIP:
        # The state before the event, in the frame of the piece: its mirror image has the same numbers there.
        same = law.mirrored == 0 or following != 0 or law.codes[i, HOME] > 0
        sign = 1.0 if same else -1.0
        push, _rate = push_on_housing(e, p, law, i, time, sign * end.y, sign * end.w)
        note_hold(p, i, push, time, margins)


@jit
def bend(c, order, theta) -> float:
    """Return the second or third derivative of a polynomial by theta."""
    total = 0.0
    for n in range(DEGREE, order - 1, -1):
        factor = n * (n - 1) if order == 2 else n * (n - 1) * (n - 2)
        total = total * theta + factor * c[n]
    return total


@jit
def of_housing_step(e, p, law, u, i, step, at, dt, c, margins) -> None:
    """Note the margins of a housing where they have extrema in one step of a piece, a polynomial from a time."""
    way, period = law.codes[i, WAY], forcing_period(p)
    order, offset = 3, 0.0
    if way != 0:
        order, offset = 2, momentum_rate(p, law, i) * dt * dt
        if step == 0 and law.codes[i, CAUSE] == HOUSING_SLIP:
            offset = 2.0 * c[2]  # without rounding
    low, first = 0.0, bend(c, order, 0.0) - offset
    for part in range(PARTS):
        high = (part + 1) / PARTS
        last = bend(c, order, high) - offset
        if first * last < 0.0 and not way * first < 0.0:
            theta = extremum(c, order, offset, low, high)
            note_extremum(e, p, law, u, i, at + theta * dt / period, theta, dt, c, margins)
        low, first = high, last


@jit
def extremum(c, order, offset, low, high) -> float:
    """Return where a derivative of a polynomial has a value, by bisections."""
    first = bend(c, order, low) - offset
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if (bend(c, order, middle) - offset) * first > 0.0:
            low = middle
        else:
            high = middle
    return low


@jit
def note_extremum(e, p, law, u, i, time, theta, dt, c, margins) -> None:
    """Note the force on a held housing, or the speed of a sliding one, at theta of a step of a piece."""
    way = law.codes[i, WAY]
    if way == 0:
        push = total_load(p) - sign_of(law.codes[i, HOME]) * bend(c, 2, theta) / (dt * dt)
        note_hold(p, i, push, time, margins)
        return
    w = 0.0
    for n in range(DEGREE, 0, -1):
        w = w * theta + n * c[n]
    begun = u[i, 0] if law.codes[i, CAUSE] != SECTION else 0.0
    q = momentum_after(e, p, law, i, u).q
    q += momentum_rate(p, law, i) * (time - begun) * forcing_period(p)
    note(margins, HOUSING_SLIDE, way * (q - w / dt), i, NO_SIDE, time)
