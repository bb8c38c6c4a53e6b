"""Solution of design scenes."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import xarray as xr

from vibropipe.physics.exciter import Exciter
from vibropipe.solve.design.face import design
from vibropipe.solve.physical import stored
from vibropipe.words.status import UnsolvedWarning

if TYPE_CHECKING:
    from vibropipe.scenes.design.keys import DesignScene
    from vibropipe.words.progress import Progress


def solve(scene: DesignScene, progress: Progress | None = None) -> xr.Dataset:
    """Find the designs of a scene in memory."""
    with warnings.catch_warnings():
        # The dataset says what is missed, and the report why.
        warnings.simplefilter("ignore", UnsolvedWarning)
        dataset = design(
            Exciter(**scene.resolved_exciter()), **scene.arguments(), progress=progress
        )
    return stored(dataset, scene.mass_and_stiffness)
