"""What can be asked for of a motion or of a steady state, and which of it each face takes."""

from __future__ import annotations

from typing import Literal, get_args

Output = Literal["harmonics", "impacts", "motion", "stability", "energy"]
OUTPUTS: tuple[str, ...] = get_args(Output)
"""All of them, as a sweep takes them; a result holds them in this order."""

SWEEP_DEFAULT: tuple[Output, ...] = ("harmonics", "impacts", "stability")
MOTION_DEFAULT: tuple[Output, ...] = ("motion", "impacts")
OF_STEADY_STATE: tuple[Output, ...] = ("harmonics", "impacts", "stability", "energy")
"""What `steady_state` returns: its motion is that of a sweep of one row."""

OF_MOTION: tuple[Output, ...] = ("impacts", "motion")
"""What is there of a motion without its steady state."""

OF_ORBIT: frozenset[str] = frozenset(OUTPUTS) - frozenset(OF_MOTION)
"""What needs the steady state on which a motion settles."""
