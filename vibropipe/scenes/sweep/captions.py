"""Captions of the pictures of a sweep, written from its data."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.figures.motion_words import PROGRESSION, aperiodic_text
from vibropipe.figures.regime_words import reasons_text
from vibropipe.figures.text import (
    NO_CURVES,
    digits,
    grid_with_units,
    parameters_text,
    plain_symbol_of,
    sentences,
    with_units,
)
from vibropipe.report.findings import largest
from vibropipe.scenes.sweep.laws import Region, regions_of
from vibropipe.scenes.sweep.layout import MAX_MULTIPLES, combinations_drawn, fitting_panels
from vibropipe.scenes.sweep.lines import has_arrows, lines_of
from vibropipe.scenes.sweep.map_layout import map_axes
from vibropipe.scenes.sweep.maps import (
    CONTOUR,
    LABELLED,
    MAX_MAPS,
    drawn_panels,
    has_negative,
    is_rounding,
    value_norm,
    without_orbit_texts,
)
from vibropipe.scenes.sweep.neighbours import LEFT_EARLY
from vibropipe.scenes.sweep.quantities import (
    COUNTED,
    DEFAULT_SHOW,
    Panel,
    Series,
    has_no_value,
    of_orbits,
    panels_of,
    series_words,
    without_rounding,
)
from vibropipe.scenes.sweep.sweep_rows import (
    axis_and_others,
    combinations,
    directions,
    is_from_rest,
    row_kinds,
    with_impacts_per_period,
)
from vibropipe.store.table import is_neutral
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import count, part_text, series


def describe_sweep(
    dataset: xr.Dataset, show: Collection[str] = (), backbone: xr.Dataset | None = None
) -> str:
    """Return the caption of the curves: parameters, colours, and rows drawn as marks."""
    along, others = axis_and_others(dataset)
    dataset = with_impacts_per_period(dataset)
    lines = series(
        f"{plain_symbol_of(dataset[name])} = {grid_with_units(dataset[name])}" for name in others
    )
    wanted = panels_of(dataset, show, joined=not others)
    panels = fitting_panels(dataset, others[1:], wanted)
    quantities = {each.name for panel in panels for each in panel.series}
    left_out = without_value_text(dataset, show, quantities)
    seen = f"Steady states against {plain_symbol_of(dataset[along])}"
    if lines:
        seen += f" for {lines}"
        if dataset.sizes[others[0]] > 1:
            seen += f"; blue, from light to dark, with {plain_symbol_of(dataset[others[0]])}"
    return sentences(
        seen,
        "Blue, from dark to light: first and further harmonics"
        if any(len(panel.series) > 1 and panel.series[0].dim == "harmonic" for panel in panels)
        else "",
        "Orange: support 1; blue, dashed: support 2"
        if any(len(panel.series) > 1 and panel.series[0].dim == "support" for panel in panels)
        else "",
        combinations_text(dataset, others[1:], MAX_MULTIPLES),
        left_out_text(dataset, others[1:], wanted),
        starts_text(dataset, arrows=_has_arrows(dataset, panels, along, others)),
        left_out,
        "" if quantities or left_out else NO_CURVES,
        "Energies are per forcing period"
        if any(name.startswith("energy") for name in quantities)
        else "",
        PROGRESSION if "housing_velocity_mean" in quantities else "",
        row_kinds_text(dataset, are_drawn=bool(quantities)),
        aperiodic_text(dataset),
        unresolved_text(dataset),
        "Wide grey line: free motion without losses" if backbone is not None else "",
        parameters_text(dataset),
    )


def _has_arrows(
    dataset: xr.Dataset, panels: Sequence[Panel], along: str, others: Sequence[str]
) -> bool:
    """Return whether arrows are drawn: of several lines in the first panel alone."""
    part = dataset.sortby(along).isel(combinations_drawn(dataset, others[1:])[0])
    lines = list(lines_of(part, others[0] if others else None))
    return any(
        has_arrows(line.row[along].values, each.of(line.row).values, line, each.name in COUNTED)
        for panel in panels[: 1 if others else None]
        for each in panel.series
        for line in lines
    )


def combinations_text(dataset: xr.Dataset, dims: list[str], most: int) -> str:
    """Write how many combinations of further parameters are drawn, if not all of them are."""
    found = len(combinations(dataset, dims))
    if found <= most:
        return ""
    names = series(plain_symbol_of(dataset[name]) for name in dims)
    return f"Of {found} combinations of {names}, {most} evenly spaced ones are drawn"


def left_out_text(dataset: xr.Dataset, dims: list[str], panels: Sequence[Panel]) -> str:
    """Write which panels are not drawn, since small multiples have no room for them; empty if all are."""
    drawn = fitting_panels(dataset, dims, panels)
    left_out = [panel for panel in panels if panel not in drawn]
    names = series(series_words(dataset, panel.series[0]) for panel in left_out)
    parameters = series(plain_symbol_of(dataset[name]) for name in dims)
    reason = f"since a page with a column for each {parameters} has no room"
    return f"Not drawn, {reason}: {names}" if left_out else ""


def without_value_text(dataset: xr.Dataset, show: Collection[str], drawn: Collection[str]) -> str:
    """Write which quantities have no value in any row and are left out, as that of a housing that slides away."""
    left_out = [
        name
        for name in show or DEFAULT_SHOW
        if name in dataset and name not in drawn and has_no_value(dataset, name)
    ]
    names = series(series_words(dataset, Series(name)) for name in left_out)
    return f"Not drawn, since no row has a value: {names}" if names else ""


def starts_text(dataset: xr.Dataset, arrows: bool = False) -> str:
    """Write where rows start: from neighbours that were followed, or at rest; empty for other starts.

    `arrows` tells whether arrows mark the directions.
    """
    ways, follow = directions(dataset), str(dataset.attrs.get("follow", ""))
    along = f" along {plain_symbol_of(dataset[follow.split()[0]])}" if follow else ""
    words = " and ".join(f"{way}wards" for way in ways)
    kept = "; arrows: jumps" if arrows else ""
    if not ways:
        rest = "Each row starts from the equilibrium without velocity"
        return rest if is_from_rest(dataset) else ""
    return f"Each row starts from its neighbour, followed {words}{along}{kept}. {LEFT_EARLY}"


def row_kinds_text(dataset: xr.Dataset, are_drawn: bool = True) -> str:
    """Write the numbers of rows that are drawn as marks, if any are, or not at all."""
    kinds = row_kinds(dataset)
    is_stable = "stable" in dataset and (dataset["stable"].values[kinds["multiple"]] == 1).all()
    orbit = "a stable orbit" if is_stable else "an orbit"  # neutral ones are drawn alike
    descriptions = [
        ("multiple", f"{orbit} of several forcing periods", " (circles)"),
        ("unstable", "an unstable orbit", " (crosses)"),
        ("no_orbit", "no periodic orbit that was found", " (dots: in a window)"),
        ("missing", "no result", ""),
    ]
    kinds["missing"] = kinds["no_orbit"] & ~has_averages(dataset)
    kinds["no_orbit"] = kinds["no_orbit"] & ~kinds["missing"]
    amounts = {kind: int(mask.sum()) for kind, mask in kinds.items()}
    texts = [
        f"{'all' if amounts[kind] == dataset['regime'].size > 1 else amounts[kind]} "
        f"{'has' if amounts[kind] == 1 else 'have'} {what}{mark if are_drawn else ''}"
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


def has_averages(dataset: xr.Dataset) -> NDArray[np.bool_]:
    """Return which rows have values that can be drawn, or are known: unresolved ones may have none."""
    known: NDArray[np.bool_] = dataset["regime"].values != Regime.UNRESOLVED
    for name in (name for name in DEFAULT_SHOW if name in dataset):
        values = dataset[name].transpose(*dataset["regime"].dims, ...).values
        known = known | np.isfinite(values.reshape(*known.shape, -1)).any(axis=-1)
    return known


def unresolved_text(dataset: xr.Dataset) -> str:
    """Write the number of unresolved rows by reason; empty if there are none."""
    unresolved = dataset["regime"].values == Regime.UNRESOLVED
    if not unresolved.any() or "status" not in dataset:
        return ""
    reasons = reasons_text(dataset["status"].values[unresolved])
    return f"Unresolved: {part_text(int(unresolved.sum()), unresolved.size, 'row')}, {reasons}"


def describe_map(dataset: xr.Dataset) -> str:
    """Return the caption of the map: where the rows start, the shares of what has no label, and what is not known."""
    _, regions = regions_of(dataset)
    _, _, further = map_axes(dataset)
    return sentences(
        points_text(dataset),
        starts_text(dataset),
        shares_text(dataset, regions),
        "Borders are drawn half-way between neighbouring points",
        combinations_text(dataset, further, MAX_MAPS),
        aperiodic_text(dataset),
        unresolved_text(dataset),
        parameters_text(dataset),
    )


def shares_text(dataset: xr.Dataset, regions: Sequence[Region]) -> str:
    """Write the shares of the regions of a map that have no label there; empty if all have one."""
    is_one = len(combinations(dataset, map_axes(dataset)[2])) == 1
    small = [r for r in regions if not is_one or r.amount < LABELLED * r.total]
    told = unresolved_text(dataset)  # which counts them
    small = [r for r in small if not (told and r.name == "unresolved")]
    shares = series(f"{region.words}, {region.share}" for region in small)
    where = "Not labelled" if is_one else "Of all points"
    return f"{where}: {shares}" if small else ""


def points_text(dataset: xr.Dataset) -> str:
    """Write at how many points the steady states are."""
    x, y, _ = map_axes(dataset)
    size = " × ".join(str(dataset.sizes[name]) for name in (x, y))
    points = f"{size} points of {plain_symbol_of(dataset[x])} and {plain_symbol_of(dataset[y])}"
    return f"Steady state at {points}"


def describe_quantities(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the caption of the maps of quantities: their largest values, signs, lines and what has no value."""
    found, most = drawn_panels(dataset, show)
    dataset = without_rounding(dataset, {each.name for each in found})
    _, _, further = map_axes(dataset)
    tops = [(largest(of_orbits(dataset, each)), each) for each in found]
    largest_values = [
        f"{with_units(top, '0' if is_rounding(dataset, each.name, float(top)) else digits(float(top)))} "
        f"({series_words(dataset, each).split(' of ')[0]})"
        for top, each in tops
        if top is not None
    ]
    is_cut = any(
        float(abs(each.of(dataset)).max()) > (value_norm(dataset, each.name).vmax or np.inf)
        for each in found
    )
    sides = ", towards support 1", ", towards support 2"
    among = "" if (dataset["regime"] < Regime.APERIODIC).all() else ", in orbits"
    in_size = " in size" if any(top is not None and float(top) < 0 for top, _ in tops) else ""
    signed = [each for each in found if has_negative(dataset, each.name)]
    has_side = any(each.name.startswith("displacement") for each in signed)
    return sentences(
        points_text(dataset),
        starts_text(dataset),
        PROGRESSION if any(each.name == "housing_velocity_mean" for each in found) else "",
        f"Largest{in_size} of each map{among}: {series(largest_values)}" if largest_values else "",
        "Colours end where at most 0.5\u00a0% of the values are larger (triangles)" if is_cut else "",
        f"White is 0, orange positive{sides[0] if has_side else ''}, blue negative"
        f"{sides[1] if has_side else ''} (dashed: from {100 * CONTOUR:.0f}\u00a0% of the scale on)"
        if signed
        else "",
        without_value_text(dataset, show, {each.name for each in found}),
        *without_orbit_texts(dataset, found),
        combinations_text(dataset, further, most),
    )  # fmt: skip
