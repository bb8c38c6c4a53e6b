"""Parameters in SI without their units, by eqs. (2)-(4)."""

from __future__ import annotations

import math
from collections.abc import Mapping

from vibropipe.words.parameters import PHYSICAL, STANDARD_GRAVITY


def non_dimensional(si: Mapping[str, float]) -> dict[str, float]:
    """Return the parameters of an exciter by eqs. (2)-(4).

    Parameters
    ----------
    si : mapping of str to float
        m and C, and any others of `PHYSICAL`, in SI.

    Returns
    -------
    dict of str to float
        The parameters of those that are given; lengths in metres.
    """
    values = {}
    for name, value in si.items():
        physical = PHYSICAL[name]
        if not physical.non_dimensional:
            continue
        if physical.dimension == "frequency":
            value /= eigenfrequency(si["m"], si["C"])
        elif physical.dimension in ("force", "stiffness"):
            value /= si["C"]
        elif physical.dimension == "damping":
            # Square roots first: the product m C can overflow where h does not.
            value = value / math.sqrt(si["m"]) / math.sqrt(si["C"])
        values[physical.non_dimensional] = value
    if si.get("slope", 0.0) != 0.0:
        weight = si["m"] * si.get("gravity", STANDARD_GRAVITY)
        values["load"] = values.get("load", 0.0) - weight * math.sin(si["slope"]) / si["C"]
    return values


def eigenfrequency(m: float, C: float) -> float:
    """Return p = sqrt(C/m), eq. (3), in rad/s."""
    return math.sqrt(C / m)
