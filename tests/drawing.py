"""Pictures of datasets by the name of their kind, as the jobs of a study draw them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.colors import to_rgb
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


def lightness(colour: str) -> float:
    """Return CIE L* of a colour, 0 to 100: how bright it is in print without colours."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
    luminance = float(np.dot((0.2126, 0.7152, 0.0722), linear))
    return 116 * luminance ** (1 / 3) - 16 if luminance > 216 / 24389 else luminance * 24389 / 27
