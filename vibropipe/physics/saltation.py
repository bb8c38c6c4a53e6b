"""The saltation matrix: the jump of the linearised motion at an impact; products and eigenvalues of 2 x 2 matrices."""

from __future__ import annotations

import math

from vibropipe.compiler import jit


@jit
def saltation_matrix(restitution, velocity_before, acceleration_before, acceleration_after):
    """Return the matrix (s11, s12, s21, s22) that maps a small deviation (dx, dx') through an impact, eq. (6).

    The perturbed motion arrives dt = -dx/x'- later. Following it back through the reset gives
    [[-R, 0], [(a+ + R a-)/x'-, -R]], with determinant R^2.

    restitution : R
    velocity_before : x'-, not zero
    acceleration_before, acceleration_after : a- and a+, from eq. (5) on both sides of the impact

    Reference: M. di Bernardo, C. J. Budd, A. R. Champneys, P. Kowalczyk, "Piecewise-smooth Dynamical Systems", Springer
    (2008), sec. 2.5.
    """
    shear = (acceleration_after + restitution * acceleration_before) / velocity_before
    return -restitution, 0.0, shear, -restitution


@jit
def product(a11, a12, a21, a22, b11, b12, b21, b22):
    """Return the product A B of two 2 x 2 matrices, each as its elements by rows."""
    return (
        a11 * b11 + a12 * b21,
        a11 * b12 + a12 * b22,
        a21 * b11 + a22 * b21,
        a21 * b12 + a22 * b22,
    )


@jit
def eigenvalues_of(trace, determinant):
    """Return the eigenvalues of a matrix, the larger modulus first, of a conjugate pair the upper one."""
    half = 0.5 * trace
    discriminant = half * half - determinant
    if discriminant < 0.0:
        root = math.sqrt(-discriminant)
        return complex(half, root), complex(half, -root)
    large = half + math.copysign(math.sqrt(discriminant), half)
    # The other one from the product, which does not cancel.
    return complex(large, 0.0), complex(determinant / large if large != 0.0 else 0.0, 0.0)
