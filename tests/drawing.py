"""Pictures of datasets by the name of their kind, as the jobs of a study draw them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from vibropipe.figures.style import house_style
from vibropipe.scenes.kind import Picture
from vibropipe.scenes.registry import kinds


def picture_of(kind: str, dataset: xr.Dataset, *chosen: str) -> Picture:
    """Return the picture that is chosen, or the one that fits a dataset."""
    return kinds()[kind].pictures_of(dataset, chosen)[0]


def draw(
    kind: str,
    dataset: xr.Dataset,
    options: Any = None,
    others: Mapping[str, xr.Dataset] | None = None,
) -> Figure:
    """Draw the picture that fits a dataset."""
    with house_style():
        return picture_of(kind, dataset).draw(dataset, options, others or {})


def caption(scene: Any, dataset: xr.Dataset, others: Mapping[str, xr.Dataset]) -> str:
    """Say what to see in the picture that fits a dataset."""
    return picture_of(scene.kind, dataset).describe(dataset, scene.figure, others)
