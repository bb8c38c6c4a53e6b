"""Many rows on all threads: a driver of a few lines over the kernel of one row."""

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

PHASES = 256
# Impacts, and rests, of an orbit that are kept: a row with more is unresolved. An orbit of 32 forcing periods with
# 256 impacts in each; an array of them for every row of a call is mapped, and only what is written to takes memory.
ORBIT_LOG_CAPACITY = 8192
ORBIT_REST_CAPACITY = 512
# Seconds between two words of progress.
PROGRESS_INTERVAL = 0.25

# Of each part of some chains its solutions, when they are there.
Solving = Future[list[list[RowResults]]]


class ImpactBuffer(NamedTuple):
    """Where the impacts of some rows go, side by side: few rows have many, so that most of it is never touched."""

    position: np.ndarray
    velocity: np.ndarray
    support: np.ndarray


def _pages(rows: int, kind: type) -> np.ndarray:
    """ORBIT_LOG_CAPACITY values of each row; only what is written to takes memory.

    numpy's own arrays of this size come in pages of 2 MB, of which a single row with many impacts would touch all.
    """
    if rows == 0:
        return np.empty((ORBIT_LOG_CAPACITY, 0), kind)
    pages = mmap.mmap(-1, rows * ORBIT_LOG_CAPACITY * np.dtype(kind).itemsize)
    with suppress(AttributeError, OSError):  # where there are no large pages
        pages.madvise(mmap.MADV_NOHUGEPAGE)
    return np.frombuffer(pages, kind).reshape(ORBIT_LOG_CAPACITY, rows)


def new_impact_buffer(rows: int) -> ImpactBuffer:
    """Room for ORBIT_LOG_CAPACITY impacts of each of so many rows."""
    return ImpactBuffer(_pages(rows, float), _pages(rows, float), _pages(rows, np.int8))


NO_IMPACT_BUFFER = new_impact_buffer(0)


def new_rows(n: int, harmonics: int, outputs: tuple[str, ...], buffer: ImpactBuffer) -> RowResults:
    """Empty results of n rows; arrays only for the outputs named. buffer: for the impacts of as many rows, at least,
    if they are asked for."""
    requested = {name: name in outputs for name in OUTPUTS}

    def zeros(*shape: int, kind: type = float, when: str | None = None) -> np.ndarray:
        return np.zeros((n if when is None or requested[when] else 0, *shape), kind)

    listed = buffer if requested["impacts"] else NO_IMPACT_BUFFER
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
        amplitudes=zeros(harmonics + 1, kind=complex, when="harmonics"),
        multipliers=zeros(2, kind=complex, when="stability"),
        impact_count=zeros(kind=np.int64, when="impacts"),
        impact_position=listed.position,
        impact_velocity=listed.velocity,
        impact_support=listed.support,
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
    """Solve parameters (rows, 7) in chains of chain_length rows, each row of a chain seeded by the one before
    it and the first by starts (rows, 2)."""
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
    """Samples of closed orbits, one row per exciter, from their sections; a multiple of 0 leaves a row as it is."""
    log, c = new_log(ORBIT_LOG_CAPACITY, ORBIT_REST_CAPACITY), np.empty(DEGREE + 1)
    for row in range(parameters.shape[0]):
        if multiple[row] > 0:
            x, v = section[row, 0], section[row, 1]
            p = row_parameters(parameters, row)
            sample_row(e, p, x, v, multiple[row], log, c, motion, row)


@dataclass
class _Solver:
    """Solves pieces of rows; each thread keeps the room for impacts that it has touched once."""

    parameters: Callable[[int, int], Sequence[np.ndarray]]
    start: tuple[float | None, float]
    chain_length: int
    max_periods: int
    patience: int
    harmonics: int
    outputs: tuple[str, ...]
    effects: Effects
    room_rows: int
    own: threading.local = field(default_factory=threading.local)

    def solve(self, values: np.ndarray, seeds: np.ndarray) -> RowResults:
        """Solve parameters (rows, 7) from starts (rows, 2)."""
        # Of each thread its own, kept: a page touched for the first time costs more than a row.
        if not hasattr(self.own, "room"):
            self.own.room = new_impact_buffer(self.room_rows)
        out = new_rows(len(values), self.harmonics, self.outputs, self.own.room)
        chain = max(1, min(self.chain_length, len(values)))
        solve_piece(self.effects, values, seeds, chain, self.max_periods, self.patience, out)
        if "motion" in self.outputs:
            # Rows in closed form were never marched and have their samples already.
            marched = np.where(out.settled_after > 0, out.period_multiple, 0)
            _sample(self.effects, values, out.section, marched, out.motion)
        return mask_unsolved(_compact(out))

    def piece(self, ends: Sequence[int]) -> list[list[RowResults]]:
        """Solve whole chains, or the parts of one, one after the other; of each part its solutions."""
        solved: list[list[RowResults]] = []
        for first, stop in pairwise(ends):
            sets = self.parameters(first, stop)
            seeds = [row_starts(values, *self.start) for values in sets]
            if solved:  # a chain goes on
                for seed, before in zip(seeds, solved[-1], strict=True):
                    seed[0] = before.section[-1]
            solved.append([self.solve(*each) for each in zip(sets, seeds, strict=True)])
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
    """Solve rows in blocks, by as many threads as numba has; bit for bit the same for every number of them.

    While a block is looked at other threads solve the next, and no more.

    Parameters
    ----------
    blocks : sequence
        The blocks and their pieces (`solve.sweep_grid.row_blocks`).
    parameters : callable
        parameters(first, stop): (stop - first, 7) of one solution of these rows, or of several side by side.
    start : (float or None, float)
        x0 and v0 of the first row of each chain (`row_starts`).
    effects : Effects
        What the kernel has, for all rows alike.
    progress : callable, optional
        Called as progress(rows done).

    Yields
    ------
    (int, list of RowResults)
        The end of a block and its solutions, in order.
    """
    work = [ends for block in blocks for ends in block]
    room_rows = max(stop - first for ends in work for first, stop in pairwise(ends))
    limits = chain_length, max_periods, patience
    solver = _Solver(parameters, start, *limits, harmonics, outputs, effects, room_rows)
    count = numba.get_num_threads()
    if count == 1:
        for block in blocks:
            parts: list[list[RowResults]] = []
            for ends in block:
                parts += solver.piece(ends)
                if progress is not None:
                    progress(ends[-1])
            yield block[-1][-1], concatenate_solutions(parts)
        return
    # Compiled or loaded once, before threads ask for it side by side.
    solver.solve(np.empty((0, len(Parameters._fields))), np.empty((0, 2)))
    threads = ThreadPoolExecutor(count)
    left, waiting = iter(work), deque[Solving]()
    try:
        for block in blocks:
            # Of blocks of a piece or two so many that no thread waits.
            limit = 2 * max(len(block), count)
            for ends in islice(left, limit - len(waiting)):
                waiting.append(threads.submit(solver.piece, ends))
            pieces = [waiting.popleft() for _ in block]
            yield block[-1][-1], gather_block(pieces, block, progress)
    finally:  # also where no more is wanted, and on Ctrl-C: what has not begun never does
        threads.shutdown(cancel_futures=True)


def gather_block(
    pieces: list[Solving],
    block: Sequence[Sequence[int]],
    progress: Callable[[int], None] | None,
) -> list[RowResults]:
    """The solutions of a block when all its pieces are solved, which are taken from the list: they are not
    kept beside them."""
    undone: Collection[Solving] = pieces
    # Once for all: to be woken for each piece takes time from the threads that solve.
    while undone:
        done, undone = wait(pieces, PROGRESS_INTERVAL, FIRST_EXCEPTION)
        for piece in done:
            piece.result()  # raises what was raised there
        if progress is not None:
            of_them = (ends for piece, ends in zip(pieces, block, strict=True) if piece in done)
            progress(block[0][0] + sum(ends[-1] - ends[0] for ends in of_them))
    parts = [part for piece in pieces for part in piece.result()]
    pieces.clear()
    return concatenate_solutions(parts)


def concatenate_solutions(parts: Sequence[Sequence[RowResults]]) -> list[RowResults]:
    """The solutions of a block from those of its parts, in order."""
    return [
        RowResults(*map(np.concatenate, zip(*each, strict=True)))
        for each in zip(*parts, strict=True)
    ]


def _compact(out: RowResults) -> RowResults:
    """The same results with impacts as flat arrays in the order of rows (contiguous ragged)."""
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
