"""Many rows on all threads: a driver of a few lines over the kernel of one row."""

from __future__ import annotations

import mmap
import threading
from collections import deque
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from itertools import islice, pairwise
from typing import NamedTuple, TypeVar

import numba
import numpy as np

from vibropipe.jit import jit_nogil
from vibropipe.kernels.outputs import Rows
from vibropipe.kernels.record import new_log
from vibropipe.kernels.row import row_parameters, sample_row, solve_in_order
from vibropipe.physics.effects import ALL_EFFECTS, Effects
from vibropipe.physics.exciter import Parameters
from vibropipe.physics.flow import ORDER

OUTPUTS = ("harmonics", "impacts", "motion", "stability", "energy")
PHASES = 256
LOG_ROOM = 8192
REST_ROOM = 512
# Rows per call of the driver: few enough for a word of progress and Ctrl-C, many enough that calls cost nothing.
# Towards the end a share of what is left, and ever fewer, so that threads end together.
ROWS_PER_CALL, LEAST_ROWS_PER_CALL, SHARE = 256, 32, 4

Labelled = TypeVar("Labelled")


class Room(NamedTuple):
    """Where the impacts of some rows go, side by side: few rows have many, so that most of it is never touched."""

    position: np.ndarray
    velocity: np.ndarray
    support: np.ndarray


def _pages(rows: int, kind: type) -> np.ndarray:
    """LOG_ROOM values of each row; only what is written to takes memory.

    numpy's own arrays of this size come in pages of 2 MB, of which a single row with many impacts would touch all.
    """
    if rows == 0:
        return np.empty((LOG_ROOM, 0), kind)
    pages = mmap.mmap(-1, rows * LOG_ROOM * np.dtype(kind).itemsize)
    with suppress(AttributeError, OSError):  # where there are no large pages
        pages.madvise(mmap.MADV_NOHUGEPAGE)
    return np.frombuffer(pages, kind).reshape(LOG_ROOM, rows)


def new_room(rows: int) -> Room:
    """Room for LOG_ROOM impacts of each of so many rows."""
    return Room(_pages(rows, float), _pages(rows, float), _pages(rows, np.int8))


NO_ROOM = new_room(0)


def new_rows(n: int, harmonics: int, outputs: tuple[str, ...], room: Room) -> Rows:
    """Empty results of n rows; arrays only for the outputs named. room: for the impacts of as many rows, at least,
    if they are asked for."""
    asked = {name: name in outputs for name in OUTPUTS}

    def zeros(*shape: int, kind: type = float, when: str | None = None) -> np.ndarray:
        return np.zeros((n if when is None or asked[when] else 0, *shape), kind)

    listed = room if asked["impacts"] else NO_ROOM
    return Rows(
        regime=np.zeros(n, np.int8),
        frequency=np.zeros(n),
        status=np.zeros(n, np.int8),
        period_multiple=np.zeros(n, np.int32),
        settled_after=np.zeros(n, np.int32),
        window=np.zeros(n, np.int32),
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
        largest=zeros(2, when="impacts"),
        energy=zeros(4, when="energy"),
        motion=zeros(2, PHASES, when="motion"),
    )


def cuts(rows: int, chain_length: int) -> list[int]:
    """Ends of the pieces that rows are solved in: of as many whole chains as one call takes, or of parts of
    chains longer than that. The same for any number of threads."""
    ends = [0]
    while ends[-1] < rows:
        first = ends[-1]
        most = min(ROWS_PER_CALL, max(LEAST_ROWS_PER_CALL, (rows - first) // SHARE))
        stop = min(rows, first + max(1, most // chain_length) * chain_length)
        ends += [*range(first + ROWS_PER_CALL, stop, ROWS_PER_CALL), stop]
    return ends


@jit_nogil
def drive(
    e: Effects,
    parameters: np.ndarray,
    starts: np.ndarray,
    chain_length: int,
    max_periods: int,
    patience: int,
    out: Rows,
) -> None:
    """Solve parameters (rows, 7) in chains of chain_length rows, each row of a chain seeded by the one before
    it and the first by starts (rows, 2)."""
    log, c = new_log(LOG_ROOM, REST_ROOM), np.empty(ORDER + 1)
    solve_in_order(e, parameters, starts, chain_length, max_periods, patience, log, c, out)


@jit_nogil
def _sample(
    e: Effects,
    parameters: np.ndarray,
    section: np.ndarray,
    multiple: np.ndarray,
    motion: np.ndarray,
) -> None:
    """Samples of closed orbits, one row per exciter, from their sections; a multiple of 0 leaves a row as it is."""
    log, c = new_log(LOG_ROOM, REST_ROOM), np.empty(ORDER + 1)
    for row in range(parameters.shape[0]):
        if multiple[row] > 0:
            x, v = section[row, 0], section[row, 1]
            p = row_parameters(parameters, row)
            sample_row(e, p, x, v, multiple[row], log, c, motion, row)


def solve_rows(
    rows: int,
    parameters: Callable[[int, int], Sequence[np.ndarray]],
    start: tuple[float, float],
    chain_length: int,
    max_periods: int,
    patience: int,
    harmonics: int,
    outputs: tuple[str, ...],
    label: Callable[[Sequence[np.ndarray], Sequence[Rows]], Labelled],
    progress: Callable[[int], None] | None = None,
    effects: Effects = ALL_EFFECTS,
    ahead: int | None = None,
) -> Generator[tuple[int, list[Labelled]]]:
    """Results of rows, piece after piece (`cuts`), by as many threads as numba has; bit for bit the same for every
    number of them.

    parameters(first, stop): (stop - first, 7) of one solution of these rows, or of several side by side. start: of
    the first row of each chain. effects: what the kernel has, for all rows alike.
    label(parameters, solutions): makes of a piece what is kept of it, as soon as it is solved.
    Yields (stop, what was made of the pieces since the last), in order, at ends of chains. About `ahead` rows are
    solved before they are taken (all, if left out). progress is told the rows done after each piece."""
    own = threading.local()

    def solve(values: np.ndarray, seeds: np.ndarray) -> Rows:
        # Of each thread its own, kept: a page touched for the first time costs more than a row.
        if not hasattr(own, "room"):
            own.room = new_room(ROWS_PER_CALL)
        out = new_rows(len(values), harmonics, outputs, own.room)
        chain = max(1, min(chain_length, len(values)))
        drive(effects, values, seeds, chain, max_periods, patience, out)
        if "motion" in outputs:
            # Rows in closed form were never marched and have their samples already.
            marched = np.where(out.settled_after > 0, out.period_multiple, 0)
            _sample(effects, values, out.section, marched, out.motion)
        return _compact(out)

    def solve_chains(ends: Sequence[int]) -> list[Labelled]:
        labelled: list[Labelled] = []
        solved: list[Rows] = []
        for first, stop in pairwise(ends):
            pieces = parameters(first, stop)
            seeds = [np.tile(start, (stop - first, 1)) for _ in pieces]
            for seed, before in zip(seeds, solved, strict=False):  # a chain goes on
                seed[0] = before.section[-1]
            solved = [solve(piece, seed) for piece, seed in zip(pieces, seeds, strict=True)]
            labelled.append(label(pieces, solved))
        return labelled

    # Compiled or loaded once, before threads ask for it side by side.
    solve(np.empty((0, len(Parameters._fields))), np.empty((0, 2)))
    work = whole_chains(cuts(rows, chain_length), chain_length)
    count = numba.get_num_threads()
    rows_of_work = max(ROWS_PER_CALL, chain_length)
    most = len(work) if ahead is None else max(count + 1, ahead // rows_of_work)
    left, waiting = iter(work), deque[Future[list[Labelled]]]()
    threads = ThreadPoolExecutor(count)
    try:
        for ends in work:
            for more in islice(left, most - len(waiting)):
                waiting.append(threads.submit(solve_chains, more))
            made = waiting.popleft().result()
            if progress is not None:
                progress(ends[-1])
            yield ends[-1], made
    finally:  # also where no more is wanted, and on Ctrl-C: what has not begun never does
        threads.shutdown(cancel_futures=True)


def whole_chains(ends: Sequence[int], chain_length: int) -> list[list[int]]:
    """Cuts grouped so that each group begins and ends with chains: what threads can solve side by side."""
    groups: list[list[int]] = []
    for first, stop in pairwise(ends):
        if first % chain_length:
            groups[-1].append(stop)
        else:
            groups.append([first, stop])
    return groups


def _compact(out: Rows) -> Rows:
    """The same results with impacts as flat arrays in the order of rows (contiguous ragged)."""
    sizes = out.impact_count
    if sizes.size == 0:
        return out
    row = np.repeat(np.arange(sizes.size), sizes)
    place = np.arange(row.size) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    return out._replace(
        impact_position=out.impact_position[place, row],
        impact_velocity=out.impact_velocity[place, row],
        impact_support=out.impact_support[place, row],
    )
