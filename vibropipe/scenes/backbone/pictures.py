"""Pictures of a backbone: over amplitude, alone or with forced motions, or the curves of eq. (10)."""

from collections.abc import Collection, Mapping
from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from vibropipe.scenes.backbone.amplitude_frequency import draw_amplitude_frequency
from vibropipe.scenes.backbone.captions import (
    amplitude_title,
    backbone_title,
    describe_amplitude_frequency,
    describe_backbone,
    describe_overlay,
)
from vibropipe.scenes.backbone.curves import draw_backbone
from vibropipe.scenes.backbone.keys import BackboneFigure
from vibropipe.scenes.backbone.overlay import draw_overlay
from vibropipe.scenes.kind import Picture, showing


def keywords(options: BackboneFigure | None, others: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Return the keywords of `draw_characteristics`."""
    names = options.together if options is not None else []
    return {**showing(options, others), "together": [others[name] for name in names]}


def draw_characteristics(
    dataset: xr.Dataset, show: Collection[str], together: Collection[xr.Dataset]
) -> Figure:
    """Draw a backbone over amplitude, alone or with the scenes that lie along it."""
    if not together:
        return draw_amplitude_frequency(dataset, show)
    return draw_overlay(*free_and_forced(dataset, together), shown_name(show))


def describe_characteristics(
    dataset: xr.Dataset, show: Collection[str], together: Collection[xr.Dataset]
) -> str:
    """Return the caption of the same."""
    if not together:
        return describe_amplitude_frequency(dataset)
    return describe_overlay(*free_and_forced(dataset, together))


def free_and_forced(
    dataset: xr.Dataset, together: Collection[xr.Dataset]
) -> tuple[list[xr.Dataset], list[xr.Dataset]]:
    """Return the backbones and the sweeps among a backbone and others."""
    free = [dataset, *(other for other in together if "eigenfrequency" in other)]
    return free, [other for other in together if "eigenfrequency" not in other]


def shown_name(show: Collection[str]) -> str:
    """Return whose harmonics are drawn over one another: `velocity` if only its quantities are shown."""
    return (
        "velocity" if show and all(name.startswith("velocity") for name in show) else "displacement"
    )


PICTURES = (
    Picture(
        "amplitude_frequency",
        draw_characteristics,
        describe_characteristics,
        lambda dataset: "eigenfrequency" in dataset,
        keywords,
        lambda dataset, show, together: "" if together else amplitude_title(dataset),
    ),
    Picture(
        "backbone",
        draw_backbone,
        lambda dataset, show: describe_backbone(dataset),
        lambda dataset: "velocity_over_l" in dataset,
        keywords=showing,
        titled=lambda dataset, show: backbone_title(dataset),
    ),
)
