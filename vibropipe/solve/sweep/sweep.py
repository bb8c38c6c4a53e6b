"""The function `sweep`: steady states over a grid of parameters, whole or in shards."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.orbits.results import RowResults
from vibropipe.physics import limits
from vibropipe.physics.effects import Effects, effect_names, has_soft_support, resolve_effects
from vibropipe.physics.exciter import Exciter, Parameters
from vibropipe.physics.start import largest_start, largest_velocity, start_text
from vibropipe.physics.ties import Ties, stated_names
from vibropipe.solve.accuracy.method_choice import check_accuracy
from vibropipe.solve.accuracy.orbit_errors import row_errors, with_error
from vibropipe.solve.checks import (
    check_accuracy_of_housing,
    check_follow,
    check_outputs,
    check_over,
    check_whole,
    swept_dampings,
)
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.solve.physical import to_physical
from vibropipe.solve.rows.label import concatenate, coordinates, label_rows, take_rows
from vibropipe.solve.rows.many import solve_rows
from vibropipe.solve.rows.sensitivity import through_ties
from vibropipe.solve.sweep.cluster import computed_values, solve_on_cluster
from vibropipe.solve.sweep.sweep_grid import Follow, SweepGrid, row_blocks
from vibropipe.solve.sweep.sweep_starts import check_corners, check_swept_start, starts_of_rows
from vibropipe.solve.warn import warn_unsolved
from vibropipe.solve.with_units import are_with_units, plain_mapping, plain_name, plain_values
from vibropipe.words.outputs import SWEEP_DEFAULT
from vibropipe.words.progress import Progress
from vibropipe.words.vocabulary import PARAMETER, describe

if TYPE_CHECKING:
    import xarray as xr


# Largest number of forcing periods marched for a row.
MAX_PERIODS = limits.PATIENCE[1]
# Forcing periods after which a row of a sweep may be left as chaotic.
PATIENCE = 200


def sweep(
    exciter: Exciter,
    over: Mapping[str, Any],
    x0: float | None = None,
    v0: float | None = None,
    harmonics: int = 3,
    follow: Follow = None,
    outputs: Sequence[str] = SWEEP_DEFAULT,
    accuracy: float | None = None,
    effects: Sequence[str] | None = None,
    client: Any = None,
    patience: int = PATIENCE,
    ties: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Find the steady states (see `steady_state`) for every combination of the values in `over`.

    Parameters
    ----------
    exciter : Exciter
        The parameters that are the same in every row.
    over : mapping of str to array_like
        Values (an array, a dask array or a list; one-dimensional) of each swept parameter of the
        exciter, of a part of the start, x0 or v0, or of a name that `ties` use, in the order of the dimensions of the
        result. Of an exciter of `from_physical` also parameters with units: omega, F and so on, in SI, as text or as
        quantities of pint; the dataset then is in SI, as `to_physical` returns it.
    x0, v0 : float, optional
        Start of every row: displacement and velocity (default 0) at tau = 0. The default of x0 is the equilibrium or,
        if the equilibrium lies beyond a support, that support. A value within 4 ulps of a support is moved onto it.
        Each can be swept instead.
    harmonics : int
        Number of harmonics of displacement and velocity, from 1 to 1,000.
    follow : (str, str), optional
        A swept parameter and a direction, such as ("nu", "up"): each row starts from the steady state of its lower
        ("up") or upper ("down") neighbour, only the first from (x0, v0). This follows stable branches, and may leave
        one a step before it ends: each step starts a transient. With "both", to show hysteresis, the sweeps up and down
        lie along a first dimension `direction`. Excludes swept starts.
    outputs : sequence of str
        Any of harmonics, impacts, motion, stability, energy, power, frame, subharmonics, poincare, lyapunov,
        sensitivity; others are neither computed nor stored.
    accuracy : float, optional
        Maximum relative error of each row: adds `error` (`vibropipe.solve.accuracy.orbit_errors`); rows beyond it have
        status `inaccurate`.
    effects : sequence of str, optional
        Any of damping, forcing, support_1, support_2, restitution, rest, load, soft, friction, second_harmonic
        (default: the first six, and those of the others that the parameters have). A specialised kernel without the
        others marches the rows; it is compiled on first use. A row that reaches a support left out has status
        `support_reached`.
    client : dask.distributed.Client, optional
        The workers of its cluster solve the rows; rows of a lost worker are solved by another one. On machines of the
        same kind the result is bitwise identical.
    patience : int
        Forcing periods, from 128 to 1,000, after which a damped row may be left as chaotic: if a perturbation grew by
        more than e^6 over the last 50 of them, unless areas of the section shrink slowly or a motion without impacts
        exists. Such rows, and all others, are marched for longer (docs/numerics.md). With 1,000 none is left before.
    ties : mapping of str to str or float, optional
        Parameters by expressions of others or of names of one's own, such as {"R2": "R1", "f": "0.02 * nu**2", "h":
        "2 * zeta"}: numbers, names, + - * / **, brackets, sqrt, exp, log, sin, cos, tan and pi (docs/theory.md). Names
        of one's own stand in `over` or have a tie themselves. Parameters are those of `Exciter`, without units.

    Returns
    -------
    xarray.Dataset
        Quantities over the names in `over` and then `support`, `harmonic`, `multiplier`, `phase` and so on, all
        non-dimensional as for `simulate`. `regime` and `status` label rows without a steady state. Impacts are a
        contiguous ragged array [1]_: `impact_*` over `impact`, with `row_size` of them for each row, in the order of
        the grid. The attributes `method`, `effects`, `start`, `follow`, `ties` and `version` say how it was made. Tied
        parameters are variables over the grid where they differ, and derivatives are by the names that are not tied,
        one's own included, with what they do to those that are.

    Raises
    ------
    ParameterError
        If an argument is out of range, a tie cannot be read, has no value or one that its parameter cannot have, goes
        round in a circle, or is of a parameter that is given as well, or `effects` leaves out an effect that the
        parameters have.
    RuntimeError
        If a worker of the cluster has other kernels, or was lost too often with the same rows.

    Warns
    -----
    UnsolvedWarning
        For each status of a row that is not `ok`, with the number of rows and the remedy.

    References
    ----------
    .. [1] CF Conventions, section 9.3.3, contiguous ragged array representation.
    """
    if isinstance(over, Mapping) and are_with_units(exciter, over, x0, v0):
        rows = sweep(
            exciter,
            plain_mapping(exciter, over),
            x0=plain_values(exciter, "x0", x0),
            v0=plain_values(exciter, "v0", v0),
            harmonics=harmonics,
            follow=follow and (plain_name(follow[0]), follow[1]),
            outputs=outputs,
            accuracy=accuracy,
            effects=effects,
            client=client,
            patience=patience,
            ties=ties,
        )
        return to_physical(rows, exciter)
    given = over if client is None else computed_values(client, over)
    grid = grid_of(exciter, given, follow, ties)
    check_swept_start(given, x0, v0)
    start = check_corners(grid, x0, 0.0 if v0 is None else v0)
    solver = check_solver(harmonics, outputs, accuracy, patience)
    solve: Any = partial(solve_shard, grid, start=start, effects=effects, **solver)
    shards = [solve(0, grid.rows)] if client is None else solve_on_cluster(client, solve, grid)
    return warn_unsolved(assemble(shards, grid))


def grid_of(
    exciter: Exciter,
    over: Mapping[str, Any],
    follow: Follow = None,
    ties: Mapping[str, Any] | None = None,
) -> SweepGrid:
    """Return the grid of a sweep; ParameterError if `over`, `follow` or `ties` is not valid."""
    tied = Ties(ties)
    values, followed = check_over(over, (*tied.own, *tied.expressions)), check_follow(over, follow)
    tied.check(stated_names(exciter), values, "over")
    grid = SweepGrid(values, followed, exciter.stated(), tied)
    given = {**exciter.numbers()._asdict(), **grid.shared, **grid.varied}
    exciter.check_frequency(
        [name for name in tied.expressions.keys() | values.keys() if np.any(given.get(name, 0.0))]
    )
    dampings = swept_dampings(
        exciter, {name: np.atleast_1d(given[name]) for name in (*values, *tied.parameters)}
    )
    shared = {name: value for name, value in exciter.stated().items() if name not in dampings}
    return SweepGrid(values, followed, shared, tied) if dampings else grid


def check_solver(
    harmonics: int, outputs: Sequence[str], accuracy: float | None, patience: int
) -> dict[str, Any]:
    """Return these arguments of `sweep` as options of `solve_blocks`; ParameterError if one is not valid."""
    return {
        "harmonics": check_whole("harmonics", harmonics, limits.HARMONICS),
        "outputs": check_outputs(outputs),
        "accuracy": None if accuracy is None else check_accuracy(accuracy),
        "patience": check_whole("patience", patience, limits.PATIENCE),
    }


def solve_shard(grid: SweepGrid, row_start: int, row_stop: int, **options: Any) -> xr.Dataset:
    """Solve the rows [row_start, row_stop) of a sweep over the dimension `row`; arguments as of `solve_blocks`."""
    (shard,) = solve_blocks(grid, row_start, row_stop, row_stop - row_start, **options)
    return shard


def solve_blocks(
    grid: SweepGrid,
    row_start: int,
    row_stop: int,
    block_rows: int,
    start: tuple[float | None, float] = (None, 0.0),
    harmonics: int = 3,
    outputs: Sequence[str] = SWEEP_DEFAULT,
    progress: Progress | None = None,
    accuracy: float | None = None,
    effects: Sequence[str] | None = None,
    patience: int = PATIENCE,
    row_work: int = limits.MAX_ROW_WORK,
    rows: np.ndarray | None = None,
) -> Generator[xr.Dataset]:
    """Solve the rows [row_start, row_stop) of a sweep in blocks, one after the other.

    A block is computed when it is requested, and few rows are solved ahead of it. The arguments have been checked.

    Parameters
    ----------
    grid : SweepGrid
        Grid of the sweep.
    row_start, row_stop : int
        First row and end; whole chains. Results do not depend on the cuts.
    block_rows : int
        Least number of rows per block.
    start : (float or None, float)
        x0 and v0, of those that are not swept.
    harmonics, outputs, accuracy, effects, patience
        As for `sweep`.
    progress : callable, optional
        Called as progress(done, total), in the rows that are solved.
    row_work : int
        Largest work of a march of a row, in steps.
    rows : (n,) array of int, optional
        Those of the rows that are solved, in their order, of a grid that follows none (default: all).

    Yields
    ------
    xarray.Dataset
        Quantities over the dimension `row`; coordinates are the swept parameters over `row` and the others as scalars.

    Raises
    ------
    ParameterError
        If `effects` leaves out an effect that the parameters have.
    """
    requested_outputs = check_outputs(outputs)
    values = {**grid.shared, **grid.varied}
    e, soft = effects_of_grid(grid, start, effects)
    check_accuracy_of_housing(e.housing, accuracy)
    attrs = origin_attrs(effect_names(e, values), start_text(values, *start), follow=grid.follow)
    attrs |= grid.ties.attrs

    def numbers(begin: int, stop: int) -> np.ndarray:
        if rows is not None:
            return rows[begin:stop]
        return grid.solved(row_start + begin, row_start + stop)

    def parameters(begin: int, stop: int) -> list[np.ndarray]:
        return [grid.parameters(Parameters._fields, numbers(begin, stop))]

    count = row_stop - row_start if rows is None else len(rows)
    row_cuts = row_blocks(count, grid.chain_length, block_rows)
    starts = starts_of_rows(grid, *start, numbers)
    solver = starts, grid.chain_length, MAX_PERIODS, patience, harmonics, requested_outputs
    with closing(solve_rows(row_cuts, parameters, *solver, progress, e, soft, row_work)) as blocks:
        begin = 0
        for stop, solved in blocks:
            block_parameters = parameters(begin, stop)
            yield _label(
                grid, row_start + begin, numbers(begin, stop), block_parameters, solved, accuracy, harmonics,
                attrs, requested_outputs,
            )  # fmt: skip
            begin = stop


def effects_of_grid(
    grid: SweepGrid, start: tuple[float | None, float], effects: Sequence[str] | None
) -> tuple[Effects, bool]:
    """Return the effects of the kernel of a sweep, and whether any support is soft; arguments as of `solve_blocks`.

    They follow from the whole grid, not from some rows: the kernel must not depend on the cuts.
    """
    values = {**grid.shared, **grid.varied}
    farthest = largest_start(values, start[0]), largest_velocity(values, start[1])
    e = resolve_effects(effects, values, *farthest, followed=grid.follow is not None)
    return e, has_soft_support(values)


def _label(
    grid: SweepGrid,
    start: int,
    numbers: np.ndarray,
    parameters: Sequence[np.ndarray],
    solved: Sequence[RowResults],
    max_error: float | None,
    harmonics: int,
    attrs: Mapping[str, Any],
    outputs: tuple[str, ...],
) -> xr.Dataset:
    """Return solved chains, by their rows, as a dataset over `row`, in the order of the rows of the grid."""
    import xarray as xr

    variables = label_rows(solved[0], parameters[0], outputs)
    if max_error is not None:
        variables = with_error(variables, row_errors(parameters[0], variables), max_error)
    variables |= {
        name: (("row",), parameters[0][:, Parameters._fields.index(name)])
        for name in grid.following
    }
    labels = coordinates(variables, harmonics)
    if grid.ties and PARAMETER in labels:
        free = grid.parameters(grid.ties.free, numbers)
        variables, by = through_ties(variables, grid.ties, free)
        labels = labels.assign({PARAMETER: np.array(by)})
    variables = take_rows(variables, np.argsort(numbers))
    coords = grid.row_coords(np.sort(numbers))
    attrs_of_block = {"row_start": start, "row_stop": start + len(numbers), **attrs}
    block = xr.Dataset(variables | coords, labels, attrs_of_block)
    return describe(block.set_coords(coords))


def assemble(shards: Sequence[xr.Dataset], grid: SweepGrid) -> xr.Dataset:
    """Join shards of `solve_shard`, in any order, into the dataset of the whole sweep, in memory."""
    import xarray as xr

    ordered = sorted(shards, key=lambda shard: shard.attrs["row_start"])
    parts = [
        {str(name): (tuple(map(str, v.dims)), v.values) for name, v in shard.data_vars.items()}
        for shard in ordered
    ]
    flat = take_rows(concatenate(parts), grid.rows_of_points(0, grid.rows))
    variables = {
        name: ((*grid.dims, *dims[1:]), values.reshape((*grid.shape, *values.shape[1:])))
        if dims[0] == "row"
        else (dims, values)
        for name, (dims, values) in flat.items()
    }
    coords: dict[str, Any] = {name: (name, values) for name, values in grid.coords.items()}
    first = ordered[0]
    for name in [str(name) for name in first.coords if name not in grid.dims]:
        # An index is kept; other coordinates are copied as variables, which are faster to build than a DataArray.
        coords[name] = first[name] if name in first.xindexes else first.variables[name]
    attrs = {k: v for k, v in first.attrs.items() if k not in ("row_start", "row_stop")}
    joined = describe(xr.Dataset(variables, coords, attrs))
    if "row_size" in joined:
        joined["row_size"].attrs["sample_dimension"] = "impact"
    return joined
