"""A constant load is an offset of the equilibrium: motions are solved about it and then displaced."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from vibropipe.physics.exciter import Exciter


def about_equilibrium(exciter: Exciter) -> Exciter:
    """Return the exciter without load whose x = 0 is the equilibrium x = load of an exciter.

    On both bodies together the load acts all the same: a housing has it.
    """
    if exciter.load == 0.0:
        return exciter
    about = replace(exciter, load=0.0, delta=exciter.delta - exciter.load)
    if exciter.mass_ratio > 0.0:
        return replace(about, housing_load=exciter.housing_load + exciter.load)
    return about


def from_equilibrium(exciter: Exciter, x: float) -> float:
    """Return a displacement of an exciter as one of `about_equilibrium`; that of a support stays on the support."""
    about = about_equilibrium(exciter)
    on_support = {exciter.upper: about.upper, exciter.lower: about.lower}
    return on_support.get(x, x - exciter.load)


def displaced(exciter: Exciter, x: Any) -> Any:
    """Return displacements of `about_equilibrium` as those of an exciter, within rigid supports; nan stays."""
    if exciter.load == 0.0:
        return x
    lower = exciter.lower if exciter.k2 == 0.0 else -np.inf
    upper = exciter.upper if exciter.k1 == 0.0 else np.inf
    return np.clip(x + exciter.load, lower, upper)
