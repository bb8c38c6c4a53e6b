"""Rows of a sweep, solved in blocks and joined: datasets over `row`, and of the whole grid."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.orbits.results import RowResults
from vibropipe.physics import limits
from vibropipe.physics.effects import Effects, effect_names, has_soft_support, resolve_effects
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.start import largest_start, largest_velocity, start_text
from vibropipe.solve.accuracy.orbit_errors import row_errors, with_error
from vibropipe.solve.checks import check_accuracy_of_housing, check_outputs
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.solve.rows.label import concatenate, coordinates, label_rows, take_rows
from vibropipe.solve.rows.many import RowLimits, Rows, solve_rows
from vibropipe.solve.rows.sensitivity import through_ties
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.solve.sweep.sweep_starts import starts_of_rows
from vibropipe.solve.threads import row_blocks
from vibropipe.words.outputs import SWEEP_DEFAULT
from vibropipe.words.progress import Progress
from vibropipe.words.vocabulary import PARAMETER, describe

if TYPE_CHECKING:
    import xarray as xr


# Largest number of forcing periods marched for a row.
MAX_PERIODS = limits.PATIENCE[1]
# Forcing periods after which a row of a sweep may be left as chaotic.
PATIENCE = 200
LIMITS = RowLimits(MAX_PERIODS, PATIENCE)


def solve_shard(grid: SweepGrid, row_start: int, row_stop: int, **options: Any) -> xr.Dataset:
    """Solve the rows [row_start, row_stop) of a sweep over the dimension `row`; arguments as of `solve_blocks`."""
    rows = range(row_start, row_stop)
    (shard,) = solve_blocks(grid, rows, len(rows), **options)
    return shard


def solve_blocks(
    grid: SweepGrid,
    rows: range | np.ndarray,
    block_rows: int,
    start: tuple[float | None, float] = (None, 0.0),
    harmonics: int = 3,
    outputs: Sequence[str] = SWEEP_DEFAULT,
    progress: Progress | None = None,
    accuracy: float | None = None,
    effects: Sequence[str] | None = None,
    limits: RowLimits = LIMITS,
) -> Generator[xr.Dataset]:
    """Solve rows of a sweep in blocks, one after the other.

    A block is computed when it is requested, and few rows are solved ahead of it. The arguments have been checked.
    Yields quantities over the dimension `row`; coordinates are the swept parameters over `row` and the others as
    scalars.

    rows : range of the rows, whole chains, on whose cuts results do not depend; or (n,) int, those that are solved, in
        their order, of a grid that follows none
    block_rows : least number of rows per block
    start : x0 and v0, of those that are not swept
    harmonics, outputs, accuracy, effects : as for `sweep`
    progress : called as progress(done, total), in the rows that are solved
    Raises ParameterError if `effects` leaves out an effect that the parameters have.
    """
    requested_outputs = check_outputs(outputs)
    values = {**grid.shared, **grid.varied}
    e, soft = effects_of_grid(grid, start, effects)
    check_accuracy_of_housing(e.housing, accuracy)
    attrs = origin_attrs(effect_names(e, values), start_text(values, *start), follow=grid.follow)
    attrs |= grid.ties.attrs
    first = rows.start if isinstance(rows, range) else 0

    def numbers(begin: int, stop: int) -> np.ndarray:
        if isinstance(rows, range):
            return grid.solved(first + begin, first + stop)
        return rows[begin:stop]

    def parameters(begin: int, stop: int) -> list[np.ndarray]:
        return [grid.parameters(Parameters._fields, numbers(begin, stop))]

    row_cuts = row_blocks(len(rows), grid.chain_length, block_rows)
    chains = Rows(parameters, starts_of_rows(grid, *start, numbers), grid.chain_length)
    solver = limits, harmonics, requested_outputs, progress, e, soft
    with closing(solve_rows(row_cuts, chains, *solver)) as blocks:
        begin = 0
        for stop, solved in blocks:
            block_parameters = parameters(begin, stop)
            yield _label(
                grid, first + begin, numbers(begin, stop), block_parameters, solved, accuracy, harmonics,
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
    return describe(xr.Dataset(variables, coords, attrs))
