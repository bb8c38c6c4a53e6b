"""Names of the physical effects that an exciter can have or lack, made from their records (`words.exciter`)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from vibropipe.words.exciter import EFFECTS

EFFECT_NAMES = tuple(each.name for each in EFFECTS)
if TYPE_CHECKING:
    Effect = str
else:
    Effect = Literal[EFFECT_NAMES]

COMMON_EFFECTS = tuple(each.name for each in EFFECTS if each.is_common)
"""Effects of eqs. (5), (6), which kernels have unless effects are stated; further ones only where they are present."""
