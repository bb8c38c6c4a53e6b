"""Derivatives of Fourier amplitudes by the parameters: the closed form of `orbits.harmonics`, differentiated."""

from __future__ import annotations

import math
from typing import NamedTuple

from vibropipe.compiler import jit, jit_inline
from vibropipe.orbits.forces import NODES, WEIGHTS
from vibropipe.orbits.harmonics import RESONANT, dynamic_stiffness
from vibropipe.physics.contact import restitution_at, support_position
from vibropipe.physics.derivatives import (
    NU,
    F,
    H,
    gap_acceleration,
    gap_acceleration_derivative,
    is_of_second,
    n_parameters,
    restitution_derivative,
    support_derivative,
)
from vibropipe.physics.flow import fastest_rate
from vibropipe.physics.load import fastest_forcing, force_at, force_slope, forcing_period
from vibropipe.physics.load_harmonics import (
    force_amplitude_derivative,
    reaction_difference,
    reaction_integral,
    reaction_of_second,
    second_amplitude_derivative,
    with_force,
)
from vibropipe.physics.quotient import divide
from vibropipe.physics.turns import TWO_PI, phase_factor, phase_integral, sincos_turns
from vibropipe.physics.variation import BY_W, BY_Y, by_parameter, n_variations, vary_flight

# Largest product of a rate and an interval of the quadrature, which is then exact to rounding.
REACH = 1.0


class Chatter(NamedTuple):
    """The chatter between an impact and a rest.

    restitution, departure : of the support; speed after the impact
    push, slope : acceleration towards the support, and the derivative of the force by the phase
    duration : in turns, from the impact to the start of the rest
    impulse : of all further impacts, away from the support
    """

    restitution: float
    departure: float
    push: float
    slope: float
    duration: float
    impulse: float


@jit_inline
def chatter_after(p, support, turn, speed, second):
    """Return the `Chatter` after an impact at a phase, in turns, with a speed."""
    sigma, r = -1.0 if support == 1 else 1.0, restitution_at(p, support)
    w, lost = r * speed, 1.0 - r
    if w == 0.0 or r >= 1.0:
        return Chatter(r, w, 0.0, 0.0, 0.0, w)
    g = -gap_acceleration(p, support, turn, 0.0, w, second)
    slope = TWO_PI * force_slope(force_at(p, sigma, turn, second), second)
    duration = 2.0 * w / (g * lost * forcing_period(p))
    return Chatter(r, w, g, slope, duration, w * (1.0 + r) / lost)


@jit_inline
def chatter_derivatives(p, chatter, support, turn, speed, d_turn, d_speed, k, second):
    """Return the derivatives of duration and impulse of a chatter by parameter k, from those of its impact."""
    r, w, g = chatter.restitution, chatter.departure, chatter.push
    dr = restitution_derivative(support, k)
    dw, lost = r * d_speed + dr * speed, 1.0 - r
    if w == 0.0:
        return 0.0, 0.0
    if r >= 1.0:
        return 0.0, dw
    by_gap = gap_acceleration_derivative(p, support, turn, w, k, second)
    dg = p.h * dw - by_gap - chatter.slope * d_turn
    d_duration = 2.0 * (dw - w * dg / g + w * dr / lost) / (g * lost * forcing_period(p))
    if k == NU:
        d_duration += chatter.duration / p.nu
    return d_duration, (dw * (1.0 + r) + 2.0 * w * dr / lost) / lost


@jit_inline
def add_impulse(p, impulse, turn, m, changes, total, d_total) -> None:
    """Add an impulse and its derivatives to the sums at the frequencies k nu/m.

    impulse, turn : change of x', and phase
    m : denominator of the frequencies
    changes : (3, parameters), derivatives of impulse and phase
    total : (harmonics + 1,) complex, increased as by `orbits.harmonics.add_support_forces`
    d_total : (harmonics + 1, 2, parameters), increased by the derivatives, real and imaginary parts apart
    """
    rotation, power = phase_factor(turn / m), complex(1.0, 0.0)
    share = p.nu / TWO_PI
    # A loop of a length that the compiler does not know is vectorised, not unrolled.
    parameters = d_total.shape[2]
    for q in range(total.size):
        total[q] += impulse * share * power
        turned = -impulse * p.nu * q / m
        for k in range(parameters):
            change, lag = changes[0, k] * share, turned * changes[1, k]
            d_total[q, 0, k] += change * power.real - lag * power.imag
            d_total[q, 1, k] += change * power.imag + lag * power.real
        d_total[q, 0, NU] += impulse / TWO_PI * power.real
        d_total[q, 1, NU] += impulse / TWO_PI * power.imag
        power *= rotation


@jit_inline
def start_of_rest(flights, j, m):
    """Return the impact before the rest that ends with flight j, and its phase before that."""
    i = j - 1 if j > 0 else flights.speed.size - 1
    return i, flights.end[i] - (m if j == 0 else 0)


@jit_inline
def add_rest(p, length, flights, j, m, changes, total, d_total, second) -> None:
    """Add chatter and rest before a released flight, and their derivatives, to the sums at k nu/m."""
    support, release = flights.home[j], flights.start[j]
    i, turn = start_of_rest(flights, j, length)
    sigma, speed = -1.0 if support == 1 else 1.0, flights.speed[i]
    chatter = chatter_after(p, support, turn, speed, second)
    start = turn + chatter.duration
    # The support force at the release is zero, so its phase does not count.
    force = -sigma * gap_acceleration(p, support, start, 0.0, 0.0, second)
    for k in range(n_parameters(second)):
        d_turn, d_speed = flights.d_end[i, k], flights.d_speed[i, k]
        d_duration, d_impulse = chatter_derivatives(
            p, chatter, support, turn, speed, d_turn, d_speed, k, second
        )
        changes[0, k], changes[1, k] = sigma * d_impulse, d_turn + 0.5 * d_duration
        changes[2, k] = force * (d_turn + d_duration)
    middle = turn + 0.5 * chatter.duration
    add_impulse(p, sigma * chatter.impulse, middle, m, changes, total, d_total)
    for q in range(total.size):
        held, at_start = phase_integral(q / m, start, release), phase_factor(start * q / m)
        reaction = reaction_integral(p, q, m, start, release)
        total[q] += support_position(p, support) * held + reaction
        for k in range(n_parameters(second)):
            change = support_derivative(support, k) * held - changes[2, k] * at_start
            if k == F:
                change += complex(0.0, 0.5) * reaction_difference(q, m, start, release)
            if second is not None and is_of_second(k):
                by_force = second_amplitude_derivative(p, k)
                change -= reaction_of_second(by_force, q, m, start, release)
            d_total[q, 0, k] += change.real
            d_total[q, 1, k] += change.imag


@jit_inline
def add_support_derivatives(p, length, flights, m, changes, total, d_total, second) -> None:
    """Add the support forces of an orbit, and their derivatives, to the sums at the frequencies k nu/m.

    p, m, changes, total, d_total : as for `add_impulse`; `changes` is work space
    length : period multiple of the orbit
    flights : filled by `vary_orbit`
    second : the effect `second_harmonic`
    """
    for j in range(flights.speed.size):
        support, speed = flights.support[j], flights.speed[j]
        sigma, r = -1.0 if support == 1 else 1.0, restitution_at(p, support)
        for k in range(n_parameters(second)):
            change = (1.0 + r) * flights.d_speed[j, k] + restitution_derivative(support, k) * speed
            changes[0, k], changes[1, k] = sigma * change, flights.d_end[j, k]
        add_impulse(p, sigma * (1.0 + r) * speed, flights.end[j], m, changes, total, d_total)
        if flights.released[j] == 1:
            add_rest(p, length, flights, j, m, changes, total, d_total, second)


@jit
def divide_derivatives(p, m, length, total, d_total, d_amplitudes, second) -> None:
    """Convert sums of support forces to amplitudes X(k nu/m), in place, and their derivatives to those of amplitudes.

    Those near resonance are converted nonetheless; `replace_resonant_derivatives` computes them anew.
    d_amplitudes : (harmonics + 1, parameters) complex.
    """
    share = 1.0 / length
    for q in range(total.size):
        forced, w = q == m, q * p.nu / m
        stiffness = dynamic_stiffness(p, q, m)
        x = divide(with_force(p, q, m, total[q] * share), stiffness)
        total[q] = x
        compliance = divide(complex(1.0, 0.0), stiffness)
        for k in range(n_parameters(second)):
            change = complex(d_total[q, 0, k], d_total[q, 1, k]) * share
            if k == NU:
                change -= x * complex(-2.0 * w * q / m, p.h * q / m)
            elif k == H:
                change -= x * complex(0.0, w)
            elif k == F and forced:
                change += force_amplitude_derivative()
            elif second is not None and is_of_second(k) and q == 2 * m:
                change += second_amplitude_derivative(p, k)
            d_amplitudes[q, k] = change * compliance


@jit_inline
def _integrate_flight(p, flights, j, cycles, ends, sums, second):
    """Integrate distance and variations of a flight times exp(-2 pi i cycles t), t in turns.

    ends : (2, variations), work space

    Returns the integral of the distance from the support that is left; `sums` (variations,) complex receives those of
    the variations.
    """
    home, start, w = flights.home[j], flights.start[j], flights.departure[j]
    turns, total = flights.end[j] - start, complex(0.0, 0.0)
    for v in range(n_variations(second)):
        sums[v] = 0.0
    sine, cosine = sincos_turns(start)
    rate = fastest_rate(fastest_forcing(p, second), p.h)
    intervals = max(1, math.ceil(turns * forcing_period(p) * rate / REACH))
    span = turns / intervals
    for interval in range(intervals):
        for g in range(NODES.size):
            at = (interval + NODES[g]) * span
            weight = phase_factor(cycles * (start + at)) * (WEIGHTS[g] * span)
            y, _rate = vary_flight(p, home, sine, cosine, at, w, ends, second)
            total += y * weight
            for v in range(n_variations(second)):
                sums[v] += ends[0, v] * weight
    return total


@jit_inline
def replace_resonant_derivatives(
    p, m, length, flights, ends, sums, total, d_amplitudes, second
) -> None:
    """Replace amplitudes near resonance, and their derivatives, by quadrature of the motion and its variation.

    p, m, flights : as for `add_support_derivatives`
    length : period multiple of the orbit
    ends, sums : (2, variations), the latter complex, work space
    total, d_amplitudes : as `divide_derivatives` leaves them
    second : the effect `second_harmonic`
    """
    period, share = forcing_period(p), 1.0 / length
    for q in range(total.size):
        if abs(dynamic_stiffness(p, q, m)) >= RESONANT:
            continue
        total[q] = 0.0
        for k in range(n_parameters(second)):
            d_amplitudes[q, k] = 0.0
        for j in range(flights.speed.size):
            home, start, w0 = flights.home[j], flights.start[j], flights.departure[j]
            released = flights.released[j] == 1
            i = j - 1 if j > 0 else flights.speed.size - 1
            sigma = -1.0 if home == 1 else 1.0
            value = _integrate_flight(p, flights, j, q / m, ends, sums[0], second)
            held = phase_integral(q / m, start, flights.end[j])
            if released:
                held += phase_integral(q / m, start_of_rest(flights, j, length)[1], start)
            total[q] += (support_position(p, home) * held + sigma * value) * share
            a0 = flights.at_start[j, 0]
            by_time = (sums[0, BY_Y] * w0 + sums[0, BY_W] * a0) * period
            for k in range(n_parameters(second)):
                change = by_parameter(home, sums, 0, k)
                if not released:
                    dw0 = restitution_at(p, home) * flights.d_speed[i, k]
                    dw0 += restitution_derivative(home, k) * flights.speed[i]
                    change += sums[0, BY_W] * dw0 - by_time * flights.d_start[j, k]
                moved = support_derivative(home, k) * held
                d_amplitudes[q, k] += (moved + sigma * change) * share
