"""Pictures of a basins scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr

from vibropipe.scenes.basins.attractors import swept_name
from vibropipe.scenes.basins.basin_map import draw_basins
from vibropipe.scenes.basins.keys import BasinsFigure
from vibropipe.scenes.basins.share_bands import draw_shares
from vibropipe.scenes.basins.share_maps import draw_share_maps
from vibropipe.scenes.basins.shares_text import (
    describe_share_maps,
    describe_shares,
    title_share_maps,
    title_shares,
)
from vibropipe.scenes.basins.text import describe_basins, title_basins
from vibropipe.scenes.kind import Picture, showing


def is_swept(dataset: xr.Dataset) -> bool:
    """Return whether the starts are those at several values of a parameter."""
    return swept_name(dataset) is not None


def branches(options: BasinsFigure | None, others: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Return the data of the scene that `branches` names, as a keyword of the pictures of shares."""
    named = None if options is None or options.branches is None else others[options.branches]
    return {"branches": named}


PICTURES = (
    Picture(
        "basins",
        draw_basins,
        describe_basins,
        lambda dataset: not is_swept(dataset),
        showing,
        title_basins,
    ),
    Picture("shares", draw_shares, describe_shares, is_swept, branches, title_shares),
    Picture(
        "maps",
        draw_share_maps,
        describe_share_maps,
        is_swept,
        titled=title_share_maps,
        heading="Which starts settle on which motion?",
    ),
)
