"""Part of the report on effects scenes: what costs most, what nothing, and how it is timed."""

from __future__ import annotations

from vibropipe.report.exciter import side_of
from vibropipe.report.parts import Answers, Datasets, Line, Side
from vibropipe.scenes.effects.prices import answers
from vibropipe.scenes.kind import ReportPart


def answers_of_scenes(datasets: Datasets) -> Answers:
    """Return the answers of each scene."""
    return {label: answers(data) for label, data in datasets.items()}


def side(datasets: Datasets) -> Side:
    """Return the numbers of the motion that the others of the first scene are compared with."""
    return side_of({label: data.isel(motion=[0]) for label, data in list(datasets.items())[:1]})


def methods(_datasets: Datasets) -> list[Line]:
    """Return the line on times and on what is left out."""
    timed = (
        "CPU time of one core without compilation, ratios round by round; kernels have the code of the effects of a "
        "scene alone, and closed forms are used where they exist"
    )
    return [Line("Time", timed)]


REPORT = ReportPart(
    "Effects",
    "What do I pay for an effect or an output that my scene calls for, and what if it does not?",
    answers_of_scenes,
    methods=methods,
    side=side,
)
