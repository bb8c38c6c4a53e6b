"""Pictures of a design scene."""

import xarray as xr

from vibropipe.scenes.design.front import describe_front, draw_front, is_front, title_front
from vibropipe.scenes.design.ranking import describe_designs, draw_designs, title_designs
from vibropipe.scenes.design.sketch import describe_sketch, draw_sketch, title_sketch
from vibropipe.scenes.design.spread_pictures import (
    describe_sensitivities,
    describe_tornado,
    draw_sensitivities,
    draw_tornado,
    title_sensitivities,
    title_tornado,
)
from vibropipe.scenes.kind import Picture


def has_designs(dataset: xr.Dataset) -> bool:
    """Return whether a dataset holds designs, and not the spread of one exciter."""
    return "vary" in dataset.attrs


COMPARE = "How do the designs compare?"
MATTERS = "Which parameter matters most?"
PICTURES = (
    Picture("front", draw_front, describe_front, is_front, titled=title_front),
    Picture("sketch", draw_sketch, describe_sketch, has_designs, titled=title_sketch),
    Picture(
        "designs",
        draw_designs,
        describe_designs,
        has_designs,
        titled=title_designs,
        heading=COMPARE,
    ),
    Picture("tornado", draw_tornado, describe_tornado, titled=title_tornado, heading=MATTERS),
    Picture(
        "sensitivities",
        draw_sensitivities,
        describe_sensitivities,
        titled=title_sensitivities,
        heading=MATTERS,
    ),
)
