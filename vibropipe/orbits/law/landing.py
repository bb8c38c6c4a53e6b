"""Where a chatter ends that no event counts: its flights in turn, until what is left is a geometric series."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.piece_log import HOME
from vibropipe.orbits.law.law import WAY
from vibropipe.orbits.law.momentum import momentum_rate
from vibropipe.orbits.law.sliding import carried, way_of
from vibropipe.orbits.law.states import hold_force, momentum_after, sign_of
from vibropipe.physics.contact import support_position
from vibropipe.physics.friction import hold_of
from vibropipe.physics.housing import times_force
from vibropipe.physics.load import constant_load, force_at, forcing_period
from vibropipe.physics.piece import acceleration_of, flight_over, flown, force_at_end

# Relative change of the pressing force over a flight of a chatter from which on the rest is a geometric series, and the
# largest one over the first flight that no event counts, and over later ones, against little more than friction.
SHORT_HOP, LONG_HOP, LONGEST_HOP = 1e-7, 0.3, 1.0
# The most flights of a chatter, and Newton's iterations for the time of one.
MAX_HOPS, MAX_NEWTON = 2000, 20


@jit
def landing_of(e, p, law, i, t, w):
    """Return the time in forcing periods from the departure of a chatter to its end, and how long its first flight is.

    The flights are those of the exact motion until they are so short that the rest is a geometric series. The length
    is the relative change of the force that presses the mass; both are infinite where nothing does.
    """
    home, begin, first = law.codes[i, HOME], t, -1.0
    R, period, factor = (p.R1 if home == 1 else p.R2), forcing_period(p), factor_of(e, p, law, i)
    for _ in range(MAX_HOPS):
        value, _stiffness, rate = hold_force(e, p, law, i, t)
        if not (-value - p.friction > 0.0 and -value > hold_of(e, p)):
            return np.inf, np.inf
        rises, falls = factor * (-value + p.friction), factor * (-value - p.friction)
        up = w / rises
        down = math.sqrt(up * up * rises / falls)
        share = (up + down) * factor * (abs(rate) / period + p.h * rises) / falls
        if first < 0.0:
            first = share
        if share < SHORT_HOP or not w > 0.0:
            # Speeds fall by a constant factor: the arrival is slower than the departure where there is friction.
            slower = R * math.sqrt(falls / rises)
            return (t - begin) + (up + down) / (
                1.0 - slower
            ) / period if slower < 1.0 else np.inf, first
        if share > LONGEST_HOP:
            return np.inf, first
        span, w = hop_of(e, p, law, i, t, w, up, down)
        if not w > 0.0:
            return np.inf, first
        t += span
        w *= R
    return np.inf, first


@jit
def least_slide(e, p, law, i, u, w, landing, share) -> float:
    """Return the least speed over c of a housing that slides through a chatter of speeds from w on.

    Speeds and flights shrink as powers of one factor, but for `share`: the speed of the housing is least before the
    first impact or at the end. landing, share : of `landing_of`
    """
    if not landing < np.inf:
        return -np.inf
    home, way = law.codes[i, HOME], law.codes[i, WAY]
    value, _stiffness, _rate = hold_force(e, p, law, i, u[i, 0])
    factor = (p.R1 if home == 1 else p.R2) * math.sqrt((value + p.friction) / (value - p.friction))
    speed = way * momentum_after(e, p, law, i, u).q
    loss = max(-way * momentum_rate(p, law, i), 0.0) * landing * forcing_period(p)
    return min(speed - (1.0 + share) * (w + loss * (1.0 - factor)), speed - loss)


@jit
def factor_of(e, p, law, i):
    """Return by what a housing that slides in a chatter multiplies all forces: 1 + kappa; 1 without one."""
    if e.housing is not None and law.codes[i, WAY] != 0:
        return 1.0 + p.mass_ratio
    return 1.0


@jit
def hop_of(e, p, law, i, t, w, up, down):
    """Return the duration of a flight of a chatter, in forcing periods, and the speed of its end, 0 if there is none.

    up, down : guesses of the times of its rise and fall.
    """
    home, period = law.codes[i, HOME], forcing_period(p)
    sigma, second = sign_of(home), e.second_harmonic
    load, factor = constant_load(sigma, support_position(p, home)), factor_of(e, p, law, i)
    if e.housing is not None:
        load += carried(p, sigma, way_of(law, i))
    y, speed, total = 0.0, w, 0.0
    for way in (1.0, -1.0):
        # Without friction both parts are one flight.
        is_whole = p.friction == 0.0
        span = up + down if is_whole else up if way > 0.0 else down
        force, pull = force_at(p, sigma, t + total, second), factor * (load - way * p.friction)
        if e.housing is not None:
            force = times_force(factor, force)
        for _ in range(MAX_NEWTON):
            flight = flight_over(factor, factor * p.h, pull, force, p.nu, span / period, second)
            end, rate = flown(flight, y, speed)
            change = acceleration_of(flight, force_at_end(flight), end, rate)
            step = rate / change
            if is_whole or way < 0.0:
                # The gap over the time, whose root at 0 is the start.
                step = end / rate if not is_whole else end * span / (rate * span - end)
            span -= step
            if abs(step) <= 1e-15 * abs(span):
                break
        flight = flight_over(factor, factor * p.h, pull, force, p.nu, span / period, second)
        y, speed = flown(flight, y, speed)
        total += span / period
        if is_whole:
            break
    return total, -speed
