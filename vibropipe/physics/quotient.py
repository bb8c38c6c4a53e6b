"""Division of complex numbers that cannot raise: numba's own raises for a zero divisor under every error model."""

from __future__ import annotations

import math

from vibropipe.compiler import jit_inline


@jit_inline
def divide(a: complex, b: complex) -> complex:
    """Return a / b by Smith's algorithm; nan + nan i where b is zero.

    The operations are those of numba and Python, so the result is the same bit for bit.

    Reference: R. L. Smith, "Algorithm 116: Complex division", Communications of the ACM 5 (1962) 435.
    """
    if abs(b.real) >= abs(b.imag):
        if b.real == 0.0:
            return complex(math.nan, math.nan)
        ratio = b.imag / b.real
        below = b.real + b.imag * ratio
        return complex((a.real + a.imag * ratio) / below, (a.imag - a.real * ratio) / below)
    if b.imag == 0.0:
        return complex(math.nan, math.nan)
    ratio = b.real / b.imag
    below = b.real * ratio + b.imag
    return complex((a.real * ratio + a.imag) / below, (a.imag * ratio - a.real) / below)
