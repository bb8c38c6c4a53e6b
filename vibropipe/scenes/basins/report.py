"""Part of the report on coexisting motions."""

from __future__ import annotations

from vibropipe.report.exciter import side_of_first
from vibropipe.report.parts import Answers, Datasets, Table
from vibropipe.scenes.basins.attractors import swept_name
from vibropipe.scenes.basins.shares_text import family_table, share_answers
from vibropipe.scenes.basins.text import basin_answers, safety_table
from vibropipe.scenes.kind import ReportPart


def answers(datasets: Datasets) -> Answers:
    """Return the answers of each scene."""
    return {
        scene: (basin_answers if swept_name(data) is None else share_answers)(data)
        for scene, data in datasets.items()
    }


def tables(datasets: Datasets) -> list[Table]:
    """Return the table of the motions of each scene."""
    found = [
        (safety_table if swept_name(data) is None else family_table)(scene, data)
        for scene, data in datasets.items()
    ]
    return [table for table in found if table is not None]


REPORT = ReportPart(
    "Coexisting motions",
    "Which start settles on which motion, and how easily is it lost?",
    answers,
    tables,
    side=side_of_first,
    rank=0,
)
