"""Derivatives of a flight between rigid supports by its start and by the parameters, in closed form.

In the frame y = sigma (x - x_ref) of a support, eq. (5) reads y'' + h y' + y = load + sigma f sin(nu tau). Times are
phases, in turns: derivatives are at fixed phases, so a flight takes less time in tau as nu grows. They are those of
`physics.piece`. A further parameter of the force adds a column with its source.
"""

from __future__ import annotations

from vibropipe.compiler import jit, jit_inline
from vibropipe.physics.contact import support_position
from vibropipe.physics.derivatives import F2, NU, PHI2, F, H, load_derivative
from vibropipe.physics.load import constant_load, force_by_phase, force_of_angle, unit_force
from vibropipe.physics.piece import (
    acceleration_of,
    by_damping,
    by_frequency,
    flight_over,
    flown,
    force_at_end,
    harmonic_response,
)

# Variations of a flight: by its displacement and velocity at the start, by a constant load, and by parameters; the last
# two with a second harmonic only.
BY_Y, BY_W, BY_LOAD, BY_NU, BY_H, BY_F, BY_F2, BY_PHI2 = range(8)
VARIATIONS, WITH_SECOND = 6, 8


@jit_inline
def n_variations(second):
    """Return the number of variations; second : int or None, the effect `second_harmonic`."""
    return VARIATIONS if second is None else WITH_SECOND


@jit
def flight_from(p, support, sine, cosine, turns, second=None):
    """Return the `Flight` of some turns that leaves a rigid support at the phase of a sine and a cosine."""
    sigma = -1.0 if support == 1 else 1.0
    load = constant_load(sigma, support_position(p, support))
    force = force_of_angle(p, sigma, sine, cosine, second)
    return flight_over(1.0, p.h, load, force, p.nu, turns, second)


@jit
def by_force(p, flight, unit, k):
    """Return the derivative of the end of a piece by f, f2 or phi2, its start and its time held.

    unit : `unit_force` at its start
    """
    if k == F:
        return harmonic_response(flight, flight.first, p.nu, unit.sine, unit.cosine)
    sine, cosine = unit.sine_2, unit.cosine_2
    if k == PHI2:
        sine, cosine = force_by_phase(p, unit), -p.f2 * unit.sine_2
    return harmonic_response(
        flight, flight.second, 2.0 * p.nu, sine, cosine, flight.second_harmonic
    )


@jit
def vary_flight(p, support, sine, cosine, turns, w, ends, second=None):
    """Fill the variations at the end of a flight that leaves a support.

    support : 1 or 2
    sine, cosine : of the phase of the start
    turns : its length, in forcing periods
    w : rate of the distance from the support at the start
    ends : (2, variations), derivatives of distance and rate at the end: by those at the start, by a constant load, and
        by nu, h, f, f2 and phi2 at fixed phases
    second : the effect `second_harmonic`

    Returns distance and rate at the end.
    """
    flight = flight_from(p, support, sine, cosine, turns, second)
    free, per_nu = flight.free, flight.t / p.nu
    ends[0, BY_Y], ends[0, BY_W], ends[1, BY_Y], ends[1, BY_W] = free.c, free.s, -free.s, free.ds
    ends[0, BY_LOAD], ends[1, BY_LOAD] = free.g, free.s
    ends[0, BY_H], ends[1, BY_H] = by_damping(flight, 0.0, w)
    end, rate = flown(flight, 0.0, w)
    later, faster = by_frequency(flight)
    ends[0, BY_NU] = later - per_nu * rate
    ends[1, BY_NU] = faster - per_nu * acceleration_of(flight, force_at_end(flight), end, rate)
    unit = unit_force(p, -1.0 if support == 1 else 1.0, sine, cosine, second)
    ends[0, BY_F], ends[1, BY_F] = by_force(p, flight, unit, F)
    if second is not None:
        ends[0, BY_F2], ends[1, BY_F2] = by_force(p, flight, unit, F2)
        ends[0, BY_PHI2], ends[1, BY_PHI2] = by_force(p, flight, unit, PHI2)
    return end, rate


@jit
def by_parameter(support, ends, part, k):
    """Return the derivative by parameter k of a variation: ends[part] summed over what k changes in the flight.

    support : the support that the flight leaves
    ends : (2, variations), of `vary_flight`
    part : 0 for the distance, 1 for its rate
    """
    total = load_derivative(support, k) * ends[part, BY_LOAD]
    if k == NU:
        total += ends[part, BY_NU]
    elif k == H:
        total += ends[part, BY_H]
    elif k == F:
        total += ends[part, BY_F]
    elif k == F2:
        total += ends[part, BY_F2]
    elif k == PHI2:
        total += ends[part, BY_PHI2]
    return total
