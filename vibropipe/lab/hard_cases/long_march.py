"""Classification of a motion by time marching only, for a method that closes no orbits.

The motion is marched for a number of forcing periods, then over a window in which its stroboscopic section is kept. It
repeats after m periods if its remaining distance to the limit, extrapolated from its changes as a geometric series, is
negligible. A small change per period is no criterion: slow drift shows it too.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibropipe.lab.hard_cases.case import Solver, end_state
from vibropipe.orbits.outputs import regime_of
from vibropipe.orbits.recurrence import MAX_MULTIPLE
from vibropipe.orbits.verdict import GROWTH_FACTOR
from vibropipe.physics.exciter import Exciter
from vibropipe.words.regimes import Regime

if TYPE_CHECKING:
    import xarray as xr

WINDOW = 4 * MAX_MULTIPLE
# Relative to the size of the motion: largest remaining distance of a settled motion, and changes that are rounding.
SETTLING_TOLERANCE, ROUNDING = 1e-6, 1e-12


class MarchedState(NamedTuple):
    """Classified motion.

    period_multiple : 0 if nothing repeats; section : (x, v) at the last period's end; last_impact : velocity of the
    last impact, nan without one; orbit : the closed orbit, of which section and last_impact are not computed.
    """

    regime: int
    period_multiple: int
    section: tuple[float, float] = (math.nan, math.nan)
    last_impact: float = math.nan
    orbit: xr.Dataset | None = None


def classify(
    solver: Solver, exciter: Exciter, periods: int, x0: float = 0.0, v0: float = 0.0
) -> MarchedState:
    """Classify the motion from (x0, v0): by its steady state (exact), or by `marched_state`."""
    if solver.steps is not None:
        return marched_state(solver, exciter, periods, x0, v0)
    steady = solver.solve_steady(exciter, x0, v0)
    return MarchedState(int(steady["regime"]), int(steady["period_multiple"]), orbit=steady)


def marched_state(
    solver: Solver, exciter: Exciter, periods: int, x0: float = 0.0, v0: float = 0.0
) -> MarchedState:
    """Classify the motion from (x0, v0) after `periods` forcing periods and a window."""
    half = periods // 2
    early_size, x, v = _marched(solver, exciter, half, x0, v0)
    late_size, x, v = _marched(solver, exciter, periods - half, x, v)
    window = solver.motion(exciter, WINDOW * exciter.period, x, v, samples_per_period=1)
    sections = np.column_stack([window["displacement"], window["velocity"]])
    size = max(float(np.abs(sections).sum(axis=1).max()), _fastest(window))
    m = period_multiple_of(sections, size)
    regime = Regime.APERIODIC
    if m > 0:
        regime = Regime(regime_of(*_contacts(exciter, window, WINDOW - m)))
    elif late_size > GROWTH_FACTOR * early_size:
        # A motion that loses energy with its speed is bounded: if it grows, it has not settled yet.
        R = {1: exciter.R1, 2: exciter.R2}
        is_lossy = any(R[int(support)] < 1.0 for support in window["impact_support"])
        regime = Regime.UNRESOLVED if exciter.h > 0.0 or is_lossy else Regime.UNBOUNDED
    last_impact = np.append(math.nan, window["impact_velocity"].values)[-1]
    return MarchedState(
        regime, m, (float(sections[-1, 0]), float(sections[-1, 1])), float(last_impact)
    )


def period_multiple_of(sections: np.ndarray, size: float) -> int:
    """Return the smallest number of periods after which sections (periods, 2) repeat, 0 if they do not."""
    if not any(_has_arrived(sections, m, size) for m in range(1, MAX_MULTIPLE + 1)):
        return 0
    # A spiralling motion nearly returns after some multiples before it does after one.
    changes = np.abs(sections[-1] - sections[-1 - MAX_MULTIPLE : -1]).sum(axis=1)[::-1]
    return int(np.argmax(changes <= 4.0 * SETTLING_TOLERANCE * size)) + 1


def _has_arrived(sections: np.ndarray, m: int, size: float) -> bool:
    """Return whether the remaining distance of a section that changes geometrically over m periods is negligible."""
    changes = np.abs(sections[m:] - sections[:-m]).sum(axis=1)
    half = changes.size // 2
    before, now = float(changes[:half].max()), float(changes[-half:].max())
    if now <= ROUNDING * size:
        return True
    rate = (now / before) ** (m / (changes.size - half))
    return now * rate < SETTLING_TOLERANCE * size * (1.0 - rate)


def _marched(
    solver: Solver, exciter: Exciter, periods: int, x: float, v: float
) -> tuple[float, float, float]:
    """Return (size, x, v) after `periods` further forcing periods, each march starting at tau = 0, the same phase."""
    motion = solver.motion(exciter, periods * exciter.period, x, v)
    x, v = end_state(motion)
    return max(abs(x) + abs(v), _fastest(motion)), min(max(x, exciter.lower), exciter.upper), v


def _fastest(motion: xr.Dataset) -> float:
    """Return the largest impact speed of a motion."""
    return float(np.max(np.abs(motion["impact_velocity"].values), initial=0.0))


def _contacts(exciter: Exciter, window: xr.Dataset, since: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of impacts and rests on each support since a whole period."""
    tau_start = since * exciter.period
    struck = window["impact_support"].values[window["impact_tau"].values > tau_start]
    rested = window["rest_support"].values[window["rest_end"].values > tau_start]
    impacts, rests = (np.array([np.sum(s == 1), np.sum(s == 2)], float) for s in (struck, rested))
    return impacts, rests
