"""Proven bounds of motions over whole grids of parameters, without a march.

Plain numpy: a study is checked without the compiler.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

# Relative margin for rounding: the bounds are proven for exact arithmetic.
ROUNDING = 1e-9


def largest_force(p: Mapping[str, np.ndarray]) -> float:
    """Return the largest magnitude of the force over the grid: `load.largest_force`, without the compiler."""
    return float(np.abs(p["f"]).max() + np.abs(p.get("f2", 0.0)).max())


def state_norm_bound(
    p: Mapping[str, np.ndarray], x: float, v: float, span: float, followed: bool
) -> float:
    """Return a proven bound of sqrt(x^2 + x'^2), and so of |x|, over all motions of a grid.

    It is the least of three bounds: growth by at most |f| per unit of time, with or without impacts; the ultimate bound
    of damped motions, where the equilibrium lies between rigid supports; the linear bound, where it keeps all motions
    off both supports. Friction leaves only the first: it takes energy, but the motion is not a linear one.

    p : values of each parameter over the grid
    x, v : start
    span : duration of the motions in tau; may be inf
    followed : whether rows start from the steady state of a neighbour, so that only f = 0 bounds them

    Returns the bound; inf if there is none.
    """
    start, force = math.hypot(x, v), largest_force(p)
    nearest = float(p["l"].min() - np.abs(p["delta"]).max())
    stiffness = max(float(np.max(p.get(k, 0.0))) for k in ("k1", "k2"))
    if stiffness > 0.0:
        # The energy that a soft support gives back to a mass that starts beyond it.
        start = math.hypot(start, math.sqrt(stiffness) * max(0.0, abs(x) - nearest))
    if force == 0.0:
        return start
    if followed:
        return math.inf
    bounds = [start + force * span]
    if np.any(p.get("friction", 0.0)):
        return bounds[0]
    damping = p["h"]
    if nearest >= 0.0 and damping.min() > 0.0 and stiffness == 0.0:
        bounds.append(float(ultimate_bound(damping, force, start).max()))
    first, second = float(np.abs(p["f"]).max()), float(np.abs(p.get("f2", 0.0)).max())
    linear = float(linear_bound(p["nu"], damping.min(), first, start).max())
    if second > 0.0:
        linear += float(linear_bound(2.0 * p["nu"], damping.min(), second, 0.0).max())
    if linear * (1 + ROUNDING) < nearest:
        bounds.append(linear)
    return min(bounds)


def linear_bound(nu: Any, h: float, f: float, start: float) -> np.ndarray:
    """Return a bound of sqrt(x^2 + x'^2) of motions without impacts.

    It is the bound of `stays_off_supports`, with the start of the free part bounded by start + 2 |X| max(1, nu).

    nu : forcing frequencies
    h, f : least damping, >= 0, and largest force of the grid
    start : sqrt(x^2 + x'^2) at the start

    Returns the bound for each nu; inf at resonance without damping.
    """
    nu = np.asarray(nu, float)
    with np.errstate(divide="ignore"):
        steady = np.abs(f) / np.hypot((1.0 - nu) * (1.0 + nu), h * nu)
    bound: np.ndarray = start + 2.0 * np.maximum(1.0, nu) * steady
    return bound


def ultimate_bound(h: Any, f: float, start: float) -> np.ndarray:
    """Return a bound of sqrt(x^2 + x'^2) for all times, impacts and rests included.

    The equilibrium must lie between the supports.

    The Lyapunov function V = (x^2 + x'^2)/2 + e x x' with 0 < e <= 1/2 lies between (1 - e) and (1 + e) times r^2/2. An
    impact has x x' > 0 before it, reduces x x' and takes energy, so V never grows there. In flight
    V' <= -k r^2 + |f| sqrt(1 + e^2) r, with k the least eigenvalue of [[e, e h/2], [e h/2, h - e]]; so V falls wherever
    r > |f| sqrt(1 + e^2)/k. e = 2 h/(4 + h^2) keeps k > 0 for every h.

    h : damping, > 0
    f : largest force
    start : sqrt(x^2 + x'^2) at the start

    Returns the bound for each h.

    Reference: H. K. Khalil, "Nonlinear Systems", 3rd ed., Prentice Hall (2002), sec. 4.8.
    """
    h = np.asarray(h, float)
    e = 2.0 * h / (4.0 + h * h)
    matrix_22 = h * (2.0 + h * h) / (4.0 + h * h)
    matrix_12 = 0.5 * e * h
    # The product of both eigenvalues over the larger one.
    least_eigenvalue = (e * matrix_22 - matrix_12 * matrix_12) / (
        0.5 * (h + np.hypot(matrix_22 - e, 2.0 * matrix_12))
    )
    ultimate_radius = np.abs(f) * np.hypot(1.0, e) / least_eigenvalue
    bound: np.ndarray = np.sqrt((1.0 + e) / (1.0 - e)) * np.maximum(start, ultimate_radius)
    return bound
