"""Cost of each physical effect and each output."""

from vibropipe.scenes.effects.keys import CHECKS, EffectsScene
from vibropipe.scenes.kind import Kind

KIND = Kind(__name__, EffectsScene, CHECKS, unit="timings", is_timed=True)
