"""Errors along a motion from impact to impact: rounding of each flight, and the uncertainty of every parameter.

The error of an impact, of its phase and speed, follows the transfer of the next flight (`orbits.sensitivity.flights`),
which adds its own. Roundings are independent: their covariance is followed. A parameter is off by the same amount in
every flight: its derivative is followed. Without rests, and while errors are so small that they stay linear. Where the
impacts of a motion repeat, its errors soon do so too.
"""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline
from vibropipe.orbits.sensitivity.errors import ULP
from vibropipe.orbits.sensitivity.flights import fill_transfer, new_flights
from vibropipe.physics.contact import restitution_at, support_position
from vibropipe.physics.derivatives import n_parameters
from vibropipe.physics.load import (
    constant_load,
    force_at,
    force_value,
    forcing_period,
    largest_force,
)
from vibropipe.physics.turns import sincos_turns

# Rows of the errors of impacts: of tau, of the speeds before and after, and of the state that leaves it,
# sqrt(dx^2 + dx'^2), which no flight increases. Standard deviations of the roundings that they cover.
DELAY, SPEED, AFTER, LEAVING = range(4)
ERRORS, COVERED = 4, 2.0
# How closely impacts repeat.
SAME = 1e-6
# Largest number of impacts that repeat, repetitions along which errors are followed first, and the largest share of an
# error that its last change makes if it goes on.
MAX_LAG, FIRST_REPETITIONS, GOES_ON = 32, 8, 0.1
# Share of the rounding of a phase in turns that is within a step; growth of the rounding of a flight per unit of tau.
IN_STEP, PER_TAU = 0.25, 0.1
# Growth of a rounding by a second harmonic, which turns twice as fast, from a phase of its own.
SECOND = 1.5


@jit_inline
def parameter_of(p, k):
    """Return the value of a parameter by its number in derivatives."""
    return (p.nu, p.f, p.h, p.l, p.delta, p.R1, p.R2, p.load, p.f2, p.phi2)[k]


@jit_inline
def acceleration_at(p, support, position, velocity, second):
    """Return x'' at a support for a velocity, at a position in turns."""
    sigma = -1.0 if support == 1 else 1.0
    load = constant_load(sigma, support_position(p, support))
    push = force_value(force_at(p, sigma, position, second), second) + load
    return sigma * push - p.h * velocity


@jit
def longer_by(p, t):
    """Return how many times the rounding of a step a flight of the length t rounds: all steps have the same matrix.

    With damping, what was rounded longer ago than twice 2/h + h, in which both parts of a motion decay by e, is gone.
    """
    kept = min(t, 2.0 * (2.0 / p.h + p.h)) if p.h > 0.0 else t
    return 1.0 + PER_TAU * kept * max(1.0, p.nu)


@jit_inline
def rounding_of(p, flights, j, second):
    """Return the standard deviations of phase and speed of the impact that ends flight j, by its own rounding.

    As `errors.fill_record` for orbits; but a march rounds a phase in its step alone, and a long flight in many steps.
    """
    home, start, end = flights.home[j], flights.start[j], flights.end[j]
    period, w0, u1 = forcing_period(p), flights.departure[j], flights.speed[j]
    t = (end - start) * period
    far = 0.0 if flights.support[j] == home else 2.0 * p.l
    push = abs(support_position(p, home)) + largest_force(p) + far
    turned = 1.0 if second is None else SECOND
    short, longer = min(1.0, t), turned * ULP * longer_by(p, t)
    height = far + t * (w0 + u1) + short * short * push
    of_phase = IN_STEP * (1.0 + start + end) + height / (u1 * period)
    of_speed = w0 + u1 + short * push + height * abs(flights.at_end[j, 0]) / u1
    return longer * of_phase, longer * of_speed


@jit_allocating
def follow_errors(p, first, position, velocity, support, out, second) -> float:
    """Follow errors from the first impact of a motion to its last.

    first : error of displacement and of velocity, independent, of the state that meets the first impact
    position, velocity, support : (n,), impacts: time in turns, velocity before, and support
    out : (ERRORS, n or more), errors of each impact
    second : the effect `second_harmonic`

    Returns the largest of delays and speeds, without what is rounded when a speed is written.
    """
    period, by = forcing_period(p), n_parameters(second)
    flights = new_flights(2, second)
    sine, cosine = 0.0, 1.0
    d_turn, d_speed = np.zeros(by), np.zeros(by)
    tt, tu, uu, largest = 0.0, 0.0, 0.0, 0.0
    for i in range(position.size):
        u = abs(velocity[i])
        if i == 0:
            a = acceleration_at(p, support[0], position[0], velocity[0], second)
            slip = a / velocity[0]
            tt = (first / (u * period)) ** 2
            uu = first * first * (1.0 + slip * slip)
            tu = slip * period * u * tt
        else:
            whole = math.floor(position[i - 1])
            start, end = position[i - 1] - whole, position[i] - whole
            flights.home[1], flights.support[1] = support[i - 1], support[i]
            flights.start[1], flights.end[1] = start, end
            flights.speed[0], flights.speed[1] = abs(velocity[i - 1]), u
            flights.departure[1] = restitution_at(p, support[i - 1]) * flights.speed[0]
            flights.released[1] = 0
            if i == 1:
                sine, cosine = sincos_turns(start)
            sine, cosine = fill_transfer(p, flights, 1, sine, cosine, second)
            t, (of_phase, of_speed) = flights.transfer[1], rounding_of(p, flights, 1, second)
            new_tt = t[0] * t[0] * tt + 2.0 * t[0] * t[1] * tu + t[1] * t[1] * uu
            new_tu = t[0] * t[2] * tt + (t[0] * t[3] + t[1] * t[2]) * tu + t[1] * t[3] * uu
            new_uu = t[2] * t[2] * tt + 2.0 * t[2] * t[3] * tu + t[3] * t[3] * uu
            tt, tu, uu = new_tt + of_phase * of_phase, new_tu, new_uu + of_speed * of_speed
            for k in range(by):
                turn, speed = d_turn[k], d_speed[k]
                d_turn[k] = t[0] * turn + t[1] * speed + flights.source[1, 0, k]
                d_speed[k] = t[2] * turn + t[3] * speed + flights.source[1, 1, k]
        by_turn, by_speed = 0.0, 0.0
        for k in range(by):
            off = 0.5 * ULP * abs(parameter_of(p, k))
            by_turn, by_speed = by_turn + off * abs(d_turn[k]), by_speed + off * abs(d_speed[k])
        turn, change = math.sqrt(max(tt, 0.0)), math.sqrt(max(uu, 0.0))
        r = restitution_at(p, support[i])
        after = -r * velocity[i]
        a = acceleration_at(p, support[i], position[i], after, second)
        delay = (turn + by_turn) * period
        speed = r * (change + by_speed) + abs(a) * delay
        out[LEAVING, i] = COVERED * math.sqrt((after * delay) ** 2 + speed * speed)
        delay, speed = (COVERED * turn + by_turn) * period, COVERED * change + by_speed
        largest = max(largest, delay, speed)
        out[DELAY, i], out[SPEED, i], out[AFTER, i] = delay, speed + ULP * u, r * speed + ULP * u
    return largest


@jit_allocating
def follow_repeated(p, first, position, velocity, support, out, second) -> float:
    """Follow errors as `follow_errors`, where impacts repeat only until the errors repeat too."""
    n, followed, lag = velocity.size, velocity.size, 0
    for k in range(1, min(MAX_LAG, n // FIRST_REPETITIONS) + 1):
        if repeats_from(position[-2 * k :], velocity[-2 * k :], k) == 0:
            lag = k
            followed = repeats_from(position, velocity, lag) + FIRST_REPETITIONS * lag
            break
    while followed < n:
        part = slice(0, followed)
        largest = follow_errors(
            p, first, position[part], velocity[part], support[part], out, second
        )
        is_settled = True
        for k in range(ERRORS):
            for i in range(followed - lag, followed):
                goes_on = (n - followed) / lag * abs(out[k, i] - out[k, i - lag])
                is_settled = is_settled and goes_on <= GOES_ON * out[k, i]
        if is_settled:
            for k in range(ERRORS):
                for j in range(followed - lag, followed):
                    out[k, j + lag : n : lag] = out[k, j]
            return largest
        followed *= 2
    return follow_errors(p, first, position, velocity, support, out, second)


@jit
def repeats_from(position, velocity, lag) -> int:
    """Return the first impact from which on all repeat `lag` impacts later, a whole number of turns; n if not the last.

    position, velocity : (n,), as for `follow_errors`.
    """
    n, first = velocity.size, velocity.size
    turns = math.floor(position[n - 1] - position[n - 1 - lag] + 0.5)
    for i in range(n - lag - 1, -1, -1):
        moved = abs(velocity[i + lag] - velocity[i])
        late = abs(position[i + lag] - position[i] - turns)
        if not (moved <= SAME * abs(velocity[i]) and late <= SAME):
            break
        first = i
    return first
