"""Solution of boundary scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from vibropipe.physics.exciter import Exciter
from vibropipe.solve.boundary.boundary import boundary
from vibropipe.solve.in_si import convert
from vibropipe.solve.physical import stored
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.vocabulary import held_name

if TYPE_CHECKING:
    from vibropipe.scenes.boundary.keys import BoundaryScene
    from vibropipe.words.progress import Progress


def solve(scene: BoundaryScene, progress: Progress | None = None) -> xr.Dataset:
    """Follow the boundaries of a scene in memory."""
    # A parameter that varies may be required, or decide what others may be: it is there, at an end of its range.
    lows = {
        name: ends[0]
        for name, ends in zip(scene.along, scene.within, strict=True)
        if name in PARAMETERS
    }
    stated = scene.untied_exciter() | lows
    ties = scene.tied().texts
    dataset = boundary(
        Exciter(**stated), scene.sought, scene.along, scene.within, scene.lines, law=scene.law, ties=ties,
    )  # fmt: skip
    if progress is not None:
        progress(scene.row_count, scene.row_count)
    # without a curve, the data would not tell what was sought and where
    dataset.attrs["sought"] = " ".join(scene.bifurcations)
    physical = stored(dataset, scene.mass_and_stiffness)
    for name, ends in zip(scene.along, scene.within, strict=True):
        held = held_name(physical.variables, name)
        physical[held].attrs["box"] = in_box(name, ends, scene.mass_and_stiffness)
    return physical


def in_box(
    name: str, ends: tuple[float, float], mass_and_stiffness: tuple[float, float] | None
) -> np.ndarray:
    """Return the ends of a parameter of the box, in SI if the study states m and C."""
    if mass_and_stiffness is None or name not in PARAMETERS:
        return np.array(ends)
    m, C = mass_and_stiffness
    return np.asarray(convert(name, np.array(ends), {"m": m, "C": C}))
