"""Values that a change of the code's form must leave as they are: rows, branches and boundaries of all effects.

They were computed by the same package, so they prove nothing by themselves: other tests hold them against references.
`python tests/solve/test_held_values.py` writes them anew, after a change that is meant to move them.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp

HELD = Path(__file__).parents[1] / "reference" / "held.json"
DIGITS = 1e-12
"""Largest change of a value of an orbit, relative to it or to 1, beside ten times its stated error."""
LABELS = ("regime", "status")
COUNTS = ("period_multiple", "impacts_per_orbit", "rests_per_orbit")
OUTPUTS = ("harmonics", "impacts", "stability", "energy")
SWITCHED = ("flip", "pitchfork", "grazing")
PAPER = {"l": 0.5, "h": 0.2, "f": 1.0, "R1": 0.7, "R2": 0.7}
SOFT = {"l": 0.5, "h": 0.2, "f": 0.6, "k1": 40.0, "h1": 1.0, "R2": 0.7}
STICKING = {"l": 0.8, "h": 0.1, "f": 1.0, "R1": 0.7, "R2": 0.6, "friction": 0.1}


def drawn_rows() -> dict[str, dict[str, float]]:
    """Return exciters of all effects, drawn once and for all, by names."""
    rng = np.random.default_rng(20261125)
    effects: dict[str, tuple[str, ...]] = {
        "rigid": (),
        "load": ("load",),
        "second": ("f2", "phi2"),
        "soft": ("k1", "h1"),
        "friction": ("friction",),
        "all": ("load", "f2", "phi2", "k2", "h2", "friction"),
    }
    ranges = {
        "nu": (0.4, 2.5), "f": (0.2, 1.5), "h": (0.05, 0.5), "l": (0.3, 1.2), "delta": (-0.1, 0.1),
        "R1": (0.4, 0.9), "R2": (0.4, 0.9), "load": (-0.1, 0.1), "f2": (0.1, 0.5), "phi2": (0.0, 6.0),
        "k1": (5.0, 100.0), "h1": (0.2, 3.0), "k2": (5.0, 100.0), "h2": (0.2, 3.0), "friction": (0.02, 0.15),
    }  # fmt: skip
    usual = ("nu", "f", "h", "l", "delta", "R1", "R2")
    rows = {}
    for name, further in effects.items():
        for i in range(12):
            row = {key: round(float(rng.uniform(*ranges[key])), 6) for key in (*usual, *further)}
            for support in "12":  # a soft support has no restitution of its own
                if f"k{support}" in row:
                    del row[f"R{support}"]
            rows[f"{name}_{i}"] = row
    return rows


BRANCHES: dict[str, tuple[dict[str, float], str, tuple[float, float], dict[str, Any]]] = {
    "rigid": (PAPER | {"nu": 1.0}, "nu", (0.6, 1.6), {"at": (0.8, 1.0, 1.2), "switch": SWITCHED}),
    "force": (PAPER | {"nu": 1.1, "R2": 0.6}, "f", (0.3, 1.5), {"at": (0.5, 1.2), "switch": ("grazing",)}),
    "second": (PAPER | {"nu": 1.0, "f2": 0.2}, "nu", (0.8, 1.3), {"at": (0.9, 1.1)}),
    "soft": (SOFT | {"nu": 1.0}, "nu", (0.8, 1.3), {"at": (0.9, 1.1)}),
    "friction": (STICKING | {"nu": 1.2}, "nu", (1.0, 1.5), {"at": (1.1, 1.4)}),
}  # fmt: skip
BOUNDARIES: dict[str, tuple[dict[str, float], str, dict[str, Any]]] = {
    "fold": (PAPER, "fold", {"lines": 3, "within": ((0.8, 1.6), (0.5, 1.5))}),
    "flip": (PAPER | {"R2": 0.6}, "flip", {"lines": 3, "within": ((0.5, 1.2), (0.5, 1.5))}),
    "grazing": (SOFT, "grazing", {"lines": 2, "within": ((0.9, 1.2), (0.2, 0.6))}),
}


def row_of(name: str) -> dict[str, Any]:
    """Return labels of a drawn row, and of an orbit its values."""
    exciter = vp.Exciter(**drawn_rows()[name])
    return record(vp.steady_state(exciter, outputs=OUTPUTS, harmonics=3))


def branch_of(name: str) -> dict[str, Any]:
    """Return the orbits asked of a branch by its parameter, and its bifurcations."""
    parameters, along, to, options = BRANCHES[name]
    ds = vp.branch(vp.Exciter(**parameters), along, to, harmonics=3, **options)
    asked = np.flatnonzero(np.isin(ds[along], options["at"]))
    found: dict[str, Any] = {f"point_{k}": record(ds.isel(point=i)) for k, i in enumerate(asked)}
    ends = [n for n in ds.variables if ds[n].dims == ("bifurcation",) and n != "bifurcation_point"]
    return found | {str(n): ds[n].values.tolist() for n in ends}


def boundary_of(name: str) -> dict[str, Any]:
    """Return the curves of a boundary by what they meet and where."""
    parameters, of, options = BOUNDARIES[name]
    ds = vp.boundary(vp.Exciter(nu=1.0, **{"f": 1.0} | parameters), of, **options)
    names = ("meeting_kind", "meeting_nu", "meeting_f", "meeting_ends")
    return {n: ds[n].values.tolist() for n in names}


def record(ds: xr.Dataset) -> dict[str, Any]:
    """Return the labels of one row, and of an orbit its values with one number a row, support or harmonic."""
    found = {n: ds[n].values.tolist() for n in LABELS if n in ds}
    multipliers = np.abs(ds.floquet_multiplier.values)
    if np.isfinite(multipliers).all():
        found |= {n: ds[n].values.tolist() for n in COUNTS if n in ds}
        found["spectral_radius"] = float(multipliers.max())
        found["spectral_radius_error"] = float(ds.floquet_multiplier_error.max())
        for n, v in sorted(ds.data_vars.items()):
            name, error = str(n), ds.get(f"{n}_error", ds.displacement_strobe_error)
            if name.endswith("_phase") and v.dims == (
                "harmonic",
            ):  # any where the amplitude is zero: hold the parts of both
                amplitude, name = name.replace("phase", "amplitude"), name.replace("phase", "parts")
                v = ds[amplitude] * xr.concat([np.cos(v), np.sin(v)], "support")
                error = ds.get(f"{amplitude}_error", ds.displacement_strobe_error)
            is_value = v.dtype == float and name not in COUNTS
            if is_value and set(v.dims) <= {"support", "harmonic"}:
                found[name] = v.values.tolist()
                found[f"{name}_error"] = float(error.fillna(0.0).max())
    return found


def differences(got: Any, held: Any, limit: float, path: str = "") -> Iterator[str]:
    """Yield where values are not the held ones, by more than a limit and ten times their errors."""
    if isinstance(held, dict):
        if got.keys() != held.keys():
            yield f"{path}: {sorted(got)} in place of {sorted(held)}"
            return
        for key in held:
            if not key.endswith("_error"):
                own = limit + 10 * held.get(f"{key}_error", 0.0)
                yield from differences(got[key], held[key], own, f"{path}.{key}")
    elif isinstance(held, int) or np.asarray(held).dtype == int:
        if got != held:
            yield f"{path}: {got} in place of {held}"
    else:
        one, two = np.array(got, float), np.array(held, float)
        if one.shape != two.shape or not np.allclose(one, two, limit, limit, equal_nan=True):
            yield f"{path}: {got} in place of {held}"


def held(sort: str) -> dict[str, Any]:
    values: dict[str, Any] = json.loads(HELD.read_text())[sort]
    return values


@pytest.mark.parametrize("name", drawn_rows())
def test_rows_are_as_held(name: str) -> None:
    assert not [*differences(row_of(name), held("rows")[name], DIGITS)]


@pytest.mark.parametrize("name", BRANCHES)
def test_branches_are_as_held(name: str) -> None:
    """Bifurcations are located to 1e-9 of their parameter."""
    got, want = branch_of(name), held("branches")[name]
    points = [key for key in want if key.startswith("point_")]
    for key in points:
        assert not [*differences(got.pop(key), want.pop(key), DIGITS, key)]
    assert not [*differences(got, want, 1e-9)]


@pytest.mark.parametrize("name", BOUNDARIES)
def test_boundaries_are_as_held(name: str) -> None:
    assert not [*differences(boundary_of(name), held("boundaries")[name], 1e-9)]


if __name__ == "__main__":
    values = {
        "rows": {name: row_of(name) for name in drawn_rows()},
        "branches": {name: branch_of(name) for name in BRANCHES},
        "boundaries": {name: boundary_of(name) for name in BOUNDARIES},
    }
    sorts = (
        f'"{sort}": {{\n' + ",\n".join(f'"{n}": {json.dumps(v)}' for n, v in found.items()) + "\n}"
        for sort, found in values.items()
    )
    HELD.write_text("{" + ",\n".join(sorts) + "}\n")
