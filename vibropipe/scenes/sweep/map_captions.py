"""Titles and captions of the maps of a sweep, written from its data."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import xarray as xr

from vibropipe.figures.text import parameters_text, plain_symbol_of, sentences
from vibropipe.report.exciter import WORDS
from vibropipe.report.findings import largest, value_text
from vibropipe.scenes.sweep.captions import (
    MAX_TITLE,
    aperiodic_text,
    combinations_text,
    follow_text,
    largest_title,
    unresolved_text,
)
from vibropipe.scenes.sweep.map_layout import map_axes
from vibropipe.scenes.sweep.quantities import SIGNED, combinations, directions, series_words
from vibropipe.scenes.sweep.quantity_maps import drawn_panels, value_norm
from vibropipe.scenes.sweep.regime_map import LABELLED, MAX_MAPS
from vibropipe.scenes.sweep.regions import regions_of
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import series


def map_title(dataset: xr.Dataset) -> str:
    """Return what a map shows: on which side of one border the mass strikes, else only what it is over."""
    x, y, _ = map_axes(dataset)
    regime = dataset["regime"]
    strikes = regime.where(regime < Regime.UNBOUNDED) != Regime.NO_IMPACT
    if 0 < int(strikes.sum()) < strikes.size and bool((regime < Regime.UNBOUNDED).all()):
        for axis in (y, x):
            steps = np.diff(strikes.sortby(axis).transpose(axis, ...).values.astype(int), axis=0)
            for sign, side in ((1, ("above", "below")), (-1, ("below", "above"))):
                if (sign * steps >= 0).all():
                    where = f"{side[0].capitalize()} one border in {plain_symbol_of(dataset[axis])}"
                    return f"{where} the mass strikes a support, {side[1]} it none"
    words = [WORDS.get(name, plain_symbol_of(dataset[name])) for name in (x, y)]
    text = f"How the mass moves over the {words[0]} and the {words[1]}"
    return (
        text
        if len(text) <= MAX_TITLE
        else f"How the mass moves over {plain_symbol_of(dataset[x])} and {plain_symbol_of(dataset[y])}"
    )


def describe_map(dataset: xr.Dataset) -> str:
    """Return the caption of the map: where the rows start, the shares of what has no label, and what is not known."""
    _, regions = regions_of(dataset)
    _, _, further = map_axes(dataset)
    is_one = len(combinations(dataset, further)) == 1
    small = [r for r in regions if not is_one or r.amount < LABELLED * r.total]
    shares = series(f"{region.words} {region.share}" for region in small)
    return sentences(
        points_text(dataset),
        follow_text(dataset),
        f"{'Of this map, without a label' if is_one else 'Of all points'}: {shares}"
        if small
        else "",
        "Borders are drawn half-way between neighbouring points",
        combinations_text(dataset, further, MAX_MAPS),
        aperiodic_text(dataset),
        unresolved_text(dataset),
        parameters_text(dataset),
    )


def points_text(dataset: xr.Dataset) -> str:
    """Write where rows start, and at how many points."""
    x, y, _ = map_axes(dataset)
    size = " × ".join(str(dataset.sizes[name]) for name in (x, y))
    start = str(dataset.attrs.get("start", ""))
    rest = (
        " from the equilibrium without velocity"
        if start == "x0 = 0, v0 = 0" and "load" not in dataset and not directions(dataset)
        else ""
    )
    return f"Steady state{rest} at {size} points of {plain_symbol_of(dataset[x])} and {plain_symbol_of(dataset[y])}"


def quantities_title(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return at which point the first quantity of the maps is largest."""
    found, _ = drawn_panels(dataset, show)
    return largest_title(dataset, found[0]) if found else ""


def describe_quantities(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the caption of the maps of quantities: their largest values, signs, lines and what has no value."""
    found, most = drawn_panels(dataset, show)
    _, _, further = map_axes(dataset)
    largest_values = []
    for each in found:
        top = largest(each.of(dataset))
        if top is not None:
            largest_values.append(
                f"{value_text(top, top, 3)} ({series_words(dataset, each).split(' of ')[0]})"
            )
    is_cut = any(
        float(abs(each.of(dataset)).max()) > (value_norm(dataset, each.name).vmax or np.inf)
        for each in found
    )
    sides = ", towards support 1", ", towards support 2"
    signed = [each for each in found if each.name in SIGNED]
    has_side = any(each.name.startswith("displacement") for each in signed)
    return sentences(
        f"Largest in size: {series(largest_values)}" if largest_values else "",
        "Colours end at the value that 0.5 % of the points exceed (triangles)" if is_cut else "",
        f"White is 0, orange positive{sides[0] if has_side else ''}, blue and striped negative"
        f"{sides[1] if has_side else ''}"
        if signed
        else "",
        "Lines: borders of aperiodic motion and of hatched rows without a value",
        "Aperiodic motion is shown by its largest impact and its average in a window"
        if bool((dataset["regime"] == Regime.APERIODIC).any())
        else "",
        combinations_text(dataset, further, most),
    )  # fmt: skip
