"""Many motions by Newmark's method, marched in lockstep on the vector units: `simulate_rows`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import prange

from vibropipe.compiler import jit_parallel
from vibropipe.lab.lanes import STATE, LaneInput, LaneResult, LaneWork, march_block
from vibropipe.march.grid import grid_time
from vibropipe.march.log import COUNTS, IMPACTS, RESTS, SHORT_FLIGHTS, Log
from vibropipe.march.newmark_steps import SIZE, STRIDE, WIDTH
from vibropipe.march.state import REST
from vibropipe.orbits.row import LOAD
from vibropipe.physics.effects import ALL_EFFECTS, Effects, all_effects
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.load_steps import sincos_tables
from vibropipe.solve.checks import span_in_turns
from vibropipe.solve.motion.simulate import check_steps
from vibropipe.solve.rows.row_results import columns_of, from_equilibrium
from vibropipe.words.parameters import FURTHER
from vibropipe.words.status import Status
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

# Capacity of the log of a row: a constant part, a part for each forcing period, and the factor by which it grows for
# rows that exceed it.
FIRST_CAPACITY, CAPACITY_PER_PERIOD, CAPACITY_GROWTH = 64, 6, 4
# Capacity of all logs of one call in contacts, which bounds its memory to about 80 MB.
MAX_CAPACITY = 2_000_000
# Columns of a log by the index of their count.
F2 = Parameters._fields.index("f2")
COLUMNS = {
    IMPACTS: ("position", "velocity", "impulse", "support"),
    RESTS: ("rest_start", "rest_end", "rest_support"),
}


def simulate_rows(
    exciters: Sequence[Exciter],
    tau_end: Any,
    x0: Any = None,
    v0: Any = 0.0,
    *,
    steps_per_period: int,
    max_impacts: int = 1_000_000,
) -> xr.Dataset:
    """Solve eqs. (5), (6) for many exciters from (x0, v0) at tau = 0 to tau_end by Newmark's method.

    Parameters
    ----------
    exciters : sequence of Exciter
        One per row.
    tau_end, x0, v0 : float or array_like
        A number for all rows, or one per row; x0 defaults as in `simulate`.
    steps_per_period : int
        Steps per forcing period.
    max_impacts : int
        Limit of contacts of a row. A row that exceeds it has status `max_impacts`, an end of nan, and the contacts up
        to the limit.

    Returns
    -------
    xarray.Dataset
        Over `row` (all non-dimensional) the parameters as coordinates, `displacement_end`, `velocity_end` and
        `status` (as of `simulate`); `impact_tau`, `impact_support`, `impact_velocity`, `impact_velocity_after` over
        `impact`, a contiguous ragged array with `row_size` impacts of each row; `rest_start`, `rest_end`,
        `rest_support` over `rest`, `row_rests` of each row.

    Raises
    ------
    ParameterError
        If a value is out of range, a sequence has another length than exciters, or an exciter has soft supports,
        friction or a second harmonic.

    Notes
    -----
    Each row is bitwise equal to the motion of `simulate(..., method="newmark")` and several times faster: WIDTH rows
    are marched in lockstep, and all threads share the blocks. Rows with similar numbers of forcing periods form a
    block.
    """
    import xarray as xr

    steps = check_steps(steps_per_period)
    rows = len(exciters)
    if rows == 0:
        raise ParameterError("exciters", exciters, must="must have at least one entry")
    if not isinstance(max_impacts, (int, np.integer)) or max_impacts < 0:
        raise ParameterError("max_impacts", max_impacts, "a whole number >= 0")
    ends, xs, vs = (
        _per_row(name, value, rows)
        for name, value in (("tau_end", tau_end), ("x0", x0), ("v0", v0))
    )
    starts = np.array([e.check_start(x, v) for e, x, v in zip(exciters, xs, vs, strict=True)])
    turns = np.array([span_in_turns(e, 0.0, end)[1] for e, end in zip(exciters, ends, strict=True)])
    parameters = np.array([e.parameters() for e in exciters])
    if all_effects(columns_of(parameters)).second_harmonic is not None:
        raise ParameterError("f2", parameters[:, F2], must="must be 0 for rows in lockstep", got="")
    columns = march_rows(parameters, starts, turns, steps, max_impacts)
    variables = {name: (_dim_of(name), values) for name, values in columns.items()}
    coords = {
        name: ("row", parameters[:, i])
        for i, name in enumerate(Parameters._fields)
        if name not in FURTHER or parameters[:, i].any()
    }
    return describe(xr.Dataset(variables, coords))


def _dim_of(name: str) -> str:
    """Return the dimension of a variable of the dataset."""
    first = name.partition("_")[0]
    return first if first in ("impact", "rest") else "row"


def _per_row(name: str, value: Any, rows: int) -> np.ndarray:
    """Return a value for each row, from a number or one per row."""
    array = np.asarray(value)
    if array.ndim > 1 or (array.ndim == 1 and array.size != rows):
        allowed = f"a number, or one for each of {rows} exciters"
        raise ParameterError(name, value, allowed, got=f"shape {array.shape}")
    return np.broadcast_to(array, rows)


def march_rows(
    parameters: np.ndarray,
    starts: np.ndarray,
    turns: np.ndarray,
    steps: int,
    max_impacts: int,
    effects: Effects = ALL_EFFECTS,
) -> dict[str, np.ndarray]:
    """March rows by Newmark's method; rows whose logs overflow are repeated with larger logs.

    Parameters
    ----------
    parameters : (rows, parameters) ndarray of float
        Parameters of each row, in the order of `PARAMETERS`.
    starts : (rows, 2) ndarray of float
        Displacement and velocity at tau = 0.
    turns : (rows,) ndarray of float
        Ends, in forcing periods.
    steps : int
        Steps per forcing period.
    max_impacts : int
        Limit of contacts of a row.
    effects : Effects
        Effects of the kernel.

    Returns
    -------
    dict of str to ndarray
        The variables of `simulate_rows`.
    """
    ends = np.array([grid_time(turn, steps) for turn in turns], float)
    starts = from_equilibrium(starts, parameters[:, LOAD])
    sines, cosines = sincos_tables(effects, steps)
    shared = (steps, max_impacts, sines, cosines, np.zeros((0, 0)))
    finished: list[dict[str, np.ndarray]] = []
    waiting = np.argsort(turns, kind="stable")
    capacity = int(FIRST_CAPACITY + CAPACITY_PER_PERIOD * min(turns.max(), max_impacts))
    while waiting.size:
        unfinished = []
        per_call = max(1, MAX_CAPACITY // capacity // WIDTH) * WIDTH
        for first in range(0, waiting.size, per_call):
            rows_of_call = waiting[first : first + per_call]
            results, logs = _empty_results(len(rows_of_call), capacity)
            _drive(
                effects,
                LaneInput(
                    parameters[rows_of_call], starts[rows_of_call], ends[rows_of_call], *shared
                ),
                results,
                logs,
            )
            is_full = results.status == Status.LOG_FULL
            unfinished.append(rows_of_call[is_full])
            finished.append(_compact(rows_of_call, results, logs, ~is_full))
        waiting, capacity = np.concatenate(unfinished), capacity * CAPACITY_GROWTH
    columns = {name: np.concatenate([part[name] for part in finished]) for name in finished[0]}
    ordered = _in_order(columns, 2 * math.pi / parameters[:, 0])
    ordered["displacement_end"] -= 0.0 - parameters[:, LOAD]
    return ordered


def _empty_results(rows: int, capacity: int) -> tuple[LaneResult, Log]:
    """Return empty results and logs of `rows` rows."""

    def zeros(kind: type = float, share: int = 1) -> np.ndarray:
        return np.zeros((rows, capacity // share), kind)

    logs = Log(
        zeros(), zeros(), zeros(), zeros(np.int8), zeros(share=4), zeros(share=4),
        zeros(np.int8, 4), zeros(share=4), zeros(np.int8, 4), np.zeros((rows, COUNTS), np.int64),
    )  # fmt: skip
    return LaneResult(np.zeros((rows, 2)), np.zeros((rows, STATE)), np.zeros(rows, np.int64)), logs


@jit_parallel
def _drive(e: Effects, inputs: LaneInput, results: LaneResult, logs: Log) -> None:
    """March all rows, each block on one thread."""
    rows = inputs.parameters.shape[0]
    for index in prange((rows + WIDTH - 1) // WIDTH):
        scratch = LaneWork(np.empty(SIZE), np.empty(2 * STRIDE), np.empty(3))
        march_block(e, inputs, results, logs, scratch, index * WIDTH)


def _compact(
    rows: np.ndarray, results: LaneResult, logs: Log, keep: np.ndarray
) -> dict[str, np.ndarray]:
    """Return state, status, counts and flattened logs of the rows to keep.

    "row" and "row_of_<count>" hold the row of each entry.
    """
    counts = logs.counts[keep]
    columns = {name: getattr(results, name)[keep] for name in LaneResult._fields}
    columns |= {"row": rows[keep], "counts": counts}
    for count_index, names in COLUMNS.items():
        columns[f"row_of_{count_index}"] = np.repeat(columns["row"], counts[:, count_index])
        for name in names:
            column = getattr(logs, name)[keep]
            columns[name] = column[np.arange(column.shape[1]) < counts[:, count_index, None]]
    return columns


def _in_order(columns: dict[str, np.ndarray], period: np.ndarray) -> dict[str, np.ndarray]:
    """Return all motions in the order of rows, by the names of the dataset, with rests that continue at the end."""
    permutation = np.argsort(columns["row"])
    state, counts, status, end = (
        columns[name][permutation] for name in ("state", "counts", "status", "end")
    )
    is_short = (status == Status.OK) & (counts[:, SHORT_FLIGHTS] > 0)
    end[~np.isin(status, (Status.OK, Status.SHORT_FLIGHTS))] = math.nan
    status[is_short] = Status.SHORT_FLIGHTS
    resting = np.flatnonzero(state[:, 6] == REST)
    open_rests = (state[resting, 7], np.full(resting.size, math.inf), state[resting, 3], resting)
    for name, values in zip((*COLUMNS[RESTS], f"row_of_{RESTS}"), open_rests, strict=True):
        columns[name] = np.append(columns[name], values.astype(columns[name].dtype))
    for count_index, names in COLUMNS.items():
        by_row = np.argsort(columns[f"row_of_{count_index}"], kind="stable")
        columns |= {name: columns[name][by_row] for name in (*names, f"row_of_{count_index}")}
    # The log also holds the tail impulses of chatters, which are not impacts.
    is_impact, of_rest = columns["support"] > 0, columns[f"row_of_{RESTS}"]
    of_impact, before = columns[f"row_of_{IMPACTS}"][is_impact], columns["velocity"][is_impact]
    return {
        "displacement_end": end[:, 0],
        "velocity_end": end[:, 1],
        "status": status.astype(np.int8),
        "row_size": np.bincount(of_impact, minlength=period.size),
        "impact_tau": columns["position"][is_impact] * period[of_impact],
        "impact_support": columns["support"][is_impact],
        "impact_velocity": before,
        "impact_velocity_after": before + columns["impulse"][is_impact],
        "row_rests": np.bincount(of_rest, minlength=period.size),
        "rest_start": columns["rest_start"] * period[of_rest],
        "rest_end": columns["rest_end"] * period[of_rest],
        "rest_support": columns["rest_support"],
    }
