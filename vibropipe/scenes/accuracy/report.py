"""Part of the report on accuracy scenes: time of each method to reach an accuracy."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.text import digits, format_number
from vibropipe.report.findings import Finding
from vibropipe.report.parts import answers_of, tables_of
from vibropipe.report.section import Section
from vibropipe.report.table import Datasets, Table, breakable
from vibropipe.scenes.accuracy.summary import time_to_reach
from vibropipe.scenes.accuracy.text import conclusions
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.measurements import Outcome

NOT_REACHED = "not reached"
MEDIAN_OF_ALL = "median of all"
CAPTION = (
    "Shortest time per forcing period (ns, one core), among the tested settings, with an error up to the column "
    "heading; the error is the largest of end state, impact times, impact velocities and harmonics. A method that "
    "reaches none is left out; in brackets: motions that reach an error, where not all do. Other packages run "
    "over fewer periods (periods_run in the dataset)."
)


def work_precision_tables(datasets: Datasets) -> list[Table]:
    """Return the table of each scene."""
    return [work_precision_table(data) for data in datasets.values() if "setting_value" in data]


def work_precision_table(dataset: xr.Dataset) -> Table:
    """Return a table of the time to reach each accuracy, in ns per forcing period.

    It has one row per motion and method that reaches any of them, then one row per installed method with the
    median over the motions that reach the accuracy, and their number if not all do.
    """
    times = time_to_reach(dataset)
    absent = (dataset["outcome"] == int(Outcome.NOT_INSTALLED)).any("setting").all("motion").values
    methods = [(i, str(m)) for i, m in enumerate(dataset["method"].values) if not absent[i]]
    rows = []
    for motion, by_method in zip(dataset["motion"].values, times.values, strict=True):
        for index, method in methods:
            if np.isfinite(by_method[index]).any():
                rows.append([breakable(str(motion)), method, *map(reached_text, by_method[index])])
    for index, method in methods:
        cells = [median_text(column) for column in times.values[:, index].T]
        rows.append([MEDIAN_OF_ALL, method, *cells])
    accuracies = [format_number(float(a), 1) for a in times["accuracy"].values]
    widths = ("auto", "auto", *["1fr"] * len(accuracies))
    return Table(["motion", "method", *accuracies], rows, CAPTION, widths, left=2)


def reached_text(time: float) -> str:
    """Write a time in ns, or NOT_REACHED."""
    return digits(float(time)) if np.isfinite(time) else NOT_REACHED


def median_text(times: np.ndarray) -> str:
    """Write the median of the finite times, with their number if some are not finite."""
    finite = times[np.isfinite(times)]
    if not finite.size:
        return NOT_REACHED
    text = digits(float(np.median(finite)))
    return text if finite.size == times.size else f"{text} ({finite.size}/{times.size})"


def sections(datasets: Datasets) -> list[Section]:
    """Return the section on the time to reach an accuracy."""
    tables = work_precision_tables(datasets)
    return [Section("Time to reach an accuracy", tables=tables)] if tables else []


def findings(datasets: Datasets) -> list[Finding]:
    """Return the conclusion of each scene."""
    return [Finding(conclusions(dataset), name) for name, dataset in datasets.items()]


REPORT = ReportPart(
    "Accuracy and time",
    "How long does a forcing period take, for the error that I accept?",
    answers_of(findings),
    tables_of(sections),
)
