"""Derivatives of the impacts of an orbit by the parameters, from the implicit function theorem.

A flight that leaves a support at the phase t0 with the speed R u0 ends with the next impact, at the phase t1 and with
the speed u1. The derivative of (t1, u1) is that by (t0, u0), the transfer of the flight, times the derivative of
(t0, u0), plus a source for each parameter at fixed (t0, u0). Along an orbit they add up to
(I - M) d(t, u) = source, M the product of all transfers, which has the eigenvalues of the return map's derivative.
After a rest a flight begins at the release, whose phase depends on the parameters alone: its transfer is 0.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit_allocating, jit_inline
from vibropipe.physics.contact import restitution_at, support_position
from vibropipe.physics.derivatives import (
    distance_derivative,
    gap_acceleration_derivative,
    n_parameters,
    restitution_derivative,
)
from vibropipe.physics.load import (
    constant_load,
    force_of_angle,
    force_slope,
    force_value,
    forcing_period,
)
from vibropipe.physics.saltation import product
from vibropipe.physics.turns import TWO_PI, sincos_turns
from vibropipe.physics.variation import BY_W, BY_Y, by_parameter, n_variations, vary_flight

# Share of 1 + |trace| + |determinant| of M below which det(I - M) is rounding: at a fold or a pitchfork, or where the
# orbit is not isolated.
SINGULAR = 1e-11


class Contacts(NamedTuple):
    """Contacts of an orbit, from 0 to m turns.

    position, velocity, support : (n,), impacts in the order in which they are stored: time in turns, velocity before,
        support
    releases : (2,), phase of the release from each support, NaN without a rest
    """

    position: np.ndarray
    velocity: np.ndarray
    support: np.ndarray
    releases: np.ndarray


class Flights(NamedTuple):
    """The flights of an orbit, each with the impact that ends it, in the order in which impacts are stored.

    Derivatives are by `n_parameters` and `n_variations`.

    home, support : (n,) int, support that is left, and support that is struck
    start, end : (n,), phases in turns; end is the phase of the impact, in [0, m)
    departure, speed : (n,), speed at the start, and of the impact
    released : (n,) int, 1 if the flight begins with the release from a rest
    at_start, at_end : (n, 2), acceleration of the distance from `home`, and its derivative by the phase through the
        force
    transfer : (n, 4), derivative of (end, speed) by those of the impact before
    source : (n, 2, parameters), derivative of (end, speed) by the parameters at a fixed impact before
    d_start, d_end, d_speed : (n, parameters), derivatives along the orbit; d_start of a released flight is that of its
        release
    ends : (n, 2, variations), variations at the ends of flights (`vary_flight`)
    before : (n, 4), products of the transfers of all flights before
    """

    home: np.ndarray
    support: np.ndarray
    start: np.ndarray
    end: np.ndarray
    departure: np.ndarray
    speed: np.ndarray
    released: np.ndarray
    at_start: np.ndarray
    at_end: np.ndarray
    transfer: np.ndarray
    source: np.ndarray
    d_start: np.ndarray
    d_end: np.ndarray
    d_speed: np.ndarray
    ends: np.ndarray
    before: np.ndarray


@jit_allocating
def new_flights(n, second):
    """Return `Flights` of n impacts, not filled; second : int or None, the effect `second_harmonic`."""
    by = n_parameters(second)
    return Flights(
        np.empty(n, np.int64), np.empty(n, np.int64), np.empty(n), np.empty(n), np.empty(n),
        np.empty(n), np.empty(n, np.int64), np.empty((n, 2)), np.empty((n, 2)), np.empty((n, 4)),
        np.empty((n, 2, by)), np.empty((n, by)), np.empty((n, by)), np.empty((n, by)),
        np.empty((n, 2, n_variations(second))), np.empty((n, 4)),
    )  # fmt: skip


@jit_inline
def first_flights(flights, n):
    """Return views of the first n flights."""
    return Flights(
        flights.home[:n], flights.support[:n], flights.start[:n], flights.end[:n],
        flights.departure[:n], flights.speed[:n], flights.released[:n], flights.at_start[:n],
        flights.at_end[:n], flights.transfer[:n], flights.source[:n], flights.d_start[:n],
        flights.d_end[:n], flights.d_speed[:n], flights.ends[:n], flights.before[:n],
    )  # fmt: skip


@jit_inline
def fill_flights(p, contacts, m, flights) -> bool:
    """Fill what is known of the flights of an orbit of m periods from its contacts.

    Returns False if a rest is followed by no impact of its own.
    """
    n = flights.speed.size
    for j in range(n):
        i = j - 1 if j > 0 else n - 1
        flights.support[j], flights.home[j] = contacts.support[j], contacts.support[i]
        flights.end[j], flights.speed[j] = contacts.position[j], abs(contacts.velocity[j])
        flights.start[j] = contacts.position[i] - (0 if j > 0 else m)
        restitution = restitution_at(p, flights.home[j])
        flights.departure[j] = restitution * abs(contacts.velocity[i])
        flights.released[j] = 0
    for side in range(2):
        release, j = contacts.releases[side], 0
        if math.isnan(release):
            continue
        while j < n and flights.end[j] < release:
            j += 1
        if j == n:
            # The flight of a release after the last impact ends with the first one, m turns later.
            j, release = 0, release - m
        if flights.released[j] == 1 or flights.home[j] != side + 1:
            return False
        flights.released[j] = 1
        flights.start[j], flights.departure[j] = release, 0.0
    return True


@jit_inline
def fill_transfer(p, flights, j, sine, cosine, second):
    """Fill transfer and source of flight j; take sine and cosine of the phase of its start, return those of its end."""
    home, start, w0 = flights.home[j], flights.start[j], flights.departure[j]
    end, released, ends = flights.end[j], flights.released[j] == 1, flights.ends[j]
    vary_flight(p, home, sine, cosine, end - start, w0, ends, second)
    period, lands_home = forcing_period(p), flights.support[j] == home
    sign = -1.0 if lands_home else 1.0
    w1 = sign * flights.speed[j]
    sigma = -1.0 if home == 1 else 1.0
    load = constant_load(sigma, support_position(p, home))
    force = force_of_angle(p, sigma, sine, cosine, second)
    a0 = 0.0 if released else force_value(force, second) + load - p.h * w0
    flights.at_start[j, 0], flights.at_start[j, 1] = a0, TWO_PI * force_slope(force, second)
    sine, cosine = sincos_turns(end)
    force = force_of_angle(p, sigma, sine, cosine, second)
    a1 = force_value(force, second) + load - p.h * w1 - (0.0 if lands_home else 2.0 * p.l)
    flights.at_end[j, 0], flights.at_end[j, 1] = a1, TWO_PI * force_slope(force, second)
    restitution, before = 0.0, 0.0
    if not released:
        restitution = restitution_at(p, home)
        before = flights.speed[j - 1 if j > 0 else flights.speed.size - 1]
    by_time_y = ends[0, BY_Y] * w0 + ends[0, BY_W] * a0
    by_time_w = ends[1, BY_Y] * w0 + ends[1, BY_W] * a0
    transfer, share = flights.transfer[j], 1.0 / (w1 * period)
    transfer[0] = by_time_y / w1
    transfer[1] = -restitution * ends[0, BY_W] * share
    transfer[2] = sign * (-by_time_w + a1 * transfer[0]) * period
    transfer[3] = sign * (restitution * ends[1, BY_W] + a1 * period * transfer[1])
    for k in range(n_parameters(second)):
        d_departure = before * restitution_derivative(home, k)
        target = 0.0 if lands_home else distance_derivative(k)
        y = by_parameter(home, ends, 0, k) + ends[0, BY_W] * d_departure
        d_end = (target - y) * share
        w = by_parameter(home, ends, 1, k) + ends[1, BY_W] * d_departure
        flights.source[j, 0, k] = d_end
        flights.source[j, 1, k] = sign * (w + a1 * period * d_end)
    return sine, cosine


@jit_inline
def follow_derivatives(flights, second, again=False) -> None:
    """Follow the derivatives of the last impact along the orbit, to the last impact again.

    What follows a release does not depend on the last impact: `again`, after a first time, ends there.
    """
    # A loop of a length that the compiler does not know is vectorised, not unrolled.
    n, parameters = flights.d_end.shape
    for j in range(n):
        if again and flights.released[j] == 1:
            return
        i = j - 1 if j > 0 else n - 1
        t = flights.transfer[j]
        t11, t12, t21, t22 = t[0], t[1], t[2], t[3]
        if flights.released[j] == 0:
            for k in range(n_parameters(second)):
                flights.d_start[j, k] = flights.d_end[i, k]
        for k in range(parameters):
            turn, speed = flights.d_end[i, k], flights.d_speed[i, k]
            flights.d_end[j, k] = t11 * turn + t12 * speed + flights.source[j, 0, k]
            flights.d_speed[j, k] = t21 * turn + t22 * speed + flights.source[j, 1, k]


@jit_inline
def vary_orbit(p, contacts, m, flights, second) -> bool:
    """Fill the derivatives of the impacts of an orbit.

    contacts : of the orbit, with an impact at least
    flights : filled
    second : the effect `second_harmonic`

    Returns whether the orbit is isolated and smooth in the parameters; if not, the derivatives are meaningless.

    Reference: R. I. Leine, H. Nijmeijer, "Dynamics and Bifurcations of Non-Smooth Mechanical Systems", Springer (2004),
    ch. 7-9.
    """
    n = flights.speed.size
    if not fill_flights(p, contacts, m, flights):
        return False
    m11, m12, m21, m22 = 1.0, 0.0, 0.0, 1.0
    sine, cosine = sincos_turns(flights.start[0])
    for j in range(n):
        if flights.released[j] == 1:
            sine, cosine = sincos_turns(flights.start[j])
        sine, cosine = fill_transfer(p, flights, j, sine, cosine, second)
        if flights.released[j] == 1:
            # The gap acceleration stays zero at the release.
            jerk = flights.at_start[j, 1]
            home, start = flights.home[j], flights.start[j]
            for k in range(n_parameters(second)):
                change = gap_acceleration_derivative(p, home, start, 0.0, k, second)
                flights.d_start[j, k] = -change / jerk
        t = flights.transfer[j]
        m11, m12, m21, m22 = product(t[0], t[1], t[2], t[3], m11, m12, m21, m22)
    determinant = (1.0 - m11) * (1.0 - m22) - m12 * m21
    scale = 1.0 + abs(m11 + m22) + abs(m11 * m22 - m12 * m21)
    if not abs(determinant) > SINGULAR * scale:
        return False
    last = n - 1
    for k in range(n_parameters(second)):
        flights.d_end[last, k] = flights.d_speed[last, k] = 0.0
    follow_derivatives(flights, second)
    for k in range(n_parameters(second)):
        turn, speed = flights.d_end[last, k], flights.d_speed[last, k]
        flights.d_end[last, k] = ((1.0 - m22) * turn + m12 * speed) / determinant
        flights.d_speed[last, k] = (m21 * turn + (1.0 - m11) * speed) / determinant
    follow_derivatives(flights, second, again=True)
    total = 0.0
    for k in range(n_parameters(second)):
        total += abs(flights.d_end[last, k]) + abs(flights.d_speed[last, k])
    return total < math.inf
