"""What boundaries are there, in words: titles, captions and answers; the curves that they tell of; labels of levels."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.text import Text
from numpy.typing import NDArray

from vibropipe.figures.line_names import Named, label_lines, with_places
from vibropipe.figures.motion_words import amount_text, changing_text, number_word
from vibropipe.figures.palette import EXACT
from vibropipe.figures.text import flag_texts, plain_symbol_of, sentences, symbol_of, ties_text
from vibropipe.report.parts import Answer
from vibropipe.scenes.design.data import in_words, shown_goals
from vibropipe.solve.rows.named import named
from vibropipe.words.quantities import FLAGS, QUANTITIES
from vibropipe.words.wording import capitalised, series

# Kinds of curves in the order of the legend.
KINDS = ("grazing", "fold", "flip", "pitchfork", "level")
# Share of the extent of all curves within which meetings are at one place.
SAME_PLACE = 1e-6
# Meetings that are no meeting of bifurcations.
UNMARKED = ("box", "lost", "points")


def plane(dataset: xr.Dataset) -> tuple[str, str]:
    """Return both parameters of boundaries, abscissa first."""
    x, y = str(dataset.attrs["boundary"]).split()
    return x, y


def kinds_present(dataset: xr.Dataset) -> dict[str, int]:
    """Return the integer of each kind of boundary that occurs, in the order of the legend."""
    codes = FLAGS["boundary_kind"]
    return {name: codes[name] for name in KINDS if (dataset["boundary_kind"] == codes[name]).any()}


def curves_of(dataset: xr.Dataset, code: int) -> Iterator[np.ndarray]:
    """Yield the indices of the points of each curve of a kind."""
    ids, kinds = dataset["curve_id"].values, dataset["boundary_kind"].values
    for number in np.unique(ids[kinds == code]):
        yield np.flatnonzero(ids == number)


def of_kinds(dataset: xr.Dataset, show: Collection[str]) -> xr.Dataset:
    """Return the curves of the kinds to show (default: all), with what they meet."""
    if not show:
        return dataset
    codes = [FLAGS["boundary_kind"][name] for name in show]
    is_kept = np.isin(dataset["boundary_kind"].values, codes)
    met = is_kept[dataset["meeting_point"].values]
    return dataset.isel(point=is_kept, meeting=met)


def marks(dataset: xr.Dataset) -> np.ndarray:
    """Return the mask of the meetings that are marked."""
    unmarked = [FLAGS["meeting_kind"][name] for name in UNMARKED]
    return ~np.isin(dataset["meeting_kind"].values, unmarked)


def without_levels(dataset: xr.Dataset) -> xr.Dataset:
    """Return the curves of bifurcations."""
    return of_kinds(dataset, [name for name in KINDS if name != "level"])


def title_boundaries(
    dataset: xr.Dataset, regimes: xr.Dataset | None = None, show: Collection[str] = ()
) -> str:
    """Return the title: at which bifurcations motions change and which levels there are; else that of the scene."""
    shown = of_kinds(dataset, show)
    kinds = series(f"{name}s" for name in kinds_present(without_levels(shown)))
    levels = [level for _number, level in level_numbers(shown)]
    titles = [f"motions change at {kinds}"] if kinds else []
    if len(levels) == 1:
        titles.append(f"where the {levels[0].words} is {levels[0].value}")
    elif levels:
        titles.append(f"levels of {series(dict.fromkeys(level.words for level in levels))}")
    return capitalised("; ".join(titles))


def describe_boundaries(
    dataset: xr.Dataset, regimes: xr.Dataset | None = None, show: Collection[str] = ()
) -> str:
    """Return the caption: what is drawn, and which curves there are."""
    left_out = [name for name in kinds_present(dataset) if name not in (show or (name,))]
    dataset = of_kinds(dataset, show)
    x, y = (plain_symbol_of(dataset[name]) for name in plane(dataset))
    unstable = bool((dataset["stable"] == 0).any())
    levels, ties = [level.text for _number, level in level_numbers(dataset)], ties_text(dataset)
    what = ["bifurcations"] * (bool(kinds_present(without_levels(dataset))) or not levels)
    what += ["levels"] * bool(levels)
    return sentences(
        f"Curves of {series(what)} of orbits over {x} and {y}"
        + ("; thin: of an unstable orbit" if unstable else ""),
        "" if dataset.sizes["point"] else curves_text(dataset, show),
        f"Levels: {'; '.join(levels)}" if levels else "",
        f"Not drawn: {series(left_out)}" if left_out else "",
        f"Circles: curves meet{change_text(dataset)}" if marks(dataset).any() else "",
        "Colours: the motions that settle; where they change without a curve, another orbit attracts the start"
        if regimes is not None
        else "",
        f"Tied: {ties}" if ties else "",
        dataset.attrs.get("incomplete", ""),
    )


def change_text(dataset: xr.Dataset) -> str:
    """Write what a change is, after a caption or a note; empty if no curve meets one."""
    changes = dataset["meeting_kind"].values == FLAGS["meeting_kind"]["change"]
    return f"; change: {changing_text(dataset)}" if changes.any() else ""


def curves_text(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Write how many curves of each kind there are, or that none is of those to `show` (default: all)."""
    ids, kinds = dataset["curve_id"].values, dataset["boundary_kind"].values
    numbers = {
        name: np.unique(ids[kinds == code]).size for name, code in kinds_present(dataset).items()
    }
    listed = series(amount_text(number, name) for name, number in numbers.items())
    sought = [name for name in dataset.attrs.get("sought", "").split() if name in (show or (name,))]
    sought += [level.text for level in shown_levels(dataset) if "level" in (show or ("level",))]
    none = f"No curve of {series(sought, 'or')} is found" if sought else "No curve is found"
    whole = amount_text(int(np.unique(ids).size), "curve")
    return f"{capitalised(whole)}: {listed}" if numbers else none


def boundary_answers(dataset: xr.Dataset) -> list[Answer]:
    """Return how many curves of which kind there are, and where they meet."""
    levels, dataset = _level_answers(dataset), without_levels(dataset)
    if levels and not dataset.sizes["point"]:
        return levels
    lead, _, kinds = curves_text(dataset).partition(": ")
    if not kinds:
        return [Answer(f"{lead} within the ranges that were searched.")]
    first = kinds.partition(",")[0]
    are = "is" if first.startswith("one ") and " and " not in first else "are"
    rest = f"Among those found {are} {first}."
    answers = [Answer(f"Motions change along at least {lead.lower()}.", rest)]
    met, rest = meetings_text(dataset)
    if met:
        answers.append(Answer(f"Curves meet in at least {met}.", rest))
    return [*answers, *levels]


def _level_answers(dataset: xr.Dataset) -> list[Answer]:
    """Return along how many curves orbits have each level, and whether stable ones do."""
    answers = []
    for number, level in level_numbers(dataset):
        of_level = dataset.isel(point=dataset["level_of"].values == number)
        curves = amount_text(len(joined_curves(dataset, number, *plane(dataset))), "curve")
        stable = of_level["stable"].values != 0
        share = "All" if stable.all() else "Some" if stable.any() else "None"
        lead = f"Along at least {curves} the {level.words} is {level.value}."
        answers.append(Answer(lead, f"{share} of the motions found there are stable."))
    found = {number for number, _level in level_numbers(dataset)}
    absent = [level.text for n, level in enumerate(shown_levels(dataset)) if n not in found]
    if absent and dataset.sizes["point"]:
        lead = f"No curve of {series(absent, 'or')} is found within the ranges that were searched."
        answers.append(Answer(lead))
    return answers


# What happens where curves meet, by the kind of meeting.
MET = {
    "cusp": "two folds meet",
    "grazing fold": "a grazing and a fold meet",
    "grazing flip": "a grazing and a flip meet",
    "grazing pitchfork": "a grazing and a pitchfork meet",
    "double grazing": "an orbit grazes twice",
    "degenerate flip": "a flip changes its direction",
    "degenerate pitchfork": "a pitchfork changes its direction",
    "chatter": "chatter begins",
    "rest": "the mass comes to rest",
}


def meetings_text(dataset: xr.Dataset) -> tuple[str, str]:
    """Write at how many points curves meet, and what happens at most of them; empty if they meet nowhere."""
    places = meeting_places(dataset)
    if not places.size:
        return "", ""
    codes = dataset["meeting_kind"].values[marks(dataset)]
    at = {int(code): np.unique(places[codes == code]).size for code in np.unique(codes)}
    code, amount = max(at.items(), key=lambda each: each[1])
    total, kind = np.unique(places).size, flag_texts("meeting_kind")[code]
    what = changing_text(dataset) if kind == "change" else MET.get(kind, f"a {kind} is met")
    where = "There" if amount == total else f"At {number_word(amount)} of them"
    return amount_text(total, "point"), f"{where} {what}."


def meeting_places(dataset: xr.Dataset) -> NDArray[np.intp]:
    """Return for each marked meeting the first one at its place: where curves meet each has one, a loop two."""
    found, marked = [], marks(dataset)
    for name in plane(dataset):
        at = dataset[f"meeting_{name}"].values[marked]
        reach = SAME_PLACE * np.ptp(dataset[name].values) if at.size else 0.0
        found.append(np.abs(at[:, None] - at) <= reach)
    return np.asarray((found[0] & found[1]).argmax(axis=1) if marked.any() else np.empty(0, int))


# Curves of a level that have a label: the longest.
LABELLED_CURVES = 3
# Distance of the ends of two pieces of one curve, as a share of what is drawn.
TOUCHING = 1e-5


class ShownLevel(NamedTuple):
    """A level: its quantity in words and as mathtext, and its value with the unit shown."""

    words: str
    symbol: str
    value: str

    @property
    def text(self) -> str:
        """The level in words."""
        return f"{self.words} = {self.value}"


def shown_levels(dataset: xr.Dataset) -> list[ShownLevel]:
    """Return the levels that were sought, by their number."""
    levels = []
    for name, text in shown_goals(dataset, "levels"):
        quantity = named(name, "levels")
        record, dims = QUANTITIES[quantity.variable], QUANTITIES[quantity.variable].dims
        words = in_words(
            quantity.variable, record.long_name, dims[0] if dims else "", quantity.number or 0
        )
        array = xr.DataArray(0.0, name=quantity.variable)
        symbol = symbol_of(array, quantity.number)
        if quantity.number and symbol == symbol_of(array):
            symbol += f" at {dims[0]} {quantity.number}"
        levels.append(ShownLevel(words, symbol, text.removeprefix("= ")))
    return levels


def level_numbers(dataset: xr.Dataset) -> Iterator[tuple[int, ShownLevel]]:
    """Yield the number and the words of each level that has curves."""
    present = set(np.unique(dataset["level_of"].values)) if "level_of" in dataset else set()
    for number, level in enumerate(shown_levels(dataset)):
        if number in present:
            yield number, level


def joined_curves(dataset: xr.Dataset, number: int, x: str, y: str) -> list[list[int]]:
    """Return the curves of a level as lists of their pieces: where the law of motion changes, a next piece begins."""
    ids = dataset["curve_id"].values
    groups: list[tuple[list[int], np.ndarray]] = []
    size = np.array([float(np.ptp(dataset[name].values)) or 1.0 for name in (x, y)])
    for curve in np.unique(ids[dataset["level_of"].values == number]).tolist():
        points = np.flatnonzero(ids == curve)[[0, -1]]
        ends = np.column_stack([dataset[name].values[points] for name in (x, y)]) / size
        near = [
            bool(np.abs(ends[:, None] - known).max(axis=-1).min() <= TOUCHING)
            for _, known in groups
        ]
        joined = [group for group, is_near in zip(groups, near, strict=True) if is_near]
        groups = [group for group, is_near in zip(groups, near, strict=True) if not is_near]
        pieces = [piece for other, _ in joined for piece in other]
        groups.append(([*pieces, curve], np.concatenate([*(known for _, known in joined), ends])))
    return [pieces for pieces, _ends in groups]


def label_levels(ax: Axes, dataset: xr.Dataset, x: str, y: str) -> list[Text]:
    """Write the value of each level at the longest of its curves; return the labels."""
    ids = dataset["curve_id"].values
    curves = {
        n: (with_places(dataset[x].values[ids == n]), with_places(dataset[y].values[ids == n]))
        for n in np.unique(ids).tolist()
    }
    lines: list[Named] = []
    for number, level in level_numbers(dataset):
        found = []
        for pieces in joined_curves(dataset, number, x, y):
            longest = max(pieces, key=lambda piece: int((ids == piece).sum()))
            drawn = ax.transData.transform(np.column_stack(curves[longest]))
            found.append((float(np.hypot(*np.diff(drawn, axis=0).T).sum()), longest))
        for n, (_length, curve) in enumerate(sorted(found, reverse=True)[:LABELLED_CURVES]):
            text = f"{level.symbol} = {level.value}"
            lines.append(Named(*curves.pop(curve), text, EXACT, n == 0))
    return label_lines(ax, lines, curves.values())
