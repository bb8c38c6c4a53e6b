"""Part of the report on sweeps: answers, orbits of a map, ranges along lines, coexisting motions, energies."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np
import xarray as xr

from vibropipe.figures.claims import MOST_DIGITS, RANGE, even_digits
from vibropipe.figures.motion_words import number_word
from vibropipe.figures.text import format_number, in_brackets, is_forced, with_units
from vibropipe.report.exciter import WORDS, side_of_first
from vibropipe.report.findings import symbol_text
from vibropipe.report.parts import DASH, Datasets, Table, of_each, tables_of_each, told_once
from vibropipe.scenes.kind import ReportPart
from vibropipe.scenes.sweep.answers import sweep_answers
from vibropipe.scenes.sweep.laws import orbit_numbers, regions_of, share_text
from vibropipe.scenes.sweep.neighbours import Doublings, differing_rows, doublings_of, is_followed
from vibropipe.scenes.sweep.quantities import ENERGY_SHOW, Series, is_shown, of_orbits
from vibropipe.scenes.sweep.sweep_rows import axis_of, is_map, lines_of, n_lines, strikes
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import STEADY
from vibropipe.words.wording import count, series

MAX_ROWS, MAX_ORBITS, MAX_TOLD = (
    8,
    5,
    4,
)  # rows of a table, of that of the orbits of a map; ranges in a note
DIGITS, GRID_DIGITS = 3, 5
MAX_QUESTION = 110  # letters, a line of the report
OF_OWN = {"its phase": "phase of the second harmonic"}  # words of a parameter by itself


def motions_table(label: str, dataset: xr.Dataset) -> Table | None:
    """Return the table of how the mass moves: of a map its orbits, else the ranges along its line or lines."""
    if dataset["regime"].size == 1:
        return None
    if is_map(dataset):
        return orbits_table(label, dataset)
    if doubles := doublings_of(dataset, axis_of(dataset)):
        return doublings_table(label, dataset, doubles)
    if n_lines(dataset) == 1:
        return ranges_table(label, dataset)
    if (table := lines_table(label, dataset)) is None:
        return None
    return replace(table, note=f"{table.note} {together_text(dataset)}".strip())


def orbits_table(label: str, dataset: xr.Dataset) -> Table | None:
    """Return the most frequent orbits with impacts and without rest, and their shares; none without them."""
    regime = dataset["regime"]
    has_counts = "impacts_per_orbit" in dataset or "impacts_per_period" in dataset
    struck = np.isin(regime.values, (Regime.ONE_SIDED_1, Regime.ONE_SIDED_2, Regime.TWO_SIDED))
    if not struck.any() or not has_counts:
        return None
    numbers = [part.values[struck].tolist() for part in orbit_numbers(dataset)]
    found = Counter(zip(*numbers, strict=True)).most_common()
    # rare ones, whose share has no digit, are counted together
    shares = [share_text(n, regime.size) for _, n in found[:MAX_ORBITS]]
    kept = sum(not text.startswith("under") for text in shares) or len(shares)
    rows = [
        [f"{m}", f"{p1}", f"{p2}", text]
        for ((m, p1, p2), _), text in zip(found[:kept], shares, strict=False)
    ]
    left = sum(n for _, n in found[kept:])
    more = f"{count(len(found) - kept, 'more kind')} of orbit"
    note = f"{more}: {share_text(left, regime.size)}." if left else ""
    head = [
        "forcing periods",
        "impacts on support 1",
        "impacts on support 2",
        "share of all points",
    ]
    resting = " and without rest" if (regime == Regime.WITH_REST).any() else ""
    title = f"The most frequent orbits with impacts{resting}, and their periods"
    return Table(head, rows, note, title=title, scene=label, left=0)


def doublings_table(label: str, dataset: xr.Dataset, doubles: Doublings) -> Table:
    """Return the rows of each period on a way of doublings to aperiodic motion."""
    axis = dataset[axis_of(dataset)]
    symbol, way = symbol_text(axis), "falls" if doubles.is_falling else "rises"
    ends = [end for _, *both in doubles.runs for end in both]
    ends.append(doubles.end)
    texts = grid_texts(axis, [np.array([end]) for end in ends])
    rows = [
        [str(m), RANGE.join(dict.fromkeys(both))]
        for (m, *_), *both in zip(doubles.runs, texts[::2], texts[1::2], strict=False)
    ]
    rows.append(["aperiodic", texts[-1]])
    note = (
        f"First and last row of each period, and the first aperiodic row. {between_rows(dataset)}"
    )
    head = ["repeats after periods", in_brackets(symbol, axis)]
    return Table(head, rows, note, title=f"How the period doubles as {symbol} {way}", scene=label)


def between_rows(dataset: xr.Dataset) -> str:
    """Write what is known of a border between rows."""
    followed = "A followed motion may be left before it ends."
    return followed if is_followed(dataset) else "A border lies between two rows."


def ranges_table(label: str, dataset: xr.Dataset) -> Table | None:
    """Return how the mass moves along a line, range by range; of many ranges the longest ones, None of one alone."""
    axis = axis_of(dataset)
    has_velocity, has_period = "impact_velocity_max" in dataset, is_forced(dataset)
    codes, regions = regions_of(dataset)
    ((_, line),) = lines_of(dataset.assign(region=codes), "region", "impact_velocity_max")
    words = {region.code: region.words for region in regions}
    multiple = line.get("period_multiple", xr.zeros_like(line["region"])).values
    is_quiet = line["region"].values == Regime.NO_IMPACT
    # undamped motions repeat after many, or never
    quiet = 1 if (multiple[is_quiet] <= 1).all() else 0
    keys = [
        (int(code), int(m) if code != Regime.NO_IMPACT else quiet)
        for code, m in zip(line["region"].values, multiple, strict=True)
    ]
    runs = [(key, [*found]) for key, found in groupby(range(len(keys)), keys.__getitem__)]
    if len(runs) == 1:
        return None  # the answers tell it
    kept = sorted(sorted(runs, key=lambda run: -len(run[1]))[:MAX_ROWS], key=lambda run: run[1])
    ends = [line[axis].values[[found[0], found[-1]]] for _, found in kept]
    spans = grid_texts(line[axis], ends)
    rows = []
    for span, ((code, m), found) in zip(spans, kept, strict=True):
        cells = [span, words[code]]
        cells += [str(m) if m > 0 else DASH] if has_period else []
        if has_velocity:
            cells.append(hardest_text(line.isel({axis: found})))
        rows.append(cells)
    longest = f", the {MAX_ROWS} longest of {len(runs)}" if len(runs) > MAX_ROWS else ""
    note = f"First and last row of each range{longest}. {between_rows(dataset)}"
    head = [in_brackets(symbol_text(line[axis]), line[axis]), "how the mass moves"]
    head += ["repeats after periods"] if has_period else []
    head += [in_brackets("hardest impact", dataset["impact_velocity_max"])] if has_velocity else []
    return Table(
        head,
        rows,
        note,
        title=f"How the mass moves along {symbol_text(line[axis])}",
        scene=label,
        left=2,
    )


def hardest_text(rows: xr.Dataset) -> str:
    """Write the largest impact velocity of some rows."""
    values = rows["impact_velocity_max"].values
    values = values[np.isfinite(values)]
    return format_number(float(values.max()), DIGITS) if values.size else DASH


def grid_texts(axis: xr.DataArray, ranges: Sequence[np.ndarray]) -> list[str]:
    """Write the first and the last row of ranges of a grid, with digits that tell neighbours apart; equal ones once."""
    grid = np.unique(axis.values)
    step = float(np.diff(grid).min(initial=np.inf))
    whole = math.floor(math.log10(float(np.abs(grid).max()) or 1.0)) + 1
    needed = whole - math.floor(math.log10(step)) if math.isfinite(step) else 0
    digits = int(np.clip(needed, GRID_DIGITS, MOST_DIGITS))
    texts = [
        RANGE.join(dict.fromkeys(format_number(float(end), digits) for end in ends))
        for ends in ranges
    ]
    ends = np.concatenate(ranges).tolist()
    return even_digits(texts, all(math.isclose(float(f"{end:.{digits}g}"), end) for end in ends))


def lines_table(label: str, dataset: xr.Dataset) -> Table | None:
    """Return the outermost rows with impacts of each line, and its hardest impact; None if no row has a result."""
    axis, unknown = axis_of(dataset), dataset["regime"] >= Regime.UNBOUNDED
    if bool(unknown.all()):
        return None
    has_velocity = "impact_velocity_max" in dataset
    if has_velocity:
        orbits = of_orbits(dataset, Series("impact_velocity_max"))
        dataset = dataset.assign(impact_velocity_max=orbits)
    rows = []
    for point, line in lines_of(dataset, "impact_velocity_max"):
        struck = np.flatnonzero(strikes(line).values)
        (ends,) = (
            grid_texts(line[axis], [line[axis].values[struck[[0, -1]]]]) if struck.size else [DASH]
        )
        cells = [point, ends, share_text(struck.size, line.sizes[axis])]
        rows.append([*cells, hardest_text(line)] if has_velocity else cells)
    symbol = in_brackets(symbol_text(dataset[axis]), dataset[axis])
    head = ["line", f"first and last {symbol} with impacts", "rows with impacts"]
    if has_velocity:
        head.append(in_brackets("hardest impact of an orbit", dataset["impact_velocity_max"]))
    title = "Where each line has impacts, and how hard they are"
    note = "Rows without a result may have impacts, too." * bool(unknown.any())
    return told_once(Table(head, rows, note, title=title, scene=label), "all lines")


def together_text(dataset: xr.Dataset) -> str:
    """Write the ranges in which both directions of one line are on different stable orbits, if there are several."""
    axis = axis_of(dataset)
    found = differing_rows(dataset, axis)
    if len(found) < 2 or any(each.point for each in found):
        return ""
    ends = [np.array([each.low, each.high]) for each in found]
    spans = grid_texts(dataset[axis], ends)
    which = "the widest first" if len(found) <= MAX_TOLD else f"the {number_word(MAX_TOLD)} widest"
    shown = with_units(dataset[axis], series(spans[:MAX_TOLD]))
    where = f"In {number_word(len(found))} ranges of {symbol_text(dataset[axis])}"
    return f"{where} the two directions are on different stable motions, {which}: {shown}."


def together_table(label: str, dataset: xr.Dataset) -> Table | None:
    """Return the ranges of `together_text` of several lines, each with its line."""
    axis = axis_of(dataset)
    found = differing_rows(dataset, axis)
    if len(found) < 2 or not any(each.point for each in found):
        return None
    rows = [
        [each.point, *(format_number(end, 5) for end in (each.low, each.high))] for each in found
    ]
    symbol = in_brackets(symbol_text(dataset[axis]), dataset[axis])
    note = "The widest ranges first. A followed motion may be left before it ends."
    title = "Rows in which the two directions are on different stable motions"
    head = ["line", f"from {symbol}", f"to {symbol}"]
    return Table(head, rows[:MAX_ROWS], note, title=title, scene=label)


def energy_table(label: str, dataset: xr.Dataset) -> Table | None:
    """Return the range of each energy over rows with an orbit and over aperiodic rows; None without a force."""
    names = {name: STEADY[name].short for name in ENERGY_SHOW if is_shown(dataset, name)}
    if "energy_input" not in names or not is_forced(dataset):
        return None
    kinds = {
        "orbits": dataset["regime"] < Regime.APERIODIC,
        "aperiodic rows": dataset["regime"] == Regime.APERIODIC,
    }
    kinds = {kind: mask for kind, mask in kinds.items() if mask.any()}
    rows = [
        [words, *(energy_text(dataset, name, mask) for mask in kinds.values())]
        for name, words in names.items()
    ]
    heads = [in_brackets(kind, dataset["energy_input"]) for kind in kinds]
    note = "Smallest and largest value; of impacts on both supports together"
    note += "; of aperiodic rows the mean of a window." if "aperiodic rows" in kinds else "."
    return Table(
        ["energy per forcing period", *heads],
        rows,
        note,
        title="Where the work of the force goes",
        scene=label,
    )


def energy_text(dataset: xr.Dataset, name: str, rows: xr.DataArray) -> str:
    """Write the range of an energy over some rows; that of impacts is the sum over both supports."""
    energy = dataset[name].where(rows)
    energy = energy.sum("support", skipna=False) if "support" in energy.dims else energy
    values = energy.values[np.isfinite(energy.values)]
    if not values.size:
        return DASH
    ends = (format_number(float(end), DIGITS) for end in (values.min(), values.max()))
    return RANGE.join(dict.fromkeys(ends))


def question(datasets: Datasets) -> str:
    """Return the question of sweeps: how the motion changes with what they run over."""
    names = dict.fromkeys(
        WORDS[str(name)] for data in datasets.values() for name in data.dims if name in WORDS
    )
    over = series(f"the {OF_OWN.get(words, words)}" for words in names) or "its start"
    text = f"How does the motion change with {over}?"
    return text if len(text) <= MAX_QUESTION else "How does the motion change with its parameters?"


answers = of_each(sweep_answers)
tables = tables_of_each(motions_table, together_table, energy_table)
REPORT = ReportPart("Steady states", question, answers, tables, side=side_of_first, rank=0)
