"""Motions with known properties on which numerical methods fail, solved by every method."""

from vibropipe.scenes.hard_cases.keys import CHECKS, HardCasesScene
from vibropipe.scenes.kind import Kind

KIND = Kind(__name__, HardCasesScene, CHECKS, unit="cases", packages=("scipy",))
