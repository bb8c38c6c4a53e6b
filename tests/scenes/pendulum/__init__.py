"""A kind of scene that the program does not know: periods of a pendulum over its amplitude."""

from pendulum.keys import CHECKS, PendulumScene
from vibropipe.scenes.kind import Kind

KIND = Kind(__name__, PendulumScene, CHECKS, unit="amplitudes")
