"""Part of the report on coexisting motions; title, captions, answers and table of basins over a parameter."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from itertools import combinations

import numpy as np
import xarray as xr

from vibropipe.figures.claims import DIGITS, at_least, at_most, outwards
from vibropipe.figures.motion_words import amount_text, aperiodic_text, number_word
from vibropipe.figures.text import format_number, in_brackets, sentences, with_units
from vibropipe.report.exciter import side_of_first
from vibropipe.report.findings import equal_text, symbol_text
from vibropipe.report.parts import DASH, Answer, Table, of_each, tables_of_each
from vibropipe.scenes.basins.answers import NOT_FOUND, basin_answers, not_found, safety_table
from vibropipe.scenes.basins.attractors import (
    OF_IMAGES,
    Change,
    attractor_words,
    changes_of,
    images_of,
    letters_of,
    named,
    ordered,
    presence,
    swept_name,
)
from vibropipe.scenes.basins.text import missing_text, start_text
from vibropipe.scenes.branch.stretches import united
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.wording import count, part_text, series

MAX_MAPS = 6
MAX_NAMED = 2  # motions in words in an answer
RARE = 0.02  # share of the starts below which a motion is easily missed
# The value at which a range ends, or the two between which it does; None at an end of the values.
Border = tuple[float, ...] | None


def title_shares(dataset: xr.Dataset, branches: xr.Dataset | None = None) -> str:
    """Return the title of the shares: whether motions coexist."""
    if not dataset.sizes["attractor_id"]:
        return NOT_FOUND
    symbol, ranges = symbol_text(dataset[swept_name(dataset)]), len(together_ranges(dataset))
    only = only_value(dataset)
    if not ranges:
        is_all = not missing_text(dataset)
        told = "all starts settle on one motion" if is_all else "at most one motion was found"
        return f"At {only or f'each value of {symbol}'}, {told}"
    if only:
        return f"Motions coexist at {only}"
    where = amount_text(ranges, f"range of {symbol}", f"ranges of {symbol}")
    return f"Motions coexist in at least {where}"  # there may be more between values of the grid


def only_value(dataset: xr.Dataset) -> str:
    """Write the value of the parameter if it has but one; else empty."""
    axis = dataset[str(swept_name(dataset))]
    return equal_text(axis, axis.values[0]) if axis.size == 1 else ""


def describe_shares(dataset: xr.Dataset, branches: xr.Dataset | None = None) -> str:
    """Return the caption of the shares over a parameter."""
    n_starts = count(dataset.sizes["x0"] * dataset.sizes["v0"], "start")
    lines = " (grey: stable orbits wide, unstable ones dashed)" if branches is not None else ""
    return sentences(
        f"(a) First harmonic of the motions{lines}. (b) Share of {n_starts} that settle on each{start_text(dataset)}; "
        "upright bars: 95 % intervals for as many random starts",
        "Grey lines: a motion appears or vanishes" if changes_of(dataset) else "",
        missing_text(dataset),
        aperiodic_text(dataset),
    )


def title_share_maps(dataset: xr.Dataset) -> str:
    """Return the title of the maps: at which values."""
    axis = dataset[swept_name(dataset)]
    return f"Basins at {amount_text(len(mapped_values(dataset)), 'value')} of {symbol_text(axis)}"


def mapped_values(dataset: xr.Dataset) -> list[int]:
    """Return the indices of the values that are mapped: spread over those where attractors coexist, or over all."""
    several = np.flatnonzero(dataset["basin_share"].count("attractor_id").values > 1)
    candidates = several if several.size else np.arange(dataset.sizes[swept_name(dataset)])
    spread = np.linspace(0, candidates.size - 1, min(MAX_MAPS, candidates.size))
    return candidates[np.unique(spread.round().astype(int))].tolist()


def describe_share_maps(dataset: xr.Dataset) -> str:
    """Return the caption of the maps at some values of the parameter."""
    symbol = symbol_text(dataset[swept_name(dataset)])
    symbols = "; symbols: their states once every forcing period"
    marks = "" if float(dataset["start_phase"]) else symbols
    return sentences(
        f"Starts at some values of {symbol}{start_text(dataset)}; colours: the motion on which they settle{marks}",
        missing_text(dataset),
    )


def share_answers(dataset: xr.Dataset) -> list[Answer]:
    """Return where motions coexist, the main change, and the smallest basin."""
    if dataset.sizes["attractor_id"] == 0:
        return [not_found(dataset)]
    changes = change_answer(dataset)
    if is_one_motion(dataset):
        return [changes] if changes else []
    found = [together_answer(dataset), changes, rare_answer(dataset)]
    return [answer for answer in found if answer]


def is_one_motion(dataset: xr.Dataset) -> bool:
    """Return whether one motion alone is found, at all values of the parameter."""
    return dataset.sizes["attractor_id"] == 1 and not changes_of(dataset)


def together_answer(dataset: xr.Dataset) -> Answer:
    """Write where several attractors coexist, the widest range, and which of them do in all of it."""
    axis = dataset[str(swept_name(dataset))]
    symbol, ranges = symbol_text(axis), together_ranges(dataset)
    if not ranges:
        return Answer("At no value of the grid do the starts settle on two motions.")
    places = [
        _place(axis, border, rounded)
        for border, rounded in zip(ranges[0], (at_most, at_least), strict=True)
    ]
    if all(place.startswith(f"{symbol} = ") for place in places):
        places[1] = places[1].removeprefix(f"{symbol} = ")
    ways = "from", "to" if places[0] else "up to"
    texts = [f"{way} {place}" for way, place in zip(ways, places, strict=True) if place]
    texts += ["on"] if places[0] and not places[1] else []
    where = " ".join(texts) or f"at {only_value(dataset) or f'all values of {symbol}'}"
    more = ", and elsewhere" if len(ranges) > 1 else ""
    low, high = _ends(dataset, *ranges[0])
    own = {index: _ends(dataset, *borders) for index, borders in _borders_of(dataset).items()}
    whole = [
        named(dataset, index)
        for index, (first, last) in own.items()
        if first <= low and high <= last
    ]
    rest = f"There {series(whole)} coexist." if 2 <= len(whole) <= MAX_NAMED else ""
    return Answer(f"The start decides which motion settles {where}{more}.", rest)


def together_ranges(dataset: xr.Dataset) -> list[tuple[Border, Border]]:
    """Return the ranges of the parameter in which several attractors coexist, the widest first.

    They may lie between two values of the grid, at neither of which two motions are found.
    """
    borders = _borders_of(dataset)
    at = {
        end: border
        for own in borders.values()
        for end, border in zip(_ends(dataset, *own), own, strict=True)
    }
    pairs = combinations((_ends(dataset, *own) for own in borders.values()), 2)
    common = ((max(one[0], other[0]), min(one[1], other[1])) for one, other in pairs)
    values = dataset[str(swept_name(dataset))].values
    # at a located value one motion may go over into another
    found = united([(low, high) for low, high in common if low < high or low == high in values])
    return [(at[low], at[high]) for low, high in sorted(found, key=lambda each: each[0] - each[1])]


def _borders_of(dataset: xr.Dataset) -> dict[int, tuple[Border, Border]]:
    """Return between which borders each attractor is."""
    values = dataset[str(swept_name(dataset))].values
    order = np.argsort(values)
    changes = {(change.attractor, change.appears): change.value for change in changes_of(dataset)}
    found: dict[int, tuple[Border, Border]] = {}
    for index in ordered(dataset):
        present = np.flatnonzero(presence(dataset, index)[order])
        if not present.size:
            continue
        ends: list[Border] = []
        for inner, outer, appears in (
            (present[0], present[0] - 1, True),
            (present[-1], present[-1] + 1, False),
        ):
            if not 0 <= outer < values.size:
                ends.append(None)
            elif (place := changes.get((index, appears))) is not None:
                ends.append((place,))
            else:
                ends.append((float(values[order][inner]), float(values[order][outer])))
        found[index] = ends[0], ends[1]
    return found


def _ends(dataset: xr.Dataset, low: Border, high: Border) -> tuple[float, float]:
    """Return two borders as numbers: located values, else those inside, or the ends of the values."""
    values = dataset[str(swept_name(dataset))].values
    return (
        float(values.min()) if low is None else low[0],
        float(values.max()) if high is None else high[0],
    )


def _place(axis: xr.DataArray, border: Border, rounded: Callable[[float, int], str]) -> str:
    """Write a border that is located, or the value inside it, rounded inwards; empty at an end of the range."""
    if border is None:
        return ""
    if len(border) == 1:
        return equal_text(axis, border[0])
    return f"at least {symbol_text(axis)} = {with_units(axis, rounded(border[0], DIGITS))}"


def change_answer(dataset: xr.Dataset) -> Answer | None:
    """Write how many changes there are, and where the motion ends that lasts longest."""
    changes, axis = changes_of(dataset), dataset[swept_name(dataset)]
    if not changes and (only := only_value(dataset)):
        return Answer(f"One motion is found at {only}.") if is_one_motion(dataset) else None
    if not changes:
        same = f"same motion{'s are' if dataset.sizes['attractor_id'] > 1 else ' is'} found"
        return Answer(f"The {same} at all values of {symbol_text(axis)} on the grid.")
    places = len({change.value for change in changes})
    lead = f"Motions appear or vanish at {amount_text(places, 'value')} of {symbol_text(axis)} or more."
    ends = [change for change in changes if not change.appears and change.other >= 0]
    if not ends:
        return Answer(lead)
    last = max(ends, key=lambda change: presence(dataset, change.attractor).sum())
    place = equal_text(axis, last.value)
    follows = letters_of(dataset)[last.other]
    vanishing = named(dataset, last.attractor)
    rest = f"With increasing {symbol_text(axis)}, {vanishing} vanishes at {place} and {follows} follows."
    return Answer(lead, rest)


def rare_answer(dataset: xr.Dataset) -> Answer | None:
    """Write which attractor the fewest starts settle on, and where, if they are few."""
    share = dataset["basin_share"]
    least = share.min()
    if not float(least) < RARE:
        return None
    name = str(swept_name(dataset))
    alike = np.argwhere(share.transpose(name, "attractor_id").values == float(least))
    letters, axis = letters_of(dataset), dataset[name]
    found = sorted({letters[int(index)] for _, index in alike})
    if len(found) > 1:
        return Answer(f"The smallest shares are those of {series(found)}.")
    if len(alike) > 1:
        return Answer(f"The smallest share is that of {found[0]}.")
    ((row, index),) = alike
    place = equal_text(axis, axis.values[row])
    return Answer(
        f"The smallest share is that of {letters[int(index)]}.",
        f"At {place}, {starts_text(dataset, float(least))} it.",
    )


def starts_text(dataset: xr.Dataset, share: float) -> str:
    """Write that so many of the starts settle on."""
    total = dataset.sizes["x0"] * dataset.sizes["v0"]
    settled = round(share * total)
    if settled == total:
        return f"{part_text(total, total, 'start')} {'settles' if total == 1 else 'settle'} on"
    amount = number_word(settled) if settled else "none"
    return f"{amount} of {count(total, 'start')} {'settles' if settled < 2 else 'settle'} on"


def family_table(scene: str, dataset: xr.Dataset) -> Table | None:
    """Return the table of the attractors of a scene over a parameter."""
    if not dataset.sizes["attractor_id"]:
        return None
    axis, letters = dataset[swept_name(dataset)], letters_of(dataset)
    changes = {(change.attractor, change.appears): change for change in changes_of(dataset)}
    rows = []
    for index in ordered(dataset):
        share = dataset["basin_share"].sel(attractor_id=index).values[presence(dataset, index)]
        if not share.size:
            continue
        ends = [changes.get((index, appears)) for appears in (True, False)]
        rows.append(
            [
                letters[index],
                attractor_words(dataset, index) + image_text(dataset, index),
                *(DASH if end is None else format_number(end.value) for end in ends),
                _neighbours(letters, *ends),
                _span(100 * float(share.min()), 100 * float(share.max())),
            ]
        )
    if is_one_motion(dataset) and rows[0][-1] == "100":
        return None  # which has no ends
    symbol = symbol_text(axis)
    unknown = ", ?: none was found" if any("?" in row[-2] for row in rows) else ""
    head = ["", "motion", in_brackets("from", axis), in_brackets("to", axis), "beyond", "share (%)"]
    note = (
        f"Values of {symbol} at which a motion appears and vanishes; a dash: it goes on to the end of the range. "
        f"Beyond: the motions that settle below and above instead{unknown}. Motions, and shares of the starts: "
        "at the values of the grid, which may miss where motions coexist."
    )
    return Table(
        head, rows, note, left=2, title="Where each motion appears and vanishes", scene=scene
    )


def image_text(dataset: xr.Dataset, index: int) -> str:
    """Write of which other attractor one is the mirror image, after its words: wherever it is, or in part."""
    name, alike = str(swept_name(dataset)), dataset[list(OF_IMAGES)]
    own = np.flatnonzero(presence(dataset, index))
    found = Counter(
        image for n in own for image in images_of(alike.isel({name: int(n)}), index)[1:]
    )
    if not found:
        return ""
    image, amount = found.most_common(1)[0]
    part = "" if amount == own.size else "in part "
    return f" ({part}mirror image of {letters_of(dataset)[image]})"


def _span(low: float, high: float) -> str:
    """Write the range of a share in per cent."""
    return format_number(low, 3) if low == high else " … ".join(outwards(low, high, 3))


def _neighbours(letters: dict[int, str], below: Change | None, above: Change | None) -> str:
    """Write the motions on which one settles below and above its values."""
    names = [letters.get(end.other, "?") if end is not None else DASH for end in (below, above)]
    return DASH if names == [DASH, DASH] else ", ".join(names)


answers = of_each(lambda data: (share_answers if swept_name(data) else basin_answers)(data))
tables = tables_of_each(
    lambda scene, data: (family_table if swept_name(data) else safety_table)(scene, data)
)
REPORT = ReportPart(
    "Coexisting motions",
    "Which start settles on which motion, and how easily is it lost?",
    answers,
    tables,
    side=side_of_first,
    rank=0,
)
