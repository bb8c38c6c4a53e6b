"""Part of the report on hard cases: where common methods fail, and what is known, measured and allowed by group."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.claims import at_most
from vibropipe.figures.text import format_number
from vibropipe.report.parts import (
    DASH,
    Answer,
    Datasets,
    Line,
    Row,
    Side,
    Table,
    of_each,
    tables_of_each,
)
from vibropipe.scenes.hard_cases.failures import asked_of, errors_of, has_failures, questions_in
from vibropipe.scenes.hard_cases.pictures import shares
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.measurements import Outcome, Passed
from vibropipe.words.wording import count, part_text

# Rows beside the drawing of the exciter, by question.
PARAMETERS = {
    "energy": ("h = f = 0", "R = 1, ẋ(0) = −0.51"),
    "grazing": ("h = f = 0", "starts at ẋ = l + depth"),
    "chatter": ("h = f = 0", "δ = −1.5: pressed on support 1"),
    "step": ("f = −1", "figure 6 of the paper"),
}


def answers_of(dataset: xr.Dataset) -> list[Answer]:
    """Return at most three answers of one scene."""
    by_question = {"grazing": on_grazing, "chatter": on_chatter, "energy": on_energy}
    found = [by_question[name](dataset) for name in by_question if name in questions_in(dataset)]
    return (found or [on_cases(dataset)])[:3]


def on_grazing(dataset: xr.Dataset) -> Answer:
    """Return which grazing impacts are found, and how many an integrator misses."""
    outcome = errors_of(dataset, "grazing", "exact")[1]
    missed = int((outcome != Outcome.OK).sum())
    lead = f"Grazing: vibropipe's exact method finds all {outcome.size} impacts."
    if missed:
        lead = (
            f"Grazing: vibropipe's exact method misses {part_text(missed, outcome.size, 'impact')}."
        )
    losses = {m: n_missed(dataset, m) for m in ("DOP853", "DOP853_short", "newmark")}
    if missed or not losses["DOP853"]:
        return Answer(lead)
    rest = f"DOP853 with events misses {losses['DOP853']} of them"
    rest += ", and none once its steps are short" if losses["DOP853_short"] == 0 else ""
    rest += "; Newmark's method misses none" if losses["newmark"] == 0 else ""
    return Answer(lead, f"{rest}.")


def n_missed(dataset: xr.Dataset, method: str) -> int | None:
    """Return how many grazing impacts a method does not find; None if it was not asked."""
    if method not in asked_of(dataset, "grazing"):
        return None
    return int((errors_of(dataset, "grazing", method)[1] != Outcome.OK).sum())


def on_chatter(dataset: xr.Dataset) -> Answer:
    """Return how well the end of a chatter is found, and whether an integrator comes to rest."""
    error, outcome = errors_of(dataset, "chatter", "exact")
    if (outcome != Outcome.OK).any():
        return Answer("Chatter: its end is not found for every restitution.")
    R = format_number(float(dataset["restitution"].values.max()), 2)
    off = f"off by at most {size_text(error.max())}"
    lead = f"Chatter: the time of its end is {off} of it, up to a restitution of {R}."
    other = errors_of(dataset, "chatter", "DOP853")[1]
    stuck = "DOP853 with events never comes to rest: it is stuck before."
    return Answer(lead, stuck if (other != Outcome.OK).all() else "")


def on_energy(dataset: xr.Dataset) -> Answer:
    """Return by how much the energy is off after all impacts, marched and in closed form."""
    error = errors_of(dataset, "energy", "exact")[0]
    if not np.isfinite(error[-1]):
        return Answer("A million impacts: the exact method does not finish them.")
    lead = f"A million impacts: the marched energy is off by at most {size_text(error[-1])} of it."
    closed = errors_of(dataset, "energy", "closed")[0]
    rest = "The closed form, used without losses and force, does not drift."
    return Answer(lead, rest if closed.max() <= np.finfo(float).eps else "")


def on_cases(dataset: xr.Dataset) -> Answer:
    """Return whether all cases keep their bounds."""
    passed = dataset["passed"].values
    broken = int((passed == Passed.NOT_PASSED).any(axis=1).sum())
    total = count(int(dataset.sizes["case"]), "case")
    if broken:
        return Answer(f"{total}: {count(broken, 'bound')} exceeded.")
    rest = "A bound is rounding times what the case multiplies it by."
    return Answer(f"{total}: every bound is kept.", rest)


def size_text(value: float) -> str:
    """Write an error, rounded up to two digits; a power of ten without its factor 1."""
    return at_most(float(value), 2).removeprefix("1 × ")


def groups_table(label: str, dataset: xr.Dataset) -> Table:
    """Return a row for each group: what is hard and known, the worst deviation of the exact method, and its bound."""
    exact = dataset.sel(solver="exact")
    share = shares(dataset.sel(solver=["exact"]))[:, 0]
    rows = []
    for group in map(str, dataset["group"].values):
        own = np.flatnonzero(exact["case_group"].values == group)
        worst = exact.isel(case=int(own[np.argmax(share[own])]))
        measured, bound = float(worst["measured"]), float(worst["bound"])
        is_count = bound == 0.0
        rows.append(
            [
                group,
                str(dataset["group_known"].sel(group=group).values),
                str(worst["reason"].values),
                str(int(exact["motions"].values[own].sum())),
                f"{measured:.0f} wrong" if is_count else size_text(measured),
                DASH if is_count else size_text(bound),
            ]
        )
    head = ["what is hard", "what is known", "why this bound", "motions", "worst", "bound"]
    note = (
        "The deviation of the exact method that is nearest to its bound, relative unless stated, and its reason. Each "
        f"motion is counted once in a group; {dataset.attrs['distinct_motions']} in all differ. {DASH}: wrong answers "
        "are counted, and none is allowed."
    )
    widths = ("2.9cm", "1fr", "3.4cm", "1.4cm", "1.7cm", "1.2cm")
    cases, groups = (count(int(dataset.sizes[dim]), dim) for dim in ("case", "group"))
    broken = (exact["passed"].values == Passed.NOT_PASSED).any()
    title = f"{cases} in {groups}" + ("" if broken else ": nothing is missed, every bound is kept")
    return Table(head, rows, note, widths, left=3, title=title, scene=label, picture="margins")


def side(datasets: Datasets) -> Side:
    """Return the parameters of the questions of the first scene."""
    first = next(iter(datasets.values()))
    if not has_failures(first):
        return Side([Row("each case", "", "has its own exciter")])
    rows = [
        Row("abcd"[k] if len(questions_in(first)) > 1 else "", *PARAMETERS[name])
        for k, name in enumerate(questions_in(first))
    ]
    return Side(rows)


def methods(_datasets: Datasets) -> list[Line]:
    """Return the lines on what is independent, and on where single cases are."""
    known = (
        "closed forms, conserved quantities, solutions of 40 digits; flights by another formula than the program's, a "
        "matrix exponential"
    )
    return [
        Line("Known by", known),
        Line("Not shown", "single cases, one a line: `vibropipe table`"),
    ]


answers, tables = of_each(answers_of), tables_of_each(groups_table)
REPORT = ReportPart(
    "Hard cases",
    "Where do common methods fail on motions with impacts, and does the exact one hold there?",
    answers,
    tables,
    methods,
    side,
)
