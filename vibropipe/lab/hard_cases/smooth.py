"""Hard cases of the motion between impacts: energy kept, growth, neighbours of resonance, scales, long times."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from vibropipe.lab.hard_cases.analytic import answered, linear, transfer
from vibropipe.lab.hard_cases.case import Bound, Case, Measure, Solver
from vibropipe.lab.hard_cases.invariants import FLIGHTS, WRONG, flights_or_breaches
from vibropipe.physics.exciter import Exciter

TURN = 2.0 * math.pi
EXACT_TURN = "6.28318530717958647692528676655900576839433879875"
IMPACTS = 1_000_000
PERIODS = 1_000_000
MOST_STEPS = 100_000_000


def keeps_energy(f: float) -> Measure:
    """The measure of the largest relative error of the energy over a million ideal impacts under force f.

    Newmark's flights are kept longer than its step: slower motions at coarser steps.
    """

    def measure(solver: Solver) -> float:
        half = 0.05 if solver.steps is None else max(0.05, 1.25 * TURN / solver.steps)
        speed = 0.5 / math.sin(half)
        found = solver.motion(Exciter(l=0.5, f=f), 1.01 * IMPACTS * 2.0 * half, v0=speed)
        if found.sizes["impact"] < IMPACTS * (1.0 if solver.steps is None else 0.9):
            return WRONG
        kept = 0.25 + found["impact_velocity"].values ** 2
        return float(np.max(np.abs(kept / speed**2 - 1.0)))

    return measure


def grows_at_resonance(solver: Solver) -> float:
    """Error after 50 periods, relative to the size: x = (sin tau - tau cos tau)/2, or newmark's own state."""
    tau, p = 50.0 * TURN, Exciter(l=1e9, f=1.0)
    found = solver.motion(p, tau)
    x, v = 0.5 * (math.sin(tau) - tau * math.cos(tau)), 0.5 * tau * math.sin(tau)
    if solver.steps is not None:
        x, v = linear(p, 50, solver.steps)
    miss = math.hypot(float(found["displacement_end"]) - x, float(found["velocity_end"]) - v)
    return miss / math.hypot(x, v)


def grows_by_impacts(solver: Solver) -> float:
    """Error of the impact velocities 4n/3, n = 1 to 1000: support at the equilibrium, nu = 2, no loss."""
    p = Exciter(l=1e9, delta=1e9, nu=2.0, f=1.0)
    count = 1000 if solver.steps is None else 20
    found = solver.motion(p, (count + 0.5) * math.pi)
    known = -4.0 / 3.0 * np.arange(1, count + 1)
    if found.sizes["impact"] != count:
        return WRONG
    return float(np.max(np.abs(found["impact_velocity"].values / known - 1.0)))


def meets_linear(exciters: list[Exciter], periods: int) -> Measure:
    """The measure of the largest error of (x, x') after so many periods, relative to their size."""

    def measure(solver: Solver) -> float:
        worst = 0.0
        for p in exciters:
            found = solver.motion(p, periods * TURN / p.nu)
            x, v = linear(p, periods, solver.steps)
            miss = math.hypot(
                float(found["displacement_end"]) - x, float(found["velocity_end"]) - v
            )
            worst = max(worst, miss / math.hypot(x, v))
        return worst

    return measure


def flies(tasks: list[tuple[Exciter, float, float, float]]) -> Measure:
    """The measure of flights (exact) or breaches (newmark) of motions given by exciter, tau_end, x0, v0."""

    def measure(solver: Solver) -> float:
        return max(flights_or_breaches(solver, *task) for task in tasks)

    return measure


def scales(solver: Solver) -> float:
    """How far a motion scaled in length by 2^-30, 2^30, ... is from the scaled motion."""
    base = {"nu": 1.0, "h": 0.2, "R1": 0.7, "R2": 0.7}
    one = solver.motion(Exciter(**base, l=0.5, f=-1.0, delta=0.01), 40.0)
    worst = 0.0
    for exponent in (-1000, -300, -30, 30, 300, 500):
        by = 2.0**exponent
        p = Exciter(**base, l=0.5 * by, f=-by, delta=0.01 * by)
        other = solver.motion(p, 40.0)
        for name, size in (("impact_velocity", by), ("impact_tau", 1.0), ("displacement_end", by)):
            if one[name].shape != other[name].shape:
                return WRONG
            miss = np.abs(other[name].values / size - one[name].values)
            worst = max(worst, float(np.max(miss, initial=0.0)))
    return worst


def holds_phase(solver: Solver) -> float:
    """Error of phase of the settled linear motion after a million periods (newmark: as many as 1e8 steps are)."""
    worst = 0.0
    for nu in (1.0, 0.7, math.sqrt(3.0)):
        p = Exciter(nu=nu, f=0.3, h=0.3, l=2.0)
        periods = PERIODS if solver.steps is None else min(PERIODS, MOST_STEPS // solver.steps)
        tau = periods * TURN / nu
        found = solver.motion(p, tau)
        # tau is a number of 53 bits: what it is short of whole periods, in exact arithmetic
        left = float(Fraction(tau) * Fraction(nu) - periods * Fraction(EXACT_TURN))
        rate, settled = answered(p, solver.steps), transfer(p, solver.steps)
        settled *= complex(math.cos(left), math.sin(left))
        miss_x = float(found["displacement_end"]) - settled.imag
        miss_v = float(found["velocity_end"]) / rate - settled.real
        worst = max(worst, math.hypot(miss_x, miss_v) / abs(settled))
    return worst


NEUTRAL = [
    Exciter(nu=1.0 + off, f=0.2, l=1e3) for off in (0, 1e-6, -1e-6, 1e-9, -1e-9, 1e-12, -1e-12)
]
CRITICAL = [Exciter(nu=0.8, f=3.0, h=2.0 + off, l=1e3) for off in (0.0, 1e-6, -1e-6, 1e-12, -1e-12)]
WORN = {"nu": 1.0, "f": -1.0, "h": 0.2, "l": 0.5, "R1": 0.7, "R2": 0.7}
DAMPED = [
    (Exciter(f=0.2, l=2.0, h=1e-12, R1=0.9, R2=0.9), 60.0, 0.0, 0.0),
    (Exciter(f=0.2, l=2.0, h=0.0, R1=0.9, R2=0.9), 60.0, 0.0, 0.0),
    (Exciter(nu=0.8, f=3.0, h=2.0, l=0.5, R1=0.3, R2=0.3), 60.0, 0.0, 0.0),
    (Exciter(nu=0.8, f=3.0, h=2.0 + 1e-12, l=0.5, R1=0.3, R2=0.3), 60.0, 0.0, 0.0),
    (Exciter(f=100.0, l=0.5, h=50.0, R1=0.4, R2=0.4), 60.0, 0.0, 0.0),
    (Exciter(f=2e4, l=0.5, h=1e4, R1=0.4, R2=0.4), 12.0, 0.0, 0.0),
]
EXTREME = [
    (Exciter(**WORN | {"nu": 1e4}), 20 * TURN / 1e4, 0.1, 1.0),
    (Exciter(**WORN | {"nu": 1e4, "f": 1e8}), 10 * TURN / 1e4, 0.1, 1.0),
    (Exciter(**WORN | {"f": 0.0}), 20.0, 0.2, 3.0),
    (Exciter(**WORN | {"f": 1e-300}), 20.0, 0.2, 3.0),
    (Exciter(**WORN | {"f": 1e6, "nu": 1e3}), 20 * TURN / 1e3, 0.0, 0.0),
    (Exciter(**WORN | {"l": 1e-9, "f": -2e-9}), 40.0, 0.0, 0.0),
    (Exciter(**WORN | {"l": 1e9, "f": -2e9}), 40.0, 0.0, 0.0),
]
OFFSET = [
    (Exciter(**WORN | {"delta": 0.5}), 40.0, 0.0, 0.0),
    (Exciter(**WORN | {"delta": -0.5}), 40.0, 0.0, 0.0),
    (Exciter(**WORN | {"delta": 0.8, "R1": 0.5, "R2": 0.5}), 40.0, 0.5, 0.0),
    (Exciter(**WORN | {"delta": -0.8, "R1": 0.5, "R2": 0.5}), 40.0, -0.5, 0.0),
    (Exciter(**WORN | {"delta": 50.0, "f": 60.0, "R2": 0.5}), 40.0, 50.0, 0.0),
]
SLOW = [(Exciter(**WORN | {"nu": 1e-4, "R1": 0.4, "R2": 0.4}), 2 * TURN / 1e-4, 0.0, 0.0)]
SMOOTH = (
    Case(
        "ideal_free",
        "R = 1, h = 0, f = 0 over 1e6 impacts",
        "x^2 + x'^2 stays, without drift",
        keeps_energy(0.0),
        Bound(1e-10, 1e-8),
    ),
    Case(
        "ideal_marched",
        "the same with f = 1e-300: every impact is marched to",
        "x^2 + x'^2 stays, without drift",
        keeps_energy(1e-300),
        Bound(1e-10, 1e-8),
    ),
    Case(
        "growth_resonance",
        "resonance without loss, 50 periods",
        "x = (sin tau - tau cos tau)/2; newmark: powers of its one-step matrix",
        grows_at_resonance,
        Bound(1e-12, 1e-10),
    ),
    Case(
        "growth_impacts",
        "resonance of the struck mass: R = 1, h = 0, nu = 2, support at the equilibrium",
        "impact n at 4n/3; exact 1000 of them, newmark 20",
        grows_by_impacts,
        Bound(1e-12, 0.5, 2),
    ),
    Case(
        "near_resonance",
        "h = 0, nu = 1 and 1 +- 1e-6, 1e-9, 1e-12; 6 periods",
        "end by the matrix exponential; newmark: powers of its one-step matrix",
        meets_linear(NEUTRAL, 6),
        Bound(1e-12, 1e-11),
    ),
    Case(
        "near_critical",
        "h = 2 and 2 +- 1e-6, 1e-12; 2 periods",
        "end by the matrix exponential; newmark: powers of its one-step matrix",
        meets_linear(CRITICAL, 2),
        Bound(1e-12, 1e-11),
    ),
    Case(
        "damping",
        "h = 0, 1e-12, 2, 2 + 1e-12, 50, 1e4, with impacts",
        FLIGHTS,
        flies(DAMPED),
        Bound(1e-10, 0.0),
    ),
    Case(
        "extremes",
        "nu = 1e4; f = 0, 1e-300, 1e6, 1e8; l = 1e-9, 1e9",
        FLIGHTS,
        flies(EXTREME),
        Bound(1e-10, 0.0),
    ),
    Case("slow_force", "nu = 1e-4 over two periods", FLIGHTS, flies(SLOW), Bound(1e-9, 0.0)),
    Case("offset", "delta = l, -l, and beyond both", FLIGHTS, flies(OFFSET), Bound(1e-12, 0.0)),
    Case(
        "scale_of_length",
        "l, f, delta times 2^-1000 to 2^500",
        "the same motion, scaled",
        scales,
        Bound(1e-12, 1e-12),
    ),
    Case(
        "million_periods",
        "1e6 periods, nu = 0.7, 1, 3^(1/2); newmark as many as 1e8 steps are",
        "phase of the settled motion; newmark's own by its transfer function",
        holds_phase,
        Bound(1e-9, 1e-8),
    ),
)
