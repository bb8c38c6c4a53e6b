"""The picture of a boundary scene."""

from __future__ import annotations

from collections.abc import Mapping

import xarray as xr

from vibropipe.scenes.boundary.captions import describe_boundaries
from vibropipe.scenes.boundary.curves import draw_boundaries
from vibropipe.scenes.boundary.keys import BoundaryFigure
from vibropipe.scenes.kind import Picture


def regimes(options: BoundaryFigure | None, others: Mapping[str, xr.Dataset]) -> xr.Dataset | None:
    """Return the sweep that is drawn under the curves."""
    return None if options is None or options.map is None else others[options.map]


PICTURES = (
    Picture(
        "boundaries",
        lambda dataset: True,
        lambda dataset, options, others: draw_boundaries(dataset, regimes(options, others)),
        lambda dataset, options, others: describe_boundaries(dataset, regimes(options, others)),
    ),
)
