"""The load of eq. (5): the force f sin(nu tau) and its constant part.

Its form is known here, in `load_steps` (whole steps) and in `load_harmonics` only.

A phase is counted in turns (forcing periods), so its reduction is exact. In the frame y = sigma (x - x_ref) of a motion
the load is a constant part plus the `Force` sigma f sin(nu tau). Displacements of kernels are counted from the
equilibrium, so an external constant load is in the positions of the supports (`contact.support_position`).

The second harmonic f2 sin(2 nu tau + phi2) has parts of `Force` and columns of its own. Functions of the march take
`second`, the effect `second_harmonic`: None leaves its code out. Others, called once for a row, look at f2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vibropipe.compiler import jit, jit_inline
from vibropipe.physics.frequency import frequency_at, moment_of, turn_at
from vibropipe.physics.turns import TWO_PI, sincos_turns

NEVER = math.inf
# Columns of a basis of motions: y, w, constant load, force in phase and force in quadrature; then the same of the
# second harmonic.
COLUMNS, COLUMNS_OF_SECOND = 5, 2
# Rounding of the load on a sticking mass, as a share of its largest magnitude, and the largest number of strides to
# its release.
LOAD_ROUNDING, MAX_STRIDES = 2.0**-51, 100_000


class Force(NamedTuple):
    """sigma f sin(nu tau) at an instant, and sigma f cos(nu tau), which determines its continuation.

    `sine_2` and `cosine_2` are sigma f2 sin(2 nu tau + phi2) and sigma f2 cos(2 nu tau + phi2).
    """

    sine: float
    cosine: float
    sine_2: float = 0.0
    cosine_2: float = 0.0


@jit_inline
def no_force():
    """Return the `Force` of a motion without one."""
    return Force(0.0, 0.0, 0.0, 0.0)


@jit_inline
def has_second(p) -> bool:
    """Return whether the force has a second harmonic, for functions without the effects of a kernel."""
    return p.f2 != 0.0


@jit_inline
def second_parts(p):
    """Return the factors of sin(2 nu tau) and cos(2 nu tau) in the second harmonic."""
    return p.f2 * math.cos(p.phi2), p.f2 * math.sin(p.phi2)


@jit_inline
def double_angle(s, c):
    """Return sine and cosine of twice an angle from those of the angle."""
    return 2.0 * s * c, (c - s) * (c + s)


@jit_inline
def forcing_period(p):
    """Return the forcing period 2 pi / nu in tau."""
    return TWO_PI / p.nu


@jit_inline
def constant_load(sigma, reference):
    """Return the constant load in the frame y = sigma (x - reference): the spring force there."""
    # A subtraction, since a negation would give a negative zero where the spring force is zero.
    return 0.0 - sigma * reference


@jit
def force_at(p, sigma: float, u: float, second=None) -> Force:
    """Return the `Force` at a phase.

    sigma : sign of the frame, 1 or -1
    u : phase in turns, or a `Moment`
    second : the effect `second_harmonic`
    """
    return _force_at(moment_of(u), p, sigma, u, second)


@jit_inline
def _force_at(moment, p, sigma, u, second) -> Force:
    """Return `force_at`; moment : `moment_of` u, as an argument, so that only one of both is compiled."""
    if moment is not None:
        force = force_on_ramp(moment.ramp, p, sigma, moment.s, second)
        # As of a force of the frequency p.nu, with the derivative of this one: `force_rate` is right.
        share = frequency_at(moment.ramp, moment.s) / p.nu
        return Force(force.sine, share * force.cosine, force.sine_2, share * force.cosine_2)
    s, c = sincos_turns(u)
    return force_of_angle(p, sigma, s, c, second)


@jit
def force_on_ramp(ramp, p, sigma, at, second) -> Force:
    """Return the `Force` at a time after the start of a `Ramp`; `cosine` is its derivative by the phase.

    The shaker has -shaker (sin(phase))'' = shaker (nu^2 sin(phase) - nu' cos(phase)).
    """
    s, c = sincos_turns(turn_at(ramp, at))
    nu, bend = frequency_at(ramp, at), ramp.shaker * ramp.change
    amplitude = ramp.f + ramp.shaker * (nu * nu)
    other = force_of_angle(p, sigma, s, c, second)
    sine, cosine = amplitude * s - bend * c, amplitude * c + 3.0 * bend * s
    return Force(sigma * sine, sigma * cosine, other.sine_2, other.cosine_2)


@jit_inline
def force_of_angle(p, sigma, s, c, second=None) -> Force:
    """Return the `Force` at the phase of a sine and a cosine; arguments as for `force_at`."""
    sine_2, cosine_2 = 0.0, 0.0
    if second is not None:
        s2, c2 = double_angle(s, c)
        in_phase, ahead = second_parts(p)
        sine_2 = sigma * (in_phase * s2 + ahead * c2)
        cosine_2 = sigma * (in_phase * c2 - ahead * s2)
    return Force(sigma * (p.f * s), sigma * (p.f * c), sine_2, cosine_2)


@jit_inline
def unit_force(p, sigma, s, c, second=None) -> Force:
    """Return the `Force` of unit amplitudes f and f2 at the phase of a sine and a cosine; arguments as for `force_at`.

    The derivative of the force by f is its sine, that by f2 its sine_2, and that by phi2 `force_by_phase`.
    """
    sine_2, cosine_2 = 0.0, 0.0
    if second is not None:
        s2, c2 = double_angle(s, c)
        in_phase, ahead = math.cos(p.phi2), math.sin(p.phi2)
        sine_2 = sigma * (in_phase * s2 + ahead * c2)
        cosine_2 = sigma * (in_phase * c2 - ahead * s2)
    return Force(sigma * s, sigma * c, sine_2, cosine_2)


@jit_inline
def force_value(force: Force, second=None):
    """Return the force."""
    if second is None:
        return force.sine
    return force.sine + force.sine_2


@jit_inline
def force_slope(force: Force, second=None):
    """Return the derivative of the force by nu tau."""
    if second is None:
        return force.cosine
    return force.cosine + 2.0 * force.cosine_2


@jit_inline
def first_harmonic(p, u):
    """Return the first harmonic of the force at a phase in turns."""
    return p.f * sincos_turns(u)[0]


@jit
def second_harmonic(p, u: float) -> float:
    """Return the second harmonic of the force at a phase in turns; 0 without one."""
    if not has_second(p):
        return 0.0
    return force_at(p, 1.0, u, 1).sine_2


@jit_inline
def force_rate(p, force: Force, second=None):
    """Return the derivative of the force by tau."""
    return p.nu * force_slope(force, second)


@jit_inline
def force_times(p, factor, u, second=None):
    """Return the product of a factor with the force, from the left, as integrals over the force are summed."""
    if second is None:
        return factor * p.f * sincos_turns(u)[0]
    return factor * force_value(force_at(p, 1.0, u, second), second)


@jit_inline
def fastest_forcing(p, second=None):
    """Return the highest frequency of the force."""
    return p.nu if second is None else 2.0 * p.nu


@jit_inline
def fastest_of_row(p):
    """Return the highest frequency of the force, as `fastest_forcing` without the effects of a kernel."""
    return 2.0 * p.nu if has_second(p) else p.nu


@jit_inline
def largest_force(p):
    """Return a bound of the magnitude of the force, sharp with one harmonic; 0 without force."""
    return abs(p.f) + abs(p.f2)


@jit_inline
def force_bounds(p):
    """Return bounds of the force and of its first and second derivative by tau, sharp with one harmonic."""
    first, second = abs(p.f), abs(p.f2)
    return (first + second, p.nu * (first + 2.0 * second), p.nu * p.nu * (first + 4.0 * second))


@jit
def release_turn(p, sigma: float, load: float) -> float:
    """Return the phase at which the force on a sticking mass turns positive.

    sigma, load : the force is sigma f sin + load

    Returns a phase in [0, 1) turns; `NEVER` if the force never turns positive, -1 if it always is.
    """
    f = sigma * p.f
    amplitude = abs(f)
    if load > amplitude:
        return -1.0
    if -load >= amplitude:
        return NEVER
    turn = math.asin(-load / amplitude) / TWO_PI
    if f < 0.0:
        turn += 0.5
    turn -= math.floor(turn)
    return 0.0 if turn >= 1.0 else turn


@jit_inline
def release_stride(value, slope, curvature, rounding):
    """Return the time in which the load on a sticking mass cannot release it; 0 where it does.

    value, slope : of the load and its derivative; curvature : bound on the second derivative; rounding : of the load.
    """
    rises = slope > 0.0 and slope * slope > 4.0 * curvature * rounding
    if value > rounding or (value >= -rounding and rises):
        return 0.0
    # The stride is that of a load pressed by its rounding at least, so that no zero holds it up.
    press = max(-value, rounding)
    root = math.sqrt(slope * slope + 2.0 * curvature * press)
    return 2.0 * press / (root + slope) if slope > 0.0 else (root - slope) / curvature


@jit
def release_wait_of_second(p, sigma: float, load: float, turn: float) -> float:
    """Return the turns from a phase to the release of a sticking mass under two harmonics; `NEVER` without one.

    The release is the first zero at which the load turns positive. A parabola above the load, whose curvature is the
    largest one of the load, has no zero before its own, so no release is passed; near a zero these strides converge
    like Newton's method. There the load rises beyond its rounding if a parabola below it does; a maximum that only
    touches zero does not, and is passed.

    sigma, load : the load on the mass is sigma times the force, plus load
    """
    force, _rate, second = force_bounds(p)
    per_turn = TWO_PI / p.nu
    curvature = second * per_turn * per_turn
    rounding = LOAD_ROUNDING * (force + abs(load))
    wait = 0.0
    for _ in range(MAX_STRIDES):
        at = force_at(p, sigma, turn + wait, 1)
        value, slope = force_value(at, 1) + load, force_rate(p, at, 1) * per_turn
        stride = release_stride(value, slope, curvature, rounding)
        if stride == 0.0:
            return wait
        wait += stride
        if wait >= 1.0:
            return NEVER
    return NEVER


@jit_inline
def unit_load(column):
    """Return (constant load, `Force`) of a column of a basis: one of them is 1, or none for y and w."""
    return (1.0 if column == 2 else 0.0), Force(
        1.0 if column == 3 else 0.0,
        1.0 if column == 4 else 0.0,
        1.0 if column == 5 else 0.0,
        1.0 if column == 6 else 0.0,
    )


@jit_inline
def first_terms(force: Force, angle):
    """Return the first two Taylor coefficients of the first harmonic by theta; angle is nu dt."""
    return force.sine, force.cosine * angle


@jit_inline
def first_terms_of_second(force: Force, angle):
    """Return the first two Taylor coefficients of the second harmonic by theta; angle is 2 nu dt."""
    return force.sine_2, force.cosine_2 * angle


@jit_inline
def force_by_phase(p, unit: Force):
    """Return the derivative of the force by phi2, from a `unit_force`."""
    return p.f2 * unit.cosine_2


@jit_inline
def next_term(before, angle, factor):
    """Return the coefficient of theta^(n + 1) from that of theta^(n - 1); factor is 1 / (n (n + 1))."""
    return -(angle * angle) * before * factor


@jit_inline
def load_terms(e, basis, n, load, force: Force):
    """Return the contribution of the load to the coefficient of theta^n, from a basis (COLUMNS, degree + 1)."""
    if e.forcing is None:
        return load * basis[2, n]
    of_load = load * basis[2, n] + (force.sine * basis[3, n] + force.cosine * basis[4, n])
    if e.second_harmonic is not None:
        of_load += force.sine_2 * basis[5, n] + force.cosine_2 * basis[6, n]
    return of_load
