"""Hard cases of contact: grazing, starts on a support, events at one instant."""

from __future__ import annotations

import itertools
import math

import numpy as np

from vibropipe.lab.hard_cases.analytic import first_peak, propagators
from vibropipe.lab.hard_cases.case import Bound, Case, Solver
from vibropipe.lab.hard_cases.invariants import WRONG
from vibropipe.physics.exciter import Exciter

DEPTHS = tuple(10.0**-n for n in (4, 6, 8, 10, 12))


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
