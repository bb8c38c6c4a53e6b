"""Quotients of what vanishes at the start of a flight by powers of its time, which keep their digits at any time."""

from __future__ import annotations

from vibropipe.compiler import jit
from vibropipe.orbits.law.momentum import momentum_rate
from vibropipe.physics.flow import DEGREE
from vibropipe.physics.piece import acceleration_of, flown, force_at_end
from vibropipe.physics.stiffness import piece_rate, piece_taylor

# Product of rate and time below which a quotient is summed from powers.
SHORT = 0.5


@jit
def power_of(t, order):
    """Return t to a power of 0 or more; compiled, t**order may raise."""
    power = 1.0
    for _ in range(order):
        power *= t
    return power


@jit
def divided_stop(e, p, law, i, flight, start, order, value, rate, c):
    """Return what `divided` does for the velocity of a housing over c, from its value and slope there."""
    t = flight.t
    if is_long(flight):
        return value / power_of(t, order), (rate - order * value / t) / power_of(t, order)
    return stop_by_powers(e, p, law, i, flight, start, order, c)


@jit
def is_long(flight) -> bool:
    """Return whether a flight is so long that a quotient by a power of its time keeps its digits."""
    fastest = max(piece_rate(flight.stiffness, flight.damping), 2.0 * flight.nu)
    return abs(flight.t) * fastest > SHORT


@jit
def divided(e, flight, start, row, order, c):
    """Return displacement (row 0) or velocity at the end of a flight over a power of its time, and its slope by it.

    The start has no powers below: the quotient is a polynomial, whose coefficients are those of the flight.
    """
    t = flight.t
    if is_long(flight):
        y, w = flown(flight, start.y, start.w)
        value, rate = y, w
        if row == 1:
            value, rate = w, acceleration_of(flight, force_at_end(flight), y, w)
        return value / power_of(t, order), (rate - order * value / t) / power_of(t, order)
    piece_taylor(
        c, start.y, start.w, flight.force, flight.load, flight.stiffness, flight.damping,
        flight.nu, t, e.second_harmonic,
    )  # fmt: skip
    total, slope, lowest = 0.0, 0.0, order + row
    for n in range(DEGREE, lowest - 1, -1):
        term = c[n] if row == 0 else n * c[n]
        total += term
        slope += (n - lowest) * term
    power = power_of(t, lowest)
    return total / power, slope / power / t


@jit
def stop_by_powers(e, p, law, i, flight, start, order, c):
    """Return the velocity of a housing over c at the end of a flight, over a power of its time, and its slope by it.

    It starts with the velocity 0 and, at order 2, without acceleration.
    """
    t, rate = flight.t, momentum_rate(p, law, (i - 1) % law.codes.shape[0])
    piece_taylor(
        c, start.y, start.w, flight.force, flight.load, flight.stiffness, flight.damping,
        flight.nu, t, e.second_harmonic,
    )  # fmt: skip
    total, slope, lowest, power = 0.0, 0.0, order + 1, t * t
    for n in range(DEGREE, lowest - 1, -1):
        total += n * c[n]
        slope += n * (n - lowest) * c[n]
    if order == 1:
        return rate - total / power, -slope / power / t
    power *= t
    return -total / power, -slope / power / t
