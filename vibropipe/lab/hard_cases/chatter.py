"""Hard cases of chatter and of plastic supports: accumulation, rest, release."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

from vibropipe.lab.hard_cases.case import Solver, expect, largest
from vibropipe.lab.hard_cases.invariants import flights_or_violations
from vibropipe.physics.exciter import Exciter

# the mass falls from 3/2 to a support 1 from the equilibrium, and the spring presses it on
FALL, FIRST_TAU, FIRST_SPEED = -1.5, math.acos(1.0 / 1.5), math.sqrt(1.25)
PRESSED = {"l": 0.5, "delta": -1.5}
SLOW = {"nu": 0.1, "f": 1.5, "h": 0.2, "l": 0.5}
INTERRUPTED = [
    (Exciter(nu=1.0, f=1.5, h=0.05, l=0.5, R1=R, R2=R), 30.0, 0.0, 0.0)
    for R in (0.9, 0.95, 0.97, 0.99)
]


def chatter_series(R: float, impacts: int) -> tuple[float, float]:
    """Time of the impact of this number (from 0) and the speed after it: half turns of circles, in closed form."""
    speeds = FIRST_SPEED * R ** np.arange(1, impacts + 1)
    return FIRST_TAU + float(np.sum(2.0 * np.arctan(speeds))), FIRST_SPEED * R ** (impacts + 1)


@largest
def chatter_ends(solver: Solver) -> Iterator[float]:
    """Error of the time of accumulation; the mass must then rest for ever, after bounded work."""
    for R in (0.05, 0.2, 0.5, 0.8, 0.9, 0.95, 0.99):
        expected, _ = chatter_series(R, 20 + math.ceil(math.log(1e-20) / math.log(R)))
        found = solver.motion(Exciter(**PRESSED, R1=R), 2.0 * expected, x0=FALL)
        expect(found["rest_end"].values.tolist() == [math.inf])
        expect(found.sizes["impact"] <= 20 + math.log(1e-9) / math.log(R))
        yield abs(float(found["rest_start"][0]) - expected) / expected


@largest
def chatter_cut(solver: Solver) -> Iterator[float]:
    """A chatter ended by tau_end, or by the end of a forcing period, after 12 impacts.

    Error of the last impact (exact); breaches (newmark, whose impacts come sooner or later).
    """
    for R, whole in itertools.product((0.5, 0.8, 0.95), (False, True)):
        last, speed = chatter_series(R, 11)
        tau_end = 0.5 * (last + chatter_series(R, 12)[0])
        exciter = Exciter(**PRESSED, R1=R, nu=2.0 * math.pi / tau_end if whole else 1.0)
        if solver.steps is not None:
            yield flights_or_violations(solver, exciter, tau_end, FALL)
            continue
        found = solver.motion(exciter, tau_end, x0=FALL)
        expect(found.sizes["impact"] == 12 and not found.sizes["rest"])
        yield abs(float(found["impact_tau"][-1]) - last) / last
        yield abs(float(found["impact_velocity_after"][-1]) + speed) / speed


def releases(solver: Solver, exciter: Exciter, tau_end: float) -> float:
    """Largest error of a release, where the force turns: f sin(nu tau) = x of the support; there must be one."""
    found = solver.motion(exciter, tau_end)
    ends, supports = found["rest_end"].values, found["rest_support"].values
    pressing = np.where(supports == 1, exciter.upper, -exciter.lower)
    turns = np.where((supports == 1) == (exciter.f > 0), 0.5, 1.0)
    # f sin falls (rises) through the support's x in the second (fourth) quarter of a period
    phase = turns - np.arcsin(pressing / abs(exciter.f)) / (2.0 * math.pi)
    ended = np.isfinite(ends)
    expect(ended.any())
    turned, phase = ends[ended] * exciter.nu / (2.0 * math.pi), phase[ended]
    miss = np.abs(turned - phase - np.round(turned - phase))
    return float(np.max(miss)) * 2.0 * math.pi / (exciter.nu * tau_end)


@largest
def chatter_released(solver: Solver) -> Iterator[float]:
    """Releases after complete chatter, R from 0.05 to 0.9."""
    for R in (0.05, 0.2, 0.5, 0.8, 0.9):
        yield releases(solver, Exciter(**SLOW, R1=R, R2=R), 200.0)


@largest
def plastic(solver: Solver) -> Iterator[float]:
    """A plastic support: pushed, the mass rests from the impact on, and leaves when the force turns."""
    for R1, R2 in ((0.0, 0.0), (0.0, 0.8), (0.8, 0.0)):
        exciter = Exciter(nu=0.7, f=1.2, h=0.2, l=0.5, R1=R1, R2=R2)
        found = solver.motion(exciter, 60.0)
        dead = np.where(found["impact_support"].values == 1, R1, R2) == 0.0
        expect(not np.any(found["impact_velocity_after"].values[dead]))
        sudden = found["rest_support"].values == (1 if R1 == 0.0 else 2)
        starts = found["rest_start"].values[sudden]
        expect(bool(np.isin(starts, found["impact_tau"].values[dead]).all()))
        yield releases(solver, exciter, 60.0)


@largest
def plastic_for_ever(solver: Solver) -> Iterator[float]:
    """Pressed into a plastic support by the spring: one impact, at a known time, and rest for ever."""
    one = Exciter(**PRESSED, R1=0.0)
    both = Exciter(**PRESSED, R1=0.0, R2=0.0)
    for exciter, x0 in ((one, FALL), (one.mirrored(), -FALL), (both, FALL)):
        found = solver.motion(exciter, 50.0, x0=x0)
        expect(found.sizes["impact"] == 1)
        expect(found["rest_end"].values.tolist() == [math.inf])
        yield abs(float(found["rest_start"][0]) / FIRST_TAU - 1.0)
