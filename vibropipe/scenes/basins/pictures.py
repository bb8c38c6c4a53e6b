"""Pictures of a basins scene."""

from __future__ import annotations

from collections.abc import Mapping

import xarray as xr

from vibropipe.scenes.basins.basin_map import draw_basins
from vibropipe.scenes.basins.keys import BasinsFigure
from vibropipe.scenes.basins.laws import swept_name
from vibropipe.scenes.basins.share_bands import draw_shares
from vibropipe.scenes.basins.share_maps import draw_share_maps
from vibropipe.scenes.basins.shares_text import describe_share_maps, describe_shares
from vibropipe.scenes.basins.text import describe_basins
from vibropipe.scenes.kind import Picture, only_picture, showing_picture


def _branches(options: BasinsFigure | None, others: Mapping[str, xr.Dataset]) -> xr.Dataset | None:
    """Return the data of the scene that `branches` names."""
    return None if options is None or options.branches is None else others[options.branches]


PICTURES = (
    showing_picture(
        "basins", draw_basins, describe_basins, lambda dataset: swept_name(dataset) is None
    ),
    Picture(
        "shares",
        lambda dataset: swept_name(dataset) is not None,
        lambda dataset, options, others: draw_shares(dataset, _branches(options, others)),
        lambda dataset, options, others: describe_shares(dataset, _branches(options, others)),
    ),
    only_picture(
        "maps",
        draw_share_maps,
        describe_share_maps,
        lambda dataset: swept_name(dataset) is not None,
    ),
)
