"""Hard cases of chatter and of plastic supports: accumulation, rest, release."""

from __future__ import annotations

import itertools
import math

import numpy as np

from vibropipe.lab.hard_cases.case import Bound, Case, Solver
from vibropipe.lab.hard_cases.invariants import FLIGHTS, WRONG, flights_or_breaches
from vibropipe.physics.exciter import Exciter

# the mass falls from 3/2 to a support 1 from the equilibrium, and the spring presses it on
FALL, FIRST_TAU, FIRST_SPEED = -1.5, math.acos(1.0 / 1.5), math.sqrt(1.25)
PRESSED = {"l": 0.5, "delta": -1.5}
SLOW = {"nu": 0.1, "f": 1.5, "h": 0.2, "l": 0.5}


def chatter_series(R: float, impacts: int) -> tuple[float, float]:
    """Time of the impact of this number (from 0) and the speed after it: half turns of circles, in closed form."""
    speeds = FIRST_SPEED * R ** np.arange(1, impacts + 1)
    return FIRST_TAU + float(np.sum(2.0 * np.arctan(speeds))), FIRST_SPEED * R ** (impacts + 1)


def chatter_ends(solver: Solver) -> float:
    """Error of the time of accumulation; the mass must then rest for ever, after bounded work."""
    worst = 0.0
    for R in (0.05, 0.2, 0.5, 0.8, 0.9, 0.95, 0.99):
        known, _ = chatter_series(R, 20 + math.ceil(math.log(1e-20) / math.log(R)))
        found = solver.motion(Exciter(**PRESSED, R1=R), 2.0 * known, x0=FALL)
        most = 20 + math.log(1e-9) / math.log(R)
        if found["rest_end"].values.tolist() != [math.inf] or found.sizes["impact"] > most:
            return WRONG
        worst = max(worst, abs(float(found["rest_start"][0]) - known) / known)
    return worst


def chatter_cut(solver: Solver) -> float:
    """A chatter ended by tau_end, or by the end of a forcing period, after 12 impacts.

    Error of the last impact (exact); breaches (newmark, whose impacts come sooner or later).
    """
    worst = 0.0
    for R, whole in itertools.product((0.5, 0.8, 0.95), (False, True)):
        last, speed = chatter_series(R, 11)
        tau_end = 0.5 * (last + chatter_series(R, 12)[0])
        p = Exciter(**PRESSED, R1=R, nu=2.0 * math.pi / tau_end if whole else 1.0)
        if solver.steps is not None:
            worst = max(worst, flights_or_breaches(solver, p, tau_end, FALL))
            continue
        found = solver.motion(p, tau_end, x0=FALL)
        if found.sizes["impact"] != 12 or found.sizes["rest"]:
            return WRONG
        worst = max(worst, abs(float(found["impact_tau"][-1]) - last) / last)
        worst = max(worst, abs(float(found["impact_velocity_after"][-1]) + speed) / speed)
    return worst


def releases(solver: Solver, exciter: Exciter, tau_end: float) -> float:
    """Largest error of a release, where the force turns: f sin(nu tau) = x of the support; WRONG without any."""
    found = solver.motion(exciter, tau_end)
    ends, supports = found["rest_end"].values, found["rest_support"].values
    pressing = np.where(supports == 1, exciter.upper, -exciter.lower)
    turns = np.where((supports == 1) == (exciter.f > 0), 0.5, 1.0)
    # f sin falls (rises) through the support's x in the second (fourth) quarter of a period
    phase = turns - np.arcsin(pressing / abs(exciter.f)) / (2.0 * math.pi)
    ended = np.isfinite(ends)
    if not ended.any():
        return WRONG
    turned, phase = ends[ended] * exciter.nu / (2.0 * math.pi), phase[ended]
    miss = np.abs(turned - phase - np.round(turned - phase))
    return float(np.max(miss)) * 2.0 * math.pi / (exciter.nu * tau_end)


def chatter_released(solver: Solver) -> float:
    """Releases after complete chatter, R from 0.05 to 0.9."""
    each = (0.05, 0.2, 0.5, 0.8, 0.9)
    return max(releases(solver, Exciter(**SLOW, R1=R, R2=R), 200.0) for R in each)


def chatter_interrupted(solver: Solver) -> float:
    """Flights of chatters that are released before they end (exact), or breaches (newmark)."""
    worst = 0.0
    for R in (0.9, 0.95, 0.97, 0.99):
        p = Exciter(nu=1.0, f=1.5, h=0.05, l=0.5, R1=R, R2=R)
        worst = max(worst, flights_or_breaches(solver, p, 30.0))
    return worst


def plastic(solver: Solver) -> float:
    """A plastic support: pushed, the mass rests from the impact on, and leaves when the force turns."""
    worst = 0.0
    for R1, R2 in ((0.0, 0.0), (0.0, 0.8), (0.8, 0.0)):
        p = Exciter(nu=0.7, f=1.2, h=0.2, l=0.5, R1=R1, R2=R2)
        found = solver.motion(p, 60.0)
        dead = np.where(found["impact_support"].values == 1, R1, R2) == 0.0
        if np.any(found["impact_velocity_after"].values[dead]):
            return WRONG
        sudden = found["rest_support"].values == (1 if R1 == 0.0 else 2)
        starts = found["rest_start"].values[sudden]
        if not np.isin(starts, found["impact_tau"].values[dead]).all():
            return WRONG
        worst = max(worst, releases(solver, p, 60.0))
    return worst


def plastic_for_ever(solver: Solver) -> float:
    """Pressed into a plastic support by the spring: one impact, at a known time, and rest for ever."""
    worst = 0.0
    for p, x0 in (
        (Exciter(**PRESSED, R1=0.0), FALL),
        (Exciter(**PRESSED, R1=0.0).mirrored(), -FALL),
        (Exciter(**PRESSED, R1=0.0, R2=0.0), FALL),
    ):
        found = solver.motion(p, 50.0, x0=x0)
        if found.sizes["impact"] != 1 or found["rest_end"].values.tolist() != [math.inf]:
            return WRONG
        worst = max(worst, abs(float(found["rest_start"][0]) / FIRST_TAU - 1.0))
    return worst


CHATTER = (
    Case(
        "chatter_complete",
        "complete chatter, R = 0.05 to 0.99, pressed for ever",
        "accumulates at the sum of its half turns; rests for ever; bounded impacts",
        chatter_ends,
        Bound(1e-12, 0.1, 2),
    ),
    Case(
        "chatter_cut",
        "chatter ended by the end, or by a period's end, after 12 impacts; R = 0.5, 0.8, 0.95",
        "exact: impact 12 by the sum of half turns; newmark: inside, reset by eq. (6)",
        chatter_cut,
        Bound(1e-12, 0.0),
    ),
    Case(
        "chatter_released",
        "complete chatter, R = 0.05 to 0.9, ended by release",
        "released where f sin(nu tau) = x of the support, whatever the method",
        chatter_released,
        Bound(1e-12, 1e-12),
    ),
    Case(
        "chatter_interrupted",
        "chatter interrupted by release, R = 0.9 to 0.99",
        FLIGHTS,
        chatter_interrupted,
        Bound(1e-12, 0.0),
    ),
    Case(
        "plastic",
        "R = 0 on either or both supports",
        "rests from the impact on; released where the force turns",
        plastic,
        Bound(1e-12, 1e-12),
    ),
    Case(
        "plastic_for_ever",
        "R = 0, pushed for ever",
        "one impact at arccos(2/3), then rest without end",
        plastic_for_ever,
        Bound(1e-14, 0.1, 2),
    ),
)
