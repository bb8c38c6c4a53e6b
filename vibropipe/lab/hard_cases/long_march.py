"""Where a motion ends that is only marched: the label of a steady state, for a method that closes no orbits.

The motion is marched for so many forcing periods, then for a window of them in which its section is kept. It
repeats after m periods if what is left of its way to where it goes, by the geometric series of its changes, is
nothing to speak of: a slow drift changes little in a period, and has far to go all the same.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibropipe.lab.hard_cases.case import Solver, end_state
from vibropipe.orbits.outputs import regime_of
from vibropipe.orbits.recurrence import MAX_MULTIPLE
from vibropipe.orbits.settling import GROWTH_FACTOR
from vibropipe.physics.exciter import Exciter
from vibropipe.words.regimes import Regime

if TYPE_CHECKING:
    import xarray as xr

WINDOW = 4 * MAX_MULTIPLE
# Shares of the motion's size: what may be left of its way, and what rounding makes of a motion at its end.
LEFT, ROUNDING = 1e-6, 1e-12


class MarchedState(NamedTuple):
    """regime, period_multiple (0: nothing repeats); of a motion that is only marched section (x, v) at the last
    whole period, and the velocity of the last impact (nan: none); else the orbit that was closed."""

    regime: int
    period_multiple: int
    section: tuple[float, float] = (math.nan, math.nan)
    last_impact: float = math.nan
    orbit: xr.Dataset | None = None


def fate_of(
    solver: Solver, exciter: Exciter, periods: int, x0: float = 0.0, v0: float = 0.0
) -> MarchedState:
    """What the motion from (x0, v0) becomes: the steady state of the exact method, else `marched_state` a march."""
    if solver.steps is not None:
        return marched_state(solver, exciter, periods, x0, v0)
    found = solver.solve_steady(exciter, x0, v0)
    return MarchedState(int(found["regime"]), int(found["period_multiple"]), orbit=found)


def marched_state(
    solver: Solver, exciter: Exciter, periods: int, x0: float = 0.0, v0: float = 0.0
) -> MarchedState:
    """What the motion from (x0, v0) has become after `periods` forcing periods and a window."""
    half = periods // 2
    early, x, v = _marched(solver, exciter, half, x0, v0)
    late, x, v = _marched(solver, exciter, periods - half, x, v)
    window = solver.motion(exciter, WINDOW * exciter.period, x, v, samples_per_period=1)
    sections = np.column_stack([window["displacement"], window["velocity"]])
    size = max(float(np.abs(sections).sum(axis=1).max()), _fastest(window))
    m = multiple_of(sections, size)
    regime = Regime.APERIODIC
    if m > 0:
        regime = Regime(regime_of(*_contacts(exciter, window, WINDOW - m)))
    elif late > GROWTH_FACTOR * early:
        # What loses energy by its speed is bounded: if it grows, it has only not settled yet.
        struck = {1: exciter.R1, 2: exciter.R2}
        lossy = any(struck[int(support)] < 1.0 for support in window["impact_support"])
        regime = Regime.UNRESOLVED if exciter.h > 0.0 or lossy else Regime.UNBOUNDED
    last = np.append(math.nan, window["impact_velocity"].values)[-1]
    return MarchedState(regime, m, (float(sections[-1, 0]), float(sections[-1, 1])), float(last))


def multiple_of(sections: np.ndarray, size: float) -> int:
    """The least number of periods after which sections (periods, 2) repeat, as said above; 0 if there is none."""
    if not any(_has_arrived(sections, m, size) for m in range(1, MAX_MULTIPLE + 1)):
        return 0
    # A motion that spirals in is near after some multiples before it is near after one.
    changes = np.abs(sections[-1] - sections[-1 - MAX_MULTIPLE : -1]).sum(axis=1)[::-1]
    return int(np.argmax(changes <= 4.0 * LEFT * size)) + 1


def _has_arrived(sections: np.ndarray, m: int, size: float) -> bool:
    """Whether little is left of the way of a section whose changes over m periods shrink as they did."""
    changes = np.abs(sections[m:] - sections[:-m]).sum(axis=1)
    half = changes.size // 2
    before, now = float(changes[:half].max()), float(changes[-half:].max())
    if now <= ROUNDING * size:
        return True
    rate = (now / before) ** (m / (changes.size - half))
    return now * rate < LEFT * size * (1.0 - rate)


def _marched(
    solver: Solver, exciter: Exciter, periods: int, x: float, v: float
) -> tuple[float, float, float]:
    """(size, x, v) after so many forcing periods more, each counted from tau = 0: it is the same phase."""
    found = solver.motion(exciter, periods * exciter.period, x, v)
    x, v = end_state(found)
    return max(abs(x) + abs(v), _fastest(found)), min(max(x, exciter.lower), exciter.upper), v


def _fastest(motion: xr.Dataset) -> float:
    return float(np.max(np.abs(motion["impact_velocity"].values), initial=0.0))


def _contacts(exciter: Exciter, window: xr.Dataset, since: int) -> tuple[np.ndarray, np.ndarray]:
    """Impacts and rests on each support since a whole period."""
    begin = since * exciter.period
    struck = window["impact_support"].values[window["impact_tau"].values > begin]
    rested = window["rest_support"].values[window["rest_end"].values > begin]
    impacts, rests = (np.array([np.sum(s == 1), np.sum(s == 2)], float) for s in (struck, rested))
    return impacts, rests
