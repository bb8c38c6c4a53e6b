"""Derivatives of Floquet multipliers by the parameters: the product of transfers, differentiated.

tr(B_n ... B_1) changes by the sum of tr(W_j dB_j) over the flights, W_j the product of all transfers but B_j, from
j + 1 round to j - 1. The determinant exp(-h m T) prod R^2 is explicit, and mu^2 - tr mu + det = 0.
"""

from __future__ import annotations

import math

from vibropipe.compiler import jit_inline
from vibropipe.physics.contact import restitution_at
from vibropipe.physics.derivatives import (
    NU,
    H,
    distance_derivative,
    gap_acceleration_derivative,
    n_parameters,
    restitution_derivative,
)
from vibropipe.physics.impulse import free_flow_by_h
from vibropipe.physics.load import forcing_period
from vibropipe.physics.quotient import divide
from vibropipe.physics.saltation import eigenvalues_of, product
from vibropipe.physics.variation import BY_W, BY_Y

# Share of the larger multiplier below which the difference of both is rounding: their derivative is infinite there.
DOUBLE = 1e-7


@jit_inline
def transfer_in_tau(p, flights, j):
    """Return the elements of the transfer of flight j, by times in tau in place of phases."""
    period, t = forcing_period(p), flights.transfer[j]
    return t[0], t[1] * period, t[2] / period, t[3]


@jit_inline
def add_trace_derivative(p, flights, j, others, slopes, second) -> None:
    """Add what flight j contributes to the derivatives of the trace.

    flights : filled by `vary_orbit`; none released
    others : tuple of 4 floats, product of the transfers of all other flights, from j + 1 round to j - 1
    slopes : (parameters,), increased
    second : the effect `second_harmonic`
    """
    home, start, end, w0 = flights.home[j], flights.start[j], flights.end[j], flights.departure[j]
    i = j - 1 if j > 0 else flights.speed.size - 1
    lands_home, r, period = flights.support[j] == home, restitution_at(p, home), forcing_period(p)
    sign = -1.0 if lands_home else 1.0
    w1 = sign * flights.speed[j]
    a0, a1 = flights.at_start[j, 0], flights.at_end[j, 0]
    ends = flights.ends[j]
    e11, e12, e21, e22 = ends[0, BY_Y], ends[0, BY_W], ends[1, BY_Y], ends[1, BY_W]
    h11, h12, h21, h22 = free_flow_by_h(p.h, (end - start) * period)
    b11, b12 = (e11 * w0 + e12 * a0) / w1, -r * e12 / w1
    for k in range(n_parameters(second)):
        dt = (flights.d_end[j, k] - flights.d_start[j, k]) * period
        if k == NU:
            dt -= (end - start) * period / p.nu
        by_h = 1.0 if k == H else 0.0
        f11, f12 = e21 * dt + by_h * h11, e22 * dt + by_h * h12
        f21, f22 = by_h * h21 - (e11 + p.h * e21) * dt, by_h * h22 - (e12 + p.h * e22) * dt
        dr = restitution_derivative(home, k)
        dw0 = r * flights.d_speed[i, k] + dr * flights.speed[i]
        dw1 = sign * flights.d_speed[j, k]
        da0 = gap_acceleration_derivative(p, home, start, w0, k, second) - p.h * dw0
        da0 += flights.at_start[j, 1] * flights.d_start[j, k]
        da1 = gap_acceleration_derivative(p, home, end, w1, k, second) - p.h * dw1
        da1 += flights.at_end[j, 1] * flights.d_end[j, k]
        if not lands_home:
            da1 -= distance_derivative(k)
        d11 = (f11 * w0 + e11 * dw0 + f12 * a0 + e12 * da0 - b11 * dw1) / w1
        d12 = -(dr * e12 + r * f12 + b12 * dw1) / w1
        d21 = da1 * b11 + a1 * d11 - (f21 * w0 + e21 * dw0 + f22 * a0 + e22 * da0)
        d22 = da1 * b12 + a1 * d12 + dr * e22 + r * f22
        slopes[k] += others[0] * d11 + others[2] * d12
        slopes[k] += sign * (others[1] * d21 + others[3] * d22)


@jit_inline
def fill_trace_derivatives(p, flights, slopes, second):
    """Fill the derivatives of the trace of the return map's derivative (parameters,), and return the trace."""
    n = flights.speed.size
    for k in range(n_parameters(second)):
        slopes[k] = 0.0
    m11, m12, m21, m22 = 1.0, 0.0, 0.0, 1.0
    for j in range(n):
        before = flights.before[j]
        before[0], before[1], before[2], before[3] = m11, m12, m21, m22
        b = transfer_in_tau(p, flights, j)
        m11, m12, m21, m22 = product(b[0], b[1], b[2], b[3], m11, m12, m21, m22)
    trace = m11 + m22
    m11, m12, m21, m22 = 1.0, 0.0, 0.0, 1.0
    for j in range(n - 1, -1, -1):
        before = flights.before[j]
        others = product(before[0], before[1], before[2], before[3], m11, m12, m21, m22)
        add_trace_derivative(p, flights, j, others, slopes, second)
        b = transfer_in_tau(p, flights, j)
        m11, m12, m21, m22 = product(m11, m12, m21, m22, b[0], b[1], b[2], b[3])
    return trace


@jit_inline
def determinant_and_derivative(p, m, flights, k):
    """Return the determinant exp(-h m T) prod R^2 of the return map's derivative, and its derivative by parameter k."""
    span = m * forcing_period(p)
    size, slope = math.exp(-p.h * span), 0.0
    if k == H:
        slope = -span * size
    elif k == NU:
        slope = p.h * span / p.nu * size
    for j in range(flights.speed.size):
        r, dr = restitution_at(p, flights.support[j]), restitution_derivative(flights.support[j], k)
        slope = slope * r * r + size * 2.0 * r * dr
        size *= r * r
    return size, slope


@jit_inline
def fill_multipliers(p, m, flights, slopes, values, derivatives, second) -> None:
    """Fill both multipliers of an orbit, the larger first, and their derivatives: (2,) and (2, parameters) complex.

    Zero with a rest; derivatives are NaN where both multipliers are equal. slopes (parameters,) is work space.
    """
    for j in range(flights.speed.size):
        if flights.released[j] == 1:
            values[:] = 0.0
            derivatives[:] = 0.0
            return
    trace = fill_trace_derivatives(p, flights, slopes, second)
    determinant, _slope = determinant_and_derivative(p, m, flights, 0)
    first, other = eigenvalues_of(trace, determinant)
    values[0], values[1] = first, other
    difference = first - other
    if not abs(difference) > DOUBLE * abs(first):
        difference = complex(math.nan, math.nan)
    share = divide(complex(1.0, 0.0), difference)
    for k in range(n_parameters(second)):
        _size, slope = determinant_and_derivative(p, m, flights, k)
        derivatives[0, k] = (first * slopes[k] - slope) * share
        derivatives[1, k] = (slope - other * slopes[k]) * share
