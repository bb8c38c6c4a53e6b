"""Part of the report on boundaries: their curves, in a table."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.text import flag_texts, format_number, orbit_texts
from vibropipe.figures.units import unit_text
from vibropipe.report.findings import Finding, range_text, symbol_text
from vibropipe.report.parts import answers_of, tables_of
from vibropipe.report.section import Section
from vibropipe.report.table import Datasets, Table
from vibropipe.scenes.boundary.captions import curves_text
from vibropipe.scenes.boundary.curves import box_of, plane
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.wording import series

# Rows of a table; the others are in the dataset.
MAX_ROWS = 24
KINDS, MEETINGS = flag_texts("boundary_kind"), flag_texts("meeting_kind")


def sections(datasets: Datasets) -> list[Section]:
    """Return the section on the boundaries of a study."""
    tables = [curve_table(name, data) for name, data in datasets.items() if data.sizes["point"]]
    return [Section("Boundaries in two parameters", tables=tables)] if tables else []


def curve_table(scene: str, dataset: xr.Dataset) -> Table:
    """Return a table of the curves of a scene."""
    x, y = plane(dataset)
    ids, ends = dataset["curve_id"].values, ends_of(dataset)
    curves, laws = np.unique(ids), orbit_texts(dataset, "point")
    rows = []
    for number in curves[:MAX_ROWS]:
        points = np.flatnonzero(ids == number)
        first = int(points[0])
        places = [
            f"({format_number(float(dataset[x][n]), 6)}, {format_number(float(dataset[y][n]), 6)})"
            for n in (first, int(points[-1]))
        ]
        names = ends.get(int(number), ["closed", "closed"])
        rows.append(
            [
                KINDS[int(dataset["boundary_kind"][first])],
                laws[first],
                places[0],
                names[0],
                places[1],
                names[-1],
            ]
        )
    axes = f"({axis_text(dataset[x])}, {axis_text(dataset[y])})"
    rest = f"; {curves.size - MAX_ROWS} more are in the dataset" if curves.size > MAX_ROWS else ""
    caption = f"Curves of {scene}: bifurcation, law of motion (m; p1, p2) at the first point, and both ends{rest}."
    return Table(["kind", "law", f"from {axes}", "end", f"to {axes}", "end"], rows, caption, left=1)


def axis_text(array: xr.DataArray) -> str:
    """Write the symbol of a parameter, with its unit."""
    units = unit_text(str(array.attrs.get("units", "1")))
    return f"{symbol_text(array)} in {units}" if units else symbol_text(array)


def ends_of(dataset: xr.Dataset) -> dict[int, list[str]]:
    """Return what each curve meets at its ends, first end first."""
    ends: dict[int, list[str]] = {}
    for n in np.argsort(dataset["meeting_point"].values, kind="stable"):
        if int(dataset["meeting_ends"][n]):
            curve = int(dataset["curve_id"][int(dataset["meeting_point"][n])])
            ends.setdefault(curve, []).append(MEETINGS[int(dataset["meeting_kind"][n])])
    return ends


def findings(datasets: Datasets) -> list[Finding]:
    """Return, for each scene, how many curves of which kind there are in its box."""
    return [Finding((finding_text(data),), name) for name, data in datasets.items()]


def finding_text(dataset: xr.Dataset) -> str:
    """Write the numbers of curves, with the box in which they were sought."""
    box = series(
        range_text(dataset[name], np.array(box_of(dataset[name])))
        for name in plane(dataset)
        if "box" in dataset[name].attrs
    )
    return curves_text(dataset) + (f", within {box}" if box else "")


REPORT = ReportPart(
    "Bifurcations",
    "Where in two parameters does the motion change?",
    answers_of(findings),
    tables_of(sections),
)
