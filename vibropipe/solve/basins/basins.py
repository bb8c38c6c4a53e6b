"""The function `basins`: which attractor each start of a grid settles on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.parameter_error import number_within
from vibropipe.physics.stated import check_untied
from vibropipe.solve.basins.attractor_families import follow_attractors
from vibropipe.solve.basins.attractors import (
    STARTS,
    STARTS_LIMITS,
    attractor_dataset,
    attractor_ids,
    motions_dataset,
)
from vibropipe.solve.basins.basin_rows import Assigned, BasinRows, joined_rows
from vibropipe.solve.basins.basin_shares import shares_dataset
from vibropipe.solve.basins.border_orbits import border_orbits, with_border_orbits
from vibropipe.solve.basins.knocks import sharpened
from vibropipe.solve.basins.of_housing import settle_rows
from vibropipe.solve.checks import LEFT_OUT, check_over, check_varied, check_whole
from vibropipe.solve.physical import to_physical
from vibropipe.solve.sweep.cluster import computed_values, solve_on_cluster
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.solve.with_units import are_with_units, plain_mapping, plain_values
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.progress import Progress, part_of
from vibropipe.words.records import FRACTION
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr


def basins(
    exciter: Exciter,
    x0: Any,
    v0: Any,
    phase: float = 0.0,
    harmonics: int = 6,
    starts: int = STARTS,
    progress: Progress | None = None,
    over: Mapping[str, Any] | None = None,
    client: Any = None,
) -> xr.Dataset:
    """Find the attractor of eqs. (5), (6) that the motion from each start of a grid settles on.

    The attractors are those of `attractors` and all that a start of the grid shows to be missing. Each start is
    marched by itself until it enters a neighbourhood of an orbit that no motion leaves [1]_, so the result does not
    depend on the number of threads.

    Parameters
    ----------
    exciter : Exciter
    x0, v0 : array_like
        Displacements, between the supports, on one or beyond a soft one, and velocities of the starts: increasing,
        one-dimensional. A start at rest within 4 ulps of a support is moved onto it. Of an exciter of `from_physical`
        they may have units, as text or quantities of pint; the dataset is then in SI.
    phase : float
        Phase of the force at the start, from 0 to 1, as a fraction of a forcing period: the motion starts at
        tau = phase * 2 pi/nu.
    harmonics : int
        Number of harmonics, from 1 to 1000.
    starts : int
        Number of scattered starts that look for attractors first, as for `attractors`.
    progress : callable, optional
        Called as progress(done, total), in starts assigned.
    over : mapping of str to array_like, optional
        Increasing values of one parameter: the basins at each of them.
    client : dask.distributed.Client, optional
        Cluster that marches the starts; its workers need this package. The result is bitwise that of one machine.

    Returns
    -------
    xarray.Dataset
        attractor (x0, v0)
            `attractor_id` of the attractor, or -1: none was found.
        periods_to_attractor (x0, v0)
            Forcing periods until the motion was assigned to it.
        border (x0, v0)
            Whether one of the four neighbours settles on another attractor.
        basin_share, basin_share_low, basin_share_high (attractor_id)
            Share of the starts of the grid, with the 95 % confidence interval for as many random starts.
        border_orbit_multiple, border_orbit_multiplier (multiplier) (border_orbit)
            Forcing periods and Floquet multipliers of unstable orbits on the borders: the border is made of the starts
            whose motions approach one of them [2]_. Those of more than 32 periods, of a fractal border all but a few,
            and those that would take too long for so few starts are left out.
        border_orbit_attractor (border_orbit, border_side)
            `attractor_id` on either side of the border.
        border_point_displacement, border_point_velocity (border_point)
            States of these orbits at the section; `border_point_orbit` has the orbit of each.
        stable_set_displacement, stable_set_velocity (stable_set_point)
            The borders themselves: starts at phase 0 whose motions approach one of these orbits, along pieces of curves
            that NaN parts; `stable_set_orbit` has the orbit. Of a set without end the beginning, with friction none.

        and over `attractor_id` all that `attractors` returns; the knocks are tried towards these borders, too. With
        `over`, the parameter is the first dimension of all these. An attractor is carried along from value to value and
        keeps its number while its states at the section change continuously, also where its period doubles or it
        becomes chaotic; where it is not, its numbers are NaN and its regime is unresolved. Borders have no orbits then,
        but there is, over `bifurcation`,

        bifurcation_<parameter>
            Value at which an attractor appears or vanishes, where it jumps or two merge: to 1/1000 of the distance of
            two values.
        attractor_change, changed_attractor
            appears or vanishes, with increasing parameter; and its `attractor_id`.
        other_attractor
            `attractor_id` of the attractor that its motion settles on where it is not, or -1.

    Raises
    ------
    ParameterError
        If a start is not finite or lies beyond a rigid support, or an argument is out of range.
    RuntimeError
        If a worker of the cluster has other kernels, or was lost too often with the same starts.

    Notes
    -----
    With a housing that slides and is at rest at the start, motions are told apart as `attractors` does, forwards and
    backwards among them; they are those of the starts of the grid alone, and borders have no orbits. Neither `phase`
    nor `over` is computed for it.

    A start whose motion is chaotic before it settles reaches an attractor that depends on rounding; such starts have
    large `periods_to_attractor`. A mass that dry friction holds for ever stays at any of many places, none of which
    attracts: its starts have the attractor -1.

    References
    ----------
    .. [1] G. Datseris, A. Wagemakers, Effortless estimation of basins of attraction, Chaos 32 (2022) 023104.
    .. [2] J. D. Skufca, J. A. Yorke, B. Eckhardt, Edge of chaos in a parallel shear flow, Physical Review Letters 96
       (2006) 174101.
    """
    if are_with_units(exciter, over, x0, v0):
        dataset = basins(
            exciter,
            plain_values(exciter, "x0", x0),
            plain_values(exciter, "v0", v0),
            phase,
            harmonics,
            starts,
            progress,
            over and plain_mapping(exciter, over),
            client,
        )
        return to_physical(dataset, exciter)
    check_whole("starts", starts, STARTS_LIMITS)
    turn, given = number_within("phase", phase, FRACTION) % 1.0, {"x0": x0, "v0": v0}
    if client is not None:
        given, over = computed_values(client, given), over and computed_values(client, over)
    xs, vs = check_starts(exciter, given["x0"], given["v0"])
    values = {} if over is None else _check_over(exciter, over, xs)
    grid = SweepGrid({**values, "x0": xs, "v0": vs}, None, exciter.stated())
    rows, assigned = BasinRows(exciter, grid, turn, starts), None
    check_rows_of_housing(rows, client)
    if client is not None:
        shards = solve_on_cluster(client, rows.shard, rows.grid)
        assigned = joined_rows([assigned_in(shard) for shard in shards])
    return solve_basins(rows, harmonics, progress, assigned)


def check_rows_of_housing(rows: BasinRows, client: Any = None) -> None:
    """Raise a ParameterError for basins that are not computed for a housing that slides."""
    if not any(exciter.mass_ratio > 0.0 for exciter in rows.exciters):
        return
    asked = {"phase": rows.phase, "over": rows.parameter, "client": client}
    for name, value in asked.items():
        if value:
            raise ParameterError(name, value, must=LEFT_OUT)


def assigned_in(shard: xr.Dataset) -> Assigned:
    """Return what a shard holds of its starts."""
    return shard.attractor_assigned.values, shard.periods_to_attractor.values


def solve_basins(
    rows: BasinRows,
    harmonics: int,
    progress: Progress | None = None,
    assigned: Assigned | None = None,
) -> xr.Dataset:
    """Return the dataset of `basins`; `assigned` is what is known of all rows, from shards."""
    if rows.parameter is not None:
        return _over_values(rows, rows.parameter, harmonics, progress, assigned)
    exciter, turn, (xs, vs) = rows.exciter, rows.phase, (rows.x0, rows.v0)
    if exciter.mass_ratio > 0.0:
        owner, periods, first = settle_rows(exciter, rows.starts(0), progress)
        dataset = motions_dataset(exciter, owner, first, harmonics, _starts_text(rows))
        return _with_starts(dataset, rows, owner.astype(np.int32), periods)
    attractors, (owner, periods) = rows.settle(0, assigned, progress)
    dataset, numbers = attractor_dataset(attractors, owner, harmonics, _starts_text(rows))
    parameters = {name: ((), value) for name, value in exciter.stated().items()}
    dataset = _with_starts(dataset.assign_coords(parameters), rows, numbers, periods)
    shape = xs.size, vs.size
    states = rows.starts(0).reshape(*shape, 2)
    orbits = border_orbits(attractors, states, owner.reshape(shape), turn)
    ids = attractor_ids(attractors)
    dataset = with_border_orbits(dataset, attractors, orbits, ids)
    return describe(sharpened(dataset, attractors, np.argsort(ids[:-1])))


def _starts_text(rows: BasinRows) -> str:
    return f"{rows.x0.size} x {rows.v0.size} starts (x0, v0) at {rows.phase:g} of a forcing period"


def _over_values(
    rows: BasinRows, name: str, harmonics: int, progress: Progress | None, assigned: Assigned | None
) -> xr.Dataset:
    """Return the basins of exciters that differ in one parameter."""
    sets, owners, times = [], [], []
    for k in range(len(rows.exciters)):
        part = part_of(progress, k * rows.starts_each, rows.grid.rows)
        attractors, (owner, periods) = rows.settle(k, assigned, part)
        sets.append(attractors)
        owners.append(owner)
        times.append(periods)
    families = follow_attractors(sets, name)
    text = f"{_starts_text(rows)}, at each value"
    dataset, numbers = shares_dataset(sets, families, owners, name, harmonics, text)
    return _with_starts(dataset, rows, numbers, np.array(times), (name,))


def _with_starts(
    dataset: xr.Dataset,
    rows: BasinRows,
    numbers: np.ndarray,
    periods: np.ndarray,
    over: tuple[str, ...] = (),
) -> xr.Dataset:
    """Return the dataset of attractors with what is known of each start (..., x0 and v0 running fastest)."""
    shape, dims = (*numbers.shape[:-1], rows.x0.size, rows.v0.size), (*over, "x0", "v0")
    attractor = numbers.reshape(shape)
    variables = {
        "attractor": (dims, attractor),
        "periods_to_attractor": (dims, periods.reshape(shape).astype(np.int32)),
        "border": (dims, border_starts(attractor).astype(np.int8)),
    }
    coords = {"start_phase": ((), rows.phase), "x0": rows.x0, "v0": rows.v0}
    return describe(dataset.assign_coords(coords).assign(variables))


def _check_over(exciter: Exciter, over: Mapping[str, Any], xs: np.ndarray) -> dict[str, np.ndarray]:
    """Return the values of the swept parameter by its name, or raise a ParameterError."""
    arrays = check_over(over)
    if len(arrays) > 1 or not set(arrays) <= set(PARAMETERS):
        must, got = f"must have one key among {', '.join(PARAMETERS)}", ", ".join(arrays)
        raise ParameterError("over", over, must=must, got=got)
    ((name, values),) = arrays.items()
    check_untied(exciter, f"over.{name}", [name])
    if not (np.diff(values) > 0).all():
        raise ParameterError(f"over.{name}", over[name], "increasing numbers")
    check_varied("over", exciter, (name,), {name: float(values[0])})
    exciter.check_frequency((name,))
    for value in values.tolist():
        for end in (xs[0], xs[-1]):
            replace(exciter, **{name: value}).check_start(end, 0.0)
    return arrays


def check_starts(exciter: Exciter, x0: Any, v0: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the displacements and velocities of a grid of starts as arrays, or raise a ParameterError."""
    arrays = []
    for name, values in (("x0", x0), ("v0", v0)):
        try:
            array = np.atleast_1d(np.asarray(values, dtype=float))
        except (TypeError, ValueError):
            array = np.empty(0)
        is_list = array.ndim == 1 and array.size > 0
        if not is_list or not np.isfinite(array).all() or not (np.diff(array) > 0).all():
            raise ParameterError(name, values, "a non-empty list of increasing finite numbers")
        arrays.append(array)
    for end in (arrays[0][0], arrays[0][-1]):
        exciter.check_start(end, 0.0)
    return arrays[0], arrays[1]


def border_starts(attractor: np.ndarray) -> np.ndarray:
    """Return which starts (..., x0, v0) have a neighbour in the grid with another attractor."""
    border = np.zeros(attractor.shape, bool)
    for axis in (-2, -1):
        ahead = np.moveaxis(attractor, axis, 0)
        differs = ahead[1:] != ahead[:-1]
        on_axis = np.moveaxis(border, axis, 0)  # a view
        on_axis[1:] |= differs
        on_axis[:-1] |= differs
    return border
