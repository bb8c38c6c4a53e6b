"""How far a motion can come: bounds that are proven, over whole grids of parameters, without a march.

Plain numpy, so that a study can be checked without the compiler.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

# Bounds are proven for exact arithmetic; this much more makes room for rounding.
ROUNDING = 1e-9


def largest_force(p: Mapping[str, np.ndarray]) -> float:
    """Largest size of the force over the grid: `load.largest_force`, without the compiler."""
    return float(np.abs(p["f"]).max())


def state_norm_bound(
    p: Mapping[str, np.ndarray], x: float, v: float, span: float, followed: bool
) -> float:
    """A proven bound of sqrt(x^2 + x'^2), and so of |x|, over all motions of the grid; inf if there is none.

    The least of: its growth by at most |f| in a unit of time, impacts or not; the ultimate bound of damped
    motions, where the equilibrium lies between the supports; the linear bound, where it keeps all motions
    off both supports.
    """
    start, force = math.hypot(x, v), largest_force(p)
    if force == 0.0:
        return start
    if followed:
        return math.inf
    sizes = [start + force * span]
    nearest, damping = float(p["l"].min() - np.abs(p["delta"]).max()), p["h"]
    if nearest >= 0.0 and damping.min() > 0.0:
        sizes.append(float(ultimate_bound(damping, force, start).max()))
    linear = float(linear_bound(p["nu"], damping.min(), force, start).max())
    if linear * (1 + ROUNDING) < nearest:
        sizes.append(linear)
    return min(sizes)


def linear_bound(nu: Any, h: float, f: float, start: float) -> np.ndarray:
    """Bound of sqrt(x^2 + x'^2) of motions that strike nothing, for each nu, from a start of that size.

    The bound of `stays_off_supports`, with the start of the free part bounded by start + 2 |X| max(1, nu);
    h >= 0 and f the least damping and the largest force of the grid. inf at resonance.
    """
    nu = np.asarray(nu, float)
    with np.errstate(divide="ignore"):
        steady = np.abs(f) / np.hypot((1.0 - nu) * (1.0 + nu), h * nu)
    size: np.ndarray = start + 2.0 * np.maximum(1.0, nu) * steady
    return size


def ultimate_bound(h: Any, f: float, start: float) -> np.ndarray:
    """Bound of sqrt(x^2 + x'^2) for all times, impacts and rests included, for each damping h > 0, from a
    start of size `start`, where the equilibrium lies between the supports.

    V = (x^2 + x'^2)/2 + e x x' with 0 < e <= 1/2 lies between (1 - e) and (1 + e) times r^2/2. A reset turns
    x x' > 0 to less and takes energy, so V never grows at an impact. In flight
    V' <= -k r^2 + |f| sqrt(1 + e^2) r, with k the least eigenvalue of [[e, e h/2], [e h/2, h - e]]; so V falls
    wherever r > |f| sqrt(1 + e^2)/k. e = 2 h/(4 + h^2) keeps k > 0 for every h.
    """
    h = np.asarray(h, float)
    e = 2.0 * h / (4.0 + h * h)
    remainder = h * (2.0 + h * h) / (4.0 + h * h)
    off = 0.5 * e * h
    # The product of both eigenvalues over the larger one.
    least = (e * remainder - off * off) / (0.5 * (h + np.hypot(remainder - e, 2.0 * off)))
    settled = np.abs(f) * np.hypot(1.0, e) / least
    size: np.ndarray = np.sqrt((1.0 + e) / (1.0 - e)) * np.maximum(start, settled)
    return size
