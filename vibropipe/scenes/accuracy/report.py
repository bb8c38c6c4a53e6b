"""What a report says of an accuracy scene: the time that each method needs to reach an accuracy."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.text import digits, format_number
from vibropipe.report.section import Section
from vibropipe.report.table import Datasets, Table, breakable
from vibropipe.scenes.accuracy.summary import time_to_reach
from vibropipe.scenes.accuracy.text import conclusion
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.measurements import Outcome

NOT_REACHED = "not reached"
MEDIAN_OF_ALL = "median of all"
CAPTION = (
    "Nanoseconds per forcing period of one core that each method needs at least for an error no larger than the head "
    "of the column says, by the settings that were tried: the largest of the errors of end state, impacts and "
    "harmonics counts. Other packages run over fewer periods, as the dataset says."
)


def race_tables(datasets: Datasets) -> list[Table]:
    """Return the table of each race."""
    return [race_table(data) for data in datasets.values() if "setting_value" in data]


def race_table(dataset: xr.Dataset) -> Table:
    """Return a row per motion and method that took part: ns per forcing period for each error; then, per
    method, the median over the motions that reach it, with their number where not all do."""
    times = time_to_reach(dataset)
    absent = (dataset["outcome"] == int(Outcome.NOT_INSTALLED)).any("setting").all("motion").values
    methods = [(i, str(m)) for i, m in enumerate(dataset["method"].values) if not absent[i]]
    rows = []
    for motion, by_method in zip(dataset["motion"].values, times.values, strict=True):
        for place, method in methods:
            rows.append([breakable(str(motion)), method, *map(reached_words, by_method[place])])
    for place, method in methods:
        cells = [median_words(column) for column in times.values[:, place].T]
        rows.append([MEDIAN_OF_ALL, method, *cells])
    accuracies = [format_number(float(a), 1) for a in times["accuracy"].values]
    widths = ("auto", "auto", *["1fr"] * len(accuracies))
    return Table(["motion", "method", *accuracies], rows, CAPTION, widths, left=2)


def reached_words(time: float) -> str:
    """Write a time in ns, or that the accuracy is not reached."""
    return digits(float(time)) if np.isfinite(time) else NOT_REACHED


def median_words(times: np.ndarray) -> str:
    """Write the median of the times there are, and of how many motions it is if not of all."""
    known = times[np.isfinite(times)]
    if not known.size:
        return NOT_REACHED
    text = digits(float(np.median(known)))
    return text if known.size == times.size else f"{text} ({known.size} of {times.size})"


def sections(datasets: Datasets) -> list[Section]:
    """Return the section of the times to reach an accuracy."""
    tables = race_tables(datasets)
    return [Section("Time to reach an accuracy", tables=tables)] if tables else []


def accuracy_notes(datasets: Datasets) -> list[str]:
    """Return the conclusion from each scene."""
    return [conclusion(dataset) for dataset in datasets.values()]


REPORT = ReportPart(sections, accuracy_notes)
