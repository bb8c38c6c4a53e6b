"""Harmonics of the load, and its work."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from vibropipe.compiler import jit_inline
from vibropipe.physics.derivatives import F2
from vibropipe.physics.load import has_second
from vibropipe.physics.turns import TWO_PI, phase_integral


@jit_inline
def force_amplitude(p):
    """Return F of the force 2 Re(F exp(i nu tau))."""
    return complex(0.0, -0.5 * p.f)


@jit_inline
def force_amplitude_derivative():
    """Return the derivative of `force_amplitude` by f."""
    return complex(0.0, -0.5)


@jit_inline
def second_amplitude(p):
    """Return F of the second harmonic 2 Re(F exp(2 i nu tau)) of the force."""
    return complex(0.5 * p.f2 * math.sin(p.phi2), -0.5 * p.f2 * math.cos(p.phi2))


@jit_inline
def second_amplitude_derivative(p, k):
    """Return the derivative of `second_amplitude` by the parameter F2 or PHI2."""
    sine, cosine = math.sin(p.phi2), math.cos(p.phi2)
    if k == F2:
        return complex(0.5 * sine, -0.5 * cosine)
    return complex(0.5 * p.f2 * cosine, 0.5 * p.f2 * sine)


@jit_inline
def with_force(p, k, m, amplitude):
    """Return a complex amplitude at k nu / m, with that of the external force added where k = m or 2 m."""
    if k == 2 * m and has_second(p):
        return amplitude + second_amplitude(p)
    return amplitude + force_amplitude(p) if k == m else amplitude


@jit_inline
def reaction_difference(k, m, start, end):
    """Return the factor of i f/2 in `reaction_integral`; arguments as for it."""
    up = phase_integral(k / m - 1.0 if k != m else 0.0, start, end)
    # sin = (exp(i nu tau) - exp(-i nu tau)) / 2i
    return up - phase_integral(k / m + 1.0, start, end)


@jit_inline
def reaction_integral(p, k, m, start, end):
    """Return a harmonic of the part of the support force that balances the external force during a rest.

    k, m : harmonic of the frequency k nu / m
    start, end : the rest, in forcing periods

    Returns the integral of minus the force times exp(-i k nu tau / m) over the rest, in forcing periods.
    """
    first = complex(0.0, 0.5 * p.f) * reaction_difference(k, m, start, end)
    if not has_second(p):
        return first
    return first - reaction_of_second(second_amplitude(p), k, m, start, end)


@jit_inline
def reaction_of_second(amplitude, k, m, start, end):
    """Return minus `reaction_integral` of the force 2 Re(amplitude exp(2 i nu tau)) alone."""
    up = phase_integral(k / m - 2.0 if k != 2 * m else 0.0, start, end)
    down = phase_integral(k / m + 2.0, start, end)
    return amplitude * up + amplitude.conjugate() * down


@jit_inline
def work_of_force(p, x):
    """Return the work of the first harmonic over a forcing period of the motion 2 Re(x exp(i nu tau))."""
    return -2.0 * p.nu * x.real * p.f * (math.pi / p.nu)


@jit_inline
def work_over_periods(p, m, x):
    """Return the work of the first harmonic over m forcing periods; as `work_of_force`, rounded another way."""
    return -2.0 * math.pi * m * p.f * x.real


@jit_inline
def work_by_amplitude(m, x):
    """Return the derivative of `work_over_periods` by f, of a given motion."""
    return -2.0 * math.pi * m * x.real


@jit_inline
def work_of_second(p, x):
    """Return the work of the second harmonic over a forcing period of the motion 2 Re(x exp(2 i nu tau))."""
    return work_at_second(p, second_amplitude(p), x)


@jit_inline
def work_at_second(p, amplitude, x):
    """Return the work of the force 2 Re(amplitude exp(2 i nu tau)) over a forcing period of 2 Re(x exp(2 i nu tau))."""
    # The mean power is that of 2 Re(F exp) with 2 Re(2 i nu x exp).
    power = 2.0 * (amplitude * complex(0.0, 2.0 * p.nu) * x.conjugate()).real
    return -power * (TWO_PI / p.nu)


def force_values(f: float, turns: Any, f2: float = 0.0, phi2: float = 0.0) -> np.ndarray:
    """Return the force at phases in turns, for records of a motion."""
    angles = 2 * math.pi * np.asarray(turns)
    values: np.ndarray = f * np.sin(angles)
    return values + f2 * np.sin(2 * angles + phi2) if f2 else values
