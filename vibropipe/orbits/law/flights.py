"""The flights of a law between its events, with their derivatives by parameters."""

from __future__ import annotations

import numpy as np

from vibropipe.compiler import jit, jit_allocating
from vibropipe.march.piece_log import CAUSE, CONTACT, DIRECTION, FORM, HELD, HOME
from vibropipe.orbits.law.law import SECTION, WAY, set_unknowns, width_of
from vibropipe.orbits.law.sliding import carried, carried_by, pull_of, way_of
from vibropipe.orbits.law.states import departure, momentum_after, reference_of, sign_of
from vibropipe.orbits.row import row_parameters
from vibropipe.physics.derivatives import (
    FRICTION,
    H1,
    H2,
    K1,
    K2,
    MASS_RATIO,
    NU,
    F,
    H,
    is_of_second,
    load_derivative,
)
from vibropipe.physics.housing import times_force
from vibropipe.physics.load import constant_load, force_at, forcing_period, unit_force
from vibropipe.physics.piece import (
    Flight,
    acceleration_of,
    by_damping,
    by_frequency,
    by_stiffness,
    flight_over,
    flown,
    force_at_end,
    forced_response,
)
from vibropipe.physics.stiffness import damping_of, stiffness_of
from vibropipe.physics.turns import sincos_turns
from vibropipe.physics.variation import by_force

# Newton's iterations for the time of a turning point, and its last change, relative to 1 forcing period and the time.
MAX_ITERATIONS, SAME_TIME = 30, 1e-15


@jit
def force_on(e, p, law, i, t):
    """Return the `Force` of piece i at a time, in its frame: 1 + kappa times as large where the housing slides."""
    force = force_at(p, sign_of(law.codes[i, HOME]), t, e.second_harmonic)
    if e.housing is not None and law.codes[i, WAY] != 0:
        return times_force(1.0 + p.mass_ratio, force)
    return force


@jit
def flight_of(e, p, law, i, t, turns) -> Flight:
    """Return the `Flight` of piece i, which is not held, over some turns from t."""
    form, home = law.codes[i, FORM], law.codes[i, HOME]
    stiffness, damping = 1.0, p.h
    if e.soft is not None and form == CONTACT:
        stiffness, damping = stiffness + stiffness_of(p, home), damping + damping_of(p, home)
    sigma = sign_of(home)
    load = constant_load(sigma, reference_of(p, home))
    if e.friction is not None:
        load -= p.friction * law.codes[i, DIRECTION]
    if e.housing is not None and law.codes[i, WAY] != 0:
        factor = 1.0 + p.mass_ratio
        load = factor * (load + carried(p, sigma, way_of(law, i)))
        stiffness, damping = factor * stiffness, factor * damping
    force = force_on(e, p, law, i, t)
    return flight_over(stiffness, damping, load, force, p.nu, turns, e.second_harmonic)


@jit
def flown_by(e, p, law, i, flight, start, t, k):
    """Return the derivatives of the end of piece i by parameter k, at a fixed start (y, w), phase and time."""
    if e.housing is not None and law.codes[i, WAY] != 0:
        return flown_beside(e, p, law, i, flight, start, t, k)
    return flown_held(e, p, law, i, flight, start, t, k)


@jit
def flown_beside(e, p, law, i, flight, start, t, k):
    """Return `flown_by` beside a housing that slides."""
    factor, sigma, way = 1.0 + p.mass_ratio, sign_of(law.codes[i, HOME]), way_of(law, i)
    if k == NU:
        return by_frequency(flight)
    if k != MASS_RATIO:
        end, rate = flown_held(e, p, law, i, flight, start, t, k)
        change = factor * carried_by(p, sigma, way, k)
        return factor * end + flight.free.g * change, factor * rate + flight.free.s * change
    # All forces on the mass grow with the factor, the load by sliding with the mass ratio.
    change = flight.load / factor - sigma * pull_of(p, way) / factor
    end, rate = forced_response(flight, flight.force)
    by_k, by_h = by_stiffness(flight, *start), by_damping(flight, *start)
    stiffness, damping = flight.stiffness, flight.damping
    return (
        (end + stiffness * by_k[0] + damping * by_h[0]) / factor + flight.free.g * change,
        (rate + stiffness * by_k[1] + damping * by_h[1]) / factor + flight.free.s * change,
    )


@jit
def flown_held(e, p, law, i, flight, start, t, k):
    """Return `flown_by` but for the factor of forces beside a housing that slides, and what that carries along."""
    form, home = law.codes[i, FORM], law.codes[i, HOME]
    if k == NU:
        return by_frequency(flight)
    in_contact = e.soft is not None and form == CONTACT
    if k == H or (in_contact and k == (H1 if home == 1 else H2)):
        return by_damping(flight, *start)
    if in_contact and k == (K1 if home == 1 else K2):
        return by_stiffness(flight, *start)
    if k == F or is_of_second(k):
        unit = unit_force(p, sign_of(home), *sincos_turns(t), e.second_harmonic)
        return by_force(p, flight, unit, k)
    change = 0.0
    if home > 0:
        change = load_derivative(home, k)
    if e.friction is not None and k == FRICTION:
        change -= law.codes[i, DIRECTION]
    return flight.free.g * change, flight.free.s * change


@jit
def state_within(e, p, law, i, u, time):
    """Return (y, w) on piece i at a time, in its frame."""
    start = departure(e, p, law, i, u)
    if e.friction is not None and law.codes[i, FORM] == HELD:
        return start.y, 0.0
    return flown(flight_of(e, p, law, i, start.t, time - start.t), start.y, start.w)


@jit
def gap_of_piece(e, p, law, i, u, support, time, at_start: bool):
    """Return the gap to a support where piece i turns, near a time or `at_start`, and when it does."""
    start = departure(e, p, law, i, u)
    y = start.y
    if at_start:
        time = start.t
    for _ in range(0 if at_start else MAX_ITERATIONS):
        flight = flight_of(e, p, law, i, start.t, time - start.t)
        y, w = flown(flight, start.y, start.w)
        change = -w / (acceleration_of(flight, force_at_end(flight), y, w) * forcing_period(p))
        time = max(time + change, start.t)
        if not abs(change) > SAME_TIME * (1.0 + abs(time)):
            break
    home = law.codes[i, HOME]
    x = reference_of(p, home) + sign_of(home) * y
    return sign_of(support) * (x - reference_of(p, support)), time


@jit_allocating
def gap_slopes(e, values, along, law, u, i, support, time, at_start: bool, steps):
    """Return the derivatives of `gap_of_piece` by all unknowns, as central differences.

    Arguments as `determinants.fill_slopes`; of all events the gap depends on that which begins the piece.
    """
    n, width = law.codes.shape[0], width_of(e.housing)
    events, slope = np.empty((n, width)), np.zeros(u.size)
    for k in range(u.size):
        if k < width * n and k % n != i:
            continue
        ends = 0.0
        for sign in (1.0, -1.0):
            set_unknowns(values, along, u, events, k, sign * steps[k])
            p = row_parameters(values, 0)
            ends += sign * gap_of_piece(e, p, law, i, events, support, time, at_start)[0]
        slope[k] = ends / (2.0 * steps[k])
    return slope


@jit
def momentum_within(e, p, law, i, u, time) -> float:
    """Return the momentum on piece i, beside a housing that slides, at a time, in its frame."""
    way, start = way_of(law, i), u[i, 0] if law.codes[i, CAUSE] != SECTION else 0.0
    rate = sign_of(law.codes[i, HOME]) * pull_of(p, way)
    return momentum_after(e, p, law, i, u).q + rate * (time - start) * forcing_period(p)
