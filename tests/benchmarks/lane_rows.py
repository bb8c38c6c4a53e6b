"""Many motions by Newmark's method, marched in lockstep on the vector units, and what is timed of them."""

from __future__ import annotations

import math
import time
from functools import partial

import llvmlite.binding as llvm
import numba
import numpy as np
from newmark_lanes import SIZE, STATE, STRIDE, WIDTH, LaneInput, LaneResult, LaneWork, march_block
from numba import prange

from vibropipe.compiler import jit_parallel
from vibropipe.lab.bench import Candidate, Item, PreparedRun, Target
from vibropipe.lab.bench_items import FORCED, STEPS, limit_threads, textbook_run
from vibropipe.lab.timing import repeated
from vibropipe.lab.work_precision import build
from vibropipe.lab.work_precision_methods import BenchmarkMotion
from vibropipe.march.grid import grid_time
from vibropipe.march.log import COUNTS, IMPACTS, RESTS, SHORT_FLIGHTS, Log
from vibropipe.march.state import REST
from vibropipe.orbits.row import LOAD
from vibropipe.physics.effects import ALL_EFFECTS, Effects
from vibropipe.physics.load_steps import sincos_tables
from vibropipe.solve.rows.row_results import from_equilibrium
from vibropipe.words.status import Status

# Rows that are timed, and their forcing periods.
ROWS, ROW_PERIODS = 128, 50
# Capacity of the log of a row: a constant part, a part for each forcing period, and the factor by which it grows for
# rows that exceed it.
FIRST_CAPACITY, CAPACITY_PER_PERIOD, CAPACITY_GROWTH = 64, 6, 4
# Capacity of all logs of one call in contacts, which bounds its memory to about 80 MB.
MAX_CAPACITY = 2_000_000
# Columns of a log by the index of their count.
COLUMNS = {
    IMPACTS: ("position", "velocity", "impulse", "support"),
    RESTS: ("rest_start", "rest_end", "rest_support"),
}


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
        By row `displacement_end`, `velocity_end` and `status`, as of `simulate`, and the numbers `row_size` of impacts
        and `row_rests` of rests; the others are those of all impacts and of all rests, row by row.

    Notes
    -----
    Each row is bitwise equal to the motion of `simulate(..., method="newmark")`: WIDTH rows are marched in lockstep,
    and all threads share the blocks. Rows with similar numbers of forcing periods form a block. Rigid supports, load
    and one harmonic are known here.
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


def newmark_item() -> Item:
    """Return the item of Newmark's method on one thread: rows in lanes, row by row, and as a textbook loop."""
    return Item(
        "newmark in lanes",
        f"h, nu, f, l, R within 5 % of the above in {ROWS} rows, {STEPS} steps per period, two impacts in each",
        "step and row",
        [
            # kernels run on threads of numba, whose time must count
            Candidate("in lanes", lanes_run, time.process_time),
            Candidate("one by one", scalar_run),
            Candidate(
                "textbook loop", partial(textbook_run, FORCED, ROW_PERIODS, ROW_PERIODS * STEPS)
            ),
        ],
        [Target("in lanes", "textbook loop", 6 if has_avx512() else 3)],
    )


def has_avx512() -> bool:
    """Return whether a vector register of the target processor holds eight floats, not four or two."""
    features = numba.config.CPU_FEATURES  # type: ignore[attr-defined]
    if features is None:  # NUMBA_CPU_FEATURES is unset: the features of this processor apply
        features = llvm.get_host_cpu_features().flatten()
    return "+avx512f" in features.split(",")


def random_parameters() -> np.ndarray:
    """Return the parameters of exciters, in rows, within 5 % of the forced one, equilibrium in the middle."""
    rows = np.tile(FORCED.parameters(), (ROWS, 1))
    rows[:, :7] *= 1.0 + np.random.default_rng(0).uniform(-0.05, 0.05, (ROWS, 7))
    return rows


def lanes_run() -> PreparedRun:
    """Return the run of all rows in lanes on one thread, impacts recorded."""
    parameters, starts = random_parameters(), np.zeros((ROWS, 2))
    turns = np.full(ROWS, float(ROW_PERIODS))
    march = partial(march_rows, parameters, starts, turns, STEPS, 10**6)
    return PreparedRun(limit_threads(1)(repeated(march)), ROWS * ROW_PERIODS * STEPS)


def scalar_run() -> PreparedRun:
    """Return the run of one row by the scalar kernel, which computes the same motion."""
    candidate = build("newmark", STEPS, BenchmarkMotion(FORCED, 0.0, 0.0, ROW_PERIODS))
    candidate.show()
    return PreparedRun(candidate.repeat, ROW_PERIODS * STEPS)
