"""Which measured quantity of a finished part foretells that it is good, in words."""

from __future__ import annotations

from typing import NamedTuple

import xarray as xr

from vibropipe.figures.claims import percent
from vibropipe.figures.text import format_number, with_units
from vibropipe.scenes.design.data import part_of
from vibropipe.solve.design.sorting import NO_RULE

DIGITS = 5  # of a threshold


def sorting_text(dataset: xr.Dataset) -> str:
    """Write which quantity of a finished part of the first design foretells that it is good; empty without a rule."""
    rule = sorting_of(dataset)
    if rule is None:
        return ""
    whose = " of design 1" if dataset.sizes.get("design", 1) > 1 else ""
    if not rule.words:
        return f"No single measured quantity foretells which exciters{whose} do."
    return (
        f"Of finished exciters{whose}, those whose {rule.words} is {rule.limit} count as good; {rule.wrong} of all "
        "are then sorted wrongly."
    )


class Sorting(NamedTuple):
    """A sorting rule in words: the quantity, the side of its threshold where parts are good, the share sorted wrongly.

    All are empty where no single quantity foretells.
    """

    words: str = ""
    limit: str = ""
    wrong: str = ""


def sorting_of(dataset: xr.Dataset, row: int = 0) -> Sorting | None:
    """Return the rule of the quantity that foretells best which parts of a design, or point, are good; None without."""
    best = foretold_by(dataset)[row]
    if best == NO_RULE or not best:
        return None
    part = part_of(dataset, best)
    if part is None:
        return Sorting()
    threshold, area, low, high = (
        part.of(dataset, f"_{name}")[row]
        for name in ("sort_threshold", "sort_area", "sort_wrong_low", "sort_wrong_high")
    )
    side = "above" if float(area) >= 0.5 else "below"
    value = with_units(threshold, format_number(float(threshold), DIGITS))
    wrong = f"{percent(float(low)).removesuffix(' %')} to {percent(float(high), up=True)}"
    return Sorting(part.words(dataset), f"{side} {value}", wrong)


def foretold_by(dataset: xr.Dataset) -> list[str]:
    """Return what foretells best, of each design or point; an attribute in files of earlier versions."""
    if "foretold_by" in dataset:
        return [str(name) for name in dataset["foretold_by"].values]
    rows = dataset["yield"].size if "yield" in dataset else 1
    return (str(dataset.attrs.get("foretold_by", NO_RULE)).split("; ") + [NO_RULE] * rows)[:rows]
