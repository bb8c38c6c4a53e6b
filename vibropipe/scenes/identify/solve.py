"""Solution of identification scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import xarray as xr

from vibropipe.physics.exciter import Exciter
from vibropipe.solve.fit.identify import identify
from vibropipe.solve.physical import stored

if TYPE_CHECKING:
    from vibropipe.scenes.identify.keys import IdentifyScene
    from vibropipe.words.progress import Progress


def solve(scene: IdentifyScene, progress: Progress | None = None) -> xr.Dataset:
    """Find the parameters of a scene in memory."""
    dataset = identify(
        Exciter(**scene.known_exciter()), scene.measured, scene.ranges(),
        scene.start.x0, scene.start.v0, scene.noise or None, scene.samples, scene.tied().texts,
        scene.steady_from, scene.blanking, scene.sign,
    )  # fmt: skip
    return stored(dataset, scene.mass_and_stiffness)
