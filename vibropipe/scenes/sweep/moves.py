"""How the mass moves along the lines of a sweep, or over a map, in answers."""

from __future__ import annotations

from itertools import groupby, pairwise

import numpy as np
import xarray as xr

from vibropipe.figures.claims import only_between_text
from vibropipe.report.findings import point_text, symbol_text
from vibropipe.report.parts import Answer
from vibropipe.scenes.sweep.laws import Region, regions_of
from vibropipe.scenes.sweep.neighbours import border_text, is_followed
from vibropipe.scenes.sweep.sweep_rows import (
    axis_of,
    directions,
    is_from_rest,
    lines_of,
    strikes,
    swept,
)
from vibropipe.words.regimes import Regime

MAX_RUNS = 4  # ways to move along a line that a sentence names
MAX_LEAD = 110  # letters of what is bold


def fills_answer(dataset: xr.Dataset) -> Answer:
    """Return how the mass moves most often on a map, with the shares of the first two ways."""
    _, regions = regions_of(dataset)
    first, *others = regions
    whole = "the map" if len(swept(dataset)) == dataset["regime"].ndim == 2 else "the maps"
    if not others:
        points = "any point" if is_negative(first) else "all points"
        return Answer(f"The mass {first.does} at {points} of {whole}.")
    is_most = 2 * first.amount > first.total
    lead = f"In most of {whole} the mass" if is_most else "The mass most often"
    second = f"on {others[0].share} it {others[0].does}"
    if others[0].amount == first.amount:
        lead = "No way to move is the most frequent."
        return Answer(lead, f"On {first.share} of {whole} the mass {first.does}; {second}.")
    return Answer(f"{lead} {first.does}.", f"That fills {first.share} of {whole}; {second}.")


def moves_answer(dataset: xr.Dataset) -> Answer:
    """Return the ways to move along a line in turn and a border as far as known; of more lines, where impacts are."""
    codes, regions = regions_of(dataset)
    axis = axis_of(dataset)
    by_code = {region.code: region for region in regions}
    turns = [by_code[code] for code, _ in groupby(codes.sortby(axis).values.ravel().tolist())]
    symbol = symbol_text(dataset[axis])
    if codes.size == 1:
        where = point_text(codes.squeeze(), dataset["regime"].dims)
        return Answer(f"The mass {regions[0].does} at {where}.")
    if len(regions) == 1:
        rows = "any row" if is_negative(regions[0]) else "all rows"
        return Answer(f"The mass {regions[0].does} in {rows} along {symbol}.")
    (_, line), *others = lines_of(dataset)
    border = border_text(line, axis, is_followed(dataset))
    lead = f"With rising {symbol} the mass {turns_text(turns)}."
    if others or len(turns) > MAX_RUNS or len(lead) > MAX_LEAD:
        found = impacts_answer(dataset)
        return found if others or " between " in found.lead else Answer(found.lead, border)
    return Answer(lead, border)


def is_negative(region: Region) -> bool:
    """Return whether the words of a region deny something: of all rows that is so in any row."""
    return " no " in region.does or " not " in region.does


def turns_text(turns: list[Region]) -> str:
    """Write ways to move in turn: `strikes no support, then each support once a period`."""
    texts = [turns[0].does]
    for before, after in pairwise(turns):
        is_same = after.does.startswith("strikes ") and before.does.startswith("strikes ")
        texts.append(after.does.removeprefix("strikes ") if is_same else after.does)
    return ", then ".join(texts)


def impacts_answer(dataset: xr.Dataset) -> Answer:
    """Return outside which rows along the axis no line has impacts, and whether each line has some.

    Rows without a result may have impacts.
    """
    axis, lines = axis_of(dataset), [line for _, line in lines_of(dataset)]
    struck = np.array([strikes(line).values for line in lines])
    unknown = np.array([line["regime"].values for line in lines]) >= Regime.UNBOUNDED
    possible = np.asarray(struck | unknown)
    number, symbol = int(struck.any(axis=1).sum()), symbol_text(dataset[axis])
    solved = " with a result" if unknown.any() else ""
    if not number:
        return Answer(f"No row{solved} along {symbol} has impacts.")
    rest = "" if possible.any(axis=1).all() else "Some lines have none."
    ways = " and ".join(f"{way}wards" for way in directions(dataset))
    start = f"Followed {ways}, impacts" if is_followed(dataset) else "Impacts"
    start = "From rest, impacts" if is_from_rest(dataset) else start
    # Between two rows without impacts none is known.
    if only := only_between_text(lines[0][axis], np.asarray(possible.any(axis=0))):
        return Answer(f"{start} occur {only}.", rest)
    if possible.all():
        where = f"in all rows{solved} along {symbol}"
    else:
        reach = bool(struck[:, [0, -1]].any(axis=0).all())
        ends = f"up to both ends of the range of {symbol}, but not in all rows"
        where = ends if reach else f"in some rows along {symbol}"
    return Answer(f"{start} occur {where}.", rest)
