"""Steady states over all combinations of swept parameters."""

from vibropipe.scenes.kind import Kind
from vibropipe.scenes.sweep.keys import CHECKS, SweepScene, check_backbone

KIND = Kind(__name__, SweepScene, CHECKS, unit="rows", check_among=check_backbone, can_be_cut=True)
