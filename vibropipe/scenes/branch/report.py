"""Part of the report on branches: their bifurcations, in a table."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.text import flag_texts, format_number, in_brackets, orbit_texts
from vibropipe.report.parts import answers_of, tables_of
from vibropipe.report.section import Section
from vibropipe.report.table import Datasets, Table
from vibropipe.scenes.branch.curves import followed, swept
from vibropipe.scenes.branch.findings import findings
from vibropipe.scenes.kind import ReportPart

# Rows of a table; the others are in the dataset.
MAX_ROWS = 24
KINDS, REASONS = flag_texts("bifurcation_kind"), flag_texts("end_reason")


def sections(datasets: Datasets) -> list[Section]:
    """Return the section on the branches of a study, if they have bifurcations."""
    tables = [bifurcation_table(name, data) for name, data in datasets.items()]
    found = [table for table in tables if table]
    return [Section("Bifurcations of the branches", tables=found)] if found else []


def bifurcation_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return a table of the bifurcations of a scene, those of the first branches; None if there are none."""
    points = dataset["bifurcation_point"].values
    if points.size == 0:
        return None
    along, over = followed(dataset), swept(dataset)
    laws = orbit_texts(dataset, "point")
    shown = np.lexsort((points, dataset["branch_id"].values[points]))[:MAX_ROWS]
    rows = [row(dataset, int(n), laws[int(points[n])], along, over) for n in shown]
    head = ["bifurcation", *(in_brackets(name, dataset[name]) for name in (along, over) if name)]
    rest = f"; {points.size - MAX_ROWS} more are in the dataset" if points.size > MAX_ROWS else ""
    caption = f"Bifurcations of {scene}: where, law of motion (m; p1, p2), and what the branch does{rest}."
    return Table([*head, "law", "branch", "goes on"], rows, caption, left=1)


def row(dataset: xr.Dataset, n: int, law: str, along: str, over: str | None) -> list[str]:
    """Return a row of the table of bifurcations."""
    point = int(dataset["bifurcation_point"][n])
    reason = REASONS[int(dataset["end_reason"][n])]
    return [
        KINDS[int(dataset["bifurcation_kind"][n])],
        format_number(float(dataset[f"bifurcation_{along}"][n]), 8),
        *([format_number(float(dataset[over][point]))] if over else []),
        law,
        str(int(dataset["branch_id"][point])),
        goes_on_text(KINDS[int(dataset["bifurcation_kind"][n])], reason),
    ]


def goes_on_text(kind: str, reason: str) -> str:
    """Return whether a branch goes on beyond a bifurcation, and if not, or if what begins there is left, why."""
    if reason == "goes on":
        return "yes"
    is_passed = kind in ("flip", "pitchfork") and reason != "parent"
    return f"yes; new orbits: {reason}" if is_passed else f"no: {reason}"


REPORT = ReportPart(
    "Branches of orbits",
    "Which orbits are there, stable or not, and where do they change?",
    answers_of(findings),
    tables_of(sections),
    rank=0,
)
