"""Titles of the pictures of a sweep: what is seen, written from its data."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np
import xarray as xr

from vibropipe.figures.claims import only_between_text
from vibropipe.figures.motion_words import number_word, way_of
from vibropipe.figures.text import plain_symbol_of
from vibropipe.figures.units import LOWERED
from vibropipe.report.findings import largest, place_texts
from vibropipe.scenes.kind import MAX_TITLE
from vibropipe.scenes.sweep.laws import regions_of, share_text
from vibropipe.scenes.sweep.map_layout import map_axes
from vibropipe.scenes.sweep.maps import drawn_panels, has_negative, is_rounding
from vibropipe.scenes.sweep.neighbours import differing_rows
from vibropipe.scenes.sweep.quantities import (
    Series,
    exponent_ends,
    of_orbits,
    panels_of,
    series_words,
    without_rounding,
)
from vibropipe.scenes.sweep.sweep_rows import (
    axis_and_others,
    is_map,
    strikes,
    with_impacts_per_period,
)
from vibropipe.solve.sweep.sweep_grid import DIRECTION
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import capitalised

SAME_VALUE = 1e-9  # relative difference of values that are one
MANY = 0.05  # share of the points from which the place of aperiodic motion is told


def sweep_title(
    dataset: xr.Dataset, show: Collection[str] = (), backbone: xr.Dataset | None = None
) -> str:
    """Return the way of a housing, that the direction of following matters, or where a quantity is largest."""
    along, others = axis_and_others(dataset)
    panels = panels_of(with_impacts_per_period(dataset), show, joined=not others)
    if panels and (way := progression_title(dataset, panels[0].series[0], [along])):
        return way
    if differing_rows(dataset, along):
        return f"Which motion settles depends on the direction in which {plain_symbol_of(dataset[along])} changes"
    return largest_title(dataset, panels[0].series[0]) if panels else ""


def largest_title(dataset: xr.Dataset, own: Series) -> str:
    """Return at which point an element of a quantity is largest among orbits; without one, or room, what it is."""
    values = of_orbits(dataset, own)
    top = largest(values)
    words = series_words(dataset, own)
    plain = capitalised(words)
    if top is None or dataset["regime"].size == 1 or is_rounding(dataset, own.name, float(top)):
        return plain
    if own.name == "lyapunov_exponent":
        return exponent_title(*exponent_ends(dataset))
    is_progression = own.name == "housing_velocity_mean"
    if is_progression and way_of(float(top), float(dataset["housing_velocity_max"].max())) is None:
        return "In no orbit does the housing progress"
    alike = abs(abs(values) - abs(float(top))) <= SAME_VALUE * abs(float(top))
    places = {*dataset["regime"].dims} - {DIRECTION}
    alike = alike.any(dim=[dim for dim in values.dims if dim not in places])
    if bool(alike.all()) and own.dim != "support":
        return f"{subjects_of(own, plain)[0]} is the same {'at all points' if is_map(dataset) else 'in all rows'}"
    if (fixed := fixed_dims(alike)) is None:
        return plain  # many starts, one motion
    size = "is longest" if plain.startswith("Longest ") else "is largest"
    size = "is largest in size" if has_negative(dataset, own.name) else size
    # what has no orbit may have larger values in its window
    all_repeat = bool((dataset["regime"] < Regime.APERIODIC).all())
    of, among = ("", "") if all_repeat else (" of orbits", "in orbits ")
    found = [f"{subject} {size}" for subject in subjects_of(own, plain, of)]
    if own.name == "impact_velocity_max":
        on = "" if own.position is None else f" support {own.position + 1}"
        found = [f"orbits strike{on} hardest"]
    if own.name == "housing_velocity_mean":
        found = [f"{among}the housing progresses fastest"]
    # between its points a quantity may be larger
    texts = [
        f"On the grid, {seen.replace('The ', 'the ', 1)} at {where}"
        for seen in found
        for where in place_texts(dataset, top, fixed)
    ]
    return next((text for text in texts if len(text) <= MAX_TITLE), plain)


def subjects_of(own: Series, plain: str, of: str = "") -> list[str]:
    """Return what a sentence is about: a quantity in words `of` some motions, and in fewer letters."""
    words, _, place = plain.removeprefix("Largest ").removeprefix("Longest ").partition(", ")
    if own.name == "displacement_amplitude":
        words = words.removesuffix(" amplitude of displacement").lower()
        return [f"The {words}{of}", f"A{(own.position or 0) + 1}{of}".translate(LOWERED)]
    at = f" at {place}" if place else ""
    words = words.removesuffix(" of the support") if place else words
    subject = f"{words[0].lower()}{words[1:]}{of}{at}"
    return [f"The {subject}", subject]


def fixed_dims(alike: xr.DataArray) -> list[str] | None:
    """Return the dimensions of which some rows have one value, if they are all rows of these; else None."""
    fixed = [
        str(dim)
        for dim in alike.dims
        if int(alike.any([other for other in alike.dims if other != dim]).sum()) == 1
    ]
    others = math.prod(alike.sizes[dim] for dim in alike.dims if dim not in fixed)
    return fixed if fixed and int(alike.sum()) == others else None


def exponent_title(low: xr.DataArray, high: xr.DataArray) -> str:
    """Return whether rows in which perturbations decay lie between rows in which they grow, along a line.

    low, high : `exponent_ends`
    """
    if low.ndim != 1:
        return ""
    low, high = (each.sortby(str(low.dims[0])) for each in (low, high))
    growing = np.flatnonzero(low.values > 0)
    if growing.size and (high.values[growing[0] : growing[-1]] < 0).any():
        return "Between rows in which perturbations grow lie some in which they decay"
    return ""


def energy_title(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return in how many orbits with impacts these take most of the work of the force; empty without impacts."""
    lost = dataset["energy_impact"].sum("support")
    struck = strikes(dataset) & (dataset["regime"] < Regime.APERIODIC)
    most = struck & (lost > 0.5 * dataset["energy_input"])
    total, amount = int(struck.sum()), int(most.sum())
    if not total:
        return ""
    share = share_text(amount, total)
    some = f"{share} orbits" if " of " in share else f"{share} of the orbits"
    orbits = {total: "all orbits", 0: "no orbit"}.get(amount, some)
    return f"Impacts take most of the work of the force in {orbits} with impacts"


def map_title(dataset: xr.Dataset) -> str:
    """Return on which side of one border the mass strikes, where motion is aperiodic, or what a map is over."""
    x, y, _ = map_axes(dataset)
    regime = dataset["regime"]
    struck = strikes(dataset)
    if 0 < int(struck.sum()) < struck.size and bool((regime < Regime.UNBOUNDED).all()):
        for axis in (y, x):
            steps = np.diff(struck.sortby(axis).transpose(axis, ...).values.astype(int), axis=0)
            for sign, side in ((1, ("above", "below")), (-1, ("below", "above"))):
                if steps.any(axis=0).mean() >= 0.5 and (sign * steps >= 0).all():
                    where = f"{side[0].capitalize()} one border in {plain_symbol_of(dataset[axis])}"
                    return f"{where} the mass strikes a support, {side[1]} it none"
    if where := tongue_title(dataset):
        return where
    ways = len([each for each in regions_of(dataset)[1] if each.name != "unresolved"])
    over = f"{plain_symbol_of(dataset[x])} and {plain_symbol_of(dataset[y])}"
    if ways < 2:
        return f"How the mass moves over {over}"
    return f"{number_word(ways).capitalize()} kinds of motion share the plane of {over}"


def tongue_title(dataset: xr.Dataset) -> str:
    """Return between which points the largest aperiodic region of one map lies; empty where little is aperiodic."""
    from scipy.ndimage import label  # slow to import

    x, y, further = map_axes(dataset)
    chaos = (dataset["regime"] == Regime.APERIODIC).sortby([x, y]).transpose(y, x, ...).values
    if further or chaos.mean() < MANY:
        return ""
    labels, _ = label(chaos)
    sizes = np.bincount(labels[chaos])
    own = labels == sizes.argmax()
    is_one = int((sizes == sizes.max()).sum()) == 1  # mirror images are equally large
    ends = [
        only_between_text(dataset[name].sortby(name), own.any(axis=n))
        for n, name in enumerate((x, y))
    ]
    where = " and ".join(each.removeprefix("only ") for each in ends if each)
    region = "The largest aperiodic region" if is_one else "An aperiodic region"
    title = f"{region} lies {where}"
    return title if where and len(title) <= MAX_TITLE else ""


def quantities_title(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the way of a housing, that values beside aperiodic motion are largest, or where the first one is."""
    found, _ = drawn_panels(dataset, show)
    if not found:
        return ""
    dataset = without_rounding(dataset, {each.name for each in found})
    axes = [name for name in map_axes(dataset)[:2] if dataset[name].dtype.kind == "f"]
    return (
        progression_title(dataset, found[0], axes)
        or beside_title(dataset, found)
        or largest_title(dataset, found[0])
    )


def progression_title(dataset: xr.Dataset, own: Series, axes: Sequence[str]) -> str:
    """Return between which rows alone a housing progresses one way; empty where this is everywhere or not known."""
    if own.name != "housing_velocity_mean":
        return ""
    speed, fastest = dataset[own.name], float(dataset["housing_velocity_max"].max())
    if not bool(speed.notnull().all()):
        return ""
    ways = [way_of(each, fastest) for each in speed.values.ravel().tolist()]
    for way in ("against x", "along x"):
        goes = speed.copy(data=np.reshape([each == way for each in ways], speed.shape))
        for axis in axes:
            others = [dim for dim in goes.dims if dim != axis]
            line = goes.any(others).sortby(axis)
            where = only_between_text(line[axis], line.values)
            title = f"On the grid, the housing progresses {way} {where}"
            if where and len(title) <= MAX_TITLE:
                return title
    return ""


def beside_title(dataset: xr.Dataset, found: Sequence[Series]) -> str:
    """Return that orbits strike hardest, or have the largest mean displacement, in a point beside aperiodic motion."""
    words = {
        "impact_velocity_max": "strike hardest",
        "displacement_mean": "have the largest mean displacement",
    }
    # of one element of several, its own largest value is no largest of all
    whole = [each for each in found if each.name in words and each.position is None]
    told = [words[own.name] for own in whole if is_beside(dataset, own)]
    title = f"On the grid, orbits {' and '.join(told)} beside aperiodic motion" if told else ""
    return title if len(title) <= MAX_TITLE else title.replace(" mean displacement", " mean")


def is_beside(dataset: xr.Dataset, own: Series) -> bool:
    """Return whether the one orbit with the largest value of a quantity has an aperiodic neighbour on a map."""
    from scipy.ndimage import binary_dilation  # slow to import

    x, y, further = map_axes(dataset)
    if further:
        return False
    ordered = dataset.sortby([x, y])
    values = abs(of_orbits(ordered, own).transpose(y, x).values)
    chaos = (ordered["regime"] == Regime.APERIODIC).transpose(y, x).values
    if not np.nan_to_num(values).any():
        return False
    top = values >= np.nanmax(values) * (1.0 - SAME_VALUE)
    return int(top.sum()) == 1 and bool(binary_dilation(chaos, np.ones((3, 3)))[top].all())
