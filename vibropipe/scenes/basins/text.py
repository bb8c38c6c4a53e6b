"""Captions and the table of attractors of a basins scene, written from its data."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import xarray as xr

from vibropipe.figures.text import REGIME_TEXT, format_number, regime_name, sentences
from vibropipe.report.findings import value_text
from vibropipe.report.section import Section
from vibropipe.report.table import DASH, Datasets, Table, breakable
from vibropipe.words.wording import count, series

CAPTION = (
    "Attractors of each scene: forcing periods m per orbit, impacts on support 1 and on support 2 per orbit (per "
    "forcing period if aperiodic), largest modulus of the Floquet multipliers, largest velocity before impact, and "
    "share of the starts with the 95 % confidence interval for as many random ones."
)


def attractor_text(dataset: xr.Dataset, index: int) -> str:
    """Write an attractor for a legend: its number, regime, period multiple and share of the starts."""
    row = dataset.isel(attractor_id=index)
    multiple = int(row["period_multiple"])
    law = REGIME_TEXT[regime_name(int(row["regime"]))]
    orbit = f", $m = {multiple}$" if multiple else ""
    return f"{index}: {law}{orbit}, {percent(float(row['basin_share']))}"


def percent(share: float) -> str:
    """Write a share in per cent, with three digits."""
    return f"{format_number(100 * share, 3)} %"


def describe_basins(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the caption of the maps, or of those of `show`."""
    n = dataset.sizes["attractor_id"]
    none = float((dataset["attractor"] < 0).mean())
    border = float(dataset["border"].mean())
    shares = [
        f"{percent(float(share))} settle on attractor {index}"
        for index, share in enumerate(dataset["basin_share"].values)
    ]
    phase = float(dataset["start_phase"])
    started = f"The motions start at {format_number(phase)} of a forcing period" if phase else ""
    slowest = f"The slowest start takes {count(int(dataset['periods_to_attractor'].max()), 'forcing period')}"
    if show and "attractor" not in show:
        what = "Forcing periods until the motion from each start settles"
        return sentences(what, started, slowest)
    what = "Attractor that the motion from each start settles on"
    if not show or "periods_to_attractor" in show:
        what = f"Above: {what[0].lower()}{what[1:]}. Below: forcing periods until it settles"
    marked = started or "Markers show the states of the attractors at the section"
    return sentences(
        what,
        f"{marked}; lines separate basins",
        f"Of the starts, {series(shares)}" if n else "No attractor was found",
        f"{percent(border)} of the starts have a neighbour that settles elsewhere" if n > 1 else "",
        f"{percent(none)} of the starts settle on none of them" if none else "",
        slowest,
    )


def sections(datasets: Datasets) -> list[Section]:
    """Return the section on coexisting motions, with a table of the attractors of all scenes."""
    rows = [row for name, data in datasets.items() for row in attractor_rows(name, data)]
    if not rows:
        return []
    head = ["scene", "attractor", "regime", "m", "impacts", "multiplier", "velocity", "share"]
    return [Section("Coexisting motions", tables=[Table(head, rows, CAPTION, left=3)])]


def attractor_rows(name: str, dataset: xr.Dataset) -> list[list[str]]:
    """Return the rows of the attractors of a scene; the first has its name."""
    rows: list[list[str]] = []
    for index in dataset["attractor_id"].values:
        row = dataset.sel(attractor_id=index)
        impacts = [format_number(float(n), 3) for n in row["impacts_per_orbit"].values]
        velocity = row["impact_velocity_max"].values
        struck = velocity[np.isfinite(velocity)]
        rows.append(
            [
                "" if rows else breakable(name),
                str(index),
                REGIME_TEXT[regime_name(int(row["regime"]))],
                str(int(row["period_multiple"])) if row["period_multiple"] else DASH,
                ", ".join(impacts),
                format_number(float(np.abs(row["floquet_multiplier"].values).max()), 3),
                value_text(row["impact_velocity_max"], struck.max()) if struck.size else DASH,
                interval_text(row),
            ]
        )
    return rows


def interval_text(row: xr.Dataset) -> str:
    """Write the share of the starts of an attractor in per cent, with its confidence interval."""
    share, low, high = (
        format_number(100 * float(row[f"basin_share{end}"]), 3) for end in ("", "_low", "_high")
    )
    return f"{share} % ({low} to {high})"
