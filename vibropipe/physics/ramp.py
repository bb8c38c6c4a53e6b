"""A ramp: a force whose frequency changes linearly in time, so that its phase is quadratic.

With s the time since the start of the ramp, the frequency is nu(s) = nu_0 + a s and the phase nu_0 tau_0 + nu_0 s +
a s^2/2; the second harmonic has twice that phase, plus phi2.
"""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_inline
from vibropipe.physics.flow import DEGREE, TAYLOR_FACTORS, fastest_rate
from vibropipe.physics.frequency import frequency_at, turn_at
from vibropipe.physics.load import (
    LOAD_ROUNDING,
    NEVER,
    double_angle,
    fastest_forcing,
    force_bounds,
    force_on_ramp,
    force_slope,
    force_value,
    release_stride,
    second_parts,
)
from vibropipe.physics.stiffness import piece_rate
from vibropipe.physics.turns import sincos_turns

# Largest product of the fastest rate and a step, and of the root of the rate at which the highest frequency changes.
# The powers of the force and of the motion are those of a majorant, Z' = rate Z + F exp(rate s + a s^2/2). On a circle
# of 40 steps about the start it is at most exp(18) (|z| + 16 F / rate), so all that the polynomial leaves out is below
# exp(18) 40^-16 / (1 - 1/40) < 1.6e-18 of (|z| + 16 F / rate): below the rounding of the polynomial.
REACH_OF_RATE, REACH_OF_CHANGE = 0.4, 0.05


def longest_step(e, p, change: float) -> float:
    """Return the longest step in tau that one polynomial covers to rounding.

    p : with the highest frequency of the ramp; change : of the frequency per unit of time.
    """
    fastest = fastest_forcing(p, e.second_harmonic)
    step: float = REACH_OF_RATE / fastest_rate(fastest, p.h)
    if change != 0.0:
        step = min(step, REACH_OF_CHANGE / math.sqrt(abs(change) * fastest / p.nu))
    return step


def steps_on_ramp(e, p, ramp) -> int:
    """Return the fewest steps in a period of the highest frequency of a ramp, that of p."""
    return math.ceil(2.0 * math.pi / p.nu / longest_step(e, p, ramp.change))


@jit
def release_wait_on_ramp(e, p, ramp, sigma, load, s, span) -> float:
    """Return the time from s to the release of a mass sticking to a support; `NEVER` if it is not within `span`.

    As `release_wait_of_second`: no release is passed, since the curvature of the load is at most that of the parabola.

    p : with the highest frequency of the ramp, and a bound of its first harmonic as f
    sigma, load : the load on the mass is sigma times the force, plus load
    s, span : time since the start of the ramp, and to its end
    """
    second = e.second_harmonic
    force, _rate, curvature = force_bounds(p)
    change = abs(ramp.change)
    curvature += change * (abs(p.f) + 2.0 * abs(p.f2))
    # The bound p.f of the first harmonic has shaker (nu^2 + change): what the curvature of that force has beside it.
    curvature += change * abs(ramp.shaker) * (4.0 * p.nu * p.nu + 2.0 * change)
    rounding = LOAD_ROUNDING * (force + abs(load))
    if force + load < -rounding:
        return NEVER
    wait = 0.0
    while wait < span:
        at = force_on_ramp(ramp, p, sigma, s + wait, second)
        value = force_value(at, second) + load
        slope = frequency_at(ramp, s + wait) * force_slope(at, second)
        stride = release_stride(value, slope, curvature, rounding)
        # Where the rounding of the time exceeds the stride, the load passes zero within it.
        if wait + stride == wait:
            return wait
        wait += stride
    return NEVER


@jit_inline
def wait_from_moment(moment, e, p, sigma, load, span):
    """Return `release_wait_on_ramp` from a `Moment`, within a time `span`, in its unit."""
    return release_wait_on_ramp(e, p, moment.ramp, sigma, load, moment.s, span) / moment.unit


@jit
def parts_on_ramp(piece, dt) -> float:
    """Return into how many parts a step dt of a ramp is divided on a piece, so that a polynomial covers one."""
    return max(1.0, math.ceil(piece_rate(piece.stiffness, piece.damping) * dt / REACH_OF_RATE))


@jit
def piece_taylor_on_ramp(c, y, w, p, moment, scale, piece, dt, second) -> None:
    """Fill c with the motion on a piece so that y(s + theta dt) = sum(c[n] theta**n) for 0 <= theta <= 1, on a ramp.

    The sine S and the cosine C of a phase with rate W + A theta obey S' = (W + A theta) C, C' = -(W + A theta) S. The
    coefficients of -shaker (sin(phase))'' are those of the sine, by n and n - 1.

    c : (DEGREE + 1,)
    y, w : displacement and velocity at s
    p : for the second harmonic
    moment : with s
    scale : factor of the force
    dt : a step over `parts_on_ramp`
    second : the effect `second_harmonic`
    """
    ramp, d2, hd = moment.ramp, dt * dt, piece.damping * dt
    rate, bend = frequency_at(ramp, moment.s) * dt, ramp.change * dt * dt
    f, shaker, stiffness = scale * ramp.f * d2, scale * ramp.shaker, piece.stiffness * d2
    s_before, c_before = sincos_turns(turn_at(ramp, moment.s))
    s, co = rate * c_before, -rate * s_before
    s2_before, c2_before, s2, co2 = 0.0, 0.0, 0.0, 0.0
    if second is not None:
        in_phase, ahead = second_parts(p)
        sine, cosine = double_angle(s_before, c_before)
        s2_before = scale * d2 * (in_phase * sine + ahead * cosine)
        c2_before = scale * d2 * (in_phase * cosine - ahead * sine)
        s2, co2 = 2.0 * rate * c2_before, -2.0 * rate * s2_before
    c[0], c[1], constant = y, w * dt, d2 * piece.load
    for n in range(2, DEGREE + 1):
        force = f * s_before + s2_before + constant
        s, co, s_before, c_before = (
            (rate * co + bend * c_before) / n,
            -(rate * s + bend * s_before) / n,
            s,
            co,
        )
        s2, co2, s2_before, c2_before = (
            2.0 * (rate * co2 + bend * c2_before) / n,
            -2.0 * (rate * s2 + bend * s2_before) / n,
            s2,
            co2,
        )
        of_state = stiffness * c[n - 2] + hd * (n - 1) * c[n - 1]
        c[n] = (force - of_state) * TAYLOR_FACTORS[n - 2] - shaker * s
        constant = 0.0
