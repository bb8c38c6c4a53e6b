"""Part of the report on designs: their numbers, and how tight each parameter must be made."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.text import format_number, in_brackets, orbit_texts, plain_symbol, with_units
from vibropipe.report.findings import Finding
from vibropipe.report.parts import answers_of, tables_of
from vibropipe.report.section import Section
from vibropipe.report.table import DASH, Datasets, Table, breakable
from vibropipe.scenes.design.captions import (
    leading,
    place_text,
    reached_text,
    value_of,
    wanted_text,
)
from vibropipe.scenes.design.data import (
    Part,
    has_spread,
    numbers,
    spread_parts,
    varied,
    wanted_parts,
)
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.designs import DesignResult

WORKSHOP = (
    "For the workshop: make each parameter to its nominal value within its tolerance. All parameters may be off at "
    "once, in any combination: at every corner, the law of motion, the bounds and the targets within what is allowed "
    "hold."
)


def sections(datasets: Datasets) -> list[Section]:
    """Return a section on the designs of a study."""
    tables: list[Table] = []
    workshop = False
    for name, dataset in datasets.items():
        tables.append(designs_table(name, dataset))
        if tight := tolerance_table(name, dataset):
            tables.append(tight)
            workshop |= any(str(each).endswith("_tolerance") for each in dataset.data_vars)
    texts = [
        f"{name}: {wanted_text(data)}. {reached_text(data)}." for name, data in datasets.items()
    ]
    return [Section("Designs", [*texts, WORKSHOP if workshop else ""], tables)] if tables else []


def designs_table(scene: str, dataset: xr.Dataset) -> Table:
    """Return the designs of a scene, one per row."""
    names, parts = varied(dataset), wanted_parts(dataset)
    head = ["design", "law", *(with_symbol(dataset[name]) for name in names)]
    head += [with_symbol(part.of(dataset), part) for part in parts] + ["margin"]
    laws = orbit_texts(dataset, "design")
    rows = [
        [
            str(number),
            laws[row],
            *(format_number(float(dataset[name].values[row]), 5) for name in names),
            *(format_number(float(part.of(dataset).values[row]), 5) for part in parts),
            format_number(float(dataset["law_margin"].values[row]), 2),
        ]
        for row, number in enumerate(numbers(dataset))
    ]
    caption = (
        f"Designs of {scene}: law of motion (m; p1, p2), varied parameters, wanted quantities, and the distance to the "
        "nearest change of law in shares of the ranges."
    )
    return Table(head, rows, caption, left=2)


def tolerance_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return how tight each parameter of the first design must be, and what it does to the wanted quantities."""
    best = dataset.isel(design=0)
    stem = {
        str(name).removesuffix("_tolerance")
        for name in dataset.data_vars
        if str(name).endswith("_tolerance")
    }
    of_spread = [str(name) for name in dataset["parameter"].values] if has_spread(dataset) else []
    names = [str(name) for name in dataset.coords if name in stem or name in of_spread]
    if not names:
        return None
    parts = spread_parts(dataset) if of_spread else []
    head = ["parameter", "nominal", *(["tolerance"] if stem else [])]
    head += (
        ["deviation", *(f"share of {breakable(part.name)}" for part in parts)] if of_spread else []
    )
    rows = []
    for name in names:
        cells = [plain_symbol(name), with_units(dataset[name], format_number(float(best[name]), 6))]
        if stem:
            cells.append(plus_minus(best, name, "_tolerance"))
        if of_spread:
            cells.append(plus_minus(best, name, "_std"))
            cells += [share_text(best, part, name) for part in parts]
        rows.append(cells)
    caption = f"Design 1 of {scene}: nominal values" + (
        ", tolerances that keep all that is wanted" if stem else ""
    )
    caption += (
        ", given standard deviations and the share of each in the variance of the wanted quantities"
        if of_spread
        else ""
    )
    return Table(head, rows, f"{caption}.")


def plus_minus(best: xr.Dataset, name: str, suffix: str) -> str:
    """Write a tolerance or a deviation of a parameter with its unit."""
    if name + suffix not in best or not np.isfinite(float(best[name + suffix])):
        return DASH
    return f"± {with_units(best[name], format_number(float(best[name + suffix]), 2))}"


def share_text(best: xr.Dataset, part: Part, name: str) -> str:
    """Write the share that a parameter has in the variance of a quantity."""
    if name not in best["parameter"].values:
        return DASH
    share = float(part.of(best, "_contribution").sel(parameter=name))
    return DASH if np.isnan(share) else f"{100 * share:.0f} %"


def with_symbol(values: xr.DataArray, part: Part | None = None) -> str:
    """Return the head of a column: the name with index, and the unit."""
    return in_brackets(breakable(part.name) if part else str(values.name), values)


def findings(datasets: Datasets) -> list[Finding]:
    """Return what the first page says: the best design of each scene, its spread, and what matters most."""
    found = []
    for name, dataset in datasets.items():
        sentences = [reached_text(dataset)]
        if int(dataset["design_result"].values[0]) == DesignResult.MET:
            values = ", ".join(
                f"{part.name} = {value_of(dataset, part, 0)}" for part in wanted_parts(dataset)
            )
            sentences.append(f"Design 1, {place_text(dataset, 0)}, has {values}")
        if has_spread(dataset):
            best = dataset.isel(design=0)
            share, low, high = (
                format_number(100 * float(best[f"law_change_{end}"]), 2)
                for end in ("share", "low", "high")
            )
            sentences.append(
                f"With the given deviations its law changes in {share} % of the samples ({low} to {high} %)"
            )
            sentences.append(f"Most of the spread of {'; '.join(leading(dataset))}")
        found.append(Finding(tuple(sentences), name))
    return found


REPORT = ReportPart(
    "Designs",
    "Which parameters give the wanted motion, and how tight must they be?",
    answers_of(findings),
    tables_of(sections),
)
