"""Derivatives by the parameters: of supports, restitution, force, and the acceleration of a gap.

A further parameter adds its part to these functions; one of the force also its source to `physics.variation`. Kernels
number parameters by their place in `ALL_DIFFERENTIATED`. Motions between rigid supports have the first ones, with those
of the second harmonic if it is called for; those of pieces have all but the last, of a housing.
"""

from __future__ import annotations

from vibropipe.compiler import jit, jit_inline
from vibropipe.physics.contact import support_position
from vibropipe.physics.load import constant_load, force_at, force_by_phase, force_value, unit_force
from vibropipe.physics.turns import sincos_turns
from vibropipe.words.exciter import EFFECTS
from vibropipe.words.parameters import PARAMETERS, THROUGH_OTHERS, of_effect

_FURTHER = [each.name for each in EFFECTS if not each.is_common and each.is_marched]
OF_SECOND = of_effect("second_harmonic")
"""Those of the second harmonic."""
OF_PIECES = of_effect("soft", "friction")
"""Those of soft supports and friction."""
OF_HOUSING = of_effect("housing")
"""Those of a housing that may slide."""
DIFFERENTIATED = tuple(
    name for name in PARAMETERS if name not in {*of_effect(*_FURTHER), *THROUGH_OTHERS}
)
"""The parameters by which all motions are differentiated, in the order of derivatives."""
ALL_DIFFERENTIATED = (*DIFFERENTIATED, *OF_SECOND, *OF_PIECES, *OF_HOUSING)
N_PARAMETERS, N_OF_PIECES = len(DIFFERENTIATED), len(ALL_DIFFERENTIATED) - len(OF_HOUSING)
N_WITH_SECOND, N_WITH_HOUSING = N_PARAMETERS + len(OF_SECOND), len(ALL_DIFFERENTIATED)
NU, F, H, L, DELTA, R1, R2, LOAD, F2, PHI2, K1, K2, H1, H2, FRICTION, FRICTION_RATIO = map(
    ALL_DIFFERENTIATED.index,
    ("nu", "f", "h", "l", "delta", "R1", "R2", "load", "f2", "phi2", "k1", "k2", "h1", "h2", "friction",
     "friction_ratio"),
)  # fmt: skip
MASS_RATIO, HOUSING_FRICTION_1, HOUSING_FRICTION_2, HOUSING_LOAD = map(
    ALL_DIFFERENTIATED.index,
    ("mass_ratio", "housing_friction_1", "housing_friction_2", "housing_load"),
)


def differentiated_by(pieces: bool, second: bool, housing: bool = False) -> tuple[str, ...]:
    """Return the parameters of derivatives with soft supports or friction, a second harmonic, or a housing, or not.

    Those of a housing come with those of pieces.
    """
    further = (*(OF_SECOND if second else ()), *(OF_PIECES if pieces or housing else ()))
    return (*DIFFERENTIATED, *further, *(OF_HOUSING if housing else ()))


@jit_inline
def is_of_second(k):
    """Return whether parameter k is one of the second harmonic."""
    return F2 <= k <= PHI2


@jit_inline
def n_parameters(second):
    """Return the number of parameters of derivatives between rigid supports; second : int or None, the effect."""
    return N_PARAMETERS if second is None else N_WITH_SECOND


@jit
def support_derivative(support, k):
    """Return the derivative of `support_position` by parameter k."""
    if k == DELTA:
        return 1.0
    if k == L:
        return 1.0 if support == 1 else -1.0
    return -1.0 if k == LOAD else 0.0


@jit
def restitution_derivative(support, k):
    """Return the derivative of the restitution of a support (1 or 2) by parameter k."""
    return 1.0 if k == (R1 if support == 1 else R2) else 0.0


@jit
def distance_derivative(k):
    """Return the derivative of the distance 2l of the supports by parameter k."""
    return 2.0 if k == L else 0.0


@jit
def load_derivative(support, k):
    """Return the derivative of the constant load in the frame of a support by parameter k."""
    return constant_load(-1.0 if support == 1 else 1.0, support_derivative(support, k))


@jit
def force_derivative(p, turn, k, second=None):
    """Return the derivative of the force by parameter k at a phase, in turns; second : int or None, the effect."""
    if second is not None and is_of_second(k):
        unit = unit_force(p, 1.0, *sincos_turns(turn), second)
        return unit.sine_2 if k == F2 else force_by_phase(p, unit)
    return sincos_turns(turn)[0] if k == F else 0.0


@jit
def gap_acceleration(p, support, turn, y, w, second=None):
    """Return y'' at the distance y from a support, with the rate w, at a phase in turns."""
    sigma = -1.0 if support == 1 else 1.0
    load = constant_load(sigma, support_position(p, support))
    return force_value(force_at(p, sigma, turn, second), second) + load - p.h * w - y


@jit
def gap_acceleration_derivative(p, support, turn, w, k, second=None):
    """Return the derivative of `gap_acceleration` by parameter k at fixed phase, y and w."""
    sigma = -1.0 if support == 1 else 1.0
    by_force = sigma * force_derivative(p, turn, k, second)
    return load_derivative(support, k) + by_force - (w if k == H else 0.0)
