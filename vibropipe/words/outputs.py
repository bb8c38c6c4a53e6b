"""Outputs of a motion and of a steady state, and which of them each function returns."""

from __future__ import annotations

from typing import Literal, get_args

Output = Literal[
    "harmonics",
    "impacts",
    "motion",
    "stability",
    "energy",
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

OF_BRANCH: tuple[Output, ...] = (*OF_STEADY_STATE, "subharmonics", "sensitivity")
"""Outputs that points of branches can have."""

OF_MOTION: tuple[Output, ...] = ("impacts", "motion")
"""Outputs of a motion that need no steady state."""

OF_ORBIT: frozenset[str] = frozenset(OUTPUTS) - frozenset(OF_MOTION)
"""Outputs that need the steady state."""
