"""Steady states over a grid of parameters: the face `sweep`, and the shards it can be cut into."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.orbits.outputs import Rows
from vibropipe.physics import limits
from vibropipe.physics.effects import asked_effects, names_of
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.start import largest_start, start_text
from vibropipe.solve.accuracy.method_choice import check_accuracy
from vibropipe.solve.accuracy.row_errors import nudged_rows, row_errors, told
from vibropipe.solve.cluster import gathered, solve_on
from vibropipe.solve.label import Variables, concatenate, coordinates, label_rows, take_rows
from vibropipe.solve.rows import solve_rows
from vibropipe.words.outputs import OUTPUTS, SWEEP_DEFAULT
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

DIRECTIONS = ("up", "down")
MAX_PERIODS = limits.PATIENCE[1]
# Forcing periods after which a row of a sweep is left where small differences grow.
PATIENCE = 300
Follow = tuple[str, str] | None


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
    """Steady states (see `steady_state`) over every combination of the values in `over`.

    over: parameter name (any of nu f h l delta R1 R2) -> values (an array, a dask array or a list), one
    dimension each, in the order given.
    Every row starts from (x0, v0), x0 left out from its equilibrium, or from the support nearest to that where it
    lies beyond; an x0 within 4 ulps of a support lies on it.
    With follow = ("nu", "up" or "down") the rows of that parameter are seeded by their neighbour from below or
    above, and only the first starts from (x0, v0): hysteresis shows.
    outputs: any of harmonics, impacts, motion, stability, energy; nothing else is computed or stored.
    accuracy: adds `error` of each row (`vibropipe.solve.accuracy.row_errors`); rows beyond it have status `inaccurate`.
    effects: any of damping, forcing, support_1, support_2, restitution, rest; rows are marched by a kernel
    without the others, compiled when it is first called for. All of them if left out. A row that reaches a
    support left out has status `support_reached`.
    client: a `dask.distributed.Client`; the rows are then solved by the workers of its cluster, and those of a
    worker that is lost by another one. The result is the same, bit for bit, on machines of the same kind.

    patience: forcing periods after which a row is taken for aperiodic if small differences in it grow by e^6
    within the last 50 of them; one in which they do not, or without damping, is marched for 1,000. Chaos that
    ends later is told only by 1,000.

    Rows that do not settle are labelled in `regime` and `status`. Impacts are a contiguous ragged array:
    flat `impact_*` over `impact`, `row_size` of them for each row in the order of the grid.
    Raises ParameterError naming the parameter, its value and what is allowed, or an effect left out that the
    parameters have.
    """
    arrays = check_over(over if client is None else gathered(client, over))
    rows, chain = count_rows(arrays, follow)
    asked: dict[str, Any] = {"follow": follow, "outputs": outputs, "effects": effects}
    asked |= {"x0": x0, "v0": v0, "harmonics": harmonics, "accuracy": accuracy}
    asked["patience"] = patience
    solve: Callable[[int, int], xr.Dataset] = partial(solve_shard, exciter, arrays, **asked)
    shards = [solve(0, rows)] if client is None else solve_on(client, solve, rows, chain)
    return assemble(shards, arrays, follow)


def check_over(over: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """The swept values as one-dimensional arrays of finite floats, in the order given."""
    arrays = {}
    for name, values in over.items():
        if name not in Parameters._fields:
            raise ParameterError(f"over: {name!r}: allowed are {', '.join(Parameters._fields)}")
        array = np.atleast_1d(np.asarray(values, dtype=float))
        if array.ndim != 1 or array.size == 0 or not np.isfinite(array).all():
            raise ParameterError(
                f"over: {name} = {values!r}: allowed is a non-empty list of finite numbers"
            )
        if np.unique(array).size != array.size:
            raise ParameterError(
                f"over: {name} = {values!r}: allowed are values that differ from each other"
            )
        arrays[name] = array
    if not arrays:
        raise ParameterError("over is empty: allowed is at least one parameter with its values")
    return arrays


def _check_follow(over: Mapping[str, Any], follow: Follow) -> Follow:
    if follow is None:
        return None
    if isinstance(follow, str) or not np.shape(follow) == (2,):
        raise ParameterError(
            f'follow = {follow!r}: allowed is a pair of a swept parameter and a direction, like ("nu", "up")'
        )
    along, direction = follow
    if along not in over:
        raise ParameterError(f"follow: along = {along!r}: allowed is one of {', '.join(over)}")
    if direction not in DIRECTIONS:
        raise ParameterError(f"follow: direction = {direction!r}: allowed is up or down")
    return along, direction


def count_rows(over: Mapping[str, Any], follow: Follow = None) -> tuple[int, int]:
    """(rows of the sweep, rows of a chain that can not be cut: 1, or the followed parameter's).

    Raises ParameterError where a parameter is followed that is not swept.
    """
    sizes = {name: np.size(values) for name, values in over.items()}
    checked = _check_follow(over, follow)
    chain = sizes[checked[0]] if checked is not None else 1
    return math.prod(sizes.values()), chain


def row_order(over: Mapping[str, np.ndarray], follow: Follow) -> list[str]:
    """The dimensions in the order in which rows count: as given, the followed one moved last."""
    names = list(over)
    return names if follow is None else [n for n in names if n != follow[0]] + [follow[0]]


def solve_shard(
    exciter: Exciter, over: Mapping[str, Any], row_start: int, row_stop: int, **asked: Any
) -> xr.Dataset:
    """Rows row_start to row_stop of a sweep over dimension `row` (the order of `row_order`), asked as of `sweep`.

    Cuts must fall on ends of chains (`count_rows`); results do not depend on where they fall.
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
    """Rows of a sweep, as `solve_shard` returns them, in blocks of at least block_rows (whole pieces of whole
    chains), one after the other: a block is made when it is asked for, and little is solved ahead of it."""
    import xarray as xr

    arrays = check_over(over)
    follow = _check_follow(arrays, follow)
    asked = _check_outputs(outputs)
    rows, chain = count_rows(arrays, follow)
    if not 0 <= row_start < row_stop <= rows or row_start % chain or row_stop % chain:
        raise ParameterError(
            f"rows {row_start} to {row_stop}: allowed are cuts from 0 to {rows} at multiples of {chain}"
        )
    _check_whole("harmonics", harmonics, limits.HARMONICS)
    _check_whole("patience", patience, limits.PATIENCE)
    wanted = None if accuracy is None else check_accuracy(accuracy)
    x0, v0 = _check_corners(exciter, arrays, x0, v0)
    # From the whole grid, not from these rows: a kernel must not depend on how the sweep was cut.
    grid = {**exciter.parameters()._asdict(), **arrays}
    farthest = largest_start(grid, x0)
    e = asked_effects(effects, grid, farthest, v0, followed=follow is not None)
    # Places in a chain in the order in which they are solved: one followed downwards from its upper end.
    along = np.arange(1) if follow is None else _along(arrays[follow[0]], follow[1])

    def parameters(first: int, stop: int) -> list[np.ndarray]:
        solved = np.arange(row_start + first, row_start + stop)
        mine = _parameters(exciter, arrays, follow, solved - solved % chain + along[solved % chain])
        return [mine] if wanted is None else [mine, nudged_rows(mine)]

    def labelled(begin: int, stop: int, solved: Sequence[Rows]) -> Variables:
        given = parameters(begin, stop)
        found, *again = map(label_rows, solved, given)
        if wanted is not None:
            found = told(found, row_errors(given[0], found, *again), wanted)
        return take_rows(found, (np.arange(0, stop - begin, chain)[:, None] + back).ravel())

    fixed = {
        name: ((), np.array(value))
        for name, value in exciter.parameters()._asdict().items()
        if name not in arrays
    }
    back = np.argsort(along)
    blocks = solve_rows(
        row_stop - row_start,
        parameters,
        (x0, v0),
        chain,
        MAX_PERIODS,
        int(patience),
        harmonics,
        asked,
        progress,
        e,
        block_rows,
    )
    with closing(blocks):
        begin = 0
        for stop, solved in blocks:
            variables = labelled(begin, stop, solved)
            attrs: dict[str, Any] = {"row_start": row_start + begin, "row_stop": row_start + stop}
            attrs["effects"], attrs["start"] = ", ".join(names_of(e)), start_text(grid, x0, v0)
            block = xr.Dataset(variables | fixed, coordinates(variables, harmonics), attrs)
            yield describe(block.set_coords(fixed))
            begin = stop


def _check_whole(name: str, value: Any, bounds: tuple[int, int]) -> None:
    if not isinstance(value, (int, np.integer)) or not bounds[0] <= value <= bounds[1]:
        raise ParameterError(f"{name} = {value!r}: allowed is {limits.within_text(bounds)}")


def _check_outputs(outputs: Sequence[str]) -> tuple[str, ...]:
    if isinstance(outputs, str) or not set(outputs) <= set(OUTPUTS):
        raise ParameterError(f"outputs = {outputs!r}: allowed are any of {', '.join(OUTPUTS)}")
    return tuple(name for name in OUTPUTS if name in outputs)


def _parameters(
    exciter: Exciter, over: Mapping[str, np.ndarray], follow: Follow, rows: np.ndarray
) -> np.ndarray:
    """The parameters (rows, 7) of numbered rows."""
    order = row_order(over, follow)
    places = np.unravel_index(rows, [over[name].size for name in order])
    parameters = np.empty((len(rows), len(Parameters._fields)))
    parameters[:] = exciter.parameters()
    for name, place in zip(order, places, strict=True):
        parameters[:, Parameters._fields.index(name)] = over[name][place]
    return parameters


def _check_corners(
    exciter: Exciter, over: Mapping[str, np.ndarray], x0: float | None, v0: float
) -> tuple[float | None, float]:
    """The start as floats, when it and the corners of the grid are checked by the exciter's own rules."""
    base = exciter.parameters()._asdict()
    for corner in itertools.product(*({float(a.min()), float(a.max())} for a in over.values())):
        row = Exciter(**{**base, **dict(zip(over, corner, strict=True))})
        row.check_start(x0, v0)
    return None if x0 is None else float(x0), float(v0)


def _along(values: np.ndarray, direction: str) -> np.ndarray:
    """The places of the values of a followed parameter, in the order in which they are solved."""
    order = np.argsort(values)
    return order if direction == "up" else order[::-1]


def assemble(
    shards: Sequence[xr.Dataset], over: Mapping[str, Any], follow: Follow = None
) -> xr.Dataset:
    """Join shards, in the order of their rows, into the dataset of the whole sweep, in memory."""
    import xarray as xr

    arrays = check_over(over)
    ordered = sorted(shards, key=lambda shard: shard.attrs["row_start"])
    parts = [
        {str(name): (tuple(map(str, v.dims)), v.values) for name, v in shard.data_vars.items()}
        for shard in ordered
    ]
    sizes = [arrays[name].size for name in arrays]
    numbers = np.arange(math.prod(sizes))
    grid_of_rows = numbers.reshape([arrays[name].size for name in row_order(arrays, follow)])
    if follow is not None:
        grid_of_rows = np.moveaxis(grid_of_rows, -1, list(arrays).index(follow[0]))
    flat = take_rows(concatenate(parts), grid_of_rows.ravel())
    variables = {
        name: ((*arrays, *dims[1:]), values.reshape(*sizes, *values.shape[1:]))
        if dims[0] == "row"
        else (dims, values)
        for name, (dims, values) in flat.items()
    }
    coords: dict[str, Any] = {name: (name, values) for name, values in arrays.items()}
    coords |= {str(name): ordered[0][name] for name in ordered[0].coords}
    attrs = {name: ordered[0].attrs[name] for name in ("effects", "start")}
    joined = describe(xr.Dataset(variables, coords, attrs))
    if "row_size" in joined:
        joined["row_size"].attrs["sample_dimension"] = "impact"
    return joined
