"""Random orbits and their proofs: stored values against proved bounds."""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import numpy as np
import xarray as xr
from random_rows import draw_rows, solve_drawn

import vibropipe as vp
from vibropipe.solve.rows.label import ragged_indices

STORED = (
    "impact_phase",
    "impact_velocity",
    "displacement_mean",
    "displacement_strobe",
    "velocity_strobe",
    "displacement_amplitude",
)
# Largest number of impacts of an orbit that is proved here.
MAX_IMPACTS = 30


def each_point(dataset: xr.Dataset, dim: str) -> Iterator[xr.Dataset]:
    """Yield the rows, each with its own impacts, that are orbits with impacts and without rests."""
    sizes = dataset.row_size.values
    for k in range(dataset.sizes[dim]):
        own = ragged_indices(sizes, np.array([k]))
        row = dataset.isel({dim: k, "impact": own})
        n = row.impacts_per_orbit.sum().item()
        is_struck = row.period_multiple > 0 and 0 < n <= MAX_IMPACTS and n == own.size
        if is_struck and not row.rests_per_orbit.any():
            yield row


def random_rows(seed: int, n: int) -> Iterator[xr.Dataset]:
    """Yield the orbits of random exciters, corners of the parameters favoured."""
    yield from each_point(solve_drawn(draw_rows(seed, n)), "row")


def random_points(seed: int, n: int, along: str = "nu") -> Iterator[xr.Dataset]:
    """Yield points of branches of n random exciters, stable and unstable ones, bifurcations included."""
    rng = np.random.default_rng(seed)
    for _ in range(n):
        nu, f, h, R1, R2 = rng.uniform([0.6, 0.2, 0.02, 0.4, 0.4], [2.5, 1.5, 0.3, 0.9, 0.9])
        exciter = vp.Exciter(l=0.5, nu=nu, f=f, h=h, delta=rng.uniform(-0.3, 0.3), R1=R1, R2=R2)
        if vp.steady_state(exciter).period_multiple > 0:
            own = getattr(exciter, along)
            branch = vp.branch(exciter, along, (0.8 * own, 1.2 * own))
            at = branch.bifurcation_point.values
            numbers = np.arange(branch.sizes["point"])
            # the two neighbours of a bifurcation are beside it
            is_beside = (abs(numbers[:, None] - at) <= 1).any(axis=1)
            branch = branch.isel(bifurcation=slice(0)).assign(beside=("point", is_beside))
            yield from each_point(branch, "point")


def random_designs(seed: int, n: int) -> Iterator[xr.Dataset]:
    """Yield the designs of n searches around random exciters, met or not."""
    rng = np.random.default_rng(seed)
    for _ in range(n):
        nu, f, h, R1, R2 = rng.uniform([0.6, 0.2, 0.02, 0.4, 0.4], [2.5, 1.5, 0.3, 0.9, 0.9])
        exciter = vp.Exciter(l=0.5, nu=nu, f=f, h=h, delta=rng.uniform(-0.3, 0.3), R1=R1, R2=R2)
        start = vp.steady_state(exciter)
        if start.period_multiple == 0 or not start.impacts_per_orbit.any():
            continue
        target = {"displacement_amplitude_1": 1.02 * float(start.displacement_amplitude[0])}
        vary = {"nu": (0.9 * nu, 1.1 * nu), "R1": (0.9 * R1, 1.1 * R1)}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", vp.UnsolvedWarning)  # of a target that is out of reach
            found = vp.design(exciter, vary, target, minimise="energy_input", samples=64)
        yield from each_point(found, "design")


def shares_of_error(row: xr.Dataset, proof: xr.Dataset) -> list[float]:
    """Return how far stored values lie outside of their proved bounds, in stated errors."""
    shares = []
    for name in STORED:
        value, error = row[name].values, row[f"{name}_error"].values.astype(float)
        low, high = proof[f"{name}_low"].values, proof[f"{name}_high"].values
        if name == "displacement_amplitude":
            value, error = value[: low.size], error[: low.size]
        off = np.maximum(np.maximum(low - value, value - high), 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            shares += np.where(off > 0, off / error, 0.0).ravel().tolist()
    return shares
