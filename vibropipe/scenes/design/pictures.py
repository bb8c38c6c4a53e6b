"""Pictures of a design scene."""

from vibropipe.scenes.design.captions import (
    describe_designs,
    describe_front,
    describe_sensitivities,
    describe_tornado,
)
from vibropipe.scenes.design.panels import draw_designs, draw_front, is_front
from vibropipe.scenes.design.spread_pictures import draw_sensitivities, draw_tornado
from vibropipe.scenes.kind import Picture

PICTURES = (
    Picture("front", draw_front, describe_front, is_front),
    Picture("designs", draw_designs, describe_designs, lambda data: "vary" in data.attrs),
    Picture("tornado", draw_tornado, describe_tornado),
    Picture("sensitivities", draw_sensitivities, describe_sensitivities),
)
