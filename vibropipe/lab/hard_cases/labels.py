"""Hard cases of labels of steady states, of symmetry, of restarts, and of rejected input.

A method that closes no orbits labels by marching: for a number of forcing periods, then over a window in which its
stroboscopic section is kept. The motion repeats after m periods if its remaining distance to the limit, extrapolated
from its changes as a geometric series, is negligible. A small change per period is no criterion: slow drift
shows it too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibropipe.lab.hard_cases.analytic import effective_frequency, response
from vibropipe.lab.hard_cases.case import Solver, count_wrong, end_state, expect, largest_error
from vibropipe.orbits.outputs import regime_of
from vibropipe.orbits.recurrence import MAX_MULTIPLE
from vibropipe.orbits.verdict import GROWTH_FACTOR
from vibropipe.physics.exciter import Exciter, ParameterError
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
    return float(np.max(np.abs(motion["impact_velocity"].values), initial=0.0))


def _contacts(exciter: Exciter, window: xr.Dataset, since: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers of impacts and rests on each support since a whole period."""
    tau_start = since * exciter.period
    struck = window["impact_support"].values[window["impact_tau"].values > tau_start]
    rested = window["rest_support"].values[window["rest_end"].values > tau_start]
    impacts, rests = (np.array([np.sum(s == 1), np.sum(s == 2)], float) for s in (struck, rested))
    return impacts, rests


MIRRORED = (
    Exciter(nu=1.0, f=-1.0, h=0.2, l=0.5, delta=0.01, R1=0.6, R2=0.8),
    Exciter(nu=0.3, f=1.5, h=0.2, l=0.5, R1=0.5, R2=0.9),
    Exciter(nu=0.7, f=1.2, h=0.2, l=0.5, R1=0.0, R2=0.8),
    Exciter(nu=2.9, f=9.0, h=0.01, l=0.5, delta=-0.3, R1=0.95, R2=1.0),
    Exciter(nu=1.0, f=0.2, h=0.0, l=0.5, delta=0.7, R1=0.9, R2=0.9),
)
SWAPPED = ("impact_support", "rest_support", "grazing_support")
BAD = (
    *((name, value) for name in ("nu", "f", "h", "l", "delta", "R1", "R2")
      for value in (math.nan, math.inf, -math.inf)),
    ("nu", -1.0), ("h", -1e-9), ("l", -0.5), ("l", 0.0),
    ("R1", 1.0000001), ("R1", -0.1), ("R2", 2.0), ("R2", -1e-300),
    ("x0", 0.6), ("x0", -0.5000001), ("x0", math.nan), ("v0", math.inf), ("tau_end", -1.0),
)  # fmt: skip


# Forcing periods that Newmark's method marches (of slow drift: many), and the limit of its steps in one motion.
PERIODS, MANY_PERIODS, MAX_STEPS = 1000, 8000, 100_000_000


@count_wrong
def unbounded(solver: Solver) -> Iterator[bool]:
    """Wrong labels of motions that grow without bound, without and with impacts.

    By newmark, only the first, at the frequency at which that method resonates.
    """
    cases = [Exciter(l=1e9, nu=1.0, f=1.0), Exciter(l=1e9, delta=1e9, nu=2.0, f=1.0)]
    if solver.steps is not None:
        cases = [Exciter(l=1e9, f=1.0, nu=1.0 / effective_frequency(Exciter(l=1.0), solver.steps))]
    for exciter in cases:
        yield classify(solver, exciter, PERIODS).regime != Regime.UNBOUNDED


@count_wrong
def multiples(solver: Solver) -> Iterator[bool]:
    """Wrong period multiples 1 to 32: a mass with half its own period between impacts, struck once in m periods."""
    for m in (1, 2, 3, 4, 5, 8, 16, 32):
        exciter = Exciter(l=50.0, delta=50.0, nu=2.0 * m, f=1.0, h=0.01, R2=0.6)
        state = classify(solver, exciter, PERIODS, v0=1.0)
        yield state.period_multiple != m or state.regime != Regime.ONE_SIDED_2
        yield state.orbit is not None and not bool(state.orbit["stable"])


@largest_error
def weakly_stable(solver: Solver) -> Iterator[float]:
    """Error of amplitude and multipliers of linear motions with long transients, started far off.

    By newmark, of the section of its own steady motion; the slowest transient need not have decayed.
    """
    for multiplier in (0.9, 0.99, 0.999, 0.9999):
        nu = 1.5
        exciter = Exciter(nu=nu, f=0.1, h=-math.log(multiplier) * nu / math.pi, l=2.0)
        periods = min(int(20.0 / -math.log(multiplier)), MAX_STEPS // (solver.steps or 1))
        state = classify(solver, exciter, periods, x0=1.0)
        expected = response(exciter, solver.steps)
        if solver.steps is not None and state.period_multiple == 0 and multiplier > 0.999:
            continue
        expect(state.regime == Regime.NO_IMPACT and state.period_multiple == 1)
        if state.orbit is None:
            yield abs(state.section[0] - expected.imag) / abs(expected)
        else:
            yield abs(float(state.orbit["displacement_amplitude"][0]) / abs(expected) - 1.0)
            deviation = np.abs(state.orbit["floquet_multiplier"].values) / multiplier - 1.0
            yield float(np.max(np.abs(deviation)))


@largest_error
def drifts(solver: Solver) -> Iterator[float]:
    """Error of the impact velocity (4/3)/(1 - R) that a struck mass approaches by 1 - R in a period.

    A row that has not settled within the limit of periods is no error where settling takes longer; "settled" elsewhere,
    or "unbounded", is. By newmark, the drift of motions reported as settled.
    """
    for R in (0.9, 0.99, 0.999, 0.9999):
        exciter = Exciter(l=1e5, delta=1e5, nu=2.0, f=1.0, R2=R)
        state = classify(solver, exciter, PERIODS)
        if state.orbit is None:
            later_state = marched_state(solver, exciter, MANY_PERIODS)
            expect(R >= 0.99 or state.period_multiple == later_state.period_multiple == 1)
            expect(Regime.UNBOUNDED not in (state.regime, later_state.regime))
            if state.period_multiple > 0:
                expect(state.regime == Regime.ONE_SIDED_2)
                yield abs(state.last_impact / later_state.last_impact - 1.0)
        elif state.period_multiple == 0 and R >= 0.99:
            expect(state.regime in (Regime.APERIODIC, Regime.UNRESOLVED))
        else:
            expect(state.period_multiple == 1 and state.orbit.sizes["impact"] == 1)
            expected = -4.0 / 3.0 / (1.0 - R)
            yield abs(float(state.orbit["impact_velocity"][0]) / expected - 1.0)


@count_wrong
def coexisting(solver: Solver) -> Iterator[bool]:
    """Wrong labels of two attractors: without impact from its own orbit, two-sided if started at high velocity."""
    exciter = Exciter(nu=1.6, f=0.25, h=0.05, l=0.5, R1=0.8, R2=0.8)
    expected = response(exciter, solver.steps)
    velocity = effective_frequency(exciter, solver.steps) * expected.real
    yield classify(solver, exciter, PERIODS, expected.imag, velocity).regime != Regime.NO_IMPACT
    fast_starts = (classify(solver, exciter, PERIODS, 0.5, -v0) for v0 in (1.0, 1.5, 2.0))
    yield all(state.regime != Regime.TWO_SIDED for state in fast_starts)


@count_wrong
def mirrored(solver: Solver) -> Iterator[int]:
    """Number of values that differ in any bit between a motion and the mirrored motion of the mirrored exciter."""
    for exciter in MIRRORED:
        x0, v0 = 0.5 * (exciter.upper + exciter.lower), 0.3
        motion = solver.motion(exciter, 40.0, x0, v0)
        mirrored_motion = solver.motion(exciter.mirrored(), 40.0, -x0, -v0)
        for name in motion.data_vars:
            expect(motion[name].shape == mirrored_motion[name].shape)
            values = mirrored_motion[name].values
            if name in SWAPPED:
                values = 3 - values
            elif "velocity" in str(name) or "displacement" in str(name):
                values = -values
            yield int(np.count_nonzero(motion[name].values != values))


@largest_error
def split(solver: Solver) -> Iterator[float]:
    """Largest change of the end of a motion that is split in two: at any time (exact), at ends of steps (newmark)."""
    for exciter in MIRRORED[:3]:
        unsplit = end_state(solver.motion(exciter, 20.0))
        for fraction in (0.1, 0.3, 0.5, 0.7, 0.9):
            tau_cut = 20.0 * fraction
            if solver.steps is not None:
                dt = 2.0 * math.pi / exciter.nu / solver.steps
                tau_cut = round(tau_cut / dt) * dt
            first = end_state(solver.motion(exciter, tau_cut))
            second = end_state(solver.motion(exciter, 20.0, *first, tau_start=tau_cut))
            yield from (abs(b - a) for a, b in zip(unsplit, second, strict=True))


@count_wrong
def rejects_bad_input(solver: Solver) -> Iterator[bool]:
    """Bad input that is accepted, or rejected without its name."""
    parameters: dict[str, Any] = {"l": 0.5, "nu": 1.0, "f": 1.0, "h": 0.1, "R1": 0.5, "R2": 0.5}
    for name, value in BAD:
        start: dict[str, Any] = {"x0": 0.0, "v0": 0.0, "tau_end": 1.0}
        try:
            if name in start:
                solver.motion(Exciter(**parameters), **start | {name: value})
            else:
                Exciter(**parameters | {name: value})
            yield True
        except ParameterError as error:
            yield name not in str(error)
