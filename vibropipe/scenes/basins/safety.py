"""How easily a motion is lost, by the map of its basins: knocks that it survives, and where starts from rest lead."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr


def knocks_of(dataset: xr.Dataset) -> dict[int, float]:
    """Return for each attractor the change of velocity within which the starts of the map lead back to it.

    All starts of the map in the columns beside a state at the section, within this change of its velocity, settle on
    the attractor; of several states the least change. NaN without an orbit, which has more states than are stored,
    where a state lies beyond the map, and if the starts are at another phase.
    """
    ordered = dataset.sortby(["x0", "v0"])
    x0, v0 = ordered["x0"].values, ordered["v0"].values
    attractor = ordered["attractor"].transpose("x0", "v0").values
    at_section = float(dataset["start_phase"]) == 0.0
    found = {}
    for index in dataset["attractor_id"].values.tolist():
        states = states_of(dataset, index)
        knocks = [
            reach(v0, attractor[columns] == index, v)
            for x, v in states
            if (columns := beside(x0, x)).size
        ]
        is_orbit = int(dataset["period_multiple"].sel(attractor_id=index)) > 0
        known = at_section and is_orbit and len(knocks) == len(states) > 0
        found[int(index)] = float(np.min(knocks)) if known else math.nan  # NaN if one is
    return found


def states_of(dataset: xr.Dataset, index: int) -> np.ndarray:
    """Return the states (n, 2) of an attractor at the section: of an orbit one a period, else all that are stored."""
    row = dataset.sel(attractor_id=index)
    n = int(row["period_multiple"]) or row.sizes["visit"]
    states = [row[f"poincare_{name}"].values[-n:] for name in ("displacement", "velocity")]
    found = np.stack(states, axis=1)
    return found[np.isfinite(found).all(axis=1)]


def beside(values: np.ndarray, value: float) -> np.ndarray:
    """Return the indices of the ascending values on either side of one, or of itself; none beyond them."""
    if not values[0] <= value <= values[-1]:
        return np.empty(0, int)
    after = int(np.searchsorted(values, value))
    return np.array([after] if values[after] == value else [after - 1, after])


def reach(v0: np.ndarray, own: np.ndarray, v: float) -> float:
    """Return the distance from a velocity within which all starts of some columns (columns, v0) are own ones.

    It ends at the last own start before the first other one, and at the nearer end of the map; NaN beyond the map, and
    where that end is nearer than a step.
    """
    edge = min(v - v0[0], v0[-1] - v)
    if edge < 0.0:
        return math.nan
    distance, is_own = np.abs(v0 - v), own.all(axis=0)
    first = distance[~is_own].min(initial=np.inf)
    if first > edge:
        return float(edge) if edge >= np.diff(v0).max(initial=0.0) > 0.0 else math.nan
    return float(distance[distance < first].max(initial=0.0))


def step_of(dataset: xr.Dataset) -> float:
    """Return the largest step of the velocities of the map, 0 for a single one."""
    return float(np.diff(np.sort(dataset["v0"].values)).max(initial=0.0))


def at_rest(dataset: xr.Dataset) -> tuple[int | None, bool]:
    """Return the attractor of the starts of the map at rest in the equilibrium, and whether rest itself is a start.

    The attractor is None if the starts beside rest have several, or none, or the map does not contain it.
    """
    columns, rows = (beside(np.sort(dataset[name].values), 0.0) for name in ("x0", "v0"))
    if not (columns.size and rows.size):
        return None, False
    attractor = dataset.sortby(["x0", "v0"])["attractor"].transpose("x0", "v0").values
    around = np.unique(attractor[np.ix_(columns, rows)])
    is_start = columns.size == rows.size == 1
    return (int(around[0]) if around.size == 1 and around[0] >= 0 else None), is_start
