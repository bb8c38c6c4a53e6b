"""What an orbit keeps to while its law holds: margins, each positive, whose zeros are where other laws begin.

Newton's method also finds orbits that are none: flights through a support, sticks under a force beyond the friction.
"""

from __future__ import annotations

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.piece_log import (
    CAUSE,
    DIRECTION,
    FORM,
    HELD,
    HOME,
    HOUSING_STOP,
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
from vibropipe.orbits.law.flights import flight_of
from vibropipe.orbits.law.housing_margins import of_housing_between, of_housing_event
from vibropipe.orbits.law.landing import LONG_HOP, landing_of, least_slide
from vibropipe.orbits.law.law import SECTION, WAY, acts_in, ends_force, frame_before, is_contact
from vibropipe.orbits.law.least import (
    CHATTER,
    FORCE,
    GAP,
    HOLD,
    HOUSING_SLIDE,
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
from vibropipe.orbits.law.motion_margins import of_motion
from vibropipe.orbits.law.states import arrival, departure, hold_force
from vibropipe.physics.contact import support_position
from vibropipe.physics.friction import hold_of, jumps_at_slip
from vibropipe.physics.piece import acceleration_of, force_at_end
from vibropipe.physics.stiffness import damping_of, stiffness_of

# Parts of a forcing period in which the largest force on a held mass is sought, and bisections for it.
HELD_PARTS, BISECTIONS = 64, 40


@jit
def fill_margins(e, p, law, u, c, margins) -> None:
    """Fill the margins of an orbit; those that nothing bounds are infinite.

    u : (n, 2)
    c : (DEGREE + 1,), work array
    margins : (KINDS + 1, 4), the last row is kept: see `least.TOUCH`
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
            of_rest(e.rest, e, p, law, i, u, start, turns, margins)
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
    if e.friction is None or law.codes[i, FORM] == RESTING:
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
def of_rest(effect, e, p, law, i, u, start, turns, margins) -> None:
    """Note by how much a chatter lands before the release, and how short its first flight is that no event counts."""
    if effect is None:
        return
    if e.housing is not None and law.codes[i, CAUSE] == HOUSING_STOP:
        # The force that presses the mass changes at once.
        value, _stiffness, _rate = hold_force(e, p, law, i, start.t)
        note(margins, HOLD, hold_of(e, p) - value, i, NO_SIDE, start.t)
    landing, share = landing_of(e, p, law, i, start.t, start.w)
    if e.housing is not None and law.codes[i, CAUSE] == REST_BEGINS and law.codes[i, WAY] != 0:
        slide = least_slide(e, p, law, i, u, start.w, landing, share)
        note(margins, HOUSING_SLIDE, slide, i, UPPER, start.t)
    note(margins, SPAN, turns - landing, i, CHATTER, start.t)
    note(margins, SPAN, LONG_HOP - share, i, CHATTER, start.t)
    if landing < turns:
        of_held(effect, e, p, law, i, 0.0, start.t + landing, turns - landing, margins)
