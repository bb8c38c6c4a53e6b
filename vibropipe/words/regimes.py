"""Regimes of motion: the integers that kernels write and datasets hold."""

from __future__ import annotations

from enum import IntEnum

NEUTRAL_TOLERANCE = 1e-9
"""Largest distance of the largest modulus of a neutral orbit's multipliers from 1: their rounding."""


class Regime(IntEnum):
    """Regime of a steady state, or why a row has none."""

    NO_IMPACT = 0
    ONE_SIDED_1 = 1
    ONE_SIDED_2 = 2
    TWO_SIDED = 3
    WITH_REST = 4
    APERIODIC = 5
    UNBOUNDED = 6
    UNRESOLVED = 7


class Chaos(IntEnum):
    """Whether perturbations of a motion grow exponentially: no, before it settles, or where it is left.

    Of a motion that is left it is not known whether it settles later.
    """

    NONE = 0
    TRANSIENT = 1
    IN_WINDOW = 2
