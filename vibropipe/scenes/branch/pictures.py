"""The picture of a branch scene."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr

from vibropipe.scenes.branch.captions import describe_branches, title_branches
from vibropipe.scenes.branch.curves import draw_branches
from vibropipe.scenes.branch.keys import BranchFigure
from vibropipe.scenes.kind import Picture


def keywords(options: BranchFigure | None, others: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Return the keywords of `draw_branches` and `describe_branches`."""
    options = options or BranchFigure()
    backbone = None if options.backbone is None else others[options.backbone]
    return {"show": options.show, "backbone": backbone}


PICTURES = (
    Picture("branches", draw_branches, describe_branches, keywords=keywords, titled=title_branches),
)
