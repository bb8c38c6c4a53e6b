"""Pictures of a basins scene."""

from vibropipe.scenes.basins.basin_map import draw_basins
from vibropipe.scenes.basins.text import describe_basins
from vibropipe.scenes.kind import showing_picture

PICTURES = (showing_picture("basins", draw_basins, describe_basins),)
