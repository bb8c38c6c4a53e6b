"""Attractors of a dataset of basins: their letters, words, colours and markers, and the knocks they survive."""

from __future__ import annotations

import math
import string
from collections import Counter
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from vibropipe.figures.canvas import open_mark
from vibropipe.figures.motion_words import words_of
from vibropipe.figures.palette import MIN_STEP, REGIME_STYLES, lightness, shaded
from vibropipe.figures.regime_words import regime_name
from vibropipe.figures.style import LINE_MARKERS

# Difference of what mirror images have alike, relative to their amplitude, and the quantities that tell them.
SAME_VALUES = 1e-6
OF_IMAGES = ("displacement_mean", "displacement_amplitude", "period_multiple", "impacts_per_orbit")
KNOCK = "knock_impulse"


def knocks_of(dataset: xr.Dataset) -> dict[int, float]:
    """Return for each attractor the least impulse that ends it, as the dataset has it, or else as the map shows.

    Of a map: the change of velocity within which starts lead back to it. All starts in the columns beside a state at
    the section, within this change of its velocity, settle on the attractor; of several states the least change, and of
    mirror images, which are each other half a period later. NaN without an orbit, which has more states than are
    stored, where a state lies beyond the map, and if the starts are at another phase.
    """
    return {index: knock for index, (knock, _at_end) in _knocks(dataset).items()}


def beyond_map(dataset: xr.Dataset) -> set[int]:
    """Return the attractors whose knock is that to the end of the map: no start there settles elsewhere."""
    return {index for index, (_knock, at_end) in _knocks(dataset).items() if at_end}


def _knocks(dataset: xr.Dataset) -> dict[int, tuple[float, bool]]:
    """Return the knock of each attractor, and whether it ends at the end of the map."""
    if KNOCK in dataset:
        values = zip(dataset["attractor_id"].values, dataset[KNOCK].values, strict=True)
        found = {int(index): (float(value), False) for index, value in values}
    else:
        found = _knocks_of_map(dataset)
    return {index: _least([found[each] for each in images_of(dataset, index)]) for index in found}


def _knocks_of_map(dataset: xr.Dataset) -> dict[int, tuple[float, bool]]:
    """Return the knock of each attractor by the starts of the map, of its own states alone."""
    found: dict[int, tuple[float, bool]] = {}
    ordered = dataset.sortby(["x0", "v0"])
    x0, v0 = ordered["x0"].values, ordered["v0"].values
    attractor = ordered["attractor"].transpose("x0", "v0").values
    at_section = float(dataset["start_phase"]) == 0.0
    for index in dataset["attractor_id"].values.tolist():
        states = states_of(dataset, index)
        knocks = [
            reach(v0, attractor[columns] == index, v)
            for x, v in states
            if (columns := beside(x0, x)).size
        ]
        is_orbit = int(dataset["period_multiple"].sel(attractor_id=index)) > 0
        known = at_section and is_orbit and len(knocks) == len(states) > 0
        found[int(index)] = _least(knocks) if known else (math.nan, False)
    return found


def _least(knocks: Sequence[tuple[float, bool]]) -> tuple[float, bool]:
    """Return the least of some knocks; NaN if one is."""
    return knocks[int(np.argmin([knock for knock, _at_end in knocks]))]


def images_of(dataset: xr.Dataset, index: int) -> list[int]:
    """Return an attractor and, if there is one, its mirror image."""
    ids = dataset["attractor_id"].values
    own = int(np.flatnonzero(ids == index)[0])
    mean, amplitude, m, impacts = (
        dataset[name].transpose("attractor_id", ...).values for name in OF_IMAGES
    )
    apart = np.maximum(abs(mean + mean[own]), abs(amplitude - amplitude[own]).max(axis=1))
    is_image = (m == m[own]) & (impacts == impacts[own, ::-1]).all(axis=1)
    is_image &= (apart <= SAME_VALUES * amplitude[own].max()) & (ids != index)
    return [index, *ids[is_image].tolist()]


def states_of(dataset: xr.Dataset, index: int) -> np.ndarray:
    """Return the states (n, 2) of an attractor at the section: of an orbit one a period, else all that are stored."""
    row = dataset.sel(attractor_id=index)
    n = int(row["period_multiple"]) or row.sizes["visit"]
    states = [row[f"poincare_{name}"].values[-n:] for name in ("displacement", "velocity")]
    found = np.stack(states, axis=1)
    return found[np.isfinite(found).all(axis=1)]


def beside(values: np.ndarray, value: float) -> np.ndarray:
    """Return the indices of the ascending values on either side of one, or of itself; none beyond them."""
    if not values[0] <= value <= values[-1]:
        return np.empty(0, int)
    after = int(np.searchsorted(values, value))
    return np.array([after] if values[after] == value else [after - 1, after])


def reach(v0: np.ndarray, own: np.ndarray, v: float) -> tuple[float, bool]:
    """Return the distance from a velocity within which all starts of some columns (columns, v0) are own ones.

    The second says whether it leads to the end of the map.

    It ends at the last own start before the first other one, and at the nearer end of the map; NaN beyond the map, and
    where that end is nearer than a step.
    """
    edge = min(v - v0[0], v0[-1] - v)
    if edge < 0.0:
        return math.nan, False
    distance, is_own = np.abs(v0 - v), own.all(axis=0)
    first = distance[~is_own].min(initial=np.inf)
    if first > edge:
        is_known = edge >= np.diff(v0).max(initial=0.0) > 0.0
        return (float(edge), True) if is_known else (math.nan, False)
    return float(distance[distance < first].max(initial=0.0)), False


def step_of(dataset: xr.Dataset) -> float:
    """Return to what knocks are known by the map, its largest step of velocities; 0 where the dataset has them."""
    if KNOCK in dataset:
        return 0.0
    return float(np.diff(np.sort(dataset["v0"].values)).max(initial=0.0))


def at_rest(dataset: xr.Dataset) -> tuple[int | None, bool]:
    """Return the attractor of the starts of the map at rest in the equilibrium, and whether rest itself is a start.

    The attractor is None if the starts beside rest have several, or none, or the map does not contain it, under a load,
    which moves the equilibrium, and of starts at another phase.
    """
    if float(dataset.get("load", 0.0)) != 0.0 or float(dataset["start_phase"]) != 0.0:
        return None, False
    columns, rows = (beside(np.sort(dataset[name].values), 0.0) for name in ("x0", "v0"))
    if not (columns.size and rows.size):
        return None, False
    attractor = dataset.sortby(["x0", "v0"])["attractor"].transpose("x0", "v0").values
    around = np.unique(attractor[np.ix_(columns, rows)])
    is_start = columns.size == rows.size == 1
    return (int(around[0]) if around.size == 1 and around[0] >= 0 else None), is_start


# Motions that a text lists; a cascade has more.
MAX_LAWS = 2
# Of a basin that shares its regime with others, in turn.
SHADES = (0.45, -0.4, 0.7, -0.65, 0.2, 0.85)


class Change(NamedTuple):
    """An attractor that appears or vanishes at a value of the swept parameter; other: -1 if there is none."""

    appears: bool
    value: float
    attractor: int
    other: int


def swept_name(dataset: xr.Dataset) -> str | None:
    """Return the swept parameter of basins, or None."""
    return next((str(dim) for dim in dataset["basin_share"].dims if dim != "attractor_id"), None)


def changes_of(dataset: xr.Dataset) -> list[Change]:
    """Return where attractors appear and vanish, in the order of the values."""
    name = swept_name(dataset)
    columns = (f"bifurcation_{name}", "changed_attractor", "other_attractor")
    values, own, other = (dataset[column].values.tolist() for column in columns)
    appears = dataset["attractor_change"].values == 1
    changes = map(Change, appears.tolist(), values, own, other)
    return sorted(changes, key=lambda change: change.value)


def presence(dataset: xr.Dataset, index: int) -> np.ndarray:
    """Return at which values of the swept parameter an attractor is."""
    return np.isfinite(dataset["basin_share"].sel(attractor_id=index).values)


def ordered(dataset: xr.Dataset) -> list[int]:
    """Return the attractors, that of the most starts first, or with a swept parameter in the order of its values."""
    name, share = swept_name(dataset), dataset["basin_share"]
    if name is None:
        keys = -share.values
    else:
        present = share.transpose("attractor_id", name).notnull().values
        keys = np.where(present.any(axis=1), present.argmax(axis=1), present.shape[1])
    return [int(index) for index in np.argsort(keys, kind="stable")]


def letters_of(dataset: xr.Dataset) -> dict[int, str]:
    """Return the letter of each attractor, A for the first of `ordered`."""
    return {index: _letters(rank) for rank, index in enumerate(ordered(dataset))}


def _letters(rank: int) -> str:
    """Return A to Z, then AA, AB and so on."""
    before, last = divmod(rank, len(string.ascii_uppercase))
    return (_letters(before - 1) if before else "") + string.ascii_uppercase[last]


def rows_of(dataset: xr.Dataset, index: int) -> list[xr.Dataset]:
    """Return the steady states of an attractor, one for each value of the swept parameter at which it is."""
    row, name = dataset.sel(attractor_id=index), swept_name(dataset)
    if name is None:
        return [row]
    return [row.isel({name: int(n)}) for n in np.flatnonzero(presence(dataset, index))]


def attractor_words(dataset: xr.Dataset, index: int) -> str:
    """Write the motions of an attractor in words, with increasing parameter."""
    texts = list(dict.fromkeys(words_of(row) for row in rows_of(dataset, index)))
    return "; ".join(texts[:MAX_LAWS]) + ("; …" if len(texts) > MAX_LAWS else "")


def named(dataset: xr.Dataset, index: int) -> str:
    """Write letter and words of an attractor: A (no impact)."""
    return f"{letters_of(dataset)[index]} ({attractor_words(dataset, index)})"


def style_name(row: xr.Dataset) -> str:
    """Return the look of a steady state, as on maps of regimes."""
    name = regime_name(int(row["regime"]))
    once = int(row["period_multiple"]) == 1 and (row["impacts_per_orbit"].values == 1).all()
    return "two_sided_more" if name == "two_sided" and not once else name


def colours_of(dataset: xr.Dataset) -> dict[int, str]:
    """Return the colour of each attractor: that of its regime, lighter or darker where several share it."""
    indices, names = ordered(dataset), []
    for index in indices:
        found = Counter(style_name(row) for row in rows_of(dataset, index))
        names.append(found.most_common(1)[0][0] if found else "unresolved")
    return dict(zip(indices, distinct_colours(names), strict=True))


def distinct_colours(names: Sequence[str]) -> list[str]:
    """Return a colour for each name of a regime: its own for the first of a regime, then shades of it.

    A shade is MIN_STEP of lightness from all others, where there is one.
    """
    found = {names.index(name): REGIME_STYLES[name].colour for name in names}
    for n, name in enumerate(names):
        if n in found:
            continue
        base, others = REGIME_STYLES[name].colour, [lightness(each) for each in found.values()]
        shades = [shaded(base, s) for s in SHADES]
        gaps = [min(abs(lightness(shade) - other) for other in others) for shade in shades]
        free = [k for k, gap in enumerate(gaps) if gap >= MIN_STEP]
        found[n] = shades[free[0] if free else int(np.argmax(gaps))]
    return [found[n] for n in range(len(names))]


def marker_of(dataset: xr.Dataset, index: int) -> dict[str, Any]:
    """Return the marker of the states of an attractor at the section: dots for one without an orbit."""
    if np.all(dataset["period_multiple"].sel(attractor_id=index) == 0):
        return open_mark(".", 2.6, 0.2)
    rank = ordered(dataset).index(index)
    return open_mark(LINE_MARKERS[rank % len(LINE_MARKERS)], 5.0, 0.9)
