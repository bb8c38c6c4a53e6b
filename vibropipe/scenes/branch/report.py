"""Part of the report on branches: answers, where which motion is stable, and the steps of a cascade."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from vibropipe.figures.claims import at_most
from vibropipe.figures.motion_words import amount_text, changing_text, words_of
from vibropipe.figures.text import format_number, in_brackets
from vibropipe.report.exciter import side_of_first
from vibropipe.report.findings import symbol_text
from vibropipe.report.parts import DASH, Table, of_each, tables_of_each
from vibropipe.scenes.branch.answers import branch_answers, distinct_texts
from vibropipe.scenes.branch.lines import (
    KINDS,
    cascade_of,
    followed,
    places_of,
    swept,
    values_beside,
    with_values_beside,
)
from vibropipe.scenes.branch.motor import jump_table, question_of, speed_table
from vibropipe.scenes.branch.stretches import (
    SAME,
    Stretch,
    coexistence,
    group_words,
    image_groups,
    rest_text,
    stable_words,
    stretches_of,
)
from vibropipe.scenes.branch.yields import yield_table
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.proofs import Proved

MAX_ROWS = 10  # of a table
N_ENDS = 4  # cells of both ends of a stable motion
STEP_DIGITS = 3  # of a step of a cascade


def stable_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return the table of the stable motions: from where to where, and what ends them; None without ends."""
    if not dataset.sizes["bifurcation"] or is_one_cascade(dataset):
        return None
    axis = dataset[followed(dataset)]
    limits = (float(axis.min()), float(axis.max()))
    kept = image_groups(stretches_of(dataset))
    widest = sorted(kept, key=lambda alike: -np.ptp(alike[0].values))[:MAX_ROWS]
    images = sorted(widest, key=lambda alike: (alike[0].over, alike[0].values[0]))
    shown = [alike[0] for alike in images]
    texts = distinct_texts(*((float(each.values[0]), float(each.values[-1])) for each in shown))
    rows = [stable_row(alike, ends, limits) for alike, ends in zip(images, texts, strict=True)]
    if len(rows) == 1 and {*rows[0][-N_ENDS:]} == {DASH}:
        return None  # one motion, stable all along
    if "from_rest" in dataset:
        rows = [[*row, rest_text(alike)] for row, alike in zip(rows, images, strict=True)]
    head = [
        "stable motion", in_brackets("from", axis), "begins at a", in_brackets("to", axis), "ends at a",
        *(["from rest"] if "from_rest" in dataset else []),
    ]  # fmt: skip
    note = f"Values of {symbol_text(axis)}"
    if any(DASH in row for row in rows):
        note += "; a dash: it goes on to the end of the range"
    if any("change" in row for row in rows):
        note += f"; change: {changing_text(dataset)}"
    if "from_rest" in dataset:
        note += "; from rest: whether the mass, started at rest, settles on it"
    has_images = any(len(alike) > 1 for alike in kept)
    note += " or its mirror image" * ("from_rest" in dataset and has_images)
    note += ". Mirror images are listed once." if has_images else "."
    if len(kept) > len(shown):
        note += f" Left out: {amount_text(len(kept) - len(shown), 'narrower range')}."
    title = "Which motions are stable, and where"
    table = Table(head, rows, note, title=title, scene=scene)
    return with_values_beside(table, dataset, (each.over for each in shown))


def is_one_cascade(dataset: xr.Dataset) -> bool:
    """Return whether all bifurcations are flips of one cascade, whose table has where each motion begins and ends."""
    return {kind: at.size for kind, at in places_of(dataset).items()} == {
        "flip": len(cascade_of(dataset))
    }


def stable_row(
    alike: list[Stretch], texts: tuple[str, str], limits: tuple[float, float]
) -> list[str]:
    """Return the cells of a stable stretch and its mirror image, if it has one; texts : its ends."""
    stretch = alike[0]
    low, high = float(stretch.values[0]), float(stretch.values[-1])
    ends = [
        (DASH, DASH) if value == limit and not kind else (text, kind or DASH)
        for value, limit, text, kind in zip((low, high), limits, texts, stretch.ends, strict=True)
    ]
    return [group_words(alike), *ends[0], *ends[1]]


def together_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return the table of the intervals in which several motions are stable, by the further parameter.

    None for one interval alone, and without a further parameter, where the bars and the stable motions say it.
    """
    axis = dataset[followed(dataset)]
    if swept(dataset) is None:
        return None
    stretches = stretches_of(dataset)
    found = [
        (value, *ends) for value, intervals in coexistence(stretches).items() for ends in intervals
    ]
    if len(found) < 2:
        return None
    shown = sorted(sorted(found, key=lambda each: each[1] - each[2])[:MAX_ROWS])
    texts = distinct_texts(*((low, high) for _, low, high in shown))
    rows = [
        [stable_words([s for s in stretches if s.over == value], low, high), *ends]
        for (value, low, high), ends in zip(shown, texts, strict=True)
    ]
    head = ["stable motions", in_brackets("from", axis), in_brackets("to", axis)]
    note = f"Values of {symbol_text(axis)} between which the start decides which of the motions followed here settles."
    if len(found) > len(shown):
        note += f" Left out: {amount_text(len(found) - len(shown), 'narrower range')}."
    title = "Where at least two motions are stable"
    table = Table(head, rows, note, title=title, scene=scene)
    return with_values_beside(table, dataset, (value for value, *_ends in shown))


def cascade_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return the table of a cascade of flips: places, steps, and their ratios; None without one."""
    places = cascade_of(dataset)
    if not places:
        return None
    axis, steps = dataset[followed(dataset)], np.abs(np.diff(places))
    first = int(dataset["period_multiple"].values[dataset["bifurcation_point"].values].min())
    # the last step is seen in the places
    decimals = max(0, STEP_DIGITS - 1 - math.floor(math.log10(steps[-1])))
    rows = []
    for n, place in enumerate(places):
        text = f"{place:.{decimals}f}".replace("-", "−")
        step = f"{steps[n - 1]:.{decimals}f}" if n else DASH
        ratio = format_number(steps[n - 2] / steps[n - 1], 3) if n > 1 else DASH
        rows.append([f"{first * 2**n} to {first * 2 ** (n + 1)}", text, step, ratio])
    symbol = symbol_text(axis)
    head = ["forcing periods", in_brackets(symbol, axis), in_brackets("step", axis), "ratio"]
    note = "Ratio: the step before over this one; in an endless cascade it tends to 4.669 (Feigenbaum)."
    title = "Where the period doubles, and by what ratio the steps shrink"
    return Table(head, rows, note, title=title, scene=scene)


def proof_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return the table of the bifurcations that are proved, and how narrow their bounds are; None without one."""
    if "bifurcation_proved" not in dataset:
        return None
    axis = dataset[followed(dataset)]
    low, high = (dataset[f"bifurcation_{axis.name}_{end}"].values for end in ("low", "high"))
    proved = np.flatnonzero(dataset["bifurcation_proved"].values == Proved.PROVED)
    if not proved.size:
        return None
    kinds = [Bifurcation(int(kind)).name.lower() for kind in dataset["bifurcation_kind"].values]
    shown = sorted(proved, key=lambda n: high[n] - low[n], reverse=True)[:MAX_ROWS]
    rows = [
        [kinds[n], format_number(float(low[n]), 10), at_most(within(low[n], high[n]), 2)]
        for n in sorted(shown, key=lambda n: low[n])
    ]
    head = [
        "bifurcation",
        in_brackets(f"at {symbol_text(axis)}", axis),
        in_brackets("within", axis),
    ]
    note = "Exactly one such bifurcation of the law lies within bounds so far apart; the lower one is written."
    if proved.size > len(shown):
        note += f" Left out: {amount_text(proved.size - len(shown), 'narrower one')}."
    return Table(head, rows, note, title="Which bifurcations are proved", scene=scene)


def within(low: float, high: float) -> float:
    """Return a bound of the distance of two bounds, each rounded once more where units were changed."""
    return float(high - low + np.spacing(abs(low)) + np.spacing(abs(high)))


def scatter_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return the table of the ends of stable motions: how these places scatter, and by what most; None without one."""
    axis = dataset[followed(dataset)]
    place = f"bifurcation_{axis.name}"
    if f"{place}_std" not in dataset:
        return None
    deviations, at = dataset[f"{place}_std"].values, dataset[place].values
    points = dataset["bifurcation_point"].values
    beside = values_beside(dataset)[points]
    reach = SAME * float(np.ptp(axis.values))
    ends: dict[tuple[float, str, str], tuple[int, float]] = {}  # mirror images have the same
    for each in sorted(stretches_of(dataset), key=lambda each: -np.ptp(each.values)):
        for value in each.values[[0, -1]]:
            there = np.flatnonzero((np.abs(at - value) <= reach) & (beside == each.over))
            if not there.size:
                continue
            # Of several branches that end there this motion may be the one whose place has no derivative. A motion
            # without a point at the place ends where another begins.
            own = [n for n in there if words_of(dataset.isel(point=int(points[n]))) == each.words]
            known = [n for n in own or there if np.isfinite(deviations[n])]
            size = float(deviations[known[0]]) if known else math.nan
            # Over more than the stretch itself the first order says nothing.
            size = size if size <= np.ptp(each.values) else math.nan
            key = (each.over, each.words, f"{value:.8g}")
            ends.setdefault(key, (int([*known, *own, *there][0]), size))
    if not ends:
        return None
    listed = [(words, *end) for (_over, words, _value), end in ends.items()][:MAX_ROWS]
    listed.sort(key=lambda each: (beside[each[1]], at[each[1]]))
    rows = []
    for words, n, size in listed:
        shares = dataset[f"{place}_contribution"].isel(bifurcation=n).fillna(0.0)
        most = shares.isel(parameter=int(shares.argmax("parameter")))
        by = f"{symbol_text(dataset[str(most['parameter'].values)])} ({100 * float(most):.0f} %)"
        by = by if size == size else DASH
        kind = KINDS[int(dataset["bifurcation_kind"][n])]
        rows.append([words, kind, format_number(float(at[n]), 5), at_most(size, 2), by])
    head = [
        "stable motion", "ends at a", in_brackets(f"at {symbol_text(axis)}", axis),
        in_brackets("standard deviation", axis), "mostly by",
    ]  # fmt: skip
    note = "Of parts that scatter as the study says, to first order; in brackets its share of the variance."
    if any(DASH in row for row in rows):
        note += (
            " A dash: it is not known, as where the mass touches both supports at once, or larger than the range of "
            "the motion, in which the first order does not hold."
        )
    if len(ends) > len(listed):
        note += f" Left out: {amount_text(len(ends) - len(listed), 'end')} of narrower ranges."
    title = "How far the places where stable motions end scatter"
    table = Table(head, rows, note, left=2, title=title, scene=scene)
    return with_values_beside(table, dataset, (beside[n] for _words, n, _size in listed))


answers = of_each(branch_answers)
tables = tables_of_each(
    speed_table, jump_table, cascade_table, stable_table, together_table, scatter_table, yield_table, proof_table,
)  # fmt: skip
REPORT = ReportPart("Branches of orbits", question_of, answers, tables, side=side_of_first, rank=0)
