"""Hard cases of contact: grazing, chatter, plastic supports, starts on a support, events at one instant."""

from __future__ import annotations

import itertools
import math

import numpy as np

from vibropipe.batch.hard_cases.case import Bound, Case, Solver
from vibropipe.batch.hard_cases.known import breaches, first_peak, flight_error, propagators
from vibropipe.physics.exciter import Exciter

WRONG = math.inf
DEPTHS = tuple(10.0**-n for n in (4, 6, 8, 10, 12))
# the mass falls from 3/2 to a support 1 from the equilibrium, and the spring presses it on
FALL, FIRST_TAU, FIRST_SPEED = -1.5, math.acos(1.0 / 1.5), math.sqrt(1.25)
PRESSED = {"l": 0.5, "delta": -1.5}
SLOW = {"nu": 0.1, "f": 1.5, "h": 0.2, "l": 0.5}


def grazes_free(solver: Solver) -> float:
    """Wrong answers to whether a free motion strikes, its peak set above or below the support."""
    _, unit = first_peak(Exciter(l=1.0), solver.steps, v0=1.0)
    wrong = 0
    for depth, sign in itertools.product(DEPTHS, (1, -1)):
        p = Exciter(l=1.0, R1=0.6)
        v0 = (1.0 + sign * depth) / unit
        for mirror in (1, -1):
            exciter = p if mirror == 1 else p.mirrored()
            found = solver.motion(exciter, 3.0, v0=mirror * v0)
            wrong += (found.sizes["impact"] > 0) != (sign > 0)
    return wrong


def grazes_forced(solver: Solver) -> float:
    """The same for a forced, damped motion from rest: the support is set beside its peak."""
    p = Exciter(nu=1.7, f=1.0, h=0.2, l=1.0, R1=0.6, R2=0.6)
    tau, peak = first_peak(p, solver.steps)
    wrong = 0
    for depth, sign in itertools.product(DEPTHS, (1, -1)):
        near = Exciter(nu=1.7, f=1.0, h=0.2, l=peak - sign * depth, R1=0.6, R2=0.6)
        found = solver.motion(near, tau + 0.2)
        wrong += (found.sizes["impact"] > 0) != (sign > 0)
    return wrong


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


def flights_or_breaches(
    solver: Solver, p: Exciter, tau_end: float, x0: float = 0.0, v0: float = 0.0
) -> float:
    """Error of all flights of a motion by the exact method; breaches of what Newmark's method must keep."""
    if solver.steps is None:
        return flight_error(p, solver.motion(p, tau_end, x0, v0), tau_end, x0, v0)
    return breaches(p, solver.motion(p, tau_end, x0, v0, samples_per_period=32))


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


def starts(solver: Solver) -> float:
    """Wrong numbers of impacts and rests of a mass that starts on a support: 3 pushes, 3 velocities, 2 sides."""
    wrong = 0
    for delta, v0, side in itertools.product((-0.8, 0.0, -0.5), (-0.3, 0.0, 0.3), (1, -1)):
        p = Exciter(l=0.5, delta=delta, R1=0.6)
        found = solver.motion(
            p if side == 1 else p.mirrored(), 0.1, x0=side * (0.5 + delta), v0=side * v0
        )
        at_start = int(np.count_nonzero(found["impact_tau"].values == 0.0))
        rests = int(found.sizes["rest"])
        stays = v0 == 0.0 and delta <= -0.5
        wrong += at_start != (v0 > 0.0) or (rests > 0) != stays
    return wrong


def ends_on_impact(solver: Solver) -> float:
    """Wrong numbers of impacts when the end falls on an impact, 1e-9 before it, and 1e-9 after it."""
    wrong = 0
    for R, x0 in itertools.product((0.0, 0.6), (0.0, 0.2)):
        p = Exciter(l=0.5, R1=R, nu=1.3, f=0.2, h=0.1)
        struck = solver.motion(p, 4.0, x0=x0, v0=1.0)["impact_tau"].values
        if struck.size == 0:
            return WRONG
        first = float(struck[0])
        for off, known in ((-1e-9, 0), (0.0, 1), (1e-9, 1)):
            wrong += solver.motion(p, first + off, x0=x0, v0=1.0).sizes["impact"] != known
    return wrong


def strikes_at_release(solver: Solver) -> float:
    """Wrong outcomes of a mass that reaches a plastic support as the force turns, 1e-9 before it, 1e-9 after it.

    It must strike once, and be off the support a little later.
    """
    p = Exciter(f=1.0, l=0.5, R1=0.0, R2=0.0)
    release, ahead = math.pi - math.asin(0.5), 0.3
    wrong = 0
    for off in (0.0, 1e-9, -1e-9):
        tau = release + off
        at_contact = np.array([0.5, 1.0, p.f * math.sin(tau), p.f * math.cos(tau)])
        x0, v0 = (propagators(p, np.array([-ahead]))[0] @ at_contact)[:2]
        found = solver.motion(p, release + 1.0, float(x0), float(v0), tau_start=tau - ahead)
        wrong += found["impact_support"].values.tolist() != [1]
        wrong += not float(found["displacement_end"]) < 0.5
    return wrong


def supports_together(solver: Solver) -> float:
    """Error of the times of 100 ideal impacts between supports 2l apart, l from 1e-3 to 1e-12."""
    worst = 0.0
    for length in (1e-3, 1e-6, 1e-9, 1e-12):
        flight = 2.0 * math.asin(length)
        # a force too small to move the mass keeps the motion off its closed form
        p = Exciter(l=length, f=1e-300)
        found = solver.motion(p, 100.0 * flight, v0=1.0)
        known = flight * (np.arange(100) + 0.5)
        sides = np.where(np.arange(100) % 2 == 0, 1, 2)
        if found.sizes["impact"] != 100 or not np.array_equal(found["impact_support"], sides):
            return WRONG
        worst = max(worst, float(np.max(np.abs(found["impact_tau"].values - known))) / flight)
    return worst


STRIKES_AS_IT_IS = "struck above, missed below, by the method's own peak"
FLIGHTS = (
    "exact: each flight is the closed form from impact to impact; newmark: inside, reset by eq. (6)"
)
CONTACTS = (
    Case(
        "grazing_free",
        "free motion, peak 1e-4, 1e-6, ..., 1e-12 beyond a support or short of it; both supports",
        f"{STRIKES_AS_IT_IS}; wrong answers of 20",
        grazes_free,
        Bound(0.0, 0.0),
    ),
    Case(
        "grazing_forced",
        "forced, damped motion, the same depths",
        f"{STRIKES_AS_IT_IS}; wrong answers of 10",
        grazes_forced,
        Bound(0.0, 0.0),
    ),
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
    Case(
        "start_on_support",
        "start on a support moving out, at rest, in; pushed, pulled, balanced",
        "one impact if it moves in, else none; rests if not pulled; wrong of 18",
        starts,
        Bound(0.0, 0.0),
    ),
    Case(
        "end_on_impact",
        "impact and end at one instant, and 1e-9 apart; R = 0 and 0.6",
        "an impact at the end is counted; wrong of 12",
        ends_on_impact,
        Bound(0.0, 0.0),
    ),
    Case(
        "impact_at_release",
        "R = 0, reached as the force turns, and 1e-9 before and after",
        "one impact, then off the support; wrong of 6",
        strikes_at_release,
        Bound(0.0, 0.0),
    ),
    Case(
        "supports_together",
        "100 ideal impacts, l = 1e-3 to 1e-12",
        "strikes in turn, every 2 arcsin l",
        supports_together,
        Bound(1e-10, 1e-4),
    ),
)
