"""Many rows on all threads: pieces of rows are distributed to threads, each solved by the compiled kernel of a row."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import Any, NamedTuple

import numba
import numpy as np

from vibropipe.compiler import jit_nogil
from vibropipe.march.log import limit_work, new_log, work_of
from vibropipe.march.piece_log import PieceLog, piece_log_of
from vibropipe.orbits.housing import STROBE
from vibropipe.orbits.results import RowResults
from vibropipe.orbits.room import new_room
from vibropipe.orbits.row import LOAD, row_parameters, solve_row_chains
from vibropipe.orbits.samples import sample_row, sample_sections
from vibropipe.orbits.sensitivity.errors import with_errors
from vibropipe.orbits.sensitivity.law_rows import with_errors_of_pieces
from vibropipe.orbits.sensitivity.rows import differentiate_rows, with_impact_derivatives
from vibropipe.orbits.undamped import is_undamped_row, sample_undamped
from vibropipe.physics.effects import ALL_EFFECTS, Effects, kernel_effects
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import DEGREE
from vibropipe.physics.limits import MAX_ROW_WORK
from vibropipe.physics.load import largest_force
from vibropipe.physics.start import row_starts
from vibropipe.solve.rows.row_results import (
    ORBIT_LOG_CAPACITY,
    ORBIT_REST_CAPACITY,
    acting_rows,
    add_load,
    compact_impacts,
    concatenate_solutions,
    contact_columns,
    from_equilibrium,
    new_impact_buffer,
    new_rows,
    without_impacts,
)
from vibropipe.solve.rows.unsolved import mask_unsolved
from vibropipe.solve.threads import Calls, Threads
from vibropipe.words.outputs import computed
from vibropipe.words.progress import Progress

# Seconds between two progress reports.
PROGRESS_INTERVAL = 0.25

# The solutions of each part of some chains, for each piece of a block.
Solving = Calls[list[list[RowResults]]]
# x0, v0 and, if it is not 0, the velocity of the housing, of all rows or as arrays (rows,).
Start = tuple[Any, ...]


class Rows(NamedTuple):
    """Rows that are solved in chains, each from where the row before ends.

    parameters : parameters(first, stop) returns a list of arrays (stop - first, 7), one for each solution computed side
        by side
    start : x0 and v0 of the first row of each chain (`row_starts`), and the velocity of a housing (default: 0); if they
        differ, start(first, stop) returns those of rows, numbered as for `parameters`
    chain_length : rows per chain
    """

    parameters: Callable[[int, int], Sequence[np.ndarray]]
    start: Start | Callable[[int, int], Start]
    chain_length: int = 1


class RowLimits(NamedTuple):
    """Limits of a row.

    max_periods, patience : those of `orbits.settling.find_steady_state`, in forcing periods
    row_work : largest work of a march, in steps
    """

    max_periods: int
    patience: int
    row_work: int = MAX_ROW_WORK


@jit_nogil
def solve_piece(
    e: Effects,
    parameters: np.ndarray,
    starts: np.ndarray,
    chain_length: int,
    limits: RowLimits,
    out: RowResults,
    pieces: PieceLog | None,
    plain: int | None,
) -> int:
    """Solve rows in chains with a log of their own, and return their work; as `orbits.row.solve_row_chains`."""
    log = new_log(ORBIT_LOG_CAPACITY, ORBIT_REST_CAPACITY, pieces, plain)
    limit_work(log, limits.row_work, 0)
    room = new_room(e, log, limits.max_periods, out)
    solve_row_chains(e, parameters, starts, chain_length, limits, room, out)
    return work_of(log)


@jit_nogil
def _sample(
    e: Effects, parameters: np.ndarray, out: RowResults, pieces: PieceLog | None, plain: int | None
) -> None:
    """Sample closed orbits from their sections: `motion` and `poincare` of the results, if requested."""
    log, c = new_log(ORBIT_LOG_CAPACITY, ORBIT_REST_CAPACITY, pieces, plain), np.empty(DEGREE + 1)
    for row in range(parameters.shape[0]):
        m = np.int64(out.period_multiple[row])
        if m > 0:
            x, v = out.section[row, 0], out.section[row, 1]
            velocity = out.housing[row, STROBE] if out.housing.size > 0 else 0.0
            p = row_parameters(parameters, row)
            is_undamped = is_undamped_row(e, p, x, v, out.regime[row], m)
            if is_undamped and largest_force(p) > 0.0:
                sample_undamped(p, x, v, out.motion, out.poincare, row)
                continue
            # Rows in closed form have the samples of their motion already.
            if out.motion.size > 0 and out.settled_after[row] > 0 and not is_undamped:
                sample_row(e, p, x, v, velocity, m, log, c, out.motion, row)
            if out.poincare.size > 0:
                sample_sections(e, p, x, v, velocity, m, log, c, out.poincare, row)


@dataclass
class _Solver:
    """Solves pieces of rows on several threads, each with an impact buffer of its own."""

    rows: Rows
    limits: RowLimits
    harmonics: int
    outputs: tuple[str, ...]
    effects: Effects
    buffer_rows: int
    contacts: int
    spent: list[int]
    of_thread: threading.local = field(default_factory=threading.local)

    def solve(self, values: np.ndarray, seeds: np.ndarray) -> RowResults:
        """Return the compacted results of parameters (rows, parameters) from starts (rows, 3)."""
        # Each thread keeps its buffer: the first use of a page costs more than a row.
        if not hasattr(self.of_thread, "buffer"):
            self.of_thread.buffer = new_impact_buffer(self.buffer_rows)
        pieces = piece_log_of(self.effects, ORBIT_LOG_CAPACITY)
        # The error of an orbit follows from its impacts, requested or not, so they always have room.
        buffer = self.of_thread.buffer
        out = new_rows(len(values), self.harmonics, self.outputs, buffer, self.effects)
        load = values[:, LOAD]
        chain = max(1, min(self.rows.chain_length, len(values)))
        starts = from_equilibrium(np.ascontiguousarray(seeds[:, :2]), load)
        if out.housing.size > 0:
            out.housing[:, STROBE] = seeds[:, 2]
        spent = solve_piece(self.effects, values, starts, chain, self.limits, out, *pieces)
        self.spent.append(spent)
        if {"motion", "poincare"} & {*self.outputs}:
            _sample(self.effects, values, out, *pieces)
        compact, second = mask_unsolved(compact_impacts(out)), self.effects.second_harmonic
        if pieces[0] is not None:
            room = pieces[0], self.contacts, self.spent
            rows = with_errors_of_pieces(compact, values, self.effects, *room)
        else:
            rows = with_errors(compact, values, ORBIT_LOG_CAPACITY, second)
            if "sensitivity" in self.outputs:
                rows = with_impact_derivatives(rows)
                differentiate_rows(values, rows, ORBIT_LOG_CAPACITY, second)
        add_load(rows, load)
        return rows if "impacts" in computed(self.outputs) else without_impacts(rows)

    def piece(self, ends: Sequence[int]) -> list[list[RowResults]]:
        """Solve whole chains, or the consecutive parts of one; return the solutions of each part."""
        solved: list[list[RowResults]] = []
        for first, stop in pairwise(ends):
            parameter_sets = [acting_rows(values) for values in self.rows.parameters(first, stop)]
            start = self.rows.start
            start = start(first, stop) if callable(start) else start
            seeds = [
                _with_housing(row_starts(values, *start[:2]), *start[2:])
                for values in parameter_sets
            ]
            if solved:  # the chain continues
                for seed, before in zip(seeds, solved[-1], strict=True):
                    seed[0, :2] = before.section[-1]
                    if before.housing.size > 0:
                        seed[0, 2] = before.housing[-1, STROBE]
            solved.append([self.solve(*each) for each in zip(parameter_sets, seeds, strict=True)])
        return solved


def _with_housing(starts: np.ndarray, velocity: Any = 0.0) -> np.ndarray:
    """Return starts (rows, 2) with the velocity of a housing, (rows, 3)."""
    return np.column_stack([starts, np.broadcast_to(velocity, len(starts))])


def solve_rows(
    blocks: Sequence[Sequence[Sequence[int]]],
    rows: Rows,
    limits: RowLimits,
    harmonics: int,
    outputs: tuple[str, ...],
    progress: Progress | None = None,
    effects: Effects = ALL_EFFECTS,
    soft: bool = False,
    spent: list[int] | None = None,
) -> Generator[tuple[int, list[RowResults]]]:
    """Solve rows in blocks on all threads of numba.

    The result is bitwise the same for any number of threads. While the caller handles a block the threads solve the
    next, and no further ones. Yields the end of a block and its solutions, in order.

    blocks : the blocks and their pieces (`solve.threads.row_blocks`)
    progress : called as progress(done, total), in rows
    effects : of the compiled kernel, the same for all rows
    soft : whether any exciter, of these rows or others beside them, has a soft support: impacts then have the columns
        of contacts
    spent : receives the work of some rows at a time
    """
    pieces = [ends for block in blocks for ends in block]
    n_rows = pieces[-1][-1]
    buffer_rows = max(stop - first for ends in pieces for first, stop in pairwise(ends))
    is_soft = soft and effects.soft is not None and effects.housing is None
    contacts = contact_columns(outputs) if is_soft else 0
    room, spent = (buffer_rows, contacts), [] if spent is None else spent
    solver = _Solver(rows, limits, harmonics, outputs, kernel_effects(effects), *room, spent)
    n_threads = numba.get_num_threads()
    if n_threads == 1 or len(pieces) == 1:
        for block in blocks:
            parts: list[list[RowResults]] = []
            for ends in block:
                parts += solver.piece(ends)
                if progress is not None:
                    progress(ends[-1], n_rows)
            yield block[-1][-1], concatenate_solutions(parts)
        return
    # Compile or load the kernel once, before several threads request it.
    solver.solve(np.empty((0, len(Parameters._fields))), np.empty((0, 3)))
    threads, waiting = Threads(n_threads), deque[Solving]()
    unstarted = iter(blocks)
    try:
        for block in blocks:
            # Enough pieces of this block and the next that no thread waits, however few a block has.
            limit = 2 * max(len(block), n_threads)
            while sum(len(calls.results) for calls in waiting) < limit and (
                following := next(unstarted, None)
            ):
                waiting.append(threads.submit([partial(solver.piece, ends) for ends in following]))
            yield block[-1][-1], _gather(waiting.popleft(), block, progress, n_rows)
    finally:  # also if the caller stops, and on Ctrl-C
        threads.stop()


def _gather(
    calls: Solving, block: Sequence[Sequence[int]], progress: Progress | None, n_rows: int
) -> list[RowResults]:
    """Wait for the pieces of a block and return its solutions."""
    # Wait for all pieces at once: waking up for each takes time from the solving threads.
    while not calls.is_over:
        calls.wait(PROGRESS_INTERVAL)
        if progress is not None:
            pairs = zip(calls.results, block, strict=True)
            solved = sum(ends[-1] - ends[0] for piece, ends in pairs if piece is not None)
            progress(block[0][0] + solved, n_rows)
    return concatenate_solutions([part for piece in calls.take() for part in piece])
