"""Pictures of a sweep."""

from collections.abc import Mapping
from typing import Any

import xarray as xr

from vibropipe.scenes.kind import Picture
from vibropipe.scenes.sweep.captions import describe_map, describe_sweep
from vibropipe.scenes.sweep.curves import axis_and_others, draw_sweep
from vibropipe.scenes.sweep.keys import MAX_LINES, SweepFigure
from vibropipe.scenes.sweep.regime_map import draw_regime_map


def is_map(dataset: xr.Dataset) -> bool:
    """Return whether a sweep has more lines than can be distinguished."""
    _, others = axis_and_others(dataset)
    return any(dataset.sizes[name] > MAX_LINES for name in others)


def curve_options(options: SweepFigure | None, others: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Return the keywords of `draw_sweep` and `describe_sweep`; raises KeyError for an unknown backbone."""
    options = options or SweepFigure()
    if options.backbone is not None and options.backbone not in others:
        known = ", ".join(sorted(others)) or "none"
        raise KeyError(
            f"figure.backbone: must be a scene of the study ({known}), got {options.backbone!r}"
        )
    backbone = None if options.backbone is None else others[options.backbone]
    return {"show": options.show, "backbone": backbone}


PICTURES = (
    Picture(
        "map",
        is_map,
        lambda dataset, options, others: draw_regime_map(dataset),
        lambda dataset, options, others: describe_map(dataset),
    ),
    Picture(
        "curves",
        lambda dataset: True,
        lambda dataset, options, others: draw_sweep(dataset, **curve_options(options, others)),
        lambda dataset, options, others: describe_sweep(dataset, **curve_options(options, others)),
    ),
)
