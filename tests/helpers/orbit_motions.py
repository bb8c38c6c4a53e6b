"""Motions of orbits from their sections."""

from __future__ import annotations

from typing import Any

import xarray as xr

import vibropipe as vp


def motion_of(exciter: vp.Exciter, orbit: xr.Dataset, turns: int = 1, **options: Any) -> xr.Dataset:
    """Return the motion from the section of an orbit over so many times its periods, without samples by default."""
    start = (float(orbit[f"{name}_strobe"]) for name in ("displacement", "velocity"))
    if exciter.mass_ratio > 0.0:
        options["housing_v0"] = float(orbit["housing_velocity_strobe"])
    span = turns * int(orbit["period_multiple"]) * exciter.period
    return vp.simulate(exciter, span, *start, **{"samples_per_period": 0, **options})
