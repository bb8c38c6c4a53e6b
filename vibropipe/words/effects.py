"""Names of the physical effects that an exciter can have or lack."""

from __future__ import annotations

from typing import Literal, get_args

Effect = Literal["damping", "forcing", "support_1", "support_2", "restitution", "rest"]
EFFECT_NAMES: tuple[Effect, ...] = get_args(Effect)
