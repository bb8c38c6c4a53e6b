"""A conservative motion (h = f = 0, R1 = R2 = 1) in closed form, for any number of impacts."""

from __future__ import annotations

import math

import numpy as np

from vibropipe.compiler import jit
from vibropipe.physics.conservative import Arc, on_arc, speed_at, top_support

Columns = dict[str, np.ndarray]


@jit
def _sample(a: Arc, tau: np.ndarray, x: np.ndarray, v: np.ndarray) -> None:
    for i in range(tau.size):
        x[i], v[i] = on_arc(a, tau[i])


def positions(a: Arc, tau: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(x, v), each (n,), of a free motion at times tau (n,) after its start."""
    x, v = np.empty(tau.size), np.empty(tau.size)
    _sample(a, tau, x, v)
    return x, v


def _times(a: Arc, at: float, span: float, moving_in: bool) -> np.ndarray:
    """Times in [0, span] at which the motion passes the end that lies `at` after its upper end; one at the
    very start counts when the mass moves in."""
    period = 2 * a.half
    first = at - a.since
    if first < 0 or (first == 0 and not moving_in):
        first += period
    return first + period * np.arange(max(0, math.floor((span - first) / period) + 1))


def contacts(a: Arc, span: float, x: float, v: float, upper: float, lower: float) -> Columns:
    """Impacts and grazings of a free motion from (x, v), up to `span` after its start, in order of time:
    the columns of `simulate` with times counted from the start, and no rests."""
    impacts: dict[str, list[np.ndarray]] = {
        name: []
        for name in ("impact_tau", "impact_support", "impact_velocity", "impact_velocity_after")
    }
    grazings: dict[str, list[np.ndarray]] = {"grazing_tau": [], "grazing_support": []}
    top = top_support(a)
    for support in (top, 3 - top):
        meets = a.meets_top if support == top else a.meets_bottom
        if meets == 0:
            continue
        moving_in = v > 0 if support == 1 else v < 0
        at = 0.0 if support == top else a.half
        times = _times(a, at, span, moving_in or meets == 2)
        side = np.full(times.size, support, np.int8)
        if meets == 2:
            grazings["grazing_tau"].append(times)
            grazings["grazing_support"].append(side)
            continue
        speed = speed_at(x, v, upper if support == 1 else lower)
        before = np.full(times.size, speed if support == 1 else -speed)
        impacts["impact_tau"].append(times)
        impacts["impact_support"].append(side)
        impacts["impact_velocity"].append(before)
        impacts["impact_velocity_after"].append(-before)
    rests: Columns = {
        "rest_start": np.empty(0),
        "rest_end": np.empty(0),
        "rest_support": np.empty(0, np.int8),
    }
    return {**_in_order(impacts, "impact_tau"), **rests, **_in_order(grazings, "grazing_tau")}


def _in_order(columns: dict[str, list[np.ndarray]], key: str) -> Columns:
    kinds = {name: np.int8 if name.endswith("support") else float for name in columns}
    parts = columns[key]
    if len(parts) < 2:
        return {n: found[0] if found else np.empty(0, kinds[n]) for n, found in columns.items()}
    # Both ends are passed by turns, so that nothing must be sorted.
    later = parts[0].size == 0 or (parts[1].size > 0 and parts[1][0] < parts[0][0])
    early, late = (1, 0) if later else (0, 1)
    merged = {}
    for name, found in columns.items():
        merged[name] = np.empty(found[0].size + found[1].size, kinds[name])
        merged[name][0::2], merged[name][1::2] = found[early], found[late]
    return merged
