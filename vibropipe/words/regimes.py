"""Regimes of motion: the integers that kernels write and datasets hold."""

from __future__ import annotations

from enum import IntEnum


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
    """Whether perturbations of a motion grow exponentially: never, before it settles, or up to where it is left."""

    NONE = 0
    TRANSIENT = 1
    LASTING = 2
