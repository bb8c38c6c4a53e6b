"""Part of the report on effects scenes: prices of effects and outputs, what costs most, and how it is timed."""

from __future__ import annotations

from dataclasses import dataclass

import xarray as xr

from vibropipe.figures.text import format_number
from vibropipe.report.exciter import side_of_first
from vibropipe.report.parts import Answer, Datasets, Line, Side, of_each
from vibropipe.scenes.kind import ReportPart
from vibropipe.words.wording import capitalised, series

# Groups that are answered, the dearest, and dear entries that are named in each.
MAX_GROUPS, MAX_NAMED = 2, 2
LEFT_OUT = "What a motion or a sweep does not call for costs hardly any time: its code is left out, or idle."


def answers(dataset: xr.Dataset) -> list[Answer]:
    """Return what costs most in the groups that cost most, what costs nothing there, and that the rest is left out."""
    by_group = groups(prices(dataset))
    dear = {group: dearest(each) for group, each in by_group.items()}
    ranked = sorted(by_group, key=lambda group: -max((p.ratio for p in dear[group]), default=1.0))
    chosen = [group for group in by_group if group in ranked[:MAX_GROUPS]]
    more = [
        f"{group}: up to {ratio_text(dear[group][0].ratio)} times as long."
        for group in ranked[MAX_GROUPS : MAX_GROUPS + 1]
        if dear[group]
    ]
    found = [group_answer(group, by_group[group]) for group in chosen]
    return [*found, Answer(LEFT_OUT, "".join(more))]


def group_answer(group: str, entries: list[Price]) -> Answer:
    """Return the answer of one group: what costs most, or least, and what costs nothing."""
    dear = dearest(entries)[:MAX_NAMED]
    free = [name(price) for price in entries if price.is_nothing]
    more = max((price.ratio for price in entries), default=0.0)
    alike = dear and more > dear[0].ratio
    title = f"{group}{', at equal impacts' * bool(alike)}: " if group else ""
    if dear:
        first, *others = (f"{ratio_text(p.ratio)} times" for p in dear)
        texts = [f"{first} as long", *others]
        both = zip(texts, dear, strict=True)
        lead = f"{title}{series(f'{text} with {name(price)}' for text, price in both)}."
    else:
        lead = f"{title}{'nothing costs anything' if len(free) == len(entries) else 'nothing costs more'}."
    cheap = series(free)
    verb = "costs" if len(free) == 1 else "cost"
    rest = f"{capitalised(cheap)} {verb} nothing." if free and dear else ""
    return Answer(capitalised(lead), rest)


def name(price: Price) -> str:
    """Return what an entry is called in a sentence: its title up to a comma or colon."""
    return price.label.split(",")[0].split(":")[0]


def title_of(dataset: xr.Dataset) -> str:
    """Return what the picture shows, as a sentence: the two dearest entries, and whether others have more impacts."""
    found = prices(dataset)
    dear = dearest(found)[:MAX_NAMED]
    if not dear:
        return "Price list: nothing costs more than what it is compared with"
    whole = max(price.ratio for price in found) <= dear[0].ratio
    among = "" if whole else "at equal impacts, "
    return f"Price list: {among}{series(name(price) for price in dear)} cost{'s' * (len(dear) == 1)} most"


# Deviation of a ratio from 1 that is nothing even without scatter: rounded to two digits the ratio is 1.0.
LEAST = 0.05


@dataclass(frozen=True)
class Price:
    """The price of one entry, relative to the time of another; `limit`: a deviation from 1 up to it is nothing.

    `is_same_motion`: it has as many impacts per period as the other.
    """

    label: str
    group: str
    ratio: float
    low: float
    high: float
    limit: float
    impacts: float
    bytes: float
    is_reference: bool
    is_same_motion: bool

    @property
    def is_nothing(self) -> bool:
        """Whether the ratio is 1 within the scatter."""
        return abs(self.ratio - 1.0) <= self.limit

    @property
    def text(self) -> str:
        """The price in words: nothing, 39 times, 0.64 of it, 1/20."""
        if self.is_nothing:
            return "nothing"
        if self.ratio > 1.0:
            return f"{ratio_text(self.ratio)} times"
        return f"1/{1.0 / self.ratio:.0f}" if self.ratio < 0.2 else f"{self.ratio:.2g} of it"


def ratio_text(ratio: float) -> str:
    """Write a ratio to two digits."""
    return f"{ratio:.0f}" if ratio >= 10 else format_number(float(f"{ratio:.2g}"), 2)


def prices(dataset: xr.Dataset) -> list[Price]:
    """Return the prices of a dataset, in its order."""
    found = []
    names = dataset["motion"].values.tolist()
    for k, name in enumerate(names):
        one = dataset.isel(motion=k)
        other = float(dataset["impacts_per_period"][names.index(str(one["compared_with"].values))])
        found.append(
            Price(
                label=str(one["label"].values),
                group=str(one["group"].values),
                ratio=float(one["time_ratio"]),
                low=float(one["time_ratio_low"]),
                high=float(one["time_ratio_high"]),
                limit=LEAST + float(one["time_scatter"]),
                impacts=float(one["impacts_per_period"]),
                bytes=float(one["bytes_per_row"]),
                is_reference=str(one["compared_with"].values) == name,
                is_same_motion=abs(float(one["impacts_per_period"]) - other) <= 0.05 * other,
            )
        )
    return found


def groups(found: list[Price]) -> dict[str, list[Price]]:
    """Return the prices by group, without the entries that others are compared with."""
    by_group: dict[str, list[Price]] = {}
    for price in found:
        by_group.setdefault(price.group, [])
        if not price.is_reference:
            by_group[price.group].append(price)
    return {group: entries for group, entries in by_group.items() if entries}


def base_times(dataset: xr.Dataset) -> dict[str, tuple[float, str]]:
    """Return the time (ns) that a ratio of 1 stands for, and of what, by group."""
    names = dataset["motion"].values.tolist()
    times: dict[str, tuple[float, str]] = {}
    for k in range(len(names)):
        one = dataset.isel(motion=k)
        other = names.index(str(one["compared_with"].values))
        if other != k:
            time = float(dataset["time_per_unit"][other])
            times.setdefault(str(one["group"].values), (time, str(one["unit"].values)))
    return times


def dearest(entries: list[Price]) -> list[Price]:
    """Return the entries that add something to the same motion, the dearest first."""
    dear = (p for p in entries if p.is_same_motion and not p.is_nothing and p.ratio > 1.0)
    return sorted(dear, key=lambda price: -price.ratio)


def side(datasets: Datasets) -> Side:
    """Return numbers and drawing of the motion that the others of the first scene are compared with."""
    first = {label: data.isel(motion=[0]) for label, data in list(datasets.items())[:1]}
    return side_of_first(first)


def methods(_datasets: Datasets) -> list[Line]:
    """Return the line on times and on what is left out."""
    timed = (
        "CPU time of one core without compilation and the checks and labels of a call, ratios round by round; kernels "
        "have the code of a scene's effects, restitution and rest, and closed forms are used where they exist"
    )
    return [Line("Time", timed)]


REPORT = ReportPart(
    "Effects",
    "What do I pay for an effect or an output that my scene calls for, and what if it does not?",
    of_each(answers),
    methods=methods,
    side=side,
)
