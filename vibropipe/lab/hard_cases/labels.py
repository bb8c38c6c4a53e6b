"""Hard cases of what is said of a motion: labels of steady states, symmetries, and input that is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from vibropipe.lab.hard_cases.analytic import answered, transfer
from vibropipe.lab.hard_cases.case import Bound, Case, Solver
from vibropipe.lab.hard_cases.invariants import WRONG
from vibropipe.lab.hard_cases.long_march import end_of
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
PERIODS, MANY_PERIODS, MOST_STEPS = 1000, 8000, 100_000_000


def unbounded(solver: Solver) -> float:
    """Wrong labels of motions that grow without bound: with supports never reached, and with impacts; by newmark,
    of the first at the frequency at which that method resonates."""
    if solver.steps is not None:
        nu = 1.0 / answered(Exciter(l=1.0), solver.steps)
        return end_of(solver, Exciter(l=1e9, f=1.0, nu=nu), PERIODS).regime != Regime.UNBOUNDED
    cases = (Exciter(l=1e9, f=1.0), Exciter(l=1e9, delta=1e9, nu=2.0, f=1.0))
    return sum(int(solver.settled(p)["regime"]) != Regime.UNBOUNDED for p in cases)


def multiples(solver: Solver) -> float:
    """Wrong period multiples of 1, 2, 4, ..., 32: a mass on its own half period is struck once in m of the force."""
    wrong = 0
    for m in (1, 2, 3, 4, 5, 8, 16, 32):
        p = Exciter(l=50.0, delta=50.0, nu=2.0 * m, f=1.0, h=0.01, R2=0.6)
        if solver.steps is not None:
            ended = end_of(solver, p, PERIODS, v0=1.0)
            wrong += ended.period_multiple != m or ended.regime != Regime.ONE_SIDED_2
            continue
        found = solver.settled(p, v0=1.0)
        wrong += int(found["period_multiple"]) != m or int(found["regime"]) != Regime.ONE_SIDED_2
        wrong += not bool(found["stable"])
    return wrong


def weakly_stable(solver: Solver) -> float:
    """Error of amplitude and multipliers of linear motions that forget their start slowly, from far off; by
    newmark, of the section of its own settled motion, the slowest of which it may not have reached."""
    worst = 0.0
    for multiplier in (0.9, 0.99, 0.999, 0.9999):
        nu = 1.5
        p = Exciter(nu=nu, f=0.1, h=-math.log(multiplier) * nu / math.pi, l=2.0)
        if solver.steps is not None:
            periods = min(int(20.0 / -math.log(multiplier)), MOST_STEPS // solver.steps)
            ended, known = end_of(solver, p, periods, x0=1.0), transfer(p, solver.steps)
            if ended.period_multiple == 0 and multiplier > 0.999:
                continue
            if ended.regime != Regime.NO_IMPACT or ended.period_multiple != 1:
                return WRONG
            worst = max(worst, abs(ended.section[0] - known.imag) / abs(known))
            continue
        found = solver.settled(p, x0=1.0)
        if int(found["regime"]) != Regime.NO_IMPACT or int(found["period_multiple"]) != 1:
            return WRONG
        size = abs(transfer(p, None))
        worst = max(worst, abs(float(found["displacement_amplitude"][0]) / size - 1.0))
        off = np.abs(found["floquet_multiplier"].values) / multiplier - 1.0
        worst = max(worst, float(np.max(np.abs(off))))
    return worst


def drifts(solver: Solver) -> float:
    """Error of the impact velocity (4/3)/(1 - R) that a struck mass comes nearer to by 1 - R in a period.

    Not to have settled within the bound on periods is no error where that takes longer; "settled" elsewhere, or
    "unbounded", is. By newmark, how far what is said to have settled goes on to drift.
    """
    worst = 0.0
    for R in (0.9, 0.99, 0.999, 0.9999):
        p = Exciter(l=1e5, delta=1e5, nu=2.0, f=1.0, R2=R)
        if solver.steps is not None:
            soon, late = (end_of(solver, p, periods) for periods in (PERIODS, MANY_PERIODS))
            if R < 0.99 and not soon.period_multiple == late.period_multiple == 1:
                return WRONG
            if Regime.UNBOUNDED in (soon.regime, late.regime):
                return WRONG
            if soon.period_multiple > 0:
                if soon.regime != Regime.ONE_SIDED_2:
                    return WRONG
                worst = max(worst, abs(soon.last_impact / late.last_impact - 1.0))
            continue
        found = solver.settled(p)
        if int(found["period_multiple"]) == 0 and R >= 0.99:
            if int(found["regime"]) not in (Regime.APERIODIC, Regime.UNRESOLVED):
                return WRONG
            continue
        if int(found["period_multiple"]) != 1 or found.sizes["impact"] != 1:
            return WRONG
        known = -4.0 / 3.0 / (1.0 - R)
        worst = max(worst, abs(float(found["impact_velocity"][0]) / known - 1.0))
    return worst


def coexisting(solver: Solver) -> float:
    """Wrong labels of two attractors of one exciter: left alone it strikes nothing, started hard it strikes."""
    p = Exciter(nu=1.6, f=0.25, h=0.05, l=0.5, R1=0.8, R2=0.8)
    known = transfer(p, solver.steps)

    def ends(x0: float, v0: float) -> int:
        if solver.steps is not None:
            return end_of(solver, p, PERIODS, x0, v0).regime
        return int(solver.settled(p, x0=x0, v0=v0)["regime"])

    wrong = ends(known.imag, answered(p, solver.steps) * known.real) != Regime.NO_IMPACT
    return wrong + all(ends(0.5, -v0) != Regime.TWO_SIDED for v0 in (1.0, 1.5, 2.0))


def mirrored(solver: Solver) -> float:
    """Numbers that differ, in the last bit or more, between a motion and the mirrored one of the mirrored exciter."""
    differ = 0
    for p in MIRRORED:
        x0, v0 = 0.5 * (p.upper + p.lower), 0.3
        one = solver.motion(p, 40.0, x0, v0)
        two = solver.motion(p.mirrored(), 40.0, -x0, -v0)
        for name in one.data_vars:
            if one[name].shape != two[name].shape:
                return WRONG
            held = two[name].values
            if name in SWAPPED:
                held = 3 - held
            elif "velocity" in str(name) or "displacement" in str(name):
                held = -held
            differ += int(np.count_nonzero(one[name].values != held))
    return differ


def split(solver: Solver) -> float:
    """Largest change of the end of a motion when it is cut in two, at five instants: by exact, at any; by newmark,
    at the ends of its steps."""
    worst = 0.0
    for p in MIRRORED[:3]:
        whole = solver.motion(p, 20.0)
        for share in (0.1, 0.3, 0.5, 0.7, 0.9):
            cut = 20.0 * share
            if solver.steps is not None:
                dt = 2.0 * math.pi / p.nu / solver.steps
                cut = round(cut / dt) * dt
            first = solver.motion(p, cut)
            x, v = float(first["displacement_end"]), float(first["velocity_end"])
            second = solver.motion(p, 20.0, x, v, tau_start=cut)
            for name in ("displacement_end", "velocity_end"):
                worst = max(worst, abs(float(second[name]) - float(whole[name])))
    return worst


def refuses(solver: Solver) -> float:
    """Bad input that is taken, or refused without its name."""
    good: dict[str, Any] = {"l": 0.5, "nu": 1.0, "f": 1.0, "h": 0.1, "R1": 0.5, "R2": 0.5}
    wrong = 0
    for name, value in BAD:
        given: dict[str, Any] = {"x0": 0.0, "v0": 0.0, "tau_end": 1.0}
        try:
            if name in given:
                given[name] = value
                solver.motion(Exciter(**good), **given)
            else:
                Exciter(**{**good, name: value})
            wrong += 1
        except ParameterError as error:
            wrong += name not in str(error)
    return wrong


LABELS = (
    Case(
        "unbounded",
        "resonance at R = 1, h = 0: the motion grows for ever",
        "labelled unbounded, with and without impacts; newmark: at its own resonance; wrong of 2",
        unbounded,
        Bound(0.0, 0.0),
    ),
    Case(
        "period_multiples",
        "orbits of 1, 2, 3, 4, 5, 8, 16, 32 periods",
        "struck once in m periods, nu = 2m, stable; wrong of 8",
        multiples,
        Bound(0.0, 0.0),
    ),
    Case(
        "weakly_stable",
        "multipliers 0.9 to 0.9999, started far off",
        "amplitude |f|/|1 - nu^2 + i h nu| and multiplier; newmark: its own settled motion",
        weakly_stable,
        Bound(1e-10, 1e-5),
    ),
    Case(
        "slow_drift",
        "struck mass that goes 1 - R of its way in a period, R = 0.9 to 0.9999",
        "impact velocity (4/3)/(1 - R), or said not to have settled; newmark: settled is settled",
        drifts,
        Bound(1e-9, 1e-5),
    ),
    Case(
        "coexisting",
        "two attractors of one exciter",
        "no impact from its own orbit, two-sided if started hard; wrong of 2",
        coexisting,
        Bound(0.0, 0.0),
    ),
    Case(
        "mirrored",
        "five exciters and their mirror images",
        "mirrored to the last bit; numbers that differ",
        mirrored,
        Bound(0.0, 0.0),
    ),
    Case(
        "split",
        "motions cut in two and gone on with",
        "the same end",
        split,
        Bound(1e-9, 1e-9),
    ),
    Case(
        "refused",
        "nan, inf, negative h or l, R outside [0, 1], nu < 0, start outside the supports",
        f"refused by name; wrong of {len(BAD)}",
        refuses,
        Bound(0.0, 0.0),
    ),
)
