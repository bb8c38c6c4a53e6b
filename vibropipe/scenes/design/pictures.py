"""Pictures of a design scene."""

from vibropipe.scenes.design.captions import (
    describe_designs,
    describe_front,
    describe_sensitivities,
    describe_tornado,
)
from vibropipe.scenes.design.panels import draw_designs, draw_front, is_front
from vibropipe.scenes.design.spread_pictures import draw_sensitivities, draw_tornado
from vibropipe.scenes.kind import only_picture

PICTURES = (
    only_picture("front", draw_front, describe_front, is_front),
    only_picture("designs", draw_designs, describe_designs),
    only_picture("tornado", draw_tornado, describe_tornado),
    only_picture("sensitivities", draw_sensitivities, describe_sensitivities),
)
