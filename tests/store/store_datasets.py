"""Synthetic datasets with names of the vocabulary, and their shards."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import xarray as xr

from vibropipe import store
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.words.vocabulary import describe

IDENTITY = {"kernel_hash": "0123456789abcdef", "fingerprint": "fedcba", "title": "Response"}


def motion(samples: int = 40, impacts: int = 5, seed: int = 0) -> xr.Dataset:
    """Return a motion with impacts, one rest without release, and no grazing."""
    random = np.random.default_rng(seed)
    sides = random.integers(1, 3, impacts).astype(np.int8)
    return describe(
        xr.Dataset(
            {
                "displacement": ("tau", random.normal(size=samples)),
                "velocity": ("tau", random.normal(size=samples)),
                "force": ("tau", random.normal(size=samples)),
                "impact_tau": ("impact", np.sort(random.uniform(0, 60, impacts))),
                "impact_support": ("impact", sides),
                "impact_velocity": ("impact", random.normal(size=impacts)),
                "rest_start": ("rest", [3.0]),
                "rest_end": ("rest", [np.inf]),
                "rest_support": ("rest", np.array([2], np.int8)),
                "grazing_tau": ("grazing", np.empty(0)),
                "grazing_support": ("grazing", np.empty(0, np.int8)),
                "displacement_end": 0.25,
                "status": np.int8(0),
            },
            coords={"tau": np.linspace(0, 60, samples), "l": 0.5, "nu": 1.0, "R1": 0.7},
            attrs=dict(IDENTITY),
        )
    )


def rows_of_sweep(rows: int, seed: int = 0, phases: int = 0) -> dict[str, np.ndarray]:
    """Return the quantities of a sweep of `rows` rows, rows first; impacts are concatenated in order of rows."""
    random = np.random.default_rng(seed)
    multiplier = random.normal(size=(rows, 2)) + 1j * random.normal(size=(rows, 2))
    mean = random.normal(size=rows)
    mean[::7] = np.nan
    values = {
        "regime": random.integers(0, 8, rows).astype(np.int8),
        "status": np.zeros(rows, np.int8),
        "period_multiple": random.integers(0, 5, rows).astype(np.int32),
        "displacement_mean": mean,
        "displacement_amplitude": random.normal(size=(rows, 3)),
        "impacts_per_orbit": random.integers(0, 3, (rows, 2)).astype(float),
        "floquet_multiplier": multiplier,
        "stable": (abs(multiplier).max(axis=1) < 1).astype(np.int8),
        "row_size": random.integers(0, 5, rows).astype(np.int32),
    }
    if phases:
        values["displacement"] = random.normal(size=(rows, phases))
    total = int(values["row_size"].sum())
    values["impact_velocity"] = random.normal(size=total)
    values["impact_support"] = random.integers(1, 3, total).astype(np.int8)
    return values


TRAILING = {
    "displacement_amplitude": "harmonic",
    "impacts_per_orbit": "support",
    "floquet_multiplier": "multiplier",
    "displacement": "phase",
}


def shard(
    values: dict[str, np.ndarray],
    start: int,
    stop: int,
    grid: SweepGrid | None = None,
    **scalars: float,
) -> xr.Dataset:
    """Return the rows [start, stop) as a shard, with their swept parameters if a grid is given."""
    starts = np.concatenate([[0], np.cumsum(values["row_size"])])
    variables = {}
    for name, all_rows in values.items():
        if name.startswith("impact_"):
            variables[name] = ("impact", all_rows[starts[start] : starts[stop]])
        elif name in TRAILING:
            variables[name] = (("row", TRAILING[name]), all_rows[start:stop])
        else:
            variables[name] = ("row", all_rows[start:stop])
    coords = {"harmonic": [1, 2, 3], "support": np.array([1, 2], np.int8), "h": 0.2, "l": 0.5}
    if "displacement" in values:
        phases = values["displacement"].shape[1]
        coords["phase"] = np.arange(phases) / phases
    if grid is not None:
        swept = grid.parameters(list(grid.values), np.arange(start, stop)).T
        coords |= {name: ("row", column) for name, column in zip(grid.values, swept, strict=True)}
    attrs = IDENTITY | {"row_start": start, "row_stop": stop}
    return describe(xr.Dataset(variables, coords | scalars, attrs))


def write_shards(
    folder: Path,
    values: dict[str, np.ndarray],
    cuts: list[int],
    grid: SweepGrid | None = None,
    **scalars: float,
) -> list[Path]:
    """Write the shards between the cuts (inner ones only) and return their paths."""
    ends = [0, *sorted(set(cuts)), len(values["row_size"])]
    paths = []
    for start, stop in pairwise(ends):
        paths.append(folder / f"{start:04d}.nc")
        store.save(shard(values, start, stop, grid, **scalars), paths[-1])
    return paths


def expected_grid(
    values: dict[str, np.ndarray], dims: dict[str, np.ndarray], follow: str | None
) -> tuple[dict[str, np.ndarray], dict[tuple[int, ...], np.ndarray]]:
    """Return what join must produce, computed row by row: values on the grid, and the impacts of each point."""
    names = list(dims)
    solving_order = [name for name in names if name != follow] + ([follow] if follow else [])
    shape = tuple(len(dims[name]) for name in names)
    starts = np.concatenate([[0], np.cumsum(values["row_size"])])
    gridded = {
        name: np.empty(shape + rows.shape[1:], rows.dtype)
        for name, rows in values.items()
        if not name.startswith("impact_")
    }
    impacts = {}
    for row, row_index in enumerate(np.ndindex(*(len(dims[name]) for name in solving_order))):
        point = tuple(row_index[solving_order.index(name)] for name in names)
        for name, grid in gridded.items():
            grid[point] = values[name][row]
        impacts[point] = values["impact_velocity"][starts[row] : starts[row + 1]]
    return gridded, impacts
