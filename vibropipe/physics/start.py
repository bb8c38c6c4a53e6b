"""Where motions start: between the supports, on one within rounding, and where no start is given."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

# A start beyond a support by no more than this share of the lengths that its place is made of lies on it: 4 ulps, since
# l + delta and delta - l are rounded, and a start written in decimals is too. So does one as near before it, if it has
# no velocity: with one it is in flight, where a motion may be as small as it likes and is gone on with from any place.
START_ROUNDING = 2.0**-50


def support_positions(half: Any, delta: Any) -> tuple[Any, Any]:
    """x of support 1 and of support 2, eq. (1), of numbers or arrays l and delta."""
    return half + delta, delta - half


def start_room(half: Any, delta: Any) -> tuple[Any, Any]:
    """Least and largest x0 that are taken with supports at l + delta and delta - l."""
    rounding = START_ROUNDING * np.maximum(np.abs(half), np.abs(delta))
    upper, lower = support_positions(half, delta)
    return lower - rounding, upper + rounding


def start_at(half: Any, delta: Any, x0: float | None, v0: float) -> Any:
    """The displacement that motions start from, for each l and delta: x0, or a support that it is within rounding
    of; left out (None) the equilibrium, or the support nearest to it where that lies beyond."""
    upper, lower = support_positions(half, delta)
    x = np.minimum(np.maximum(0.0 if x0 is None else x0, lower), upper)
    if v0 != 0.0:
        return x
    rounding = START_ROUNDING * np.maximum(np.abs(half), np.abs(delta))
    to_upper, to_lower = upper - x, x - lower
    x = np.where((to_upper <= rounding) & (to_upper <= to_lower), upper, x)
    return np.where((to_lower <= rounding) & (to_lower < to_upper), lower, x)


def row_starts(parameters: np.ndarray, x0: float | None, v0: float) -> np.ndarray:
    """Starts (rows, 2) of parameters (rows, 7)."""
    starts = np.empty((len(parameters), 2))
    starts[:, 0], starts[:, 1] = start_at(parameters[:, 3], parameters[:, 4], x0, v0), v0
    return starts


def largest_start(values: Mapping[str, Any], x0: float | None) -> float:
    """The start farthest from the equilibrium over the grid of `values` (parameter name -> its values); 0 where one
    left out is the equilibrium in every row."""
    if x0 is not None:
        return x0
    half, delta = (np.asarray(values[name], float) for name in ("l", "delta"))
    return max(0.0, float(np.abs(delta).max() - half.min()))


def start_text(values: Mapping[str, Any], x0: float | None, v0: float) -> str:
    """A start in words, for the attributes of a dataset; as `largest_start`."""
    place = f"{0.0 if x0 is None else float(x0):g}"
    if x0 is None and largest_start(values, None) > 0.0:
        place = "0 or the support nearest to it"
    return f"x0 = {place}, v0 = {float(v0):g}"
