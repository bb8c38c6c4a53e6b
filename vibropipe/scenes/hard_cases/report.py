"""The page of the hard cases: what was asked, what is known, what was measured, passed or not."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.text import format_number
from vibropipe.report.section import Section
from vibropipe.report.table import DASH, Datasets, Table, breakable
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.status import Status
from vibropipe.words.wording import count, share

CAPTION = (
    "What was asked of each case, what is conserved or known of it, and the distance measured by each method with its "
    "steps per forcing period."
)
FAILED = "not passed: "
JOINED = "\u00a0"


def sections(datasets: Datasets) -> list[Section]:
    """Return the section of the hard cases."""
    tables = hard_case_tables(datasets)
    if not tables:
        return []
    return [Section("Hard cases", [hard_case_words(datasets)], tables, is_landscape=True)]


def hard_case_tables(datasets: Datasets) -> list[Table]:
    """Return the table of each scene of hard cases."""
    return [hard_case_table(data) for data in datasets.values() if "measured" in data]


def hard_case_table(dataset: xr.Dataset) -> Table:
    """Return one row per case: asked, known, and per solver the value measured and its bound."""
    rows = []
    for place, name in enumerate(dataset["case"].values):
        case = dataset.isel(case=place)
        cells = [verdict(case.isel(solver=n)) for n in range(dataset.sizes["solver"])]
        texts = [breakable(str(name)), str(case["asked"].item()), str(case["known"].item())]
        rows.append([*texts, *cells, passed_words(case)])
    solvers = [str(solver) for solver in dataset["solver"].values]
    widths = ("2.5cm", "1fr", "1fr", *["2.2cm"] * len(solvers), "1.5cm")
    return Table(["case", "asked", "known", *solvers, "passed"], rows, CAPTION, widths, left=3)


def verdict(cell: xr.Dataset) -> str:
    """Write what was measured and what is allowed; a failure says so first."""
    passed = int(cell["passed"])
    if passed == 2:
        return DASH
    measured, bound = float(cell["measured"]), float(cell["bound"])
    if passed == 0:
        return f"{FAILED}{format_number(measured, 2)} >{JOINED}{power(bound)}"
    if measured == 0.0 and bound == 0.0:
        return "0"
    return f"{format_number(measured, 2)} ≤{JOINED}{power(bound)}"


def power(value: float) -> str:
    """Write a number; a power of ten without its 1."""
    return format_number(value, 2).removeprefix("1 × ")


def passed_words(case: xr.Dataset) -> str:
    """Write by how many of the solvers asked a case is passed."""
    found = case["passed"].values
    good, total = int((found == 1).sum()), int((found != 2).sum())
    return "passed" if good == total else f"{good} of {total}"


def hard_case_words(datasets: Datasets) -> str:
    """Say how many of the checks are passed, and by how many motions and impacts."""
    found = [data for data in datasets.values() if "measured" in data]
    if not found:
        return ""
    passed = sum(int((data["passed"].values == 1).sum()) for data in found)
    asked = sum(int((data["passed"].values != 2).sum()) for data in found)
    motions = sum(int(data["motions"].values.sum()) for data in found)
    impacts = sum(int(data["impacts"].values.sum()) for data in found)
    short = sum(int(data["short_flight_motions"].values.sum()) for data in found)
    worst = {Status(int(code)) for data in found for code in np.unique(data["worst_status"].values)}
    said = (
        f"{share(passed, asked, 'check')} passed, over {count(motions, 'motion')} with "
        f"{count(impacts, 'impact')}. "
        "A cell holds the distance from what is known and the largest one allowed; a lone 0 counts "
        "wrong answers. A dash: orbits are closed by no step."
    )
    if Status.SHORT_FLIGHTS in worst:
        said += (
            f" In {count(short, 'motion')} Newmark's method met flights shorter than its step, and said "
            "so in the status."
        )
    return said


REPORT = ReportPart(sections)
