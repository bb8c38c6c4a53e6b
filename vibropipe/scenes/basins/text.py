"""Captions and the table of attractors of a basins scene, written from its data."""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np
import xarray as xr

from vibropipe.figures.text import (
    REGIME_TEXT,
    format_number,
    impact_texts,
    regime_name,
    rests_of,
    sentences,
)
from vibropipe.report.findings import Finding, value_text
from vibropipe.report.section import Section
from vibropipe.report.table import DASH, Datasets, Table, breakable
from vibropipe.scenes.basins.laws import law_text, swept_name
from vibropipe.scenes.basins.shares_text import family_table, share_texts
from vibropipe.words.wording import count, series

# Share of border starts above which lines between the basins would cover them.
MAX_BORDER = 0.25
CAPTION = (
    "Attractors of each scene: forcing periods m per orbit, impacts on support 1 and on support 2 per orbit (per "
    "forcing period if aperiodic), largest modulus of the Floquet multipliers, largest velocity before impact, "
    "{force}and share of the starts with the 95 % confidence interval for as many random ones."
)
FORCE = "largest force of a soft support, "


def attractor_text(dataset: xr.Dataset, index: int) -> str:
    """Write an attractor for a legend: its number, regime, period multiple and share of the starts."""
    law = attractor_law(dataset, index).replace("m = ", "$m$ = ")
    return f"{index}: {law}, {percent(float(dataset['basin_share'][index]))}"


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
    longest = count(int(dataset["periods_to_attractor"].max()), "forcing period")
    slowest = f"The slowest start takes {longest}" if n else "No attractor was found"
    if show and "attractor" not in show:
        what = "Forcing periods until the motion from each start settles"
        return sentences(what, started, slowest)
    what = "Attractor that the motion from each start settles on"
    if not show or "periods_to_attractor" in show:
        what = f"Above: {what[0].lower()}{what[1:]}. Below: forcing periods until it settles"
    if n == 0:
        return sentences(what, started, "No attractor was found")
    marked = started or "Markers show the states of the attractors at the section"
    lines = "; lines separate basins" if border <= MAX_BORDER else ""
    return sentences(
        what,
        f"{marked}{lines}",
        "" if phase else saddles_text(dataset),
        f"Of the starts, {series(shares)}",
        f"{percent(border)} of the starts have a neighbour that settles elsewhere" if n > 1 else "",
        f"{percent(none)} of the starts settle on none of them" if none else "",
        slowest,
    )


def saddles_text(dataset: xr.Dataset) -> str:
    """Write what the crosses are: unstable orbits between basins."""
    sizes = dataset["border_orbit_multiple"].values.tolist()
    if not sizes:
        return ""
    orbits = count(len(sizes), "unstable orbit")
    multiples = series(map(str, dict.fromkeys(sorted(sizes))))
    if float(dataset["border"].mean()) > MAX_BORDER:
        return f"Crosses: {orbits} (m = {multiples}) of those that the borders contain"
    which = "it" if len(sizes) == 1 else "one of them"
    return f"Crosses: {orbits} (m = {multiples}) on the borders, which are the starts that approach {which}"


def sections(datasets: Datasets) -> list[Section]:
    """Return the section on coexisting motions, with a table of the attractors of all scenes.

    Scenes over a parameter have one each.
    """
    single = {name: data for name, data in datasets.items() if swept_name(data) is None}
    soft = any("support_force_max" in data for data in single.values())
    rows = [row for name, data in single.items() for row in attractor_rows(name, data, soft)]
    over = [
        family_table(name, data)
        for name, data in datasets.items()
        if name not in single and data.sizes["attractor_id"]
    ]
    if not rows and not over:
        return []
    head = ["scene", "attractor", "regime", "m", "impacts", "multiplier", "velocity"]
    head += ["force", "share"] if soft else ["share"]
    caption = CAPTION.format(force=FORCE if soft else "")
    tables = [Table(head, rows, caption, left=3)] if rows else []
    return [Section("Coexisting motions", tables=[*tables, *over])]


def findings(datasets: Datasets) -> list[Finding]:
    """Return the findings of each scene."""
    return [
        Finding(basin_texts(data) if swept_name(data) is None else share_texts(data), name)
        for name, data in datasets.items()
    ]


def basin_texts(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return what a map of basins shows, a sentence each."""
    n, border = dataset.sizes["attractor_id"], float(dataset["border"].mean())
    if n == 0:
        return ("No attractor was found",)
    if n == 1:
        return (f"All starts settle on one motion, {attractor_law(dataset, 0)}",)
    open_text = ""
    if border > MAX_BORDER:
        open_text = ": a start known no better than that does not decide which motion is reached"
    each = [
        f"{interval_text(dataset.sel(attractor_id=index))} settle on attractor {index}, {attractor_law(dataset, index)}"
        for index in range(n)
    ]
    return (
        f"Among the motions followed here, at least {n} coexist (95 % intervals in brackets): of the starts "
        f"{'; '.join(each)}",
        f"{percent(border)} of the starts have a neighbour in the grid that settles elsewhere{open_text}",
        saddles_text(dataset).removeprefix("Crosses: ") if dataset["start_phase"] == 0 else "",
    )


def attractor_law(dataset: xr.Dataset, index: int) -> str:
    """Write the law of motion of an attractor."""
    row = dataset.sel(attractor_id=index)
    return law_text(int(row["regime"]), int(row["period_multiple"]))


def attractor_rows(name: str, dataset: xr.Dataset, soft: bool = False) -> list[list[str]]:
    """Return the rows of the attractors of a scene; the first has its name. soft : whether forces have a column."""
    rows: list[list[str]] = []
    for index in dataset["attractor_id"].values:
        row = dataset.sel(attractor_id=index)
        struck = row["impacts_per_orbit"]
        impacts = impact_texts(struck.values, rests_of(row, struck).values)
        largest = float(np.abs(row["floquet_multiplier"].values).max())
        rows.append(
            [
                "" if rows else breakable(name),
                str(index),
                REGIME_TEXT[regime_name(int(row["regime"]))],
                str(int(row["period_multiple"])) if row["period_multiple"] else DASH,
                ", ".join(impacts),
                DASH if math.isnan(largest) else format_number(largest, 3),
                largest_text(row, "impact_velocity_max"),
                *([largest_text(row, "support_force_max")] if soft else []),
                interval_text(row),
            ]
        )
    return rows


def largest_text(row: xr.Dataset, name: str) -> str:
    """Write the larger of the values of both supports; a dash without one."""
    values = row[name].values if name in row else np.empty(0)
    known = values[np.isfinite(values)]
    return value_text(row[name], known.max()) if known.size else DASH


def interval_text(row: xr.Dataset) -> str:
    """Write the share of the starts of an attractor in per cent, with its confidence interval."""
    share, low, high = (
        format_number(100 * float(row[f"basin_share{end}"]), 3) for end in ("", "_low", "_high")
    )
    return f"{share} % ({low} to {high})"
