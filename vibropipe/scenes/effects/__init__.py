"""What each effect and each output costs."""

from vibropipe.scenes.effects.keys import CHECKS, EffectsScene
from vibropipe.scenes.kind import Kind

KIND = Kind(__name__, EffectsScene, CHECKS, unit="timings", is_timed=True)
