"""Part of the report on designs: their numbers, and how tight each parameter must be made."""

from __future__ import annotations

import xarray as xr

from vibropipe.figures.text import format_number, in_brackets, orbit_texts
from vibropipe.report.findings import Finding
from vibropipe.report.parts import answers_of, tables_of
from vibropipe.report.section import Section
from vibropipe.report.table import Datasets, Table, breakable
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
    has_yield,
    numbers,
    varied,
    wanted_parts,
)
from vibropipe.scenes.design.workshop import (
    NOMINAL_DIGITS,
    makeable_text,
    nominal,
    parameters_table,
    workshop_texts,
    yields_table,
)
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.designs import DesignResult


def sections(datasets: Datasets) -> list[Section]:
    """Return a section on the designs of a study."""
    tables: list[Table] = []
    texts = [
        f"{name}: {wanted_text(data)}. {reached_text(data)}." for name, data in datasets.items()
    ]
    for name, dataset in datasets.items():
        tables.append(designs_table(name, dataset))
        tables += [
            table
            for table in (yields_table(name, dataset), parameters_table(name, dataset))
            if table is not None
        ]
        texts += workshop_texts(name, dataset)
    return [Section("Designs", texts, tables)] if tables else []


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
            *(format_number(nominal(dataset, name, row), NOMINAL_DIGITS) for name in names),
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
            sentences += makeable_text(dataset) if has_yield(dataset) else []
        if has_spread(dataset):
            best = dataset.isel(design=0)
            share, low, high = (
                format_number(100 * float(best[f"law_change_{end}"]), 2)
                for end in ("share", "low", "high")
            )
            sentences.append(
                f"With the given deviations the law of design 1 changes in {share} % of the samples ({low} to {high} %)"
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
