"""The picture of a boundary scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr

from vibropipe.scenes.boundary.captions import describe_boundaries, title_boundaries
from vibropipe.scenes.boundary.curves import draw_boundaries
from vibropipe.scenes.boundary.keys import BoundaryFigure
from vibropipe.scenes.kind import Picture


def keywords(options: BoundaryFigure | None, others: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Return the keywords of `draw_boundaries` and `describe_boundaries`."""
    options = options or BoundaryFigure()
    regimes = None if options.map is None else others[options.map]
    return {"regimes": regimes, "show": options.show}


PICTURES = (
    Picture(
        "boundaries",
        draw_boundaries,
        describe_boundaries,
        keywords=keywords,
        titled=title_boundaries,
    ),
)
