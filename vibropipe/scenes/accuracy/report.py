"""Part of the report on accuracy scenes: answers, the times to errors of one motion, and how it is measured."""

from __future__ import annotations

from dataclasses import replace

from vibropipe.report.exciter import side_of
from vibropipe.report.parts import Answers, Datasets, Line, Side, Table
from vibropipe.scenes.accuracy.asked import asked_answer, has_asked
from vibropipe.scenes.accuracy.text import answers, packages_of, times_table
from vibropipe.scenes.kind import ReportPart


def answers_of_scenes(datasets: Datasets) -> Answers:
    """Return the answers of each scene."""
    return {
        label: [*([] if data["method"].size == 1 else answers(data)),
                *([asked_answer(data)] if has_asked(data) else [])]
        for label, data in datasets.items()
    }  # fmt: skip


def tables(datasets: Datasets) -> list[Table]:
    """Return the times to errors of each scene of one motion."""
    found = ((label, times_table(data)) for label, data in datasets.items())
    return [
        replace(table, scene=label, picture="work_precision")
        for label, table in found
        if table is not None
    ]


def side(datasets: Datasets) -> Side:
    """Return the numbers of the motion of the first scene, or the ranges of its motions."""
    first = dict(list(datasets.items())[:1])
    return replace(side_of(first), drawn=first)


def methods(datasets: Datasets) -> list[Line]:
    """Return the lines on errors and times, and on other packages."""
    timed = (
        "CPU time of one core without compilation, median of rounds in which all methods take turns; errors: end state "
        "and impact velocities over their sizes, impact times over the period, harmonics over the amplitude; impacts "
        "slower than 5 % of the fastest are not compared"
    )
    return [Line("Measured", timed), Line("Others", packages_of(datasets.values()))]


REPORT = ReportPart(
    "Accuracy",
    "How long does a forcing period take, for the error that I accept?",
    answers_of_scenes,
    tables,
    methods,
    side,
)
