"""Starts of motions: between the supports, on a support within rounding, or by default."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.parameter_error import ParameterError, as_float, number_within
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.records import FINITE

if TYPE_CHECKING:
    from vibropipe.physics.exciter import Exciter

# Parameters that a start depends on, and their columns.
OF_START = ("l", "delta", "load")
COLUMNS = tuple(list(PARAMETERS).index(name) for name in (*OF_START, "k1", "k2"))
# Largest distance from a support at which a start is moved on to it, as a share of max(l, |delta|): 4 ulps, since
# l + delta, delta - l and a start in decimals are rounded. A start between the supports is moved only if it has no
# velocity: with one it is in flight, and a motion may be continued from any state, however close to a support.
START_ROUNDING = 2.0**-50


def support_positions(half: Any, delta: Any) -> tuple[Any, Any]:
    """Return x of support 1 and of support 2, eq. (1); half is l, and both arguments are numbers or arrays."""
    return half + delta, delta - half


def start_room(exciter: Exciter) -> tuple[float, float]:
    """Return the least and the largest x0 that are accepted: `room`, and rounding beyond rigid supports."""
    rounding = START_ROUNDING * max(abs(exciter.l), abs(exciter.delta))
    least, most = room(exciter)
    return least - rounding, most + rounding


def start_at(half: Any, delta: Any, x0: Any, v0: Any, load: Any = 0.0) -> Any:
    """Return the displacement that motions start from, for each l, delta and load.

    half, delta : l and delta
    x0 : displacement; None is the equilibrium, or the support nearest to it where that lies beyond
    load : constant force; the equilibrium is there

    Returns x0, or the position of a support within START_ROUNDING of it.
    """
    upper, lower = support_positions(half, delta)
    x = flying = np.minimum(np.maximum(load if x0 is None else x0, lower), upper)
    if np.ndim(v0) == 0 and v0 != 0.0:
        return x
    rounding = START_ROUNDING * np.maximum(np.abs(half), np.abs(delta))
    to_upper, to_lower = upper - x, x - lower
    x = np.where((to_upper <= rounding) & (to_upper <= to_lower), upper, x)
    x = np.where((to_lower <= rounding) & (to_lower < to_upper), lower, x)
    return x if np.ndim(v0) == 0 else np.where(v0 == 0.0, x, flying)


def checked_start(exciter: Exciter, x0: float | None, v0: float) -> tuple[float, float]:
    """Return a start as floats, on a support that it is within rounding of: `Exciter.check_start`."""
    v = number_within("v0", v0, FINITE)
    x = None
    if x0 is not None:
        allowed = f"a finite number from {exciter.lower:.10g} to {exciter.upper:.10g} (between the supports)"
        x = as_float("x0", x0, allowed)
        least, most = start_room(exciter)
        if (x > exciter.upper and exciter.k1 > 0.0) or (x < exciter.lower and exciter.k2 > 0.0):
            return number_within("x0", x, FINITE), v
        if not least <= x <= most:
            raise ParameterError("x0", x, allowed)
    return float(start_at(exciter.l, exciter.delta, x, v, exciter.load)), v


def room(exciter: Exciter) -> tuple[float, float]:
    """Return the least and the largest displacement of the mass: the supports where they are rigid."""
    least, most = exciter.lower, exciter.upper
    return -np.inf if exciter.k2 > 0.0 else least, np.inf if exciter.k1 > 0.0 else most


def within_room(exciter: Exciter, x: float) -> float:
    """Return a displacement, moved onto the rigid support that it lies beyond."""
    least, most = room(exciter)
    return min(max(x, least), most)


def row_starts(parameters: np.ndarray, x0: Any, v0: Any) -> np.ndarray:
    """Return the starts of rows.

    parameters : (rows, parameters), in the order of `PARAMETERS`
    x0, v0 : as in `start_at`; x0 may lie beyond a soft support

    Returns (rows, 2), displacement and velocity.
    """
    starts = np.empty((len(parameters), 2))
    half, delta, load, k1, k2 = (parameters[:, column] for column in COLUMNS)
    starts[:, 0], starts[:, 1] = start_at(half, delta, x0, v0, load), v0
    if x0 is not None:
        upper, lower = support_positions(half, delta)
        is_beyond = ((k1 > 0.0) & (x0 > upper)) | ((k2 > 0.0) & (x0 < lower))
        starts[:, 0] = np.where(is_beyond, x0, starts[:, 0])
    return starts


def largest_start(values: Mapping[str, Any], x0: float | None) -> float:
    """Return the displacement from the equilibrium of the start farthest from it over a grid.

    values : values of each parameter over the grid, and of x0 if it is swept
    x0 : as in `start_at`

    Returns 0 for None where the default start is the equilibrium in every row.
    """
    half, delta, load = (np.asarray(values.get(name, 0.0), float) for name in OF_START)
    if "x0" in values:
        return float(np.abs(values["x0"]).max() + np.abs(load).max())
    if x0 is not None:
        ends = x0 - load.min(), x0 - load.max()
        return float(max(ends, key=abs))
    offset = max(delta.max() - load.min(), load.max() - delta.min())
    return max(0.0, float(offset - half.min()))


def largest_velocity(values: Mapping[str, Any], v0: float) -> float:
    """Return the largest speed of a start over a grid: of the values of v0 if it is swept."""
    return float(np.abs(values["v0"]).max()) if "v0" in values else v0


def start_text(values: Mapping[str, Any], x0: float | None, v0: float) -> str:
    """Return a start as text for the attributes of a dataset; arguments are those of `largest_start`."""
    load = np.asarray(values.get("load", 0.0), float)
    equilibrium = f"{float(load.max()):g}" if load.min() == load.max() else "load"
    x0_text = f"= {equilibrium if x0 is None else f'{float(x0):g}'}"
    if "x0" in values:
        x0_text = "swept"
    elif x0 is None and largest_start(values, None) > 0.0:
        x0_text = f"= {equilibrium} or the support nearest to it"
    v0_text = "swept" if "v0" in values else f"= {float(v0):g}"
    return f"x0 {x0_text}, v0 {v0_text}"
