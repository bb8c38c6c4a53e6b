"""Steady states over all combinations of swept parameters."""

from vibropipe.scenes.keys.checks import check_backbone
from vibropipe.scenes.kind import Kind
from vibropipe.scenes.sweep.keys import CHECKS, SweepScene

KIND = Kind(__name__, SweepScene, CHECKS, unit="rows", check_among=check_backbone, can_be_cut=True)
