"""Many rows on all threads: pieces of rows are distributed to threads, each solved by the compiled kernel of a row."""

from __future__ import annotations

import mmap
import threading
from collections import deque
from collections.abc import Callable, Collection, Generator, Sequence
from concurrent.futures import FIRST_EXCEPTION, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import islice, pairwise
from typing import NamedTuple

import numba
import numpy as np

from vibropipe.compiler import jit_nogil
from vibropipe.march.log import new_log
from vibropipe.orbits.outputs import RowResults
from vibropipe.orbits.row import row_parameters, sample_row, solve_row_chains
from vibropipe.physics.effects import ALL_EFFECTS, Effects
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import DEGREE
from vibropipe.physics.start import row_starts
from vibropipe.solve.unsolved import mask_unsolved
from vibropipe.words.outputs import OUTPUTS

# Samples of an orbit of the output `motion`.
PHASES = 256
# Largest number of impacts, and of rests, in an orbit; a row with more is unresolved. The impacts suffice for 32
# forcing periods of 256 impacts each. Memory for them is mapped for every row, but only pages written to are used.
ORBIT_LOG_CAPACITY = 8192
ORBIT_REST_CAPACITY = 512
# Seconds between two progress reports.
PROGRESS_INTERVAL = 0.25

# The solutions of each part of some chains, as a future.
Solving = Future[list[list[RowResults]]]


class ImpactBuffer(NamedTuple):
    """Impacts of rows, each array (ORBIT_LOG_CAPACITY, rows). Most rows have few, so that most pages stay unused."""

    position: np.ndarray
    velocity: np.ndarray
    support: np.ndarray


def _pages(rows: int, kind: type) -> np.ndarray:
    """Return an array (ORBIT_LOG_CAPACITY, rows) that uses memory only where it is written to."""
    # numpy allocates arrays of this size in pages of 2 MB, all of which one row with many impacts would use.
    if rows == 0:
        return np.empty((ORBIT_LOG_CAPACITY, 0), kind)
    pages = mmap.mmap(-1, rows * ORBIT_LOG_CAPACITY * np.dtype(kind).itemsize)
    with suppress(AttributeError, OSError):  # systems without large pages
        pages.madvise(mmap.MADV_NOHUGEPAGE)
    return np.frombuffer(pages, kind).reshape(ORBIT_LOG_CAPACITY, rows)


def new_impact_buffer(rows: int) -> ImpactBuffer:
    """Return a buffer for ORBIT_LOG_CAPACITY impacts of each row."""
    return ImpactBuffer(_pages(rows, float), _pages(rows, float), _pages(rows, np.int8))


NO_IMPACT_BUFFER = new_impact_buffer(0)


def new_rows(n: int, harmonics: int, outputs: tuple[str, ...], buffer: ImpactBuffer) -> RowResults:
    """Return empty results of n rows.

    Parameters
    ----------
    n : int
        Number of rows.
    harmonics : int
        Number of harmonics.
    outputs : tuple of str
        Requested outputs; the arrays of the others have no entries.
    buffer : ImpactBuffer
        Buffer for the impacts of at least n rows, used if impacts are requested.
    """
    requested = {name: name in outputs for name in OUTPUTS}

    def zeros(*shape: int, dtype: type = float, when: str | None = None) -> np.ndarray:
        return np.zeros((n if when is None or requested[when] else 0, *shape), dtype)

    impacts = buffer if requested["impacts"] else NO_IMPACT_BUFFER
    return RowResults(
        regime=np.zeros(n, np.int8),
        frequency=np.zeros(n),
        status=np.zeros(n, np.int8),
        period_multiple=np.zeros(n, np.int32),
        settled_after=np.zeros(n, np.int32),
        window_periods=np.zeros(n, np.int32),
        residual=np.full(n, np.nan),
        section=np.zeros((n, 2)),
        impacts=np.zeros((n, 2)),
        rests=np.zeros((n, 2)),
        amplitudes=zeros(harmonics + 1, dtype=complex, when="harmonics"),
        multipliers=zeros(2, dtype=complex, when="stability"),
        impact_count=zeros(dtype=np.int64, when="impacts"),
        impact_position=impacts.position,
        impact_velocity=impacts.velocity,
        impact_support=impacts.support,
        impact_velocity_max=zeros(2, when="impacts"),
        energy=zeros(4, when="energy"),
        motion=zeros(2, PHASES, when="motion"),
    )


@jit_nogil
def solve_piece(
    e: Effects,
    parameters: np.ndarray,
    starts: np.ndarray,
    chain_length: int,
    max_periods: int,
    patience: int,
    out: RowResults,
) -> None:
    """Solve rows in chains with a log of their own; parameters as for `orbits.row.solve_row_chains`."""
    log, c = new_log(ORBIT_LOG_CAPACITY, ORBIT_REST_CAPACITY), np.empty(DEGREE + 1)
    solve_row_chains(e, parameters, starts, chain_length, max_periods, patience, log, c, out)


@jit_nogil
def _sample(
    e: Effects,
    parameters: np.ndarray,
    section: np.ndarray,
    multiple: np.ndarray,
    motion: np.ndarray,
) -> None:
    """Sample closed orbits of period multiples (rows,) from their sections (rows, 2); multiple 0 skips a row."""
    log, c = new_log(ORBIT_LOG_CAPACITY, ORBIT_REST_CAPACITY), np.empty(DEGREE + 1)
    for row in range(parameters.shape[0]):
        if multiple[row] > 0:
            x, v = section[row, 0], section[row, 1]
            p = row_parameters(parameters, row)
            sample_row(e, p, x, v, multiple[row], log, c, motion, row)


@dataclass
class _Solver:
    """Solves pieces of rows on several threads, each with an impact buffer of its own."""

    parameters: Callable[[int, int], Sequence[np.ndarray]]
    start: tuple[float | None, float]
    chain_length: int
    max_periods: int
    patience: int
    harmonics: int
    outputs: tuple[str, ...]
    effects: Effects
    buffer_rows: int
    of_thread: threading.local = field(default_factory=threading.local)

    def solve(self, values: np.ndarray, seeds: np.ndarray) -> RowResults:
        """Return the compacted results of parameters (rows, 7) from starts (rows, 2)."""
        # Each thread keeps its buffer: the first use of a page costs more than a row.
        if not hasattr(self.of_thread, "buffer"):
            self.of_thread.buffer = new_impact_buffer(self.buffer_rows)
        out = new_rows(len(values), self.harmonics, self.outputs, self.of_thread.buffer)
        chain = max(1, min(self.chain_length, len(values)))
        solve_piece(self.effects, values, seeds, chain, self.max_periods, self.patience, out)
        if "motion" in self.outputs:
            # Rows in closed form, which are not marched, have their samples already.
            marched = np.where(out.settled_after > 0, out.period_multiple, 0)
            _sample(self.effects, values, out.section, marched, out.motion)
        return mask_unsolved(compact_impacts(out))

    def piece(self, ends: Sequence[int]) -> list[list[RowResults]]:
        """Solve whole chains, or the consecutive parts of one; return the solutions of each part."""
        solved: list[list[RowResults]] = []
        for first, stop in pairwise(ends):
            parameter_sets = self.parameters(first, stop)
            seeds = [row_starts(values, *self.start) for values in parameter_sets]
            if solved:  # the chain continues
                for seed, before in zip(seeds, solved[-1], strict=True):
                    seed[0] = before.section[-1]
            solved.append([self.solve(*each) for each in zip(parameter_sets, seeds, strict=True)])
        return solved


def solve_rows(
    blocks: Sequence[Sequence[Sequence[int]]],
    parameters: Callable[[int, int], Sequence[np.ndarray]],
    start: tuple[float | None, float],
    chain_length: int,
    max_periods: int,
    patience: int,
    harmonics: int,
    outputs: tuple[str, ...],
    progress: Callable[[int], None] | None = None,
    effects: Effects = ALL_EFFECTS,
) -> Generator[tuple[int, list[RowResults]]]:
    """Solve rows in blocks on all threads of numba.

    The result is bitwise the same for any number of threads. While the caller handles a block the threads solve the
    next, and no further ones.

    Parameters
    ----------
    blocks : sequence
        The blocks and their pieces (`solve.sweep_grid.row_blocks`).
    parameters : callable
        parameters(first, stop) returns a list of arrays (stop - first, 7), one for each solution computed side by
        side.
    start : (float or None, float)
        x0 and v0 of the first row of each chain (`row_starts`).
    chain_length : int
        Rows per chain.
    max_periods, patience : int
        Limits of `orbits.settling.find_steady_state`, in forcing periods.
    harmonics : int
        Number of harmonics.
    outputs : tuple of str
        Requested outputs.
    progress : callable, optional
        Called as progress(rows solved).
    effects : Effects
        Effects of the compiled kernel, the same for all rows.

    Yields
    ------
    (int, list of RowResults)
        The end of a block and its solutions, in order.
    """
    pieces = [ends for block in blocks for ends in block]
    buffer_rows = max(stop - first for ends in pieces for first, stop in pairwise(ends))
    limits = chain_length, max_periods, patience
    solver = _Solver(parameters, start, *limits, harmonics, outputs, effects, buffer_rows)
    n_threads = numba.get_num_threads()
    if n_threads == 1:
        for block in blocks:
            parts: list[list[RowResults]] = []
            for ends in block:
                parts += solver.piece(ends)
                if progress is not None:
                    progress(ends[-1])
            yield block[-1][-1], concatenate_solutions(parts)
        return
    # Compile or load the kernel once, before several threads request it.
    solver.solve(np.empty((0, len(Parameters._fields))), np.empty((0, 2)))
    pool = ThreadPoolExecutor(n_threads)
    unstarted, waiting = iter(pieces), deque[Solving]()
    try:
        for block in blocks:
            # Enough pieces of this block and the next that no thread waits, however few a block has.
            limit = 2 * max(len(block), n_threads)
            for ends in islice(unstarted, limit - len(waiting)):
                waiting.append(pool.submit(solver.piece, ends))
            block_pieces = [waiting.popleft() for _ in block]
            yield block[-1][-1], gather_block(block_pieces, block, progress)
    finally:  # also if the caller stops, and on Ctrl-C: pieces not yet started are cancelled
        pool.shutdown(cancel_futures=True)


def gather_block(
    pieces: list[Solving],
    block: Sequence[Sequence[int]],
    progress: Callable[[int], None] | None,
) -> list[RowResults]:
    """Wait for the pieces of a block and return its solutions. The list of pieces is emptied to free their memory."""
    unfinished: Collection[Solving] = pieces
    # Wait for all pieces at once: waking up for each takes time from the solving threads.
    while unfinished:
        done, unfinished = wait(pieces, PROGRESS_INTERVAL, FIRST_EXCEPTION)
        for piece in done:
            piece.result()  # raises the exception of the thread
        if progress is not None:
            solved_ends = (ends for piece, ends in zip(pieces, block, strict=True) if piece in done)
            progress(block[0][0] + sum(ends[-1] - ends[0] for ends in solved_ends))
    parts = [part for piece in pieces for part in piece.result()]
    pieces.clear()
    return concatenate_solutions(parts)


def concatenate_solutions(parts: Sequence[Sequence[RowResults]]) -> list[RowResults]:
    """Join the solutions of the parts of a block, in order."""
    return [
        RowResults(*map(np.concatenate, zip(*each, strict=True)))
        for each in zip(*parts, strict=True)
    ]


def compact_impacts(out: RowResults) -> RowResults:
    """Return the results with impacts as flat arrays in the order of rows (contiguous ragged arrays)."""
    sizes = out.impact_count
    if sizes.size == 0:
        return out
    row = np.repeat(np.arange(sizes.size), sizes)
    index = np.arange(row.size) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    return out._replace(
        impact_position=out.impact_position[index, row],
        impact_velocity=out.impact_velocity[index, row],
        impact_support=out.impact_support[index, row],
    )
