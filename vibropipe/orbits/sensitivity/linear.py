"""Derivatives by the parameters of motions without impacts: linear motions, and rests that never end."""

from __future__ import annotations

import math

from vibropipe.compiler import jit
from vibropipe.physics.derivatives import F2, NU, F, H, is_of_second, support_derivative
from vibropipe.physics.linear import (
    linear_amplitude,
    linear_multipliers,
    second_linear_amplitude,
)
from vibropipe.physics.load import forcing_period, has_second
from vibropipe.physics.load_harmonics import (
    force_amplitude_derivative,
    second_amplitude_derivative,
    work_at_second,
    work_by_amplitude,
    work_of_second,
    work_over_periods,
)
from vibropipe.physics.quotient import divide


@jit
def amplitude_derivative(p, amplitude, n, k):
    """Return the derivative by parameter k of the amplitude X(n nu) under a force that does not depend on it."""
    stiffness = complex((1.0 - n * p.nu) * (1.0 + n * p.nu), p.h * (n * p.nu))
    change = complex(0.0, 0.0)
    if k == NU:
        change = complex(-2.0 * n * n * p.nu, n * p.h)
    elif k == H:
        change = complex(0.0, n * p.nu)
    return divide(-amplitude * change, stiffness)


@jit
def linear_amplitude_derivative(p, k):
    """Return the derivative of `linear_amplitude` by parameter k."""
    if k == F:
        return divide(
            force_amplitude_derivative(), complex((1.0 - p.nu) * (1.0 + p.nu), p.h * p.nu)
        )
    return amplitude_derivative(p, linear_amplitude(p), 1.0, k)


@jit
def second_linear_amplitude_derivative(p, k):
    """Return the derivative of `second_linear_amplitude` by parameter k."""
    if is_of_second(k):
        stiffness = complex((1.0 - 2.0 * p.nu) * (1.0 + 2.0 * p.nu), p.h * (2.0 * p.nu))
        return divide(second_amplitude_derivative(p, k), stiffness)
    return amplitude_derivative(p, second_linear_amplitude(p), 2.0, k)


@jit
def linear_roots(p):
    """Return the roots of s^2 + h s + 1 = 0 and their derivatives by h, in the order of `linear_multipliers`."""
    b = 0.5 * p.h
    square = (1.0 - b) * (1.0 + b)
    root = math.sqrt(abs(square))
    if square > 0.0:
        first, second = complex(-b, root), complex(-b, -root)
        slope = complex(0.0, 2.0 * root)
    else:
        first, second = complex(-1.0 / (b + root), 0.0), complex(-(b + root), 0.0)
        slope = complex(2.0 * root, 0.0)
    return first, second, divide(-first, slope), divide(second, slope)


@jit
def write_linear(p, out, row) -> None:
    """Write the derivatives of the steady motion without impacts, for h > 0."""
    period = forcing_period(p)
    first, second, first_h, second_h = linear_roots(p)
    multipliers = linear_multipliers(p)
    amplitude, amplitude_2 = linear_amplitude(p), second_linear_amplitude(p)
    for k in range(out.d_section.shape[2]):
        x, x2 = linear_amplitude_derivative(p, k), second_linear_amplitude_derivative(p, k)
        out.d_section[row, 0, k] = 2.0 * x.real
        out.d_section[row, 1, k] = -2.0 * (p.nu * x.imag + (amplitude.imag if k == NU else 0.0))
        if has_second(p) or k == F2:
            out.d_section[row, 0, k] += 2.0 * x2.real
            out.d_section[row, 1, k] -= 4.0 * p.nu * x2.imag
            out.d_section[row, 1, k] -= 4.0 * amplitude_2.imag if k == NU else 0.0
        if out.d_amplitudes.size > 0:
            out.d_amplitudes[row, :, k] = 0.0
            if out.d_amplitudes.shape[1] > 1:
                out.d_amplitudes[row, 1, k] = x
            if out.d_amplitudes.shape[1] > 2:
                out.d_amplitudes[row, 2, k] = x2
        if out.d_multipliers.size > 0:
            by_first, by_second = complex(0.0, 0.0), complex(0.0, 0.0)
            if k == NU:
                by_first, by_second = -first * (period / p.nu), -second * (period / p.nu)
            elif k == H:
                by_first, by_second = first_h * period, second_h * period
            out.d_multipliers[row, 0, k] = multipliers[0] * by_first
            out.d_multipliers[row, 1, k] = multipliers[1] * by_second
        if out.d_exponent.size > 0:
            out.d_exponent[row, k] = first_h.real if k == H else 0.0
        if out.d_energy.size > 0:
            work = work_over_periods(p, 1, x)
            if k == F:
                work += work_by_amplitude(1, amplitude)
            if has_second(p):
                work += work_of_second(p, x2)
            if is_of_second(k):
                work += work_at_second(p, second_amplitude_derivative(p, k), amplitude_2)
            out.d_energy[row, 0, k] = out.d_energy[row, 1, k] = work
            out.d_energy[row, 2, k] = out.d_energy[row, 3, k] = 0.0


@jit
def write_held(support, out, row) -> None:
    """Write the derivatives of a mass that rests on a support for ever."""
    for k in range(out.d_section.shape[2]):
        out.d_section[row, 0, k], out.d_section[row, 1, k] = support_derivative(support, k), 0.0
        if out.d_amplitudes.size > 0:
            out.d_amplitudes[row, :, k] = 0.0
            out.d_amplitudes[row, 0, k] = support_derivative(support, k)
        if out.d_multipliers.size > 0:
            out.d_multipliers[row, :, k] = 0.0
        if out.d_energy.size > 0:
            out.d_energy[row, :, k] = 0.0
