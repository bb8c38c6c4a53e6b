"""Which orbits of branches and designs the mass settles on from rest."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vibropipe.physics.exciter import Parameters
from vibropipe.solve.motion.after_ramp import SAME, SAME_ORBIT
from vibropipe.solve.rows.points import solve_points
from vibropipe.words.outputs import OF_STEADY_STATE
from vibropipe.words.parameters import DEFAULTS

if TYPE_CHECKING:
    import xarray as xr

SHAPE = ("displacement_mean", "displacement_amplitude", "displacement_phase")


def reached_from_rest(orbits: xr.Dataset) -> np.ndarray:
    """Return whether the motion from rest settles on the orbit of each row, as codes of `settled_same`.

    The motion begins at the equilibrium, or the support nearest to it, without velocity, at the phase 0 of the force.
    Two orbits are one if their period multiples and the harmonics of their displacements are the same. Of a motion
    that is no orbit it is not known.

    orbits : over one dimension of rows, as `point` or `design`, without units, with harmonics
    """
    n = orbits["stable"].size
    columns = [
        np.broadcast_to(orbits[name] if name in orbits else DEFAULTS[name], n)
        for name in Parameters._fields
    ]
    parameters, stable = np.column_stack(columns), orbits["stable"].values == 1
    is_orbit = orbits["period_multiple"].values > 0
    found = np.where(is_orbit, SAME["other"], SAME["unknown"]).astype(np.int8)
    stable &= is_orbit
    if not stable.any():
        return found
    different, at = np.unique(parameters[stable], axis=0, return_inverse=True)
    harmonics = orbits.sizes["harmonic"]
    rest = solve_points(different, (None, 0.0), OF_STEADY_STATE, harmonics).variables
    shapes = _shape(*(rest[name][1][at] for name in SHAPE))
    own = _shape(*(orbits[name].values[stable] for name in SHAPE))
    multiples = rest["period_multiple"][1][at]
    is_near = (np.abs(own - shapes) <= SAME_ORBIT * np.abs(own).max(axis=1)[:, None]).all(axis=1)
    is_near &= orbits["period_multiple"].values[stable] == multiples
    code = np.where(is_near, SAME["same"], SAME["other"])
    found[stable] = np.where(multiples == 0, SAME["unknown"], code)
    return found


def _shape(mean: np.ndarray, amplitudes: np.ndarray, phases: np.ndarray) -> np.ndarray:
    """Return mean and harmonics of the displacement of rows, (rows, 1 + harmonics), whichever period begins them."""
    waves = amplitudes * np.exp(1j * np.where(amplitudes == 0.0, 0.0, phases))
    return np.column_stack([mean, waves])
