"""Accuracy, run time and provenance of the datasets."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from vibropipe.figures.text import departure, format_number, with_units
from vibropipe.report.table import DASH, Datasets, Table, breakable
from vibropipe.words.wording import series

Sidecars = Mapping[str, Mapping[str, Any]]

HEAD = ["scene", "method", "requested", "achieved", "error vs exact", "residual", "seconds"]
# Attribute of a dataset -> its name in the report.
SOURCES = {
    "source": "program",
    "git_commit": "commit",
    "kernel_hash": "kernels",
    "study_hash": "study text",
    "versions": "versions",
    "machine": "kind of machine",
}
HASH_LENGTH = 12


def accuracy_table(datasets: Datasets, sidecars: Sidecars) -> Table:
    """Return a table of one row per scene: method, requested and achieved accuracy, residual, run time."""
    rows = []
    for name, dataset in datasets.items():
        rows.append(
            [
                breakable(name),
                str(dataset.attrs.get("method", DASH)),
                attribute(dataset, "accuracy_asked"),
                achieved(dataset),
                with_units(dataset["displacement"], format_number(departure(dataset), 2))
                if "displacement_exact" in dataset
                else DASH,
                format_number(largest_residual(dataset), 2),
                seconds_text(sidecars.get(name, {})),
            ]
        )
    caption = (
        "Method, requested and achieved accuracy, largest deviation from the exact motion, largest residual of an "
        "orbit, and run time. A dash: not applicable."
    )
    return Table(HEAD, rows, caption, ("1fr", *["auto"] * (len(HEAD) - 1)))


def attribute(dataset: xr.Dataset, name: str) -> str:
    """Write a numeric attribute; a dash if there is none."""
    value = dataset.attrs.get(name, "none")
    return DASH if isinstance(value, str) else format_number(float(value), 2)


def achieved(dataset: xr.Dataset) -> str:
    """Write the achieved accuracy; for a sweep, the largest error of a row with an orbit."""
    if "error" not in dataset:
        return attribute(dataset, "accuracy_reached")
    error = dataset["error"].values[dataset["period_multiple"].values > 0]
    return format_number(float(error.max()), 2) if error.size else DASH


def seconds_text(sidecar: Mapping[str, Any]) -> str:
    """Write the run time of a scene, after its estimate if there is one."""
    elapsed, estimate = sidecar.get("seconds"), sidecar.get("expected_seconds")
    text = DASH if elapsed is None else format_number(float(elapsed), 2)
    return text if estimate is None else f"{format_number(float(estimate), 2)} / {text}"


def largest_residual(dataset: xr.Dataset) -> float:
    """Return the largest residual of an orbit, nan if there is none."""
    if "residual" not in dataset:
        return float("nan")
    residual = dataset["residual"].values
    closed = residual[np.isfinite(residual)]
    return float(closed.max()) if closed.size else float("nan")


def accuracy_text(datasets: Datasets, notes: Iterable[str] = ()) -> str:
    """Write the largest residual of an orbit, then the notes of the kinds of scenes."""
    residuals = {n: r for n, d in datasets.items() if np.isfinite(r := largest_residual(d))}
    texts = []
    if residuals:
        worst = max(residuals, key=lambda name: residuals[name])
        texts.append(
            "Orbits are closed by Newton's method; the largest residual is "
            f"{format_number(residuals[worst], 2)}, in {breakable(worst)}."
        )
    texts += notes
    texts.append(
        "Times are wall-clock seconds, all jobs together, as estimated / measured where an estimate exists."
    )
    return " ".join(texts)


def provenance_table(datasets: Datasets) -> Table:
    """Return the table of provenance; where datasets differ, each value with its scenes."""
    rows = []
    for key, title in SOURCES.items():
        values: dict[str, list[str]] = {}
        for name, dataset in datasets.items():
            if key in dataset.attrs:
                values.setdefault(plain(key, dataset.attrs[key]), []).append(breakable(name))
        if len(values) == 1:
            rows.append([title, next(iter(values))])
        elif values:
            rows.append([title, "; ".join(f"{v} ({series(names)})" for v, names in values.items())])
    fingerprints = [
        f"{breakable(name)} {str(dataset.attrs['fingerprint'])[:HASH_LENGTH]}"
        for name, dataset in datasets.items()
        if "fingerprint" in dataset.attrs
    ]
    if fingerprints:
        rows.append(["scene fingerprint", ", ".join(fingerprints)])
    caption = "Program, sources and versions that the datasets were computed with."
    return Table(["", "value"], rows, caption, ("auto", "1fr"), left=2)


def plain(key: str, value: Any) -> str:
    """Write an attribute in one line: versions as a list, hashes shortened."""
    text = str(value)
    if key == "versions":
        try:
            return ", ".join(f"{name} {version}" for name, version in json.loads(text).items())
        except (ValueError, AttributeError):
            return text
    return text[:HASH_LENGTH] if key.endswith("_hash") else text
