"""Orbits by their impacts: the smooth equations of an impact sequence, and the derivative of its return map.

An orbit of m forcing periods with n impacts is a zero of 2n equations in the times t_i of its impacts (in forcing
periods) and the velocities v_i before them: the flight from impact i, which departs with -R v_i, is at time t_(i+1)
at the support of impact i + 1 with the velocity v_(i+1). Flights are closed forms, so stable and unstable orbits are
found alike, and the equations stay smooth where the orbit touches a support or ceases to be a motion.

An orbit that is its own mirror image half an orbit later, x(tau + m T/2) = -x(tau), is described by the first half of
its impacts: the last flight then leads to the mirror image of the first impact. Where the symmetry breaks these
equations stay regular.
"""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit
from vibropipe.physics.contact import restitution_at, support_position
from vibropipe.physics.forced_flow import acceleration, fly_freely
from vibropipe.physics.load import forcing_period
from vibropipe.physics.saltation import product, saltation_matrix


@jit
def next_impact(span, mirrored, supports, u, i):
    """Return the impact that ends flight i.

    Returns (j, time, velocity, support, sign): j is its index, 0 after the last flight; sign is -1 if it is the mirror
    image of impact j, else 1.
    """
    n = supports.size
    if i + 1 < n:
        return i + 1, u[i + 1], u[n + i + 1], np.int64(supports[i + 1]), 1.0
    if mirrored == 0:
        return 0, u[0] + span, u[n], np.int64(supports[0]), 1.0
    return 0, u[0] + span, -u[n], np.int64(3 - supports[0]), -1.0


@jit
def fill_equations(p, span, mirrored, supports, u, residual, jacobian) -> None:
    """Evaluate the equations of a sequence, and their derivative.

    span, mirrored, supports : as of a `Law`
    u : (2n,) or longer, times of the impacts in forcing periods, then velocities before them
    residual : (2n,) or longer, distance of the end of each flight from the next support, and from the next velocity
    jacobian : (2n, 2n) or larger, or without rows, derivative by u
    """
    n, period = supports.size, forcing_period(p)
    for row in range(min(2 * n, jacobian.shape[0])):
        for column in range(2 * n):
            jacobian[row, column] = 0.0
    for i in range(n):
        j, end, velocity, support, sign = next_impact(span, mirrored, supports, u, i)
        x, restitution = support_position(p, supports[i]), restitution_at(p, supports[i])
        v = -restitution * u[n + i]
        x1, v1, e11, e12, e21, e22 = fly_freely(p, u[i], end, x, v)
        residual[2 * i] = x1 - support_position(p, support)
        residual[2 * i + 1] = v1 - velocity
        if jacobian.shape[0] > 0:
            a, a1 = acceleration(p, x, v, u[i]), acceleration(p, x1, v1, end)
            jacobian[2 * i, i] -= (e11 * v + e12 * a) * period
            jacobian[2 * i + 1, i] -= (e21 * v + e22 * a) * period
            jacobian[2 * i, n + i] -= restitution * e12
            jacobian[2 * i + 1, n + i] -= restitution * e22
            jacobian[2 * i, j] += v1 * period
            jacobian[2 * i + 1, j] += a1 * period
            jacobian[2 * i + 1, n + j] -= sign


@jit
def return_derivative(p, span, mirrored, supports, u):
    """Return trace and determinant of the return map's derivative over `span`.

    They are those of the product of flow and saltation matrices; of a mirrored sequence, of the map to the mirror
    image.
    """
    n, period = supports.size, forcing_period(p)
    j11, j12, j21, j22 = 1.0, 0.0, 0.0, 1.0
    determinant = math.exp(-p.h * span * period)
    for i in range(n):
        _j, end, _velocity, _support, _sign = next_impact(span, mirrored, supports, u, i)
        x, restitution = support_position(p, supports[i]), restitution_at(p, supports[i])
        before = u[n + i]
        s11, s12, s21, s22 = saltation_matrix(
            restitution,
            before,
            acceleration(p, x, before, u[i]),
            acceleration(p, x, -restitution * before, u[i]),
        )
        j11, j12, j21, j22 = product(s11, s12, s21, s22, j11, j12, j21, j22)
        _x, _v, e11, e12, e21, e22 = fly_freely(p, u[i], end, x, -restitution * before)
        j11, j12, j21, j22 = product(e11, e12, e21, e22, j11, j12, j21, j22)
        determinant *= restitution * restitution
    trace = j11 + j22
    return (-trace if mirrored == 1 else trace), determinant


@jit
def eigenvalues(trace, determinant):
    """Return the eigenvalues of a 2 x 2 matrix, the larger modulus first, as complex numbers."""
    half = 0.5 * trace
    discriminant = half * half - determinant
    if discriminant < 0.0:
        root = math.sqrt(-discriminant)
        return complex(half, root), complex(half, -root)
    large = half + math.copysign(math.sqrt(discriminant), half)
    return complex(large, 0.0), complex(determinant / large if large != 0.0 else 0.0, 0.0)
