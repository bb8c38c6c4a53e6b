"""Hard cases of contact: grazing, starts on a support, coincident events; chatter, plastic supports, release."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

from vibropipe.lab.hard_cases.analytic import first_peak, propagators
from vibropipe.lab.hard_cases.case import (
    Solver,
    count_wrong,
    expect,
    flights_or_violations,
    largest_error,
)
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


# Distances of a peak from the support, on either side.
DEPTHS = tuple(10.0**-n for n in (4, 6, 8, 10, 12))


@count_wrong
def grazes_free(solver: Solver) -> Iterator[bool]:
    """Wrong answers to whether a free motion strikes, with its peak above or below the support."""
    _, peak = first_peak(Exciter(l=1.0), solver.steps, v0=1.0)
    base = Exciter(l=1.0, R1=0.6)
    for depth, sign in itertools.product(DEPTHS, (1, -1)):
        v0 = (1.0 + sign * depth) / peak
        for exciter, start in ((base, v0), (base.mirrored(), -v0)):
            motion = solver.motion(exciter, 3.0, v0=start)
            yield (motion.sizes["impact"] > 0) != (sign > 0)


@count_wrong
def grazes_forced(solver: Solver) -> Iterator[bool]:
    """Wrong answers for a forced, damped motion from rest, with the support next to its peak."""
    forced = {"nu": 1.7, "f": 1.0, "h": 0.2, "R1": 0.6, "R2": 0.6}
    tau, peak = first_peak(Exciter(**forced, l=1.0), solver.steps)
    for depth, sign in itertools.product(DEPTHS, (1, -1)):
        motion = solver.motion(Exciter(**forced, l=peak - sign * depth), tau + 0.2)
        yield (motion.sizes["impact"] > 0) != (sign > 0)


@count_wrong
def starts(solver: Solver) -> Iterator[bool]:
    """Wrong numbers of impacts and rests of a mass that starts on a support: 3 forces, 3 velocities, 2 supports."""
    for delta, v0, side in itertools.product((-0.8, 0.0, -0.5), (-0.3, 0.0, 0.3), (1, -1)):
        upper = Exciter(l=0.5, delta=delta, R1=0.6)
        exciter = upper if side == 1 else upper.mirrored()
        motion = solver.motion(exciter, 0.1, x0=side * (0.5 + delta), v0=side * v0)
        at_start = int(np.count_nonzero(motion["impact_tau"].values == 0.0))
        must_rest = v0 == 0.0 and delta <= -0.5
        yield at_start != (v0 > 0.0) or (motion.sizes["rest"] > 0) != must_rest


@count_wrong
def ends_on_impact(solver: Solver) -> Iterator[bool]:
    """Wrong numbers of impacts when the end falls on an impact, and 1e-9 before and after it."""
    for R, x0 in itertools.product((0.0, 0.6), (0.0, 0.2)):
        exciter = Exciter(l=0.5, R1=R, nu=1.3, f=0.2, h=0.1)
        impact_tau = solver.motion(exciter, 4.0, x0=x0, v0=1.0)["impact_tau"].values
        expect(impact_tau.size > 0)
        for offset, expected in ((-1e-9, 0), (0.0, 1), (1e-9, 1)):
            motion = solver.motion(exciter, float(impact_tau[0]) + offset, x0=x0, v0=1.0)
            yield motion.sizes["impact"] != expected


@count_wrong
def strikes_at_release(solver: Solver) -> Iterator[bool]:
    """Wrong outcomes of a mass that reaches a plastic support at its release time, and 1e-9 before and after.

    It must strike once and be off the support a little later.
    """
    exciter = Exciter(nu=1.0, f=1.0, l=0.5, R1=0.0, R2=0.0)
    release, lead = math.pi - math.asin(0.5), 0.3
    for offset in (0.0, 1e-9, -1e-9):
        tau = release + offset
        at_contact = np.array([0.5, 1.0, exciter.f * math.sin(tau), exciter.f * math.cos(tau)])
        x0, v0 = (propagators(exciter, np.array([-lead]))[0] @ at_contact)[:2]
        motion = solver.motion(exciter, release + 1.0, float(x0), float(v0), tau_start=tau - lead)
        yield motion["impact_support"].values.tolist() != [1]
        yield not float(motion["displacement_end"]) < 0.5


@largest_error
def supports_together(solver: Solver) -> Iterator[float]:
    """Relative error of the times of 100 ideal impacts between supports 2l apart, l from 1e-3 to 1e-12."""
    for length in (1e-3, 1e-6, 1e-9, 1e-12):
        flight = 2.0 * math.asin(length)
        # a force too small to move the mass excludes the closed form
        exciter = Exciter(l=length, nu=1.0, f=1e-300)
        motion = solver.motion(exciter, 100.0 * flight, v0=1.0)
        expected = flight * (np.arange(100) + 0.5)
        expect(motion["impact_support"].values.tolist() == [1, 2] * 50)
        yield float(np.max(np.abs(motion["impact_tau"].values - expected))) / flight
