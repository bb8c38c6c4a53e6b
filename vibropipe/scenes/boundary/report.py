"""Part of the report on boundaries: how many curves there are, and from where to where each leads."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.motion_words import (
    amount_text,
    motion_words,
    number_word,
    regime_by,
    rests_of,
)
from vibropipe.figures.text import flag_texts, format_number, in_brackets
from vibropipe.report.findings import symbol_text
from vibropipe.report.parts import Table, of_each, tables_of_each
from vibropipe.scenes.boundary.text import boundary_answers, change_text, marks, plane, shown_levels
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.regimes import Regime

MAX_ROWS, MAX_PASSED = 12, 3  # curves of the table; meetings of its note
# Distance of both ends of a curve that turns back, as a share of the plane.
SAME_PLACE = 1e-6
# Of the largest value of a parameter: what is nearer to 0 is beyond the digits of the others, and of where curves meet.
ROUNDING = 1e-5
KINDS, MEETINGS = flag_texts("boundary_kind"), flag_texts("meeting_kind")


def curve_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return a table of the curves of a scene, the longest MAX_ROWS; None without a curve."""
    if not dataset.sizes["point"]:
        return None
    x, y = plane(dataset)
    ids, ends = dataset["curve_id"].values, ends_of(dataset)
    lengths = lengths_of(dataset)
    longest = sorted(sorted(lengths, key=lambda number: -lengths[number])[:MAX_ROWS])
    rows = []
    for number in longest:
        first, last = np.flatnonzero(ids == number)[[0, -1]].tolist()
        names = ends.get(number, ["closed", "closed"])
        rows.append(
            [
                kind_text(dataset, first),
                words_at(dataset, first),
                place_text(dataset, first),
                end_text(names[0]),
                place_text(dataset, last)
                if names[-1] == "closed"
                else far_text(dataset, first, last),
                end_text(names[-1]),
            ]
        )
    where = f"({in_brackets(symbol_text(dataset[x]), dataset[x])}, {in_brackets(symbol_text(dataset[y]), dataset[y])})"
    note = f"Places: {where}. Motion: at the first point. Ends: the range that was searched, or what the curve meets"
    note += f"{change_text(dataset)}.{passed_text(dataset)}"
    if len(lengths) > len(longest):
        note += f" Left out: {amount_text(len(lengths) - len(longest), 'shorter curve')}."
    head = ["curve of", "motion", "from", "where it meets", "to", "where it meets"]
    title = "From where to where each curve leads"
    return Table(head, rows, note, left=2, title=title, scene=scene)


def lengths_of(dataset: xr.Dataset) -> dict[int, float]:
    """Return the length of each curve in the plane, of which each axis has the length 1."""
    ids = dataset["curve_id"].values
    steps = np.where(np.diff(ids) == 0, np.hypot(*np.diff(plotted(dataset))), 0.0)
    return {int(number): float(steps[ids[1:] == number].sum()) for number in np.unique(ids)}


def plotted(dataset: xr.Dataset) -> np.ndarray:
    """Return the points (2, n) of all curves in the plane, of which each axis has the length 1."""
    values = np.stack([dataset[name].values for name in plane(dataset)])
    lengths = np.ptp(values, axis=1, keepdims=True)
    return np.asarray(values / np.where(lengths > 0.0, lengths, 1.0))


def kind_text(dataset: xr.Dataset, point: int) -> str:
    """Write of what the curve through a point is: a kind of bifurcation, or a quantity with its value."""
    number = int(dataset["level_of"][point]) if "level_of" in dataset else -1
    kind = KINDS[int(dataset["boundary_kind"][point])]
    return shown_levels(dataset)[number].text if number >= 0 else kind


def place_text(dataset: xr.Dataset, point: int, of: str = "") -> str:
    """Write the parameters of a point of a curve, or `of` a meeting; what rounding leaves beside 0 is 0."""
    texts = []
    for name in plane(dataset):
        value, size = float(dataset[of + name][point]), float(np.abs(dataset[name].values).max())
        texts.append(format_number(value if abs(value) > ROUNDING * size else 0.0))
    return f"({', '.join(texts)})"


def far_text(dataset: xr.Dataset, first: int, last: int) -> str:
    """Write the place of the last point of a curve; of one that turns back to where it began, where it turns."""
    points = plotted(dataset)[:, first : last + 1]
    away = np.hypot(*(points - points[:, :1]))
    if first == last or away[-1] > SAME_PLACE:
        return place_text(dataset, last)
    return f"back, turning at {place_text(dataset, first + int(away.argmax()))}"


def passed_text(dataset: xr.Dataset) -> str:
    """Write what curves meet between their ends, and where, after a note; empty if nothing."""
    passed = np.flatnonzero(marks(dataset) & (dataset["meeting_ends"].values == 0))
    texts = [
        f"{end_text(MEETINGS[int(dataset['meeting_kind'][n])])} at {place_text(dataset, n, 'meeting_')}"
        for n in passed[:MAX_PASSED].tolist()
    ]
    more = f" and {number_word(passed.size - MAX_PASSED)} more" * (passed.size > MAX_PASSED)
    return f" Met between ends: {'; '.join(texts)}{more}." if texts else ""


def end_text(name: str) -> str:
    """Write what a curve meets at an end: grazing and fold; double grazing."""
    if name == "box":
        return "end of the range"
    return name if name.startswith(("double", "degenerate")) else name.replace(" ", " and ")


def words_at(dataset: xr.Dataset, point: int) -> str:
    """Write the motion of a point of a curve in words."""
    struck = dataset["impacts_per_orbit"]
    impacts, rests = (
        np.nan_to_num(array.isel(point=point).values)
        for array in (struck, rests_of(dataset, struck))
    )
    regime = Regime.WITH_REST if (rests > 0).any() else regime_by(impacts)
    return motion_words(regime, int(dataset["period_multiple"][point]), impacts, rests)


def ends_of(dataset: xr.Dataset) -> dict[int, list[str]]:
    """Return what each curve meets at its ends, first end first."""
    ends: dict[int, list[str]] = {}
    for n in np.argsort(dataset["meeting_point"].values, kind="stable"):
        if int(dataset["meeting_ends"][n]):
            curve = int(dataset["curve_id"][int(dataset["meeting_point"][n])])
            ends.setdefault(curve, []).append(MEETINGS[int(dataset["meeting_kind"][n])])
    return ends


answers, tables = of_each(boundary_answers), tables_of_each(curve_table)
REPORT = ReportPart(
    "Bifurcations", "Where in two parameters does the motion change?", answers, tables
)
