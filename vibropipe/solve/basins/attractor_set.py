"""The attractors of one exciter: found as starts need them, and told apart by their states at the section."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from vibropipe.orbits.basins import FAILED, LINES, UNDECIDED, Cells, Ellipses
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.limits import MAX_CALL_WORK, START_WORK
from vibropipe.solve.basins.neighbourhood import (
    MAX_RADIUS,
    Ellipse,
    spectral_radius,
    trapping_ellipse,
)
from vibropipe.solve.basins.section_map import SectionMap
from vibropipe.solve.sweep.blocks import MAX_PERIODS
from vibropipe.words.progress import Progress
from vibropipe.words.regimes import Regime

# Forcing periods after which starts not yet assigned wait until some of them have been solved as steady states, since
# the attractor that they settle on may be unknown; and the factor by which the limit grows where all are known.
FIRST_LIMIT, LAST_LIMIT, LIMIT_GROWTH = 64, 16384, 4
# Undecided starts that are solved as steady states at a time.
SAMPLE = 16
# Largest distance of section points of one orbit found twice, in the units of the section map.
SAME_ORBIT = 1e-6
# Sections that mark the cells of an attractor without an orbit, and those before that are left out. The cells are the
# smallest, by powers of two, of which it visits at most MAX_CELLS, each on average by 32 sections; the first size is a
# COARSEST-th of its extent. Larger ones would cover what lies between the bands of an attractor.
MEASURE_SECTIONS, MEASURE_TRANSIENT = 65536, 1024
MAX_CELLS, COARSEST, FINEST, MIN_EXTENT = 2048, 32, 2**30, 1e-200


class Attractor(NamedTuple):
    """One attractor.

    period_multiple : forcing periods of its orbit; 0 without an orbit
    sections : (n, 2), its section points in order of time, from the one with the least displacement on; without an
        orbit, many states of one motion
    ellipses : neighbourhoods of section points that no motion leaves
    cells : without an orbit, the cells that it visits (`visited_cells`)
    """

    period_multiple: int
    sections: np.ndarray
    ellipses: tuple[Ellipse, ...]
    cells: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None

    def sort_key(self) -> tuple[bool, int, float]:
        """Return what attractors are numbered by: orbits first, by period multiple, then by displacement."""
        place = self.sections[0] if self.period_multiple else self.sections.mean(axis=0)
        return self.period_multiple == 0, self.period_multiple, float(place[0])


class AttractorSet:
    """The attractors of an exciter that are known so far.

    known : those found before, then all in the order in which they were found
    """

    def __init__(self, exciter: Exciter, known: Iterable[Attractor] = ()) -> None:
        self.section = SectionMap(exciter)
        self.known = list(known)

    def assigned(self, starts: np.ndarray, phase: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """March starts (n, 2) until they are assigned to a known attractor, not far: the first step of `settle`.

        Each start may take START_WORK, whatever the others do.

        Returns owner and periods as `settle` does; UNDECIDED and 0 if no attractor is known. Those of a start do not
        depend on others.
        """
        if not self.known:
            return np.full(len(starts), UNDECIDED), np.zeros(len(starts), np.int64)
        return self._assign(starts, phase, FIRST_LIMIT, START_WORK)

    def _assign(
        self, starts: np.ndarray, phase: float, limit: int, start_work: int = 0
    ) -> tuple[np.ndarray, np.ndarray]:
        regions = self._ellipses(), self._cells()
        return self.section.assign(starts, phase, *regions, limit, start_work)

    def settle(
        self,
        starts: np.ndarray,
        phase: float = 0.0,
        progress: Progress | None = None,
        assigned: tuple[np.ndarray, np.ndarray] | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Find the attractor that each start settles on; unknown ones are added.

        Starts are marched until they are assigned. If some are not after a limit, a sample of them is solved as steady
        states, which finds attractors still unknown, and all are marched again from their starts, further once the
        sample brings nothing new. So what is found for a start depends neither on threads nor on other starts, but for
        attractors that would not have been found without them. All share an amount of work that grows with their
        number; starts for which it does not suffice stay undecided.

        starts : (n, 2), displacements and velocities
        phase : phase of the force at the start, in turns
        progress : called as progress(done, total), in starts assigned
        assigned : what `assigned` returns for these starts, if that is known
        Returns the index (n,) into `known` of each start, negative where none was found, and the forcing periods until
        its motion was assigned.
        """
        first = self.assigned(starts, phase) if assigned is None else assigned
        owner, periods = (np.array(each, np.int64) for each in first)
        self.section.allow(MAX_CALL_WORK + START_WORK * len(starts))
        limit, is_new = FIRST_LIMIT, np.ones(len(starts), bool)
        while True:
            undecided = np.flatnonzero(owner == UNDECIDED)
            if progress is not None:
                progress(len(starts) - undecided.size, len(starts))
            if not undecided.size or self.section.work_left <= undecided.size:
                break
            unsolved = undecided[is_new[undecided]]
            sample = unsolved[:: max(1, unsolved.size // SAMPLE)]
            is_new[sample] = False
            n_known = len(self.known)
            self._discover(starts[sample], phase)
            if len(self.known) == n_known:
                if limit == LAST_LIMIT or not self.known:
                    break
                limit = min(LAST_LIMIT, LIMIT_GROWTH * limit)
            owner[undecided], periods[undecided] = self._assign(starts[undecided], phase, limit)
        if undecided.size and self.known:
            # Newton's method closes from afar an orbit that motions approach very slowly.
            owner[undecided] = self._discover(starts[undecided], phase, orbits_only=True)
            periods[undecided] = limit
        if undecided.size and progress is not None:
            progress(len(starts), len(starts))
        return owner, periods

    def attractor_of(self, state: np.ndarray) -> int:
        """Return the index of the attractor that a state (2,) at the section settles on, added if it is new.

        Negative: none was found.
        """
        return int(self._discover(state[None], 0.0)[0])

    def _discover(self, starts: np.ndarray, phase: float, orbits_only: bool = False) -> np.ndarray:
        """Solve starts as steady states and add the attractors that are new.

        Returns the index (n,) into `known` of each start, or negative.
        """
        owner = np.full(len(starts), FAILED)
        if phase:
            starts = np.array(
                [(*self.section.sections(each, 1, phase), each)[0] for each in starts]
            )
        rows = self.section.steady_states(starts.reshape(-1, 2), MAX_PERIODS)
        for i, (m, regime) in enumerate(zip(rows.period_multiple, rows.regime, strict=True)):
            if m > 0:
                owner[i] = self._orbit(rows.section[i], int(m))
            elif (
                regime == Regime.APERIODIC
                and not orbits_only
                and loses(self.section.exciter, rows.impacts[i])
            ):
                owner[i] = self._aperiodic(rows.section[i])
        return owner

    def _captured(self, start: np.ndarray) -> int:
        """Return the index of the known attractor that a state at the section settles on, or UNDECIDED."""
        return max(UNDECIDED, int(self.owners(start[None])[0]))

    def owners(self, states: np.ndarray) -> np.ndarray:
        """Return the index of the known attractor that each state (n, 2) at the section settles on, or negative."""
        return self._assign(states, 0.0, LAST_LIMIT)[0]

    def _orbit(self, point: np.ndarray, m: int) -> int:
        """Return the index of the orbit of m periods through a point, added if it is new; FAILED if not stable."""
        points = self.section.sections(point, m)
        if len(points) < m:  # its march takes too much work
            return FAILED
        points = np.roll(points, 1, axis=0)
        for index, other in enumerate(self.known):
            if other.period_multiple == m and self._distance(other, point) <= SAME_ORBIT:
                return index
        if not spectral_radius(self.section.jacobian(points[0], m)) < MAX_RADIUS:
            return FAILED
        points = np.roll(points, -int(np.argmin(points[:, 0])), axis=0)
        left = self.section.work_left
        ellipses = [trapping_ellipse(self.section, each, m) for each in points]
        self.section.allow(left)  # a limit of its own, that the starts do not bear
        trapping = tuple(ellipse for ellipse in ellipses if ellipse is not None)
        if not trapping and self.section.exciter.friction > 0.0:
            # Motions creep towards the edge of the places where friction holds the mass for ever.
            return FAILED
        self.known.append(Attractor(m, points, trapping))
        return len(self.known) - 1

    def _distance(self, orbit: Attractor, point: np.ndarray) -> float:
        """Return the least distance of a state from the section points of an orbit, in units of the section map."""
        return float(np.abs((orbit.sections - point) / self.section.scale).max(axis=1).min())

    def _aperiodic(self, start: np.ndarray) -> int:
        """Return the index of the attractor of a motion without an orbit, added if it is new."""
        index = self._captured(start)
        if index >= 0:
            return index
        sections = self.section.sections(start, MEASURE_SECTIONS)
        if len(sections) < MEASURE_SECTIONS:
            return FAILED
        for index, other in enumerate(self.known):
            if other.period_multiple and self._distance(other, sections[-1]) <= SAME_ORBIT:
                return index
        rows = self.section.steady_states(sections[-1:], MAX_PERIODS)
        if rows.period_multiple[0] > 0:  # the chaos was a transient
            return self._orbit(rows.section[0], int(rows.period_multiple[0]))
        if rows.regime[0] != Regime.APERIODIC:
            return FAILED
        index = self._captured(sections[-1])
        if index >= 0:
            return index
        measure = sections[MEASURE_TRANSIENT:]
        self.known.append(Attractor(0, measure, (), visited_cells(measure)))
        return len(self.known) - 1

    def _ellipses(self) -> Ellipses:
        """Return the ellipses of all known orbits."""
        each = [
            (ellipse, index)
            for index, attractor in enumerate(self.known)
            for ellipse in attractor.ellipses
        ]
        return Ellipses(
            np.array([ellipse.center for ellipse, _index in each]).reshape(-1, 2),
            np.array([ellipse.shape[[0, 0, 1], [0, 1, 1]] for ellipse, _index in each]).reshape(
                -1, 3
            ),
            np.array([index for _ellipse, index in each], np.int64),
        )

    def _cells(self) -> Cells:
        """Return the cells that the known attractors without an orbit visit."""
        chosen = [(i, each.cells) for i, each in enumerate(self.known) if each.cells is not None]
        visited = [cells for _index, (cells, _corner, _scale) in chosen]
        return Cells(
            np.concatenate([np.empty(0, np.int64), *visited]),
            np.cumsum([0, *map(len, visited)]),
            np.array([corner for _index, (_cells, corner, _scale) in chosen]).reshape(-1, 2),
            np.array([scale for _index, (_cells, _corner, scale) in chosen]).reshape(-1, 2),
            np.array([index for index, _cells in chosen], np.int64),
        )


def visited_cells(sections: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the cells that an attractor visits.

    Returns cells, corner and scale as in `Cells`, of one attractor.
    """
    corner = sections.min(axis=0)
    offsets = sections - corner
    extent = np.maximum(offsets.max(axis=0), MIN_EXTENT)
    n, cells, scale = COARSEST, np.zeros(1, np.int64), 1.0 / extent
    while n <= FINEST:
        column, line = (offsets * (n / extent)).astype(np.int64).T
        finer = np.unique(column * LINES + line)
        if finer.size > MAX_CELLS and n > COARSEST:
            break
        cells, scale, n = finer, n / extent, 2 * n
    return cells, corner, scale


def loses(exciter: Exciter, impacts: np.ndarray) -> bool:
    """Return whether a motion with impacts (2,) on the supports loses energy: without loss nothing attracts."""
    soft = np.array([exciter.k1, exciter.k2]) > 0
    at = np.where(soft, [exciter.h1 > 0, exciter.h2 > 0], [exciter.R1 < 1, exciter.R2 < 1])
    return exciter.h > 0 or exciter.friction > 0 or bool(at[impacts > 0].any())
