"""Exciters with a housing that slides, and where their motions are after some periods."""

from __future__ import annotations

from typing import Any

import numpy as np

import vibropipe as vp

# Names in the references of parameters that have others here.
NAMES = {
    "kappa": "mass_ratio",
    "d1": "housing_friction_1",
    "d2": "housing_friction_2",
    "pull": "housing_load",
}
SECTION = ("displacement_strobe", "velocity_strobe", "housing_velocity_strobe")
ENDS = ("displacement_end", "velocity_end", "housing_velocity_end")

STRUCK = vp.Exciter(
    nu=1.043, f=0.882, h=0.403, l=1.0, delta=-0.19, R1=0.3, R2=0.55, mass_ratio=0.585,
    housing_friction_1=0.292, housing_friction_2=0.438,
)  # fmt: skip
SYMMETRIC = vp.Exciter(
    l=0.3, nu=1.3, f=0.9, h=0.2, R1=0.6, R2=0.6, mass_ratio=0.6, housing_friction_1=0.2,
    housing_friction_2=0.2,
)  # fmt: skip
RUBBED = vp.Exciter(
    l=0.3, nu=1.3, f=0.9, h=0.1, delta=0.05, R1=0.5, R2=0.6, mass_ratio=0.8, housing_friction_1=0.1,
    housing_friction_2=0.2, housing_load=0.03, friction=0.15,
)  # fmt: skip
FREE = vp.Exciter(
    l=1.5, nu=0.7, f=0.9, h=0.3, mass_ratio=0.8, housing_friction_1=0.4, housing_friction_2=0.5
)
# It rests while the housing slides, until its release.
RESTING = vp.Exciter(
    l=0.5, nu=1.17, f=1.92, h=0.09, R1=0.77, R2=0.46, delta=-0.05, f2=0.5, mass_ratio=0.88,
    housing_friction_1=0.23, housing_friction_2=0.03,
)  # fmt: skip
# The housing stops under one rest, and slides through the other.
STOPPED = vp.Exciter(
    l=0.5, nu=0.43, f=1.13, h=0.1, R1=0.37, R2=0.55, delta=0.17, f2=0.18, mass_ratio=1.56,
    housing_friction_1=0.22, housing_friction_2=0.08,
)  # fmt: skip


def exciter_of(entry: dict[str, Any]) -> vp.Exciter:
    """Return the exciter of a reference."""
    return vp.Exciter(**{NAMES.get(n, n): float(v) for n, v in entry["parameters"].items()})


def section_map(exciter: vp.Exciter, state: np.ndarray, m: int) -> np.ndarray:
    """Return the state of both bodies after m forcing periods."""
    x, v, velocity = (float(each) for each in state)
    end = vp.simulate(exciter, m * exciter.period, x, v, housing_v0=velocity, samples_per_period=0)
    return np.array([float(end[name]) for name in ENDS])
