"""Lengths in metres that a force cannot go with: those of a unit that was not meant."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

# A support farther away than this many times the largest displacement of the linear motion is never struck, and a force
# or an offset that holds the spring this many times as far as the supports is not meant. A wrong prefix is 1000.
IMPLAUSIBLE = 100.0
HOLDS = "holds the spring {} from its equilibrium"
# What is odd of a parameter this large, and by which units.
ODD = (
    ("f", f"F: the force {HOLDS}", "F, C and l"),
    ("f2", f"F2: the second harmonic of the force {HOLDS}", "F2, C and l"),
    ("delta", "delta: the equilibrium lies {} from the middle between the supports", "delta and l"),
    ("shaker", "shaker, or m_e e / m: the frame swings by {}", "shaker, m_e, e and l"),
    ("load", f"load: the constant force {HOLDS}", "load, C and l"),
    ("friction", f"friction: dry friction {HOLDS}", "friction, C and l"),
)


def unit_warning(values: Mapping[str, Any]) -> str:
    """Return what is odd about the lengths of exciters, all with lengths in metres; empty for nothing.

    values : parameters by name, each with all values or the ends of a range; those left out are 0, nu is 1
    """
    p = {name: np.atleast_1d(np.asarray(value, float)) for name, value in values.items()}
    if "l" not in p:
        return ""

    def ends(name: str, default: float = 0.0) -> tuple[float, float]:
        sizes = np.abs(p.get(name, np.array([default])))
        return float(sizes.min()), float(sizes.max())

    (least, most) = ends("nu", 1.0)
    high = ends("f")[1] + ends("shaker")[1] * most**2
    near = min(max(1.0, least), most)  # the frequency nearest to resonance
    stiffness = np.hypot(1.0 - near**2, ends("h")[0] * near)
    largest = high * max(1.0, 1.0 / stiffness if stiffness else np.inf) + ends("f2")[1]
    distance = ends("l")[0] - ends("delta")[1] - ends("load")[1]
    if 0.0 < IMPLAUSIBLE * largest < distance:
        return (
            f"l: the nearer support is {distance:.3g} m away, but the mass swings by {largest:.2g} m without supports: "
            "check the units of l, F and C"
        )
    for name, does, units in ODD:
        size = ends(name)[0]
        if size > IMPLAUSIBLE * ends("l")[1]:
            return f"{does.format(f'{size:.3g} m')}, {size / ends('l')[1]:.3g} times l: check the units of {units}"
    return ""
