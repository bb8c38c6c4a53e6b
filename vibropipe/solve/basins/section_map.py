"""The return map of one exciter as the search for attractors calls it, on one thread or on all."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TypeVar

import numba
import numpy as np

from vibropipe.compiler import jit_nogil
from vibropipe.march.grid import exact_grid
from vibropipe.march.log import Log, limit_work, new_log, work_left, work_of
from vibropipe.march.piece_log import PieceLog, piece_log_of
from vibropipe.orbits.basins import (
    Cells,
    Ellipses,
    assign_starts,
    map_states,
    record_sections,
    section_jacobian,
)
from vibropipe.orbits.preimages import map_back
from vibropipe.orbits.results import RowResults
from vibropipe.orbits.row import LOAD
from vibropipe.physics.effects import Effects, all_effects
from vibropipe.physics.exciter import Exciter, Parameters
from vibropipe.physics.flow import DEGREE
from vibropipe.physics.limits import MAX_CALL_WORK, MAX_ROW_WORK
from vibropipe.solve.rows.many import RowLimits, solve_piece
from vibropipe.solve.rows.row_results import (
    ORBIT_LOG_CAPACITY,
    ORBIT_REST_CAPACITY,
    add_load,
    concatenate_solutions,
    new_rows,
)
from vibropipe.solve.rows.unsolved import mask_unsolved
from vibropipe.solve.threads import Threads

# Starts that a thread assigns at a time.
PIECE = 256
# Largest distance of the image of a preimage from its state, in the units of the section map.
RETRACED = 1e-9
# Rows that a thread solves at a time, which may take a thousand periods each.
ROWS_PIECE = 16

T = TypeVar("T")


@jit_nogil
def _assign_piece(
    e: Effects,
    p: Parameters,
    starts: np.ndarray,
    phase: float,
    regions: tuple[Ellipses, Cells],
    max_periods: int,
    assigned: tuple[np.ndarray, np.ndarray],
    limits: tuple[int, int],
    pieces: PieceLog | None,
    plain: int | None,
) -> int:
    """Assign starts with a log of their own, and return their work; arguments as for `orbits.basins.assign_starts`.

    limits : those of `limit_work`.
    """
    log, c = new_log(ORBIT_LOG_CAPACITY, ORBIT_REST_CAPACITY, pieces, plain), np.empty(DEGREE + 1)
    limit_work(log, *limits)
    assign_starts(e, p, exact_grid(e, p), starts, phase, regions, max_periods, log, c, assigned)
    return work_of(log)


@jit_nogil
def _map_piece(
    e: Effects,
    p: Parameters,
    states: np.ndarray,
    m: int,
    images: np.ndarray,
    sequence: np.ndarray,
    log: Log,
) -> None:
    map_states(e, p, exact_grid(e, p), states, m, log, np.empty(DEGREE + 1), images, sequence)


@jit_nogil
def _map_back_piece(
    e: Effects, p: Parameters, states: np.ndarray, before: np.ndarray, log: Log
) -> None:
    map_back(e, p, exact_grid(e, p), states, log, np.empty(DEGREE + 1), before)


@jit_nogil
def _record_piece(
    e: Effects, p: Parameters, x: float, v: float, phase: float, sections: np.ndarray, log: Log
) -> int:
    return record_sections(
        e, p, exact_grid(e, p), x, v, phase, log, np.empty(DEGREE + 1), sections
    )  # fmt: skip


@jit_nogil
def _jacobian(
    e: Effects, p: Parameters, x: float, v: float, m: int, log: Log
) -> tuple[float, float, float, float]:
    return section_jacobian(e, p, exact_grid(e, p), x, v, m, log, np.empty(DEGREE + 1))


class SectionMap:
    """The return map of one exciter.

    scale : (2,), units of x and x' at the section: l, and l times the larger of 1 and nu
    """

    def __init__(self, exciter: Exciter) -> None:
        self.exciter = exciter
        self._parameters = all_effects(exciter.stated(), pieces=True), exciter.parameters()
        self._equilibrium = np.array([exciter.load, 0.0])
        self._origin = 0.0 - self._equilibrium
        self.scale = exciter.l * np.array([1.0, max(1.0, exciter.nu)])
        self._log = new_log(ORBIT_LOG_CAPACITY, ORBIT_REST_CAPACITY, *self._pieces())
        self.allow(MAX_CALL_WORK)

    def _pieces(self) -> tuple[PieceLog | None, int | None]:
        """Return `pieces` and `plain` of a log; each thread has its own."""
        return piece_log_of(self._parameters[0], ORBIT_LOG_CAPACITY)

    @property
    def work(self) -> int:
        """Work of all marches that are not on several threads so far, in steps."""
        return int(work_of(self._log))

    @property
    def work_left(self) -> int:
        """Work that all further marches may take, in steps; each takes a little in any case."""
        return max(1, int(work_left(self._log)))

    def allow(self, work: int) -> None:
        """Allow all further marches so much work, in steps."""
        limit_work(self._log, 0, work)

    def _spend(self, work: int) -> None:
        """Subtract the work of marches on all threads."""
        self.allow(max(1, self.work_left - work))

    def jacobian(self, point: np.ndarray, m: int) -> np.ndarray:
        """Return the Jacobian (2, 2) of the m-period return map at a state (2,)."""
        x, v = point - self._equilibrium
        return np.reshape(_jacobian(*self._parameters, x, v, m, self._log), (2, 2))

    def images(self, states: np.ndarray, m: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the images (n, 2) of states under the m-period return map, and their contacts (`map_states`)."""
        images, sequence = np.empty_like(states), np.empty(len(states), np.int64)
        starts = np.ascontiguousarray(states - self._equilibrium)
        _map_piece(*self._parameters, starts, m, images, sequence, self._log)
        return images - self._origin, sequence

    def preimages(self, states: np.ndarray) -> np.ndarray:
        """Return the states (n, 2) a forcing period before states at the section.

        They are NaN where the march forward does not lead back: after a rest, with R = 0 or with friction there is no
        one state before.
        """
        before, is_finite = np.full_like(states, np.nan), np.isfinite(states).all(axis=1)
        e, p = self._parameters
        rebounds = {f"R{n}": getattr(p, f"R{n}") for n in (1, 2) if getattr(p, f"k{n}") == 0.0}
        if p.friction == 0.0 and min(rebounds.values(), default=1.0) > 0.0:
            # Backward in time damping and impacts give what they took, and sines change their sign.
            given = {name: -getattr(p, name) for name in ("f", "h", "h1", "h2", "f2", "phi2")}
            given |= {name: 1.0 / value for name, value in rebounds.items()}
            backward = p._replace(**given)
            earlier = np.empty((np.count_nonzero(is_finite), 2))
            starts = states[is_finite] - self._equilibrium
            _map_back_piece(e, backward, starts, earlier, self._log)
            before[is_finite] = earlier - self._origin
        mapped = np.flatnonzero(np.isfinite(before).all(axis=1))
        images, _contacts = self.images(before[mapped], 1)
        missed = np.abs((images - states[mapped]) / self.scale).max(axis=1)
        before[mapped[~(missed <= RETRACED)]] = np.nan
        return before

    def sections(self, start: np.ndarray, n: int, phase: float = 0.0) -> np.ndarray:
        """Return the next n sections of the motion from a start (2,); fewer if its march fails."""
        sections = np.empty((n, 2))
        x, v = start - self._equilibrium
        written = _record_piece(*self._parameters, x, v, phase, sections, self._log)
        return sections[:written] - self._origin

    def steady_states(self, starts: np.ndarray, max_periods: int) -> RowResults:
        """Return the steady states, without outputs, that motions from starts (n, 2) at the phase 0 settle on."""
        e, p = self._parameters
        parameters = np.tile(np.array(p), (len(starts), 1))
        row_work = min(MAX_ROW_WORK, 1 + self.work_left // max(1, len(starts)))
        works: list[int] = []

        def solve(first: int) -> list[RowResults]:
            part = slice(first, first + ROWS_PIECE)
            rows = new_rows(len(starts[part]), 1, ("stability",))
            seeds = starts[part] - self._equilibrium
            row_limits = RowLimits(max_periods, max_periods, row_work)
            work = solve_piece(e, parameters[part], seeds, 1, row_limits, rows, *self._pieces())
            works.append(work)
            add_load(rows, parameters[part, LOAD])
            return [mask_unsolved(rows)]

        pieces = self._on_threads(solve, len(starts), ROWS_PIECE)
        self._spend(sum(works))
        return concatenate_solutions(pieces)[0]

    def assign(
        self,
        starts: np.ndarray,
        phase: float,
        ellipses: Ellipses,
        cells: Cells,
        max_periods: int,
        start_work: int = 0,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Assign starts to attractors.

        starts : (n, 2)
        phase, ellipses, cells, max_periods : as for `orbits.basins.assign_starts`
        start_work : work that each start may take, in steps; 0: all share what is left, whoever needs it
        Returns the attractor (n,) of each start, and forcing periods marched. Each start is marched by itself, so they
        do not depend on the number of threads.
        """
        n, starts = len(starts), starts - self._equilibrium
        ellipses = ellipses._replace(center=ellipses.center - self._equilibrium)
        cells = cells._replace(corner=cells.corner - self._equilibrium)
        owner, periods = np.empty(n, np.int64), np.empty(n, np.int64)
        share, regions, works = self.work_left / max(1, n), (ellipses, cells), list[int]()

        def solve(first: int) -> None:
            part = slice(first, first + PIECE)
            limits = start_work, 0 if start_work else 1 + int(share * len(starts[part]))
            work = _assign_piece(
                *self._parameters, starts[part], phase, regions, max_periods,
                (owner[part], periods[part]), limits, *self._pieces(),
            )  # fmt: skip
            works.append(work)

        self._on_threads(solve, n, PIECE)
        if not start_work:
            self._spend(sum(works))
        return owner, periods

    @staticmethod
    def _on_threads(solve: Callable[[int], T], n: int, piece: int) -> list[T]:
        """Return solve(first) for no rows and for the pieces of n rows, solved on all threads, in order."""
        # Without rows: the kernel is compiled or loaded once, before several threads request it.
        nothing = solve(n)
        if n == 0:
            return [nothing]
        threads = Threads(numba.get_num_threads())
        try:
            calls = [partial(solve, first) for first in range(0, n, piece)]
            return [nothing, *threads.submit(calls).take()]
        finally:  # also on Ctrl-C
            threads.stop()
