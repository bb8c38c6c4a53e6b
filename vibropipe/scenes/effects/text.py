"""Answers of an effects scene: what costs most, what costs nothing, group by group."""

from __future__ import annotations

import xarray as xr

from vibropipe.report.parts import Answer
from vibropipe.scenes.effects.prices import Price, dearest, groups, prices, ratio_text
from vibropipe.words.wording import series

# Groups that are answered, the dearest first, and dear entries that are named in each.
MAX_ANSWERS, MAX_NAMED = 3, 2


def answers(dataset: xr.Dataset) -> list[Answer]:
    """Return what costs most in the groups that cost most, and what costs nothing there."""
    by_group = groups(prices(dataset))
    top = {
        group: max((p.ratio for p in dearest(each)), default=1.0)
        for group, each in by_group.items()
    }
    chosen = sorted(by_group, key=lambda group: -top[group])[:MAX_ANSWERS]
    return [group_answer(group, by_group[group]) for group in by_group if group in chosen]


def group_answer(group: str, entries: list[Price]) -> Answer:
    """Return the answer of one group: what costs most, or least, and what costs nothing."""
    dear = dearest(entries)[:MAX_NAMED]
    free = [name(price) for price in entries if price.is_nothing]
    title = f"{group}: " if group else ""
    if dear:
        lead = f"{title}{series(f'{name(p)} {ratio_text(p.ratio)} times' for p in dear)}."
    else:
        lead = f"{title}{'nothing costs anything' if len(free) == len(entries) else 'nothing costs more'}."
    cheap = series(free)
    verb = "costs" if len(free) == 1 else "cost"
    rest = f"{cheap[:1].upper()}{cheap[1:]} {verb} nothing." if free and dear else ""
    return Answer(lead[:1].upper() + lead[1:], rest)


def name(price: Price) -> str:
    """Return what an entry is called in a sentence: its title up to a comma or colon."""
    return price.label.split(",")[0].split(":")[0]


def title_of(dataset: xr.Dataset) -> str:
    """Return what the picture shows, as a sentence: the two dearest entries."""
    dear = dearest(prices(dataset))[:MAX_NAMED]
    if not dear:
        return "Price list: nothing costs more than what it is compared with"
    return f"Price list: {series(name(price) for price in dear)} cost{'s' * (len(dear) == 1)} most"
