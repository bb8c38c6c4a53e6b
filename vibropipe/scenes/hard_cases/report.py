"""Part of the report on hard cases: description, known property, measured deviation, verdict."""

from __future__ import annotations

from collections.abc import Iterable

import xarray as xr

from vibropipe.figures.text import format_number
from vibropipe.report.findings import Finding
from vibropipe.report.parts import answers_of, tables_of
from vibropipe.report.section import Section
from vibropipe.report.table import DASH, Datasets, Table, breakable
from vibropipe.scenes.hard_cases.pictures import describe_hard_cases
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.measurements import Passed
from vibropipe.words.status import Status
from vibropipe.words.wording import count, share

CAPTION = (
    "Test cases: description, known property, and measured deviation by method (number: Newmark steps per forcing "
    "period)."
)
FAILED = "not passed: "
NO_BREAK_SPACE = "\u00a0"


def sections(datasets: Datasets) -> list[Section]:
    """Return the section on hard cases."""
    tables = hard_case_tables(datasets)
    if not tables:
        return []
    return [Section("Hard cases", [verdict_summary(datasets)], tables, is_landscape=True)]


def findings(datasets: Datasets) -> list[Finding]:
    """Return how many checks of each scene are passed, over how many motions, and what is not passed."""
    return [
        Finding((checks_text([data]), describe_hard_cases(data)), name)
        for name, data in datasets.items()
        if "measured" in data
    ]


def hard_case_tables(datasets: Datasets) -> list[Table]:
    """Return the table of each scene."""
    return [hard_case_table(data) for data in datasets.values() if "measured" in data]


def hard_case_table(dataset: xr.Dataset) -> Table:
    """Return a table of one row per case: description, known property, deviation and bound by solver."""
    rows = []
    for index, name in enumerate(dataset["case"].values):
        case = dataset.isel(case=index)
        cells = [verdict(case.isel(solver=n)) for n in range(dataset.sizes["solver"])]
        texts = [breakable(str(name)), str(case["asked"].item()), str(case["known"].item())]
        rows.append([*texts, *cells, passed_text(case)])
    solvers = [str(solver) for solver in dataset["solver"].values]
    widths = ("2.5cm", "1fr", "1fr", *["2.2cm"] * len(solvers), "1.5cm")
    return Table(
        ["case", "description", "known property", *solvers, "passed"], rows, CAPTION, widths, left=3
    )


def verdict(cell: xr.Dataset) -> str:
    """Write the measured deviation and its bound, after FAILED if the case does not pass."""
    passed = Passed(int(cell["passed"]))
    if passed == Passed.NOT_ASKED:
        return DASH
    measured, bound = float(cell["measured"]), float(cell["bound"])
    if passed == Passed.NOT_PASSED:
        return f"{FAILED}{format_number(measured, 2)} >{NO_BREAK_SPACE}{power(bound)}"
    if measured == 0.0 and bound == 0.0:
        return "0"
    return f"{format_number(measured, 2)} ≤{NO_BREAK_SPACE}{power(bound)}"


def power(value: float) -> str:
    """Write a number, a power of ten without its factor 1."""
    return format_number(value, 2).removeprefix("1 × ")


def passed_text(case: xr.Dataset) -> str:
    """Write "passed", or how many of the applicable solvers pass the case."""
    passed, total = n_passed(case)
    return "passed" if passed == total else f"{passed} of {total}"


def n_passed(dataset: xr.Dataset) -> tuple[int, int]:
    """Return the number of passed checks and of all applicable ones."""
    verdicts = dataset["passed"].values
    return int((verdicts == Passed.PASSED).sum()), int((verdicts != Passed.NOT_ASKED).sum())


def checks_text(cases: Iterable[xr.Dataset]) -> str:
    """Write how many checks are passed, over how many motions and impacts."""
    passed = total = motions = impacts = 0
    for data in cases:
        own_passed, own_total = n_passed(data)
        passed, total = passed + own_passed, total + own_total
        motions += int(data["motions"].values.sum())
        impacts += int(data["impacts"].values.sum())
    return (
        f"{share(passed, total, 'check')} passed, over {count(motions, 'motion')} with "
        f"{count(impacts, 'impact')}."
    )


def verdict_summary(datasets: Datasets) -> str:
    """Write the number of passed checks, of motions and impacts, and how to read the table."""
    cases = [data for data in datasets.values() if "measured" in data]
    if not cases:
        return ""
    text = (
        f"{checks_text(cases)} Each cell gives the measured deviation and its bound; a single 0 means no wrong answer. "
        "A dash: not applicable to time stepping."
    )
    if any((data["worst_status"].values == Status.SHORT_FLIGHTS).any() for data in cases):
        short = sum(int(data["short_flight_motions"].values.sum()) for data in cases)
        text += (
            f" In {count(short, 'motion')}, Newmark's method reported flights shorter than its step "
            "(status short_flights)."
        )
    return text


REPORT = ReportPart(
    "Hard cases",
    "Do hard cases stay numerically stable?",
    answers_of(findings),
    tables_of(sections),
)
