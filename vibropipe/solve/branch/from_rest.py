"""Which orbits of branches the mass settles on from rest."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vibropipe.physics.exciter import Parameters
from vibropipe.solve.rows.points import solve_points
from vibropipe.words.outputs import OF_STEADY_STATE
from vibropipe.words.parameters import DEFAULTS
from vibropipe.words.quantities import FLAGS

if TYPE_CHECKING:
    import xarray as xr

# Of the size of the orbit: orbits that are closed to rounding differ by far less, and others by more.
SAME_ORBIT = 1e-6
CODES = FLAGS["from_rest"]


def reached_from_rest(branches: xr.Dataset) -> np.ndarray:
    """Return whether the motion from rest settles on the orbit of each point, (points,), as codes of `from_rest`.

    The motion begins at the equilibrium, or the support nearest to it, without velocity, at the phase 0 of the force.
    Two orbits are one if their period multiples and the harmonics of their displacements are the same.

    Parameters
    ----------
    branches : xarray.Dataset
        Over `point`, without units, with harmonics.
    """
    n = branches.sizes["point"]
    columns = [
        np.broadcast_to(branches[name] if name in branches else DEFAULTS[name], n)
        for name in Parameters._fields
    ]
    parameters, stable = np.column_stack(columns), branches["stable"].values == 1
    found = np.full(n, CODES["other"], np.int8)
    if not stable.any():
        return found
    different, at = np.unique(parameters[stable], axis=0, return_inverse=True)
    harmonics = branches.sizes["harmonic"]
    rest = solve_points(different, (None, 0.0), OF_STEADY_STATE, harmonics).variables
    multiples, shapes = rest["period_multiple"][1][at], _shape({k: v for k, (_, v) in rest.items()})
    own = _shape(branches.isel(point=stable))
    is_near = (np.abs(own - shapes[at]) <= SAME_ORBIT * np.abs(own).max(axis=1)[:, None]).all(
        axis=1
    )
    is_near &= branches["period_multiple"].values[stable] == multiples
    code = np.where(is_near, CODES["same"], CODES["other"])
    found[stable] = np.where(multiples == 0, CODES["unknown"], code)
    return found


def _shape(rows) -> np.ndarray:  # type: ignore[no-untyped-def]
    """Return mean and harmonics of the displacement of rows, (rows, 1 + harmonics), whichever period begins them."""
    amplitudes, phases = (
        np.asarray(rows[f"displacement_{name}"]) for name in ("amplitude", "phase")
    )
    waves = amplitudes * np.exp(1j * np.where(amplitudes == 0.0, 0.0, phases))
    return np.column_stack([np.asarray(rows["displacement_mean"]), waves])
