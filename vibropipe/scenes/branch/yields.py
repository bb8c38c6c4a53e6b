"""Yields along branches in a report: at how many points most parts are good, and a table of some of them."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.claims import percent
from vibropipe.figures.motion_words import amount_text, words_of
from vibropipe.figures.text import format_number, in_brackets
from vibropipe.report.findings import symbol_text
from vibropipe.report.parts import ROWS_SHOWN, Answer, Table
from vibropipe.scenes.branch.lines import followed, place_text, values_beside, with_values_beside
from vibropipe.scenes.design.sorting_words import sorting_of
from vibropipe.scenes.design.workshop import MADE, sorting_cells

PARTS = "1,024 parts"


def scattered_at(dataset: xr.Dataset) -> np.ndarray:
    """Return the points whose yield is known, by the further parameter and then along the branches."""
    if "yield" not in dataset:
        return np.empty(0, int)
    known = np.flatnonzero(np.isfinite(dataset["yield"].values))
    along, beside = dataset[followed(dataset)].values, values_beside(dataset)
    return known[np.lexsort([along[known], beside[known]])]


def kept_words(dataset: xr.Dataset) -> str:
    """Write what good parts keep."""
    return "their law of motion" + (" and the bounds" if dataset.attrs.get("subject_to") else "")


def yield_answer(dataset: xr.Dataset) -> Answer | None:
    """Write at how many points most parts are good, and at which the fewest are; None without yields."""
    points = scattered_at(dataset)
    if not points.size:
        return None
    shares, lows = dataset["yield"].values[points], dataset["yield_low"].values[points]
    made, n = int((lows >= MADE).sum()), points.size
    keep = f"at least {percent(MADE)} of the parts keep {kept_words(dataset)}."
    if n == 1:
        lead = f"At the one point where parts were scattered {'' if made else 'it is not shown that '}{keep}"
    elif made:
        lead = f"At {f'all {n}' if made == n else f'{made} of {n}'} points where parts were scattered, {keep}"
    else:
        lead = f"At none of {n} points where parts were scattered is it shown that {keep}"
    if shares.min() == shares.max():
        return Answer(lead, f"At each, {percent(float(shares.min()))} of {PARTS} do.")
    least, alike = int(points[shares.argmin()]), int((shares == shares.min()).sum())
    fewest = f"The fewest, {percent(float(shares.min()))} of {PARTS}, do at"
    if alike > 1:
        return Answer(lead, f"{fewest} {alike} of these points.")
    return Answer(lead, f"{fewest} {place_text(dataset, least)}.")


def yield_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return the table of the yields of some points, and what foretells there which parts are good; None without."""
    points = scattered_at(dataset)
    if not points.size:
        return None
    shown = points
    if points.size > ROWS_SHOWN:
        shown = points[np.linspace(0, points.size - 1, ROWS_SHOWN).round().astype(int)]
    axis = dataset[followed(dataset)]
    values = [dataset[name] for name in ("yield", "yield_low", "yield_high")]
    rules = {point: sorting_of(dataset, point) for point in shown.tolist()}
    has_rule = any(rule is not None for rule in rules.values())
    rows = []
    for point, rule in rules.items():
        share, low, high = (float(each[point]) for each in values)
        ends = f"{percent(low).removesuffix(' %')} to {percent(high, up=True)}"
        rows.append(
            [
                words_of(dataset.isel(point=point)), format_number(float(axis[point]), 5),
                percent(share), ends, *(sorting_cells(rule, share) if has_rule else []),
            ]
        )  # fmt: skip
    head = [
        "stable motion", in_brackets(f"at {symbol_text(axis)}", axis), "yield", "95 % interval",
        *(["parts are good whose", "is", "sorted wrongly"] if has_rule else []),
    ]  # fmt: skip
    note = (
        f"Yield: share of {PARTS}, scattered by the given deviations and started from the orbit of the point, that "
        f"keep {kept_words(dataset)}; nothing is said of what lies between the points."
    )
    if has_rule:
        note += " Sorted wrongly: between which shares of all parts, with 95 % confidence."
    if points.size > len(shown):
        note += f" Left out: {amount_text(points.size - len(shown), 'point')} between these."
    widths = ("1fr", "auto", "auto", "auto", *("1.2fr", "auto", "auto") * has_rule)
    title = "How many scattered parts are good along the branches"
    table = Table(head, rows, note, widths, title=title, scene=scene)
    return with_values_beside(table, dataset, values_beside(dataset)[shown])
