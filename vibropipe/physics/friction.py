"""Dry friction: a force of constant size against the velocity; at rest it holds the mass up to the same size.

The law of Coulomb; a held mass may stand a larger force than the one against a sliding one (`friction_ratio`). A
sliding mass is a free one under a constant load.
"""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_inline
from vibropipe.physics.contact import CHATTER_TOLERANCE
from vibropipe.physics.frequency import moment_of
from vibropipe.physics.load import NEVER, release_turn, release_wait_of_second
from vibropipe.physics.ramp import wait_from_moment


@jit_inline
def friction_of(e, p):
    """Return the friction; 0 where the effect is absent."""
    friction = 0.0
    if e.friction is not None:
        friction = p.friction
    return friction


@jit_inline
def hold_of(e, p):
    """Return the largest force that holds a mass without velocity; 0 where the effect is absent."""
    hold = 0.0
    if e.friction is not None:
        hold = p.friction_ratio * p.friction
    return hold


@jit_inline
def jumps_at_slip(e, p):
    """Return whether a held mass has an acceleration as soon as it slips."""
    if e.friction is None:
        return False
    return p.friction_ratio > 1.0 and p.friction > 0.0


@jit
def slip_wait(e, p, sigma, pull, turn):
    """Return when the force on a held mass exceeds what holds it.

    sigma : sign of the frame
    pull : the constant part of the force on the mass: the force is sigma F + pull
    turn : phase in turns, or a `Moment`

    Returns the turns until then, from a `Moment` in its unit, NEVER if it does not; and the direction, 1 or -1 in the
    frame.
    """
    if e.forcing is None:
        return NEVER, 1.0
    return _forced_slip_wait(moment_of(turn), e, p, sigma, pull, turn)


@jit_inline
def _forced_slip_wait(moment, e, p, sigma, pull, turn):
    """Return `slip_wait` under a force; moment : `moment_of` the phase, as an argument, which decides the code."""
    hold = hold_of(e, p)
    if moment is not None:
        span = moment.ramp.span - moment.s
        up = wait_from_moment(moment, e, p, sigma, pull - hold, span)
        span = min(span, up * moment.unit)
        down = wait_from_moment(moment, e, p, -sigma, -pull - hold, span)
        return (down, -1.0) if down < up else (up, 1.0)
    wait, direction = NEVER, 1.0
    for way in (1.0, -1.0):
        if e.second_harmonic is not None:
            after = release_wait_of_second(p, way * sigma, way * pull - hold, turn)
            if after < wait:
                wait, direction = after, way
            continue
        release = release_turn(p, way * sigma, way * pull - hold)
        if release == NEVER:
            continue
        after = 0.0
        if release >= 0.0:
            after = release - turn
            after -= math.floor(after)
        if after < wait:
            wait, direction = after, way
    return wait, direction


@jit
def chatter_with_friction(w, press, friction, hold, rate, restitution, h, nu):
    """Return the duration of a chatter on a rigid support against friction; NEVER while it is not a geometric series.

    A hop rises against press + friction and falls under press - friction: friction takes speed in every hop, so that
    hops are a geometric series at R = 1 too. Arguments and tolerance are those of `contact.chatter_duration`; press :
    force that presses the mass on the support, hold : force up to which friction holds it at the top of a hop, rate :
    bound of its rate of change.
    """
    rises, falls = press + friction, press - friction
    if not (press > hold and falls > 0.0):
        return NEVER
    tolerance = CHATTER_TOLERANCE * min(1.0, 1.0 / nu)
    flight = w / rises + w / math.sqrt(rises * falls)
    if flight <= tolerance:
        return flight
    ratio = restitution * math.sqrt(falls / rises)
    if ratio >= 1.0:
        return NEVER
    duration = flight / (1.0 - ratio)
    return duration if duration * (duration * (rate / falls + h)) <= tolerance else NEVER
