"""Captions of the pictures of a sweep, written from its data."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import xarray as xr

from vibropipe.figures.text import (
    NO_CURVES,
    grid_with_units,
    plain_symbol,
    plain_symbol_of,
    reasons_text,
    sentences,
)
from vibropipe.scenes.sweep.followed import LEFT_EARLY
from vibropipe.scenes.sweep.layout import MAX_MULTIPLES, fitting_panels
from vibropipe.scenes.sweep.quantities import (
    Panel,
    axis_and_others,
    combinations,
    directions,
    panels_of,
    row_kinds,
    with_impacts_per_period,
)
from vibropipe.store.stability import is_neutral
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import count, series

MANY_ORBITS = 4  # orbits that a caption names


def describe_sweep(
    dataset: xr.Dataset, show: Collection[str] = (), backbone: xr.Dataset | None = None
) -> str:
    """Return the caption of the curves: parameters, largest first harmonic, and rows drawn as marks."""
    along, others = axis_and_others(dataset)
    dataset = with_impacts_per_period(dataset)
    lines = series(
        f"{plain_symbol_of(dataset[name])} = {grid_with_units(dataset[name])}" for name in others
    )
    backbone_text = "Wide grey line: conservative exciter" if backbone is not None else ""
    wanted = panels_of(dataset, show)
    panels = fitting_panels(dataset, others[1:], wanted)
    quantities = {each.name for panel in panels for each in panel.series}
    return sentences(
        f"Steady states against {plain_symbol(along)}" + (f" for {lines}" if lines else ""),
        combinations_text(dataset, others[1:], MAX_MULTIPLES),
        left_out_text(dataset, others[1:], wanted),
        follow_text(dataset, arrows=True),
        "" if quantities else NO_CURVES,
        "Energies are per forcing period"
        if any(name.startswith("energy") for name in quantities)
        else "",
        row_kinds_text(dataset, show),
        aperiodic_text(dataset),
        unresolved_text(dataset),
        backbone_text,
    )


def combinations_text(dataset: xr.Dataset, dims: list[str], most: int) -> str:
    """Write how many combinations of further parameters are drawn, if not all of them are."""
    found = len(combinations(dataset, dims))
    if found <= most:
        return ""
    names = series(plain_symbol(name) for name in dims)
    return f"Of {found} combinations of {names}, {most} evenly spaced ones are drawn"


def left_out_text(dataset: xr.Dataset, dims: list[str], panels: Sequence[Panel]) -> str:
    """Write which panels are not drawn, since small multiples have no room for them; empty if all are."""
    left_out = panels[len(fitting_panels(dataset, dims, panels)) :]
    names = series(panel_text(dataset, panel) for panel in left_out)
    parameters = series(plain_symbol(name) for name in dims)
    return (
        f"Not drawn, since a page with a column for each {parameters} has no room: {names} (figure.show chooses others)"
        if left_out
        else ""
    )


def panel_text(dataset: xr.Dataset, panel: Panel) -> str:
    """Write what a panel shows in words, with the number of the support, harmonic or the like."""
    own = panel.series[0]
    words = str(dataset[own.name].attrs.get("long_name", own.name.replace("_", " ")))
    if own.dim is None or own.position is None:
        return words
    numbers = dataset[own.dim].values if own.dim in dataset.coords else None
    number = own.position + 1 if numbers is None else int(numbers[own.position])
    return f"{words} ({own.dim} {number})"


def follow_text(dataset: xr.Dataset, arrows: bool = False) -> str:
    """Write along which parameter and in which directions rows were followed; empty if they were not.

    `arrows` tells whether arrows mark the directions.
    """
    ways, follow = directions(dataset), str(dataset.attrs.get("follow", ""))
    along = f" along {plain_symbol(follow.split()[0])}" if follow else ""
    words = " and ".join(f"{way}wards" for way in ways)
    kept = "; arrows mark where the two differ" if arrows and len(ways) > 1 else ""
    if not ways:
        return ""
    return f"Each row starts from its neighbour, followed {words}{along}{kept}. {LEFT_EARLY}"


def row_kinds_text(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Write the numbers of rows that are drawn as marks or not at all."""
    kinds = row_kinds(dataset)
    drawn = bool(panels_of(dataset, show))
    descriptions = [
        ("multiple", "an orbit of m > 1 forcing periods", " (circles)"),
        ("unstable", "an unstable orbit", " (crosses)"),
        ("no_orbit", "no periodic orbit", " (dots: averages)"),
    ]
    amounts = {kind: int(mask.sum()) for kind, mask in kinds.items()}
    texts = [
        f"{amounts[kind]} {'has' if amounts[kind] == 1 else 'have'} {what}{mark if drawn else ''}"
        for kind, what, mark in descriptions
        if amounts[kind]
    ]
    orbits = dataset["regime"].values < Regime.APERIODIC
    neutral = int((orbits & is_neutral(dataset)).sum()) if "stable" in dataset else 0
    if neutral:
        verb = "is" if neutral == 1 else "are"
        texts.append(f"{neutral} {verb} neutral, so that perturbations neither grow nor decay")
    text = series(texts)
    total = dataset["regime"].size
    return f"Of {count(total, 'row')}, {text}; bars: regime of each row" if text else ""


def aperiodic_text(dataset: xr.Dataset) -> str:
    """Write in how long a window motions are aperiodic; empty if none is."""
    aperiodic = dataset["regime"].values == Regime.APERIODIC
    if not aperiodic.any() or "window_periods" not in dataset:
        return ""
    periods = int(
        dataset["window_periods"].transpose(*dataset["regime"].dims).values[aperiodic].min()
    )
    return (
        f"Aperiodic motions are so in a window of at least {count(periods, 'forcing period')}: "
        "whether one settles later is not known"
    )


def unresolved_text(dataset: xr.Dataset) -> str:
    """Write the number of unresolved rows by reason; empty if there are none."""
    unresolved = dataset["regime"].values == Regime.UNRESOLVED
    if not unresolved.any() or "status" not in dataset:
        return ""
    reasons = reasons_text(dataset["status"].values[unresolved])
    total = count(dataset["regime"].size, "row")
    return f"Unresolved: {int(unresolved.sum())} of {total}: {reasons}"
