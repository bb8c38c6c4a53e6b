"""Outputs of a motion and of a steady state, and which of them each function returns."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Literal, get_args

Output = Literal[
    "harmonics",
    "impacts",
    "motion",
    "stability",
    "energy",
    "power",
    "frame",
    "subharmonics",
    "poincare",
    "lyapunov",
    "sensitivity",
]
OUTPUTS: tuple[str, ...] = get_args(Output)
"""All outputs, in the order in which a dataset holds them; a sweep can have each."""

SWEEP_DEFAULT: tuple[Output, ...] = ("harmonics", "impacts", "stability")
MOTION_DEFAULT: tuple[Output, ...] = ("motion", "impacts")
OF_STEADY_STATE: tuple[Output, ...] = ("harmonics", "impacts", "stability", "energy")
"""Outputs of `steady_state` unless others are requested."""

OF_BRANCH: tuple[Output, ...] = (*OF_STEADY_STATE, "power", "frame", "subharmonics", "sensitivity")
"""Outputs that points of branches can have."""

FOLLOWS_FROM: Mapping[str, tuple[Output, ...]] = {
    "power": ("energy", "impacts"),
    "frame": ("energy", "harmonics", "impacts"),
}
"""Outputs that follow from others, which are computed for them."""

OF_MOTION: tuple[Output, ...] = ("impacts", "motion")
"""Outputs of a motion that need no steady state."""

OF_ORBIT: frozenset[str] = frozenset(OUTPUTS) - frozenset(OF_MOTION)
"""Outputs that need the steady state."""


def computed(outputs: Collection[str]) -> tuple[str, ...]:
    """Return what is computed for some outputs: they and those that they follow from, in the order of `OUTPUTS`."""
    sources = {source for name in outputs for source in FOLLOWS_FROM.get(name, ())}
    return tuple(name for name in OUTPUTS if name in outputs or name in sources)
