"""Attributes that say how a dataset was made, the same from Python and from a study."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from vibropipe.solve.sweep.sweep_grid import Follow
from vibropipe.words.methods import METHODS

EXACT, NEWMARK = METHODS


def origin_attrs(
    effects: Iterable[str], start: str, steps_per_period: int | None = None, follow: Follow = None
) -> dict[str, Any]:
    """Return the attributes of a dataset that say how it was made.

    They are `method` (exact or newmark), `effects`, `start` and `version`; `steps_per_period` and `follow` where there
    are any.

    effects : those that were computed
    start : where the motions start, as text
    steps_per_period : of Newmark's method; None for the exact method
    follow : followed parameter and direction
    """
    from vibropipe import __version__

    attrs: dict[str, Any] = {
        "method": EXACT if steps_per_period is None else NEWMARK,
        "effects": ", ".join(effects),
        "start": start,
        "version": __version__,
    }
    if steps_per_period is not None:
        attrs["steps_per_period"] = steps_per_period
    if follow is not None:
        attrs["follow"] = " ".join(follow)
    return attrs
