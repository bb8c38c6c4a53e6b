"""Parameters in SI without their units, by eqs. (2)-(4)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from vibropipe.physics.parameter_error import ParameterError, number_within
from vibropipe.physics.restitution import is_contact_damping
from vibropipe.words.parameters import PHYSICAL, STANDARD_GRAVITY
from vibropipe.words.records import FRACTION

NO_DAMPING = "must be 0 where {} = 0: a rigid support has a restitution, no damping"
# A restitution of 1 states nothing: it is the value of a support without one.
TWICE_DAMPED = "must be left out beside {R} below 1, since {R} and {k} give it ({R} = 1 for a damping of its own)"
NO_HOUSING = "must be 0 where mass_ratio = 0: the housing is fixed then"
NO_SHAKER = (
    "must be 0 where mass_ratio > 0: the force on a mass in a housing that slides pushes off the housing, that of an "
    "unbalance or a shaken frame does not"
)
WITHOUT_MASS = "must be left out without M, the mass of the housing, which is fixed then"
BESIDE = "must be left out unless {} stands beside it"
WITHIN_MASS = "must not exceed m, of which it is a part"
FREQUENCY_REQUIRED = "is required beside {} ({})"
# Forces with units, by what they are without.
WRITTEN_FORCES = {"F": "f", "F2": "f2", "shaker": "shaker", "m_e": "shaker"}


def non_dimensional(si: Mapping[str, float]) -> dict[str, float]:
    """Return the parameters of an exciter by eqs. (2)-(4).

    si : m and C, and any others of `PHYSICAL`, in SI

    Returns the parameters of those that are given; lengths in metres.
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
        elif physical.dimension == "mass":
            value = si["m"] / value
        elif physical.dimension == "damping":
            # Square roots first: the product m C can overflow where h does not.
            value = value / math.sqrt(si["m"]) / math.sqrt(si["C"])
        values[physical.non_dimensional] = value
    if si.get("slope", 0.0) != 0.0:
        down = si.get("gravity", STANDARD_GRAVITY) * math.sin(si["slope"]) / si["C"]
        values["load"] = values.get("load", 0.0) - si["m"] * down
        if "M" in si:
            values["housing_load"] = values.get("housing_load", 0.0) - si["M"] * down
    if "m_e" in si and "e" in si:
        values["shaker"] = values.get("shaker", 0.0) + si["m_e"] * si["e"] / si["m"]
    return values


def eigenfrequency(m: float, C: float) -> float:
    """Return p = sqrt(C/m), eq. (3), in rad/s."""
    return math.sqrt(C / m)


def check_together(
    given: Mapping[str, Any], si: Mapping[str, float], restitution: Mapping[str, float]
) -> None:
    """Raise a ParameterError, in physical words, if parameters do not go together."""
    for name, other in (("m_e", "e"), ("e", "m_e"), ("gravity", "slope")):
        if name in si and other not in si:
            raise ParameterError(name, given[name], must=BESIDE.format(other))
    if si.get("m_e", 0.0) > si["m"]:
        raise ParameterError("m_e", given["m_e"], must=WITHIN_MASS)
    for name in ("D1", "D2", "P") if "M" not in si else ():
        if si.get(name, 0.0) != 0.0:
            raise ParameterError(name, given[name], must=WITHOUT_MASS)
    for R, C, H in (("R1", "C1", "H1"), ("R2", "C2", "H2")):
        if si.get(H, 0.0) > 0.0 and si.get(C, 0.0) == 0.0:
            raise ParameterError(H, given[H], must=NO_DAMPING.format(C))
        if H not in si or not number_within(R, restitution[R], FRACTION) < 1.0:
            continue
        numbers = non_dimensional({name: si[name] for name in ("m", "C", C, H) if name in si})
        k, h = (numbers.get(PHYSICAL[name].non_dimensional, 0.0) for name in (C, H))
        if not is_contact_damping(h, restitution[R], k):
            raise ParameterError(H, given[H], must=TWICE_DAMPED.format(R=R, k=C, h=H))


def unit_factors(m: float, C: float) -> dict[str, float]:
    """Return the SI values of the units of non-dimensional quantities with lengths in metres."""
    p = eigenfrequency(m, C)
    return {
        "time": 1.0 / p,
        "frequency": p,
        "rate": p,
        "velocity": p,
        "acceleration": p**2,
        "force": C,
        "stiffness": C,
        "damping": math.sqrt(m) * math.sqrt(C),
        "energy": C,
        "torque": C,
        "power": C * p,
        "impulse": C / p,
    }
