"""Captions of the pictures of a sweep, written from its data."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
import xarray as xr

from vibropipe.figures.motion_words import aperiodic_text, number_word, way_of
from vibropipe.figures.text import (
    NO_CURVES,
    grid_with_units,
    parameters_text,
    plain_symbol_of,
    reasons_text,
    sentences,
)
from vibropipe.report.findings import largest, place_texts, value_text
from vibropipe.scenes.sweep.laws import Region, regions_of, share_text
from vibropipe.scenes.sweep.layout import MAX_MULTIPLES, fitting_panels
from vibropipe.scenes.sweep.map_layout import map_axes
from vibropipe.scenes.sweep.maps import (
    LABELLED,
    MAX_MAPS,
    drawn_panels,
    has_negative,
    value_norm,
    without_orbit_texts,
)
from vibropipe.scenes.sweep.neighbours import LEFT_EARLY, differing_rows
from vibropipe.scenes.sweep.quantities import (
    Panel,
    Series,
    axis_and_others,
    combinations,
    directions,
    is_from_rest,
    panels_of,
    row_kinds,
    series_words,
    strikes,
    with_impacts_per_period,
)
from vibropipe.solve.sweep.sweep_grid import DIRECTION
from vibropipe.store.table import is_neutral
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import capitalised, count, series

MAX_TITLE = 85  # letters
SAME_VALUE = 1e-9  # relative difference of values that are one


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
    seen = f"Steady states against {plain_symbol_of(dataset[along])}"
    if lines:
        seen += (
            f" for {lines}; blue, from light to dark, with {plain_symbol_of(dataset[others[0]])}"
        )
    return sentences(
        seen,
        "Blue, from dark to light: first and further harmonics"
        if any(len(panel.series) > 1 and panel.series[0].dim == "harmonic" for panel in panels)
        else "",
        combinations_text(dataset, others[1:], MAX_MULTIPLES),
        left_out_text(dataset, others[1:], wanted),
        starts_text(dataset, arrows=bool(quantities)),
        "" if quantities else NO_CURVES,
        "Energies are per forcing period"
        if any(name.startswith("energy") for name in quantities)
        else "",
        row_kinds_text(dataset, are_drawn=bool(quantities)),
        aperiodic_text(dataset),
        unresolved_text(dataset),
        "Wide grey line: free motion without losses" if backbone is not None else "",
        parameters_text(dataset),
    )


def sweep_title(
    dataset: xr.Dataset, show: Collection[str] = (), backbone: xr.Dataset | None = None
) -> str:
    """Return what is seen: that the direction of following matters, else where the first quantity is largest."""
    along, others = axis_and_others(dataset)
    if differing_rows(dataset, along):
        return f"Which motion settles depends on the direction in which {plain_symbol_of(dataset[along])} changes"
    panels = panels_of(with_impacts_per_period(dataset), show, joined=not others)
    return largest_title(dataset, panels[0].series[0]) if panels else ""


def largest_title(dataset: xr.Dataset, own: Series) -> str:
    """Return at which point an element of a quantity is largest among orbits; without one, or room, what it is."""
    values = of_orbits(dataset, own)
    top = largest(values)
    words = series_words(dataset, own)
    plain = capitalised(words)
    if top is None or not float(top) or dataset["regime"].size == 1:
        return plain
    if own.name == "lyapunov_exponent":
        exponent = own.of(dataset)
        return exponent_title(exponent.where(dataset["regime"] < Regime.UNBOUNDED))
    is_creep = own.name == "housing_velocity_mean"
    if is_creep and way_of(float(top), float(dataset["housing_velocity_max"].max())) is None:
        return "In no orbit does the housing creep"
    alike = abs(abs(values) - abs(float(top))) <= SAME_VALUE * abs(float(top))
    places = {*dataset["regime"].dims} - {DIRECTION}
    if int(alike.any(dim=[dim for dim in values.dims if dim not in places]).sum()) > 1:
        return plain  # many starts, one motion
    subject = plain.removeprefix("Largest ")
    if own.name == "displacement_amplitude":
        subject = f"The {subject.removesuffix(' amplitude of displacement').lower()}"
    size = "is largest in size" if has_negative(dataset, own.name) else "is largest"
    # what has no orbit may have larger values in its window
    all_repeat = bool((dataset["regime"] < Regime.APERIODIC).all())
    of, among = ("", "") if all_repeat else (" of orbits", "in orbits ")
    seen = f"{capitalised(subject)}{of} {size}"
    if own.name == "impact_velocity_max":
        on = "" if own.position is None else f" support {own.position + 1}"
        seen = f"Orbits strike{on} hardest"
    if own.name == "housing_velocity_mean":
        seen = f"{among}the housing creeps fastest"
    # between its points a quantity may be larger
    seen = f"On the grid, {seen[0].lower()}{seen[1:]}"
    texts = [f"{seen} at {where}" for where in place_texts(dataset, top)]
    return next((text for text in texts if len(text) <= MAX_TITLE), plain)


def of_orbits(dataset: xr.Dataset, own: Series) -> xr.DataArray:
    """Return an element of a quantity in the rows with an orbit: that of a window is no maximum."""
    return own.of(with_impacts_per_period(dataset)).where(dataset["regime"] < Regime.APERIODIC)


def exponent_title(exponent: xr.DataArray) -> str:
    """Return whether rows in which perturbations decay lie between rows in which they grow, along a line."""
    if exponent.ndim != 1:
        return ""
    signs = np.sign(exponent.sortby(str(exponent.dims[0])).values)
    growing = np.flatnonzero(signs > 0)
    if growing.size and (signs[growing[0] : growing[-1]] < 0).any():
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


def combinations_text(dataset: xr.Dataset, dims: list[str], most: int) -> str:
    """Write how many combinations of further parameters are drawn, if not all of them are."""
    found = len(combinations(dataset, dims))
    if found <= most:
        return ""
    names = series(plain_symbol_of(dataset[name]) for name in dims)
    return f"Of {found} combinations of {names}, {most} evenly spaced ones are drawn"


def left_out_text(dataset: xr.Dataset, dims: list[str], panels: Sequence[Panel]) -> str:
    """Write which panels are not drawn, since small multiples have no room for them; empty if all are."""
    left_out = panels[len(fitting_panels(dataset, dims, panels)) :]
    names = series(series_words(dataset, panel.series[0]) for panel in left_out)
    parameters = series(plain_symbol_of(dataset[name]) for name in dims)
    reason = f"since a page with a column for each {parameters} has no room"
    return f"Not drawn, {reason}: {names}" if left_out else ""


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
    descriptions = [
        ("multiple", "a stable orbit of m > 1 forcing periods", " (circles)"),
        ("unstable", "an unstable orbit", " (crosses)"),
        ("no_orbit", "no periodic orbit that was found", " (dots: averages)"),
    ]
    amounts = {kind: int(mask.sum()) for kind, mask in kinds.items()}
    texts = [
        f"{amounts[kind]} {'has' if amounts[kind] == 1 else 'have'} {what}{mark if are_drawn else ''}"
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


def unresolved_text(dataset: xr.Dataset) -> str:
    """Write the number of unresolved rows by reason; empty if there are none."""
    unresolved = dataset["regime"].values == Regime.UNRESOLVED
    if not unresolved.any() or "status" not in dataset:
        return ""
    reasons = reasons_text(dataset["status"].values[unresolved])
    total = count(dataset["regime"].size, "row")
    return f"Unresolved: {int(unresolved.sum()):,} of {total}, {reasons}"


def map_title(dataset: xr.Dataset) -> str:
    """Return what a map shows: on which side of one border the mass strikes, else only what it is over."""
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
    ways = len([each for each in regions_of(dataset)[1] if each.name != "unresolved"])
    over = f"{plain_symbol_of(dataset[x])} and {plain_symbol_of(dataset[y])}"
    if ways < 2:
        return f"How the mass moves over {over}"
    return f"{number_word(ways).capitalize()} kinds of motion share the plane of {over}"


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
    shares = series(f"{region.words} {region.share}" for region in small)
    where = "Of this map, without a label" if is_one else "Of all points"
    return f"{where}: {shares}" if small else ""


def points_text(dataset: xr.Dataset) -> str:
    """Write at how many points the steady states are."""
    x, y, _ = map_axes(dataset)
    size = " × ".join(str(dataset.sizes[name]) for name in (x, y))
    points = f"{size} points of {plain_symbol_of(dataset[x])} and {plain_symbol_of(dataset[y])}"
    return f"Steady state at {points}"


def quantities_title(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return at which point the first quantity of the maps is largest."""
    found, _ = drawn_panels(dataset, show)
    return largest_title(dataset, found[0]) if found else ""


def describe_quantities(dataset: xr.Dataset, show: Collection[str] = ()) -> str:
    """Return the caption of the maps of quantities: their largest values, signs, lines and what has no value."""
    found, most = drawn_panels(dataset, show)
    _, _, further = map_axes(dataset)
    tops = [(largest(of_orbits(dataset, each)), series_words(dataset, each)) for each in found]
    largest_values = [
        f"{value_text(top, top, 3)} ({words.split(' of ')[0]})"
        for top, words in tops
        if top is not None
    ]
    is_cut = any(
        float(abs(each.of(dataset)).max()) > (value_norm(dataset, each.name).vmax or np.inf)
        for each in found
    )
    sides = ", towards support 1", ", towards support 2"
    among = "" if (dataset["regime"] < Regime.APERIODIC).all() else " of orbits"
    signed = [each for each in found if has_negative(dataset, each.name)]
    has_side = any(each.name.startswith("displacement") for each in signed)
    return sentences(
        points_text(dataset),
        starts_text(dataset),
        f"Largest{' in size' if signed else ''}{among}: {series(largest_values)}" if largest_values else "",
        "Colours end at the value that 0.5 % of the points exceed (triangles)" if is_cut else "",
        f"White is 0, orange positive{sides[0] if has_side else ''}, blue and striped negative"
        f"{sides[1] if has_side else ''}"
        if signed
        else "",
        *without_orbit_texts(dataset, found),
        combinations_text(dataset, further, most),
    )  # fmt: skip
