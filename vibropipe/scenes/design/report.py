"""Part of the report on designs: their numbers, and how tight each parameter must be made."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.claims import at_least
from vibropipe.figures.text import format_number, in_brackets, orbit_texts
from vibropipe.report.parts import Answer, Answers
from vibropipe.report.table import Datasets, Table, breakable
from vibropipe.scenes.design.captions import leading, reached_text, value_of, wanted_text
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
    lost_text,
    makeable,
    nearest_limit_text,
    nominal,
    parameters_table,
    yields_table,
)
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.designs import DesignResult


def tables(datasets: Datasets) -> list[Table]:
    """Return the tables of designs: what they are, their yields and tolerances, and how tight the first one is."""
    made = (designs_table, yields_table, parameters_table)
    found = [table(name, dataset) for name, dataset in datasets.items() for table in made]
    return [table for table in found if table is not None]


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
            at_least(float(dataset["law_margin"].values[row]), 2),
        ]
        for row, number in enumerate(numbers(dataset))
    ]
    note = (
        f"Wanted: {wanted_text(dataset)}. Law: (m; p1, p2). Margin: distance to the nearest change of law in shares of "
        "the ranges, rounded down."
    )
    return Table(head, rows, note, left=2, title="Laws and quantities of the designs", scene=scene)


def with_symbol(values: xr.DataArray, part: Part | None = None) -> str:
    """Return the head of a column: the name with index, and the unit."""
    return in_brackets(breakable(part.name) if part else str(values.name), values)


def answers(datasets: Datasets) -> Answers:
    """Return what page 1 says: how many designs can be made, what the best one has, and what is lost or matters."""
    return {name: answers_of_scene(dataset) for name, dataset in datasets.items()}


def answers_of_scene(dataset: xr.Dataset) -> list[Answer]:
    """Return the answers of one scene."""
    if int(dataset["design_result"].values[0]) != DesignResult.MET:
        lead, _, rest = reached_text(dataset).partition("; ")
        return [Answer(f"{lead}.", f"{rest[:1].upper()}{rest[1:]}.")]
    found = [makeable(dataset) if has_yield(dataset) else Answer(f"{reached_text(dataset)}.")]
    # Targets are met: what is bounded or least tells more.
    parts = sorted(wanted_parts(dataset), key=lambda part: np.isfinite(part.end(dataset, "target")))
    parts = [part for part in parts if part.variable != "yield"]
    if parts:
        words = parts[0].plain_words(dataset)
        lead = f"The {words} of design 1 is {value_of(dataset, parts[0], 0)}."
        found.append(Answer(lead, nearest_limit_text(dataset)))
    if (lost := lost_text(dataset)) and has_yield(dataset):
        found.append(Answer(lost))
    elif has_spread(dataset) and (texts := leading(dataset, in_words=True)):
        found.append(Answer(f"Most of the spread of {texts[0]}."))
    return found


REPORT = ReportPart(
    "Designs",
    "Which parameters give the wanted motion, and how tight must they be?",
    answers,
    tables,
)
