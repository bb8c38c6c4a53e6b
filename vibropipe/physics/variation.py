"""Derivatives of a flight by its start and by the parameters: variations that fly along with the motion.

In the frame y = sigma (x - x_ref) of a support, eq. (5) reads y'' + h y' + y = load + sigma f sin(nu tau). Times are
phases, in turns. The derivative of y by a parameter at a fixed phase obeys the same equation with another right-hand
side, its source: 1 for the constant load, sigma sin(nu tau) for f, -y' for h and, since tau = phase 2 pi/nu,
-(2 y'' + h y')/nu for nu. Each is a Taylor polynomial by the recurrence of `physics.flow`, so resonance and critical
damping are no special cases. The second harmonic adds the sources sigma sin(2 nu tau + phi2) for f2 and
sigma f2 cos(2 nu tau + phi2) for phi2. A further parameter of the force adds a column with its source.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline
from vibropipe.physics.derivatives import F2, NU, PHI2, F, H, load_derivative
from vibropipe.physics.flow import DEGREE, TAYLOR_FACTORS
from vibropipe.physics.load import (
    first_terms,
    first_terms_of_phase,
    first_terms_of_second,
    next_term,
)

# Variations of a flight: by its displacement and velocity at the start, and responses to the sources; the last two
# with a second harmonic only.
BY_Y, BY_W, BY_LOAD, BY_NU, BY_H, BY_F, BY_F2, BY_PHI2 = range(8)
VARIATIONS, WITH_SECOND = 6, 8
# Factors of the recurrence, 1 / ((n + 1) (n + 2)), and 1 / (n + 2).
FACTORS = np.array(TAYLOR_FACTORS)
SHARES = np.array([1.0 / (n + 2) for n in range(DEGREE - 1)])


@jit_inline
def n_variations(second):
    """Return the number of variations; second : int or None, the effect `second_harmonic`."""
    return VARIATIONS if second is None else WITH_SECOND


class Workspace(NamedTuple):
    """Work arrays of variations, VARIATIONS or WITH_SECOND of them.

    c : (DEGREE + 1,), polynomial of the motion
    z : (DEGREE + 1, VARIATIONS), polynomials of the variations
    ends : (2, VARIATIONS)
    """

    c: np.ndarray
    z: np.ndarray
    ends: np.ndarray


@jit_allocating
def new_workspace(second):
    """Return a new `Workspace`; second : int or None, the effect `second_harmonic`."""
    n = n_variations(second)
    return Workspace(np.empty(DEGREE + 1), np.empty((DEGREE + 1, n)), np.empty((2, n)))


@jit
def vary_step(p, c, unit, dt, ends, z, second) -> None:
    """Fill the polynomials of all variations over a step, and move the variations to its end.

    c : (DEGREE + 1,), the motion over the step (`taylor`)
    unit : the force of a unit amplitude at the start of the step
    ends : (2, VARIATIONS), displacements and velocities at the start; on return those at the end
    z : (DEGREE + 1, VARIATIONS), filled with the coefficients by theta
    second : the effect `second_harmonic`
    """
    square, damped, by_nu, n_columns = dt * dt, p.h * dt, 1.0 / p.nu, n_variations(second)
    term, term_next = first_terms(unit, p.nu * dt)
    twice = 2.0 * p.nu * dt
    f2, f2_next = first_terms_of_second(unit, twice)
    phase, phase_next = first_terms_of_phase(p, unit, twice)
    for v in range(n_columns):
        z[0, v], z[1, v] = ends[0, v], ends[1, v] * dt
        ends[0, v], ends[1, v] = z[0, v] + z[1, v], z[1, v]
    for n in range(DEGREE - 1):
        to_next, share = square * FACTORS[n], damped * SHARES[n]
        for v in range(n_columns):
            z[n + 2, v] = -to_next * z[n, v] - share * z[n + 1, v]
        z[n + 2, BY_LOAD] += 0.5 * square if n == 0 else 0.0
        z[n + 2, BY_NU] -= (2.0 * c[n + 2] + share * c[n + 1]) * by_nu
        z[n + 2, BY_H] -= dt * SHARES[n] * c[n + 1]
        z[n + 2, BY_F] += to_next * term
        term, term_next = term_next, next_term(term, p.nu * dt, FACTORS[n])
        if second is not None:
            z[n + 2, BY_F2] += to_next * f2
            z[n + 2, BY_PHI2] += to_next * phase
            f2, f2_next = f2_next, next_term(f2, twice, FACTORS[n])
            phase, phase_next = phase_next, next_term(phase, twice, FACTORS[n])
        for v in range(n_columns):
            ends[0, v] += z[n + 2, v]
            ends[1, v] += (n + 2) * z[n + 2, v]
    for v in range(n_columns):
        ends[1, v] /= dt


@jit
def begin_variations(p, w, ends) -> None:
    """Fill ends (2, variations) with the variations at the start of a flight with the rate w."""
    for v in range(ends.shape[1]):
        ends[0, v] = ends[1, v] = 0.0
    ends[0, BY_Y] = ends[1, BY_W] = 1.0
    # The derivative by the phase is fixed with w at nu: w = nu dy/dphase / (2 pi).
    ends[1, BY_NU] = -w / p.nu


@jit
def by_parameter(support, ends, part, k):
    """Return the derivative by parameter k of a variation: ends[part] summed over what k changes in the flight.

    support : the support that the flight leaves
    ends : (2, VARIATIONS), of `vary_flight`
    part : 0 for the distance, 1 for its rate
    """
    total = load_derivative(support, k) * ends[part, BY_LOAD]
    if k == NU:
        total += ends[part, BY_NU]
    elif k == H:
        total += ends[part, BY_H]
    elif k == F:
        total += ends[part, BY_F]
    elif k == F2:
        total += ends[part, BY_F2]
    elif k == PHI2:
        total += ends[part, BY_PHI2]
    return total
