"""Hard cases of what is said of a motion: labels of steady states, symmetries, and input that is refused."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from vibropipe.lab.hard_cases.analytic import effective_frequency, transfer
from vibropipe.lab.hard_cases.case import Solver, count, end_state, expect, largest
from vibropipe.lab.hard_cases.long_march import fate_of, marched_state
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.words.regimes import Regime

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


# Forcing periods that Newmark's method is marched for, and most steps.
PERIODS, MANY_PERIODS, MAX_STEPS = 1000, 8000, 100_000_000


@count
def unbounded(solver: Solver) -> Iterator[bool]:
    """Wrong labels of motions that grow without bound: with supports never reached, and with impacts; by newmark,
    of the first at the frequency at which that method resonates."""
    cases = [Exciter(l=1e9, f=1.0), Exciter(l=1e9, delta=1e9, nu=2.0, f=1.0)]
    if solver.steps is not None:
        cases = [Exciter(l=1e9, f=1.0, nu=1.0 / effective_frequency(Exciter(l=1.0), solver.steps))]
    for exciter in cases:
        yield fate_of(solver, exciter, PERIODS).regime != Regime.UNBOUNDED


@count
def multiples(solver: Solver) -> Iterator[bool]:
    """Wrong period multiples of 1, 2, 4, ..., 32: a mass on its own half period is struck once in m of the force."""
    for m in (1, 2, 3, 4, 5, 8, 16, 32):
        exciter = Exciter(l=50.0, delta=50.0, nu=2.0 * m, f=1.0, h=0.01, R2=0.6)
        ended = fate_of(solver, exciter, PERIODS, v0=1.0)
        yield ended.period_multiple != m or ended.regime != Regime.ONE_SIDED_2
        yield ended.orbit is not None and not bool(ended.orbit["stable"])


@largest
def weakly_stable(solver: Solver) -> Iterator[float]:
    """Error of amplitude and multipliers of linear motions that forget their start slowly, from far off; by
    newmark, of the section of its own settled motion, the slowest of which it may not have reached."""
    for multiplier in (0.9, 0.99, 0.999, 0.9999):
        nu = 1.5
        exciter = Exciter(nu=nu, f=0.1, h=-math.log(multiplier) * nu / math.pi, l=2.0)
        periods = min(int(20.0 / -math.log(multiplier)), MAX_STEPS // (solver.steps or 1))
        ended, expected = fate_of(solver, exciter, periods, x0=1.0), transfer(exciter, solver.steps)
        if solver.steps is not None and ended.period_multiple == 0 and multiplier > 0.999:
            continue
        expect(ended.regime == Regime.NO_IMPACT and ended.period_multiple == 1)
        if ended.orbit is None:
            yield abs(ended.section[0] - expected.imag) / abs(expected)
        else:
            yield abs(float(ended.orbit["displacement_amplitude"][0]) / abs(expected) - 1.0)
            off = np.abs(ended.orbit["floquet_multiplier"].values) / multiplier - 1.0
            yield float(np.max(np.abs(off)))


@largest
def drifts(solver: Solver) -> Iterator[float]:
    """Error of the impact velocity (4/3)/(1 - R) that a struck mass comes nearer to by 1 - R in a period.

    Not to have settled within the bound on periods is no error where that takes longer; "settled" elsewhere, or
    "unbounded", is. By newmark, how far what is said to have settled goes on to drift.
    """
    for R in (0.9, 0.99, 0.999, 0.9999):
        exciter = Exciter(l=1e5, delta=1e5, nu=2.0, f=1.0, R2=R)
        soon = fate_of(solver, exciter, PERIODS)
        if soon.orbit is None:
            late = marched_state(solver, exciter, MANY_PERIODS)
            expect(R >= 0.99 or soon.period_multiple == late.period_multiple == 1)
            expect(Regime.UNBOUNDED not in (soon.regime, late.regime))
            if soon.period_multiple > 0:
                expect(soon.regime == Regime.ONE_SIDED_2)
                yield abs(soon.last_impact / late.last_impact - 1.0)
        elif soon.period_multiple == 0 and R >= 0.99:
            expect(soon.regime in (Regime.APERIODIC, Regime.UNRESOLVED))
        else:
            expect(soon.period_multiple == 1 and soon.orbit.sizes["impact"] == 1)
            expected = -4.0 / 3.0 / (1.0 - R)
            yield abs(float(soon.orbit["impact_velocity"][0]) / expected - 1.0)


@count
def coexisting(solver: Solver) -> Iterator[bool]:
    """Wrong labels of two attractors of one exciter: left alone it strikes nothing, started hard it strikes."""
    exciter = Exciter(nu=1.6, f=0.25, h=0.05, l=0.5, R1=0.8, R2=0.8)
    expected = transfer(exciter, solver.steps)
    rate = effective_frequency(exciter, solver.steps) * expected.real
    yield fate_of(solver, exciter, PERIODS, expected.imag, rate).regime != Regime.NO_IMPACT
    hard = (fate_of(solver, exciter, PERIODS, 0.5, -v0) for v0 in (1.0, 1.5, 2.0))
    yield all(ended.regime != Regime.TWO_SIDED for ended in hard)


@count
def mirrored(solver: Solver) -> Iterator[int]:
    """Numbers that differ, in the last bit or more, between a motion and the mirrored one of the mirrored exciter."""
    for exciter in MIRRORED:
        x0, v0 = 0.5 * (exciter.upper + exciter.lower), 0.3
        one = solver.motion(exciter, 40.0, x0, v0)
        two = solver.motion(exciter.mirrored(), 40.0, -x0, -v0)
        for name in one.data_vars:
            expect(one[name].shape == two[name].shape)
            held = two[name].values
            if name in SWAPPED:
                held = 3 - held
            elif "velocity" in str(name) or "displacement" in str(name):
                held = -held
            yield int(np.count_nonzero(one[name].values != held))


@largest
def split(solver: Solver) -> Iterator[float]:
    """Largest change of the end of a motion when it is cut in two, at five instants: by exact, at any; by newmark,
    at the ends of its steps."""
    for exciter in MIRRORED[:3]:
        whole = end_state(solver.motion(exciter, 20.0))
        for share in (0.1, 0.3, 0.5, 0.7, 0.9):
            cut = 20.0 * share
            if solver.steps is not None:
                dt = 2.0 * math.pi / exciter.nu / solver.steps
                cut = round(cut / dt) * dt
            first = end_state(solver.motion(exciter, cut))
            second = end_state(solver.motion(exciter, 20.0, *first, tau_start=cut))
            yield from (abs(b - a) for a, b in zip(whole, second, strict=True))


@count
def rejects_bad_input(solver: Solver) -> Iterator[bool]:
    """Bad input that is taken, or refused without its name."""
    good: dict[str, Any] = {"l": 0.5, "nu": 1.0, "f": 1.0, "h": 0.1, "R1": 0.5, "R2": 0.5}
    for name, value in BAD:
        given: dict[str, Any] = {"x0": 0.0, "v0": 0.0, "tau_end": 1.0}
        try:
            if name in given:
                solver.motion(Exciter(**good), **given | {name: value})
            else:
                Exciter(**good | {name: value})
            yield True
        except ParameterError as error:
            yield name not in str(error)
