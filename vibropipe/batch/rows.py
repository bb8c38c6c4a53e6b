"""Many rows on all threads: a driver of a few lines over the kernel of one row."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numba import prange

from vibropipe.jit import jit_parallel
from vibropipe.kernels.outputs import Rows
from vibropipe.kernels.record import new_log
from vibropipe.kernels.row import sample_row, solve_row
from vibropipe.physics.effects import ALL_EFFECTS, Effects
from vibropipe.physics.flow import ORDER

OUTPUTS = ("harmonics", "impacts", "motion", "stability", "energy")
PHASES = 256
LOG_ROOM = 8192
REST_ROOM = 512
# Rows per call of the driver: often enough for a word of progress and Ctrl-C, rare enough to cost nothing.
ROWS_PER_CALL = 1024
# Chains are dealt out like cards, so that costly neighbours (aperiodic regions) land on different threads.
HANDS = 64


def new_rows(n: int, harmonics: int, outputs: tuple[str, ...]) -> Rows:
    """Empty results of n rows; arrays only for the outputs named."""
    asked = {name: name in outputs for name in OUTPUTS}

    def zeros(*shape: int, kind: type = float, when: str | None = None) -> np.ndarray:
        return np.zeros((n if when is None or asked[when] else 0, *shape), kind)

    listed = n if asked["impacts"] else 0
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
        # Rows side by side: few have many impacts, so that most of this room is never touched and takes no
        # memory; a page touched for the first time costs more than a row.
        impact_position=np.empty((LOG_ROOM, listed)),
        impact_velocity=np.empty((LOG_ROOM, listed)),
        impact_support=np.empty((LOG_ROOM, listed), np.int8),
        largest=zeros(2, when="impacts"),
        energy=zeros(4, when="energy"),
        motion=zeros(2, PHASES, when="motion"),
    )


def cuts(rows: int, chain_length: int) -> list[int]:
    """Ends of the pieces that rows are solved in: of as many whole chains as one call takes, or of parts of
    chains longer than that."""
    step = max(1, ROWS_PER_CALL // chain_length) * chain_length
    within = range(0, chain_length, ROWS_PER_CALL)
    return [*(first + part for first in range(0, rows, step) for part in within), rows]


@jit_parallel
def _drive(
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
    chains = parameters.shape[0] // chain_length
    hands = min(HANDS, chains)
    for hand in prange(hands):
        log = new_log(LOG_ROOM, REST_ROOM)
        c = np.empty(ORDER + 1)
        for chain in range(hand, chains, hands):
            x, v = starts[chain * chain_length, 0], starts[chain * chain_length, 1]
            for row in range(chain * chain_length, (chain + 1) * chain_length):
                lower = parameters[row, 4] - parameters[row, 3]
                upper = parameters[row, 3] + parameters[row, 4]
                x = min(max(x, lower), upper)
                x, v = solve_row(e, parameters[row], x, v, max_periods, patience, log, c, out, row)


@jit_parallel
def _sample(
    e: Effects,
    parameters: np.ndarray,
    section: np.ndarray,
    multiple: np.ndarray,
    motion: np.ndarray,
) -> None:
    """Samples of closed orbits, one row per exciter, from their sections; a multiple of 0 leaves a row as it is."""
    for row in prange(parameters.shape[0]):
        if multiple[row] > 0:
            log = new_log(LOG_ROOM, REST_ROOM)
            x, v = section[row, 0], section[row, 1]
            sample_row(
                e, parameters[row], x, v, multiple[row], log, np.empty(ORDER + 1), motion, row
            )


def solve_rows(
    parameters: np.ndarray,
    starts: np.ndarray,
    chain_length: int,
    max_periods: int,
    patience: int,
    harmonics: int,
    outputs: tuple[str, ...],
    progress: Callable[[int], None] | None = None,
    effects: Effects = ALL_EFFECTS,
) -> list[Rows]:
    """Results of parameters (rows, 7) from starts (rows, 2), in pieces (`cuts`); bit for bit the same
    for every number of threads. effects: what the kernel has, for all rows alike.
    progress is told the number of rows done after each piece."""
    pieces: list[Rows] = []
    for first, stop in pairwise(cuts(len(parameters), chain_length)):
        piece = slice(first, stop)
        seeds = np.array(starts[piece])
        if first % chain_length:  # a chain goes on
            seeds[0] = pieces[-1].section[-1]
        out = new_rows(stop - first, harmonics, outputs)
        _drive(
            effects,
            np.ascontiguousarray(parameters[piece]),
            seeds,
            min(chain_length, stop - first),
            max_periods,
            patience,
            out,
        )
        if "motion" in outputs:
            # Rows in closed form were never marched and have their samples already.
            marched = np.where(out.settled_after > 0, out.period_multiple, 0)
            _sample(
                effects, np.ascontiguousarray(parameters[piece]), out.section, marched, out.motion
            )
        pieces.append(_compact(out))
        if progress is not None:
            progress(stop)
    return pieces


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
