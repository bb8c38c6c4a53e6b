"""Solution of design scenes."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import xarray as xr

from vibropipe.physics.exciter import Exciter
from vibropipe.scenes.certificate import with_certificate
from vibropipe.solve.design.face import design
from vibropipe.solve.physical import stored
from vibropipe.solve.rebuild import exciter_of
from vibropipe.words.designs import DesignResult
from vibropipe.words.proofs import REFUSED
from vibropipe.words.status import UnsolvedWarning

if TYPE_CHECKING:
    from vibropipe.scenes.design.keys import DesignScene
    from vibropipe.words.progress import Progress


def solve(scene: DesignScene, progress: Progress | None = None) -> xr.Dataset:
    """Find the designs of a scene in memory."""
    with warnings.catch_warnings():
        # The dataset says what is missed, and the report why.
        warnings.simplefilter("ignore", UnsolvedWarning)
        dataset = design(Exciter(**scene.untied_exciter()), **scene.arguments(), progress=progress)
    whole = stored(dataset, scene.mass_and_stiffness)
    if scene.prove is None:
        return whole
    if int(dataset["design_result"][0]) != DesignResult.MET:
        return whole.assign_attrs({REFUSED: "no design was found that keeps all that is wanted"})
    return with_certificate(whole, scene, exciter_of(dataset.isel(design=0)))
