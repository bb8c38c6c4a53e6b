"""Effects: what of the physics a scene calls for, as types, so that an absent branch is never compiled.

Each field is 1 (present) or None (absent). numba types None at compile time, so `if effects.forcing is not
None` costs nothing where forcing is absent: the branch is not in the machine code, and every set of effects
is cached on disk like any other signature.
"""

from __future__ import annotations

from typing import NamedTuple


class Effects(NamedTuple):
    """Presence of each physical effect: 1 or None."""

    damping: int | None = 1
    forcing: int | None = 1
    support_1: int | None = 1
    support_2: int | None = 1
    restitution: int | None = 1
    rest: int | None = 1


ALL_EFFECTS = Effects()
