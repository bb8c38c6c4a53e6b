"""Known motions on which numerical methods fail, by every method."""

from vibropipe.scenes.hard_cases.keys import CHECKS, HardCasesScene
from vibropipe.scenes.kind import Kind

KIND = Kind(__name__, HardCasesScene, CHECKS, unit="cases")
