"""Names of the physical effects that an exciter can have or lack."""

from __future__ import annotations

from typing import Literal, get_args

Effect = Literal[
    "damping",
    "forcing",
    "support_1",
    "support_2",
    "restitution",
    "rest",
    "load",
    "soft",
    "friction",
    "second_harmonic",
]
EFFECT_NAMES: tuple[Effect, ...] = get_args(Effect)
COMMON_EFFECTS: tuple[Effect, ...] = EFFECT_NAMES[:6]
"""Effects of eqs. (5), (6), which kernels have unless effects are stated; further ones only where they are present."""
