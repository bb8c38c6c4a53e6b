"""Masking of unsolved rows: a row has results only if its motion was solved."""

from __future__ import annotations

import numpy as np

from vibropipe.orbits.housing import LARGEST_SPEED, MEAN
from vibropipe.orbits.results import RowResults
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status

# A row is solved if an orbit was found, or a motion without one was averaged over a window.
SOLVED = (Status.OK, Status.MAX_PERIODS)


def is_solved(status: np.ndarray) -> np.ndarray:
    """Return which rows have results, from their status (rows,)."""
    return np.isin(status, SOLVED)


def mask_unsolved(rows: RowResults) -> RowResults:
    """Remove the results of unsolved rows from compacted results (`solve.row_results`), changed in place.

    Numbers become NaN and contacts are removed; the impacts of unsolved rows are left out of what is returned. A row
    with a required number that is not finite counts as unsolved: status `not_finite`. NaN are samples of a motion
    without an orbit, and the mean and the largest velocity of a housing in one without bound. `section` is kept, since
    the next row of a chain starts from it.
    """
    lost = is_solved(rows.status) & ~_is_finite(rows)
    rows.status[lost] = Status.NOT_FINITE
    unsolved = ~is_solved(rows.status)
    rows.regime[unsolved] = Regime.UNRESOLVED
    for counts in (
        rows.period_multiple,
        rows.window_periods,
        rows.chaos,
        rows.impacts,
        rows.rests,
        rows.grazings,
    ):
        counts[unsolved] = 0
    rows.residual[unsolved] = np.inf
    for values in (
        rows.amplitudes,
        rows.multipliers,
        rows.impact_velocity_max,
        rows.subharmonics,
        rows.poincare,
        rows.exponent,
        rows.energy,
        rows.forces,
        rows.housing,
        rows.housing_harmonics,
    ):
        values[unsolved[: len(values)]] = np.nan
    unbounded = rows.regime == Regime.UNBOUNDED
    # a housing that becomes ever faster has no mean velocity, nor a largest one
    rows.housing[np.ix_(unbounded[: len(rows.housing)], (MEAN, LARGEST_SPEED))] = np.nan
    no_orbit = rows.period_multiple == 0
    rows.motion[no_orbit[: len(rows.motion)]] = np.nan
    return _without_impacts(rows, unsolved)


def _is_finite(rows: RowResults) -> np.ndarray:
    """Return which rows have only finite values among those that a row must have."""
    orbit = rows.period_multiple > 0
    finite: np.ndarray = np.isfinite(rows.section).all(axis=1)
    finite &= ~orbit | (np.isfinite(rows.residual) & (rows.frequency > 0))
    for values, required in (
        (rows.amplitudes, np.ones(orbit.size, bool)),
        (rows.poincare, np.ones(orbit.size, bool)),
        (rows.multipliers, orbit),
        (rows.energy, orbit),
        (rows.housing, np.ones(orbit.size, bool)),
        (rows.motion, orbit),
    ):
        if len(values):
            finite &= ~required | np.isfinite(values).reshape(orbit.size, -1).all(axis=1)
    if len(rows.exponent):
        finite &= ~(
            orbit & np.isnan(rows.exponent).any(axis=1)
        )  # -inf where a rest erases perturbations
    if len(rows.subharmonics):
        multiples = np.arange(rows.subharmonics.shape[1])
        required = multiples % np.maximum(rows.period_multiple, 1)[:, None] > 0
        finite &= (np.isfinite(rows.subharmonics) | ~required).all(axis=1)
    if len(rows.impact_velocity_max):
        finite &= (np.isfinite(rows.impact_velocity_max) | (rows.impacts == 0)).all(axis=1)
    return finite


def _without_impacts(rows: RowResults, unsolved: np.ndarray) -> RowResults:
    """Return the results without the listed impacts of unsolved rows."""
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
