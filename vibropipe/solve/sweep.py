"""Steady states over a grid of parameters: the face `sweep`, and the shards it can be cut into."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.orbits.outputs import RowResults
from vibropipe.physics import limits
from vibropipe.physics.effects import effect_names, resolve_effects
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.start import largest_start, start_text
from vibropipe.solve.accuracy.method_choice import check_accuracy
from vibropipe.solve.accuracy.row_errors import perturbed_rows, row_errors, with_error
from vibropipe.solve.cluster import computed_values, solve_on_cluster
from vibropipe.solve.label import concatenate, coordinates, label_rows, take_rows
from vibropipe.solve.rows import solve_rows
from vibropipe.solve.sweep_grid import DIRECTIONS, Follow, SweepGrid, row_blocks
from vibropipe.words.outputs import OUTPUTS, SWEEP_DEFAULT
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

MAX_PERIODS = limits.PATIENCE[1]
# Forcing periods after which a row of a sweep is left where small differences grow.
PATIENCE = 300


def sweep(
    exciter: Exciter,
    over: Mapping[str, Any],
    x0: float | None = None,
    v0: float = 0.0,
    harmonics: int = 3,
    follow: Follow = None,
    outputs: Sequence[str] = SWEEP_DEFAULT,
    accuracy: float | None = None,
    effects: Sequence[str] | None = None,
    client: Any = None,
    patience: int = PATIENCE,
) -> xr.Dataset:
    """Find the steady states (see `steady_state`) over every combination of the values in `over`.

    Parameters
    ----------
    exciter : Exciter
        The parameters that are the same in every row.
    over : mapping of str to array_like
        Parameter (any of nu f h l delta R1 R2) -> its values (an array, a dask array or a list): one dimension
        each, in the order given.
    x0, v0 : float, optional
        Start of every row: displacement and velocity at tau = 0. An x0 left out is the equilibrium, or the support
        nearest to it where that lies beyond; one within 4 ulps of a support lies on it.
    harmonics : int
        Harmonics of displacement and velocity that are kept.
    follow : (str, str), optional
        A swept parameter and a direction, ("nu", "up" or "down"): its rows are seeded by their neighbour from below
        or above, and only the first starts from (x0, v0), so that hysteresis shows.
    outputs : sequence of str
        Any of harmonics, impacts, motion, stability, energy; nothing else is computed or stored.
    accuracy : float, optional
        Relative error wanted of each row: adds `error` (`vibropipe.solve.accuracy.row_errors`), and rows beyond it
        have status `inaccurate`.
    effects : sequence of str, optional
        Any of damping, forcing, support_1, support_2, restitution, rest; all of them if left out. Rows are marched
        by a kernel without the others, compiled when it is first called for. A row that reaches a support left out
        has status `support_reached`.
    client : dask.distributed.Client, optional
        The workers of its cluster solve the rows, and those of a worker that is lost are solved by another one. The
        result is the same, bit for bit, on machines of the same kind.
    patience : int
        Forcing periods after which a row is taken for aperiodic if small differences in it grow by e^6 within the
        last 50 of them; one in which they do not, or without damping, is marched for 1,000. Chaos that ends later
        is found only with 1,000.

    Returns
    -------
    xr.Dataset
        Quantities, all non-dimensional (units of l, p and m), over the names in `over` and then `support`,
        `harmonic`, `multiplier` or `phase`. Rows that do not settle are labelled in `regime` and `status`. Impacts
        are a contiguous ragged array: `impact_*` over `impact`, `row_size` of them for each row in the order of the
        grid.

    Raises
    ------
    ParameterError
        If a value is outside what is allowed, or an effect is left out that the parameters call for.
    RuntimeError
        If a worker of the cluster has other kernels, or was lost too often with the same rows.

    References
    ----------
    Equations (5) and (6) of the paper are the model; contiguous ragged arrays are those of the CF conventions,
    section 9.3.3.
    """
    grid = grid_of(exciter, over if client is None else computed_values(client, over), follow)
    asked: dict[str, Any] = {"follow": follow, "outputs": outputs, "effects": effects}
    asked |= {"x0": x0, "v0": v0, "harmonics": harmonics, "accuracy": accuracy}
    asked["patience"] = patience
    solve: Callable[[int, int], xr.Dataset] = partial(solve_shard, exciter, grid.values, **asked)
    shards = [solve(0, grid.rows)] if client is None else solve_on_cluster(client, solve, grid)
    return assemble(shards, grid.values, follow)


def grid_of(exciter: Exciter, over: Mapping[str, Any], follow: Follow = None) -> SweepGrid:
    """Return the grid of a sweep; ParameterError where values or what is followed are not allowed."""
    values, followed = check_over(over), _check_follow(over, follow)
    parameters = exciter.parameters()._asdict().items()
    shared = {name: value for name, value in parameters if name not in values}
    return SweepGrid(values, followed, shared)


def check_over(over: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """The swept values as one-dimensional arrays of finite floats, in the order given."""
    arrays = {}
    for name, values in over.items():
        if name not in Parameters._fields:
            must = f"must have keys among {', '.join(Parameters._fields)}"
            raise ParameterError("over", over, must=must, got=repr(name))
        array = np.atleast_1d(np.asarray(values, dtype=float))
        if array.ndim != 1 or array.size == 0 or not np.isfinite(array).all():
            raise ParameterError(f"over.{name}", values, "a non-empty list of finite numbers")
        if np.unique(array).size != array.size:
            raise ParameterError(f"over.{name}", values, "values that differ from each other")
        arrays[name] = array
    if not arrays:
        must = "must have at least one parameter with its values"
        raise ParameterError("over", over, must=must)
    return arrays


def _check_follow(over: Mapping[str, Any], follow: Follow) -> Follow:
    if follow is None:
        return None
    if isinstance(follow, str) or np.shape(follow) != (2,):
        allowed = 'a pair of a swept parameter and a direction, like ("nu", "up")'
        raise ParameterError("follow", follow, allowed)
    along, direction = follow
    if along not in over:
        raise ParameterError("follow.along", along, f"a swept parameter ({', '.join(over)})")
    if direction not in DIRECTIONS:
        raise ParameterError("follow.direction", direction, "up or down")
    return along, direction


def solve_shard(
    exciter: Exciter, over: Mapping[str, Any], row_start: int, row_stop: int, **asked: Any
) -> xr.Dataset:
    """Solve the rows [row_start, row_stop) of a sweep over dimension `row`, asked as of `sweep`.

    Rows count as in `SweepGrid`, and cuts fall between its chains; results do not depend on where they fall.
    """
    (shard,) = solve_blocks(exciter, over, row_start, row_stop, row_stop - row_start, **asked)
    return shard


def solve_blocks(
    exciter: Exciter,
    over: Mapping[str, Any],
    row_start: int,
    row_stop: int,
    block_rows: int,
    x0: float | None = None,
    v0: float = 0.0,
    harmonics: int = 3,
    follow: Follow = None,
    outputs: Sequence[str] = SWEEP_DEFAULT,
    progress: Callable[[int], None] | None = None,
    accuracy: float | None = None,
    effects: Sequence[str] | None = None,
    patience: int = PATIENCE,
) -> Generator[xr.Dataset]:
    """Solve rows of a sweep, as `solve_shard` does, in blocks of at least block_rows rows, one after the other.

    A block is made when it is asked for, and little is solved ahead of it. Each holds the values of all
    parameters of its rows: those that are swept over `row`, the others once.
    """
    grid = grid_of(exciter, over, follow)
    if not grid.is_cut(row_start, row_stop):
        must = f"must be cut from 0 to {grid.rows} at multiples of {grid.chain_length}"
        got = f"{row_start} to {row_stop}"
        raise ParameterError("rows", (row_start, row_stop), must=must, got=got)
    requested = _check_outputs(outputs)
    _check_whole("harmonics", harmonics, limits.HARMONICS)
    _check_whole("patience", patience, limits.PATIENCE)
    wanted = None if accuracy is None else check_accuracy(accuracy)
    x0, v0 = _check_corners(grid, x0, v0)
    # From the whole grid, not from these rows: a kernel must not depend on how the sweep was cut.
    values = {**grid.shared, **grid.values}
    e = resolve_effects(effects, values, largest_start(values, x0), v0, followed=follow is not None)
    attrs = {"effects": ", ".join(effect_names(e)), "start": start_text(values, x0, v0)}

    def parameters(begin: int, stop: int) -> list[np.ndarray]:
        numbers = grid.solved(row_start + begin, row_start + stop)
        mine = grid.parameters(Parameters._fields, numbers)
        return [mine] if wanted is None else [mine, perturbed_rows(mine)]

    cut = row_blocks(row_stop - row_start, grid.chain_length, block_rows)
    solver = (x0, v0), grid.chain_length, MAX_PERIODS, int(patience), harmonics, requested
    with closing(solve_rows(cut, parameters, *solver, progress, e)) as blocks:
        begin = 0
        for stop, solved in blocks:
            given = parameters(begin, stop)
            yield _label(grid, row_start + begin, given, solved, wanted, harmonics, attrs)
            begin = stop


def _label(
    grid: SweepGrid,
    start: int,
    parameters: Sequence[np.ndarray],
    solved: Sequence[RowResults],
    wanted: float | None,
    harmonics: int,
    attrs: Mapping[str, Any],
) -> xr.Dataset:
    """Return whole chains from row `start` as a dataset over `row`, brought from the order in which they were solved
    into that of the grid's rows."""
    import xarray as xr

    stop = start + len(parameters[0])
    found, *again = map(label_rows, solved, parameters)
    if wanted is not None:
        found = with_error(found, row_errors(parameters[0], found, *again), wanted)
    found = take_rows(found, np.argsort(grid.solved(start, stop)))
    swept = grid.parameters(grid.dims, np.arange(start, stop))
    given: dict[str, Any] = {name: ((), np.array(value)) for name, value in grid.shared.items()}
    given |= {name: ("row", swept[:, axis]) for axis, name in enumerate(grid.dims)}
    own = {"row_start": start, "row_stop": stop, **attrs}
    block = xr.Dataset(found | given, coordinates(found, harmonics), own)
    return describe(block.set_coords(given))


def _check_whole(name: str, value: Any, bounds: tuple[int, int]) -> None:
    if not isinstance(value, (int, np.integer)) or not bounds[0] <= value <= bounds[1]:
        raise ParameterError(name, value, limits.within_text(bounds))


def _check_outputs(outputs: Sequence[str]) -> tuple[str, ...]:
    if isinstance(outputs, str) or not set(outputs) <= set(OUTPUTS):
        raise ParameterError("outputs", outputs, f"a list of {', '.join(OUTPUTS)}")
    return tuple(name for name in OUTPUTS if name in outputs)


def _check_corners(grid: SweepGrid, x0: float | None, v0: float) -> tuple[float | None, float]:
    """The start as floats, when it and the corners of the grid are checked by the exciter's own rules."""
    ends = ({float(values.min()), float(values.max())} for values in grid.values.values())
    for corner in itertools.product(*ends):
        Exciter(**grid.shared, **dict(zip(grid.dims, corner, strict=True))).check_start(x0, v0)
    return None if x0 is None else float(x0), float(v0)


def assemble(
    shards: Sequence[xr.Dataset], over: Mapping[str, Any], follow: Follow = None
) -> xr.Dataset:
    """Join shards, in any order, into the dataset of the whole sweep, in memory."""
    import xarray as xr

    grid = SweepGrid(check_over(over), follow)
    ordered = sorted(shards, key=lambda shard: shard.attrs["row_start"])
    parts = [
        {str(name): (tuple(map(str, v.dims)), v.values) for name, v in shard.data_vars.items()}
        for shard in ordered
    ]
    flat = take_rows(concatenate(parts), grid.rows_of_points())
    variables = {
        name: ((*grid.dims, *dims[1:]), values.reshape(*grid.shape, *values.shape[1:]))
        if dims[0] == "row"
        else (dims, values)
        for name, (dims, values) in flat.items()
    }
    coords: dict[str, Any] = {name: (name, values) for name, values in grid.values.items()}
    first = ordered[0]
    for name in [str(name) for name in first.coords if name not in grid.dims]:
        # an index is taken over; of others a bare variable is, since a DataArray takes long to make
        coords[name] = first[name] if name in first.xindexes else first.variables[name]
    attrs = {name: first.attrs[name] for name in ("effects", "start")}
    joined = describe(xr.Dataset(variables, coords, attrs))
    if "row_size" in joined:
        joined["row_size"].attrs["sample_dimension"] = "impact"
    return joined
