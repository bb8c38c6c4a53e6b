"""Rows that are not solved have no results: what a row says of its motion holds, or is not there."""

from __future__ import annotations

import numpy as np

from vibropipe.orbits.outputs import RowResults
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status

# Solved: an orbit was found, or its absence was measured over a window.
SOLVED = (Status.OK, Status.MAX_PERIODS)


def is_solved(status: np.ndarray) -> np.ndarray:
    """Which rows have results, from the status (rows,) that their march ended with."""
    return np.isin(status, SOLVED)


def mask_unsolved(rows: RowResults) -> RowResults:
    """The same compacted results (`solve.rows`), nan and without contacts where a row is not solved.

    A row that has a number which is none is not solved either: status `not_finite`. Energies and samples are those
    of orbits, and nan of a motion without one. `section` stays: it seeds the next row of a chain.
    """
    lost = is_solved(rows.status) & ~_is_finite(rows)
    rows.status[lost] = Status.NOT_FINITE
    unsolved = ~is_solved(rows.status)
    rows.regime[unsolved] = Regime.UNRESOLVED
    for counts in (rows.period_multiple, rows.window_periods, rows.impacts, rows.rests):
        counts[unsolved] = 0
    rows.residual[unsolved] = np.inf
    for values in (rows.amplitudes, rows.multipliers, rows.impact_velocity_max):
        values[unsolved[: len(values)]] = np.nan
    no_orbit = rows.period_multiple == 0
    for values in (rows.energy, rows.motion):
        values[no_orbit[: len(values)]] = np.nan
    return _without_impacts(rows, unsolved)


def _is_finite(rows: RowResults) -> np.ndarray:
    """Whether all numbers are finite that a row must have, from the arrays there are of size."""
    orbit = rows.period_multiple > 0
    finite: np.ndarray = np.isfinite(rows.section).all(axis=1)
    finite &= ~orbit | (np.isfinite(rows.residual) & (rows.frequency > 0))
    for values, needed in (
        (rows.amplitudes, np.ones(orbit.size, bool)),
        (rows.multipliers, orbit),
        (rows.energy, orbit),
        (rows.motion, orbit),
    ):
        if len(values):
            finite &= ~needed | np.isfinite(values).reshape(orbit.size, -1).all(axis=1)
    if len(rows.impact_velocity_max):
        finite &= (np.isfinite(rows.impact_velocity_max) | (rows.impacts == 0)).all(axis=1)
    return finite


def _without_impacts(rows: RowResults, unsolved: np.ndarray) -> RowResults:
    """The results without the impacts listed of some rows."""
    count = rows.impact_count
    if not count.size or not count[unsolved].any():
        return rows
    kept = ~np.repeat(unsolved, count)
    count[unsolved] = 0
    return rows._replace(
        impact_position=rows.impact_position[kept],
        impact_velocity=rows.impact_velocity[kept],
        impact_support=rows.impact_support[kept],
    )
