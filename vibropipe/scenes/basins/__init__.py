"""Coexisting motions, and which of them each start of a grid settles on."""

from vibropipe.scenes.basins.keys import CHECKS, BasinsScene
from vibropipe.scenes.kind import Kind

KIND = Kind(__name__, BasinsScene, CHECKS, unit="starts", packages=("scipy",))
