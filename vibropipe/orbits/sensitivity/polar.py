"""Derivatives of amplitudes and phases, from those of complex amplitudes."""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_nogil

# Share of the largest amplitude, or of its derivative, below which an amplitude, or a derivative, is rounding.
ROUNDING = 1e-13


@jit
def largest_modulus(values) -> float:
    """Return the largest modulus of complex values (n,), without regard to NaN."""
    largest = 0.0
    for value in values:
        size = abs(value)
        largest = size if size > largest else largest
    return largest


@jit_nogil
def polar_derivatives(values, derivatives, amplitude, phase) -> None:
    """Fill the derivatives of 2 |X| and arg X.

    Where X is zero within rounding the phase has no derivative, and the amplitude one only if that of X is zero.

    Parameters
    ----------
    values : (rows, n) complex
        X.
    derivatives : (rows, n, parameters) complex
        Of X.
    amplitude, phase : (rows, n, parameters) float
        Filled.
    """
    for row in range(values.shape[0]):
        rounding = ROUNDING * largest_modulus(values[row])
        for q in range(values.shape[1]):
            x = values[row, q]
            size = abs(x)
            for k in range(derivatives.shape[2]):
                d = derivatives[row, q, k]
                if size <= rounding:
                    steepest = largest_modulus(derivatives[row, :, k])
                    stays = abs(d) <= ROUNDING * steepest
                    amplitude[row, q, k], phase[row, q, k] = 0.0 if stays else math.nan, math.nan
                else:
                    turned = x.conjugate() * d
                    amplitude[row, q, k] = 2.0 * turned.real / size
                    phase[row, q, k] = turned.imag / (size * size)
