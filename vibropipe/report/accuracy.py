"""How far the datasets can be trusted, what they cost, and what they were made from."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from vibropipe.figures.text import departure, format_number
from vibropipe.report.table import DASH, Datasets, Table, breakable
from vibropipe.words.wording import series

Sidecars = Mapping[str, Mapping[str, Any]]

HEAD = ["scene", "method", "asked", "reached", "from exact", "residual", "seconds"]
# attribute of a dataset -> how the report calls it
SOURCES = {
    "source": "made by",
    "git_commit": "commit",
    "kernel_hash": "kernels",
    "study_hash": "study text",
    "versions": "versions",
    "machine": "kind of machine",
}
HASH_LENGTH = 12


def accuracy_table(datasets: Datasets, sidecars: Sidecars) -> Table:
    """Return one row per scene: method, accuracy asked for and reached, measures, time taken."""
    rows = []
    for name, dataset in datasets.items():
        rows.append(
            [
                breakable(name),
                str(dataset.attrs.get("method", DASH)),
                attribute(dataset, "accuracy_asked"),
                reached(dataset),
                format_number(departure(dataset), 2) if "displacement_exact" in dataset else DASH,
                format_number(largest_residual(dataset), 2),
                seconds_text(sidecars.get(name, {})),
            ]
        )
    caption = (
        "Method, accuracy asked for and reached, and what was measured on each dataset. A dash: not asked, or nothing "
        "to measure."
    )
    return Table(HEAD, rows, caption, ("1fr", *["auto"] * (len(HEAD) - 1)))


def attribute(dataset: xr.Dataset, name: str) -> str:
    """Write a number kept as an attribute; a dash where there is none."""
    value = dataset.attrs.get(name, "none")
    return DASH if isinstance(value, str) else format_number(float(value), 2)


def reached(dataset: xr.Dataset) -> str:
    """Write the accuracy that was reached; of a sweep the largest error of a row with an orbit."""
    if "error" not in dataset:
        return attribute(dataset, "accuracy_reached")
    error = dataset["error"].values[dataset["period_multiple"].values > 0]
    return format_number(float(error.max()), 2) if error.size else DASH


def seconds_text(sidecar: Mapping[str, Any]) -> str:
    """Write the time a scene took, before it the time that was expected where that is known."""
    elapsed, estimate = sidecar.get("seconds"), sidecar.get("expected_seconds")
    text = DASH if elapsed is None else format_number(float(elapsed), 2)
    return text if estimate is None else f"{format_number(float(estimate), 2)} / {text}"


def largest_residual(dataset: xr.Dataset) -> float:
    """Return the largest distance by which an orbit of ``dataset`` fails to close, or nan."""
    if "residual" not in dataset:
        return float("nan")
    residual = dataset["residual"].values
    closed = residual[np.isfinite(residual)]
    return float(closed.max()) if closed.size else float("nan")


def accuracy_text(datasets: Datasets, notes: Iterable[str] = ()) -> str:
    """Say how well orbits close, then the notes of the kinds of scenes."""
    residuals = {n: r for n, d in datasets.items() if np.isfinite(r := largest_residual(d))}
    said = []
    if residuals:
        worst = max(residuals, key=lambda name: residuals[name])
        said.append(
            "An orbit is refined until it returns to its own start; the largest distance left is "
            f"{format_number(residuals[worst], 2)}, in {breakable(worst)}."
        )
    said += notes
    said.append(
        "Seconds are those one run took, on the machine it ran on; where a plan was made there before, "
        "behind those it expected (expected / taken)."
    )
    return " ".join(said)


def provenance_table(datasets: Datasets) -> Table:
    """Return what the datasets were made from; where they differ, with the scenes of each."""
    rows = []
    for key, says in SOURCES.items():
        found: dict[str, list[str]] = {}
        for name, dataset in datasets.items():
            if key in dataset.attrs:
                found.setdefault(plain(key, dataset.attrs[key]), []).append(breakable(name))
        if len(found) == 1:
            rows.append([says, next(iter(found))])
        elif found:
            rows.append([says, "; ".join(f"{v} ({series(names)})" for v, names in found.items())])
    fingerprints = [
        f"{breakable(name)} {str(dataset.attrs['fingerprint'])[:HASH_LENGTH]}"
        for name, dataset in datasets.items()
        if "fingerprint" in dataset.attrs
    ]
    if fingerprints:
        rows.append(["what was asked", ", ".join(fingerprints)])
    caption = "What the datasets were made from and with."
    return Table(["", "value"], rows, caption, ("auto", "1fr"), left=2)


def plain(key: str, value: Any) -> str:
    """Write an attribute in one line: JSON as a list of names and values, hashes shortened."""
    text = str(value)
    if key == "versions":
        try:
            return ", ".join(f"{name} {version}" for name, version in json.loads(text).items())
        except (ValueError, AttributeError):
            return text
    return text[:HASH_LENGTH] if key.endswith("_hash") else text
