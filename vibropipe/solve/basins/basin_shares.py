"""Basins at each value of a parameter, with the attractors carried along, as a labelled dataset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibropipe.orbits.results import RowResults
from vibropipe.physics.effects import all_effect_names, all_effects, has_soft_support
from vibropipe.physics.start import within_room
from vibropipe.solve.basins.attractor_families import Families
from vibropipe.solve.basins.attractor_set import AttractorSet
from vibropipe.solve.basins.attractors import reachable_velocity, shares, states_at_section
from vibropipe.solve.basins.knocks import knocks_of
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.solve.rows.label import Variables, coordinates, label_rows
from vibropipe.solve.rows.many import RowLimits, Rows, solve_rows
from vibropipe.solve.rows.row_results import columns_of
from vibropipe.solve.sweep.blocks import MAX_PERIODS
from vibropipe.solve.threads import row_blocks
from vibropipe.words.outputs import OF_STEADY_STATE
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

# States at the section stored for each attractor at each value.
VISITS = 128


class _Member(NamedTuple):
    """An attractor at a value: index of the value, number of the attractor, and its place in the set there."""

    value: int
    number: int
    place: int


def shares_dataset(
    sets: Sequence[AttractorSet],
    families: Families,
    owners: Sequence[np.ndarray],
    name: str,
    harmonics: int,
    start: str,
) -> tuple[xr.Dataset, np.ndarray]:
    """Return the attractors over a parameter, and the number of the attractor of each start.

    sets : at each value
    families : their numbers
    owners : of each value, the index (n,) of the attractor of each start in its set, or negative
    start : the starts, for the attributes
    Returns a dataset over `name` and `attractor_id`, whose numbers are NaN where an attractor is not, and the
    `attractor_id` (values, n) of each start; -1 for none.
    """
    import xarray as xr

    n_families = 1 + max((int(each.max(initial=-1)) for each in families.numbers), default=-1)
    members = sorted(
        _Member(k, int(number), index)
        for k, own in enumerate(families.numbers)
        for index, number in enumerate(own)
    )
    shape = len(sets), n_families
    numbers = np.array(
        [np.append(own, -1)[np.maximum(owner, -1)] for own, owner in zip(families.numbers, owners, strict=True)],
        np.int32,
    )  # fmt: skip
    at = (
        np.array([each.value for each in members], int),
        np.array([each.number for each in members], int),
    )
    variables = _shares(numbers, at, shape)
    variables |= _steady_states(sets, members, at, shape, harmonics)
    variables |= _visits(sets, members, at, shape)
    variables |= _knocks(sets, members, at, shape)
    variables |= _changes(families, name)
    values = np.array([getattr(each.section.exciter, name) for each in sets])
    first = sets[0].section.exciter.stated()
    coords: dict[str, Any] = {key: ((), value) for key, value in first.items() if key != name}
    coords |= {name: values, "attractor_id": np.arange(n_families, dtype=np.int32)}
    labelled = {
        key: ((name, "attractor_id", *dims[1:]) if dims[0] == "row" else dims, array)
        for key, (dims, array) in variables.items()
    }
    attrs = origin_attrs(all_effect_names({**first, name: values}, pieces=True), start)
    plain = {key: entry for key, entry in labelled.items() if "visit" not in entry[0]}
    dataset = xr.Dataset(labelled | coords, coordinates(plain, harmonics), attrs)
    return describe(dataset.set_coords([*coords, f"bifurcation_{name}"])), numbers


def _shares(
    numbers: np.ndarray, at: tuple[np.ndarray, np.ndarray], shape: tuple[int, int]
) -> Variables:
    """Return the shares of the starts, NaN where there is no attractor."""
    counts = np.array([np.bincount(own[own >= 0], minlength=shape[1]) for own in numbers])
    each = shares(counts, numbers.shape[1])
    names = "basin_share", "basin_share_low", "basin_share_high"
    return {
        name: (("row",), _spread(array[at], at, shape))
        for name, array in zip(names, each, strict=True)
    }


def _steady_states(
    sets: Sequence[AttractorSet],
    members: Sequence[_Member],
    at: tuple[np.ndarray, np.ndarray],
    shape: tuple[int, int],
    harmonics: int,
) -> Variables:
    """Return the steady states of attractors as variables over `row`, each spread over value and number."""
    exciters = [sets[each.value].section.exciter for each in members]
    if not members:
        # The variables are those of one motion, without entries.
        exciter = sets[0].section.exciter
        parameters = np.array([exciter.parameters()])
        rows = _solve(parameters, np.array([[within_room(exciter, 0.0), 0.0]]), harmonics)
        return {
            name: (dims, _spread(values[:0], at, shape) if dims[0] == "row" else values[:0])
            for name, (dims, values) in label_rows(rows, parameters).items()
        }
    parameters = np.array([each.parameters() for each in exciters])
    states = np.empty((len(members), 2))
    for row, each in enumerate(members):
        attractor = sets[each.value].known[each.place]
        states[row] = attractor.sections[0 if attractor.period_multiple else -1]
        states[row, 0] = within_room(exciters[row], states[row, 0])
    rows = _solve(parameters, states, harmonics)
    fills = {"regime": Regime.UNRESOLVED}
    return {
        name: (dims, _spread(values, at, shape, fills.get(name, 0)) if dims[0] == "row" else values)
        for name, (dims, values) in label_rows(rows, parameters).items()
    }


def _solve(parameters: np.ndarray, states: np.ndarray, harmonics: int) -> RowResults:
    """Return the steady states of parameters (rows, 7) from states (rows, 2), as `steady_state` finds each."""
    n, columns = len(parameters), columns_of(parameters)
    alone = Rows(
        lambda first, stop: [parameters[first:stop]],
        lambda first, stop: (states[first:stop, 0], states[first:stop, 1]),
    )
    ((_stop, (rows,)),) = solve_rows(
        row_blocks(n, 1, n), alone, RowLimits(MAX_PERIODS, MAX_PERIODS), harmonics, OF_STEADY_STATE,
        effects=all_effects(columns, pieces=True), soft=has_soft_support(columns),
    )  # fmt: skip
    return rows


def _visits(
    sets: Sequence[AttractorSet],
    members: Sequence[_Member],
    at: tuple[np.ndarray, np.ndarray],
    shape: tuple[int, int],
) -> Variables:
    """Return states of attractors at the section."""
    states = np.empty((len(members), VISITS, 2))
    for row, each in enumerate(members):
        states[row] = states_at_section(sets[each.value].known[each.place], VISITS)
    return {
        f"poincare_{name}": (("row", "visit"), _spread(states[:, :, column], at, shape))
        for column, name in enumerate(("displacement", "velocity"))
    }


def _knocks(
    sets: Sequence[AttractorSet],
    members: Sequence[_Member],
    at: tuple[np.ndarray, np.ndarray],
    shape: tuple[int, int],
) -> Variables:
    """Return how hard each attractor may be hit (`knocks_of`)."""
    knocks = np.empty((len(members), 2))
    for row, each in enumerate(members):
        known = sets[each.value]
        velocity = reachable_velocity(known.section.exciter)
        knocks[row] = knocks_of(known, known.known[each.place], each.place, velocity)
    return {
        name: (("row",), _spread(knocks[:, column], at, shape))
        for column, name in enumerate(("knock", "knock_impulse"))
    }


def _changes(families: Families, name: str) -> Mapping[str, Any]:
    """Return where attractors appear and vanish."""
    each, dim = families.changes, ("bifurcation",)
    return {
        f"bifurcation_{name}": (dim, np.array([change.value for change in each], float)),
        "attractor_change": (dim, np.array([change.appears for change in each], np.int8)),
        "changed_attractor": (dim, np.array([change.family for change in each], np.int32)),
        "other_attractor": (dim, np.array([change.other for change in each], np.int32)),
    }


def _spread(
    values: np.ndarray, at: tuple[np.ndarray, np.ndarray], shape: tuple[int, int], fill: int = 0
) -> np.ndarray:
    """Return rows spread over the values of the parameter and the attractors, with NaN or `fill` elsewhere."""
    is_whole = values.dtype.kind in "iu"
    spread = np.full((*shape, *values.shape[1:]), fill if is_whole else np.nan, values.dtype)
    spread[at] = values
    return spread
