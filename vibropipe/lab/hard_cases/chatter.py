"""Hard cases of chatter and plastic supports: accumulation, sticking, release."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

from vibropipe.lab.hard_cases.case import Solver, expect, largest_error
from vibropipe.lab.hard_cases.invariants import flights_or_violations
from vibropipe.physics.exciter import Exciter

# The mass starts 3/2 from the equilibrium and falls to a support at distance 1, into which the spring presses it.
FALL, FIRST_TAU, FIRST_SPEED = -1.5, math.acos(1.0 / 1.5), math.sqrt(1.25)
PRESSED = {"l": 0.5, "delta": -1.5}
SLOW = {"nu": 0.1, "f": 1.5, "h": 0.2, "l": 0.5}
INTERRUPTED = [
    (Exciter(nu=1.0, f=1.5, h=0.05, l=0.5, R1=R, R2=R), 30.0, 0.0, 0.0)
    for R in (0.9, 0.95, 0.97, 0.99)
]


def chatter_series(R: float, impacts: int) -> tuple[float, float]:
    """Return time of impact `impacts` (counted from 0) and the speed after it: half turns in the phase plane."""
    speeds = FIRST_SPEED * R ** np.arange(1, impacts + 1)
    return FIRST_TAU + float(np.sum(2.0 * np.arctan(speeds))), FIRST_SPEED * R ** (impacts + 1)


@largest_error
def chatter_ends(solver: Solver) -> Iterator[float]:
    """Relative error of the accumulation time; the mass must then stick, after a bounded number of impacts."""
    for R in (0.05, 0.2, 0.5, 0.8, 0.9, 0.95, 0.99):
        expected, _ = chatter_series(R, 20 + math.ceil(math.log(1e-20) / math.log(R)))
        motion = solver.motion(Exciter(**PRESSED, R1=R), 2.0 * expected, x0=FALL)
        expect(motion["rest_end"].values.tolist() == [math.inf])
        expect(motion.sizes["impact"] <= 20 + math.log(1e-9) / math.log(R))
        yield abs(float(motion["rest_start"][0]) - expected) / expected


@largest_error
def chatter_cut(solver: Solver) -> Iterator[float]:
    """Chatter ended by tau_end, or by the end of a forcing period, after 12 impacts.

    Error of the last impact (exact); violations (newmark, whose impacts are shifted in time).
    """
    for R, is_whole_period in itertools.product((0.5, 0.8, 0.95), (False, True)):
        last, speed = chatter_series(R, 11)
        tau_end = 0.5 * (last + chatter_series(R, 12)[0])
        exciter = Exciter(**PRESSED, R1=R, nu=2.0 * math.pi / tau_end if is_whole_period else 1.0)
        if solver.steps is not None:
            yield flights_or_violations(solver, exciter, tau_end, FALL)
            continue
        motion = solver.motion(exciter, tau_end, x0=FALL)
        expect(motion.sizes["impact"] == 12 and not motion.sizes["rest"])
        yield abs(float(motion["impact_tau"][-1]) - last) / last
        yield abs(float(motion["impact_velocity_after"][-1]) + speed) / speed


def release_error(solver: Solver, exciter: Exciter, tau_end: float) -> float:
    """Return the largest error of a release, where f sin(nu tau) falls to the support's x; one must occur."""
    motion = solver.motion(exciter, tau_end)
    ends, supports = motion["rest_end"].values, motion["rest_support"].values
    support_x = np.where(supports == 1, exciter.upper, -exciter.lower)
    quarter = np.where((supports == 1) == (exciter.f > 0), 0.5, 1.0)
    # f sin falls (rises) through the support's x in the second (fourth) quarter of a period
    phase = quarter - np.arcsin(support_x / abs(exciter.f)) / (2.0 * math.pi)
    has_ended = np.isfinite(ends)
    expect(has_ended.any())
    release_turns, phase = ends[has_ended] * exciter.nu / (2.0 * math.pi), phase[has_ended]
    deviation = np.abs(release_turns - phase - np.round(release_turns - phase))
    return float(np.max(deviation)) * 2.0 * math.pi / (exciter.nu * tau_end)


@largest_error
def chatter_released(solver: Solver) -> Iterator[float]:
    """Error of releases after complete chatter, R from 0.05 to 0.9."""
    for R in (0.05, 0.2, 0.5, 0.8, 0.9):
        yield release_error(solver, Exciter(**SLOW, R1=R, R2=R), 200.0)


@largest_error
def plastic(solver: Solver) -> Iterator[float]:
    """A plastic support: a pressed mass sticks from the impact on, and leaves when the force falls to the spring's."""
    for R1, R2 in ((0.0, 0.0), (0.0, 0.8), (0.8, 0.0)):
        exciter = Exciter(nu=0.7, f=1.2, h=0.2, l=0.5, R1=R1, R2=R2)
        motion = solver.motion(exciter, 60.0)
        is_plastic_impact = np.where(motion["impact_support"].values == 1, R1, R2) == 0.0
        expect(not np.any(motion["impact_velocity_after"].values[is_plastic_impact]))
        is_plastic_rest = motion["rest_support"].values == (1 if R1 == 0.0 else 2)
        starts = motion["rest_start"].values[is_plastic_rest]
        expect(bool(np.isin(starts, motion["impact_tau"].values[is_plastic_impact]).all()))
        yield release_error(solver, exciter, 60.0)


@largest_error
def plastic_for_ever(solver: Solver) -> Iterator[float]:
    """A mass pressed permanently into a plastic support: one impact at a known time, then sticking to the end."""
    one = Exciter(**PRESSED, R1=0.0)
    both = Exciter(**PRESSED, R1=0.0, R2=0.0)
    for exciter, x0 in ((one, FALL), (one.mirrored(), -FALL), (both, FALL)):
        motion = solver.motion(exciter, 50.0, x0=x0)
        expect(motion.sizes["impact"] == 1)
        expect(motion["rest_end"].values.tolist() == [math.inf])
        yield abs(float(motion["rest_start"][0]) / FIRST_TAU - 1.0)
