"""Methods that solve a motion: the closed-form flow, and constant average acceleration."""

from __future__ import annotations

from typing import Literal, get_args

Method = Literal["exact", "newmark"]
METHODS: tuple[Method, ...] = get_args(Method)


def method_text(steps_per_period: int | None = None) -> str:
    """Return the method as text: the exact one, or newmark with its steps."""
    if steps_per_period is None:
        return "exact"
    return f"newmark, {steps_per_period} steps per forcing period"
