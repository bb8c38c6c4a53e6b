"""Hard cases of contact: grazing, starts on a support, events at one instant."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

from vibropipe.lab.hard_cases.analytic import first_peak, propagators
from vibropipe.lab.hard_cases.case import Solver, count, expect, largest
from vibropipe.physics.exciter import Exciter

DEPTHS = tuple(10.0**-n for n in (4, 6, 8, 10, 12))


@count
def grazes_free(solver: Solver) -> Iterator[bool]:
    """Wrong answers to whether a free motion strikes, its peak set above or below the support."""
    _, unit = first_peak(Exciter(l=1.0), solver.steps, v0=1.0)
    p = Exciter(l=1.0, R1=0.6)
    for depth, sign in itertools.product(DEPTHS, (1, -1)):
        v0 = (1.0 + sign * depth) / unit
        for exciter, start in ((p, v0), (p.mirrored(), -v0)):
            found = solver.motion(exciter, 3.0, v0=start)
            yield (found.sizes["impact"] > 0) != (sign > 0)


@count
def grazes_forced(solver: Solver) -> Iterator[bool]:
    """The same for a forced, damped motion from rest: the support is set beside its peak."""
    forced = {"nu": 1.7, "f": 1.0, "h": 0.2, "R1": 0.6, "R2": 0.6}
    tau, peak = first_peak(Exciter(**forced, l=1.0), solver.steps)
    for depth, sign in itertools.product(DEPTHS, (1, -1)):
        found = solver.motion(Exciter(**forced, l=peak - sign * depth), tau + 0.2)
        yield (found.sizes["impact"] > 0) != (sign > 0)


@count
def starts(solver: Solver) -> Iterator[bool]:
    """Wrong numbers of impacts and rests of a mass that starts on a support: 3 pushes, 3 velocities, 2 sides."""
    for delta, v0, side in itertools.product((-0.8, 0.0, -0.5), (-0.3, 0.0, 0.3), (1, -1)):
        p = Exciter(l=0.5, delta=delta, R1=0.6)
        exciter = p if side == 1 else p.mirrored()
        found = solver.motion(exciter, 0.1, x0=side * (0.5 + delta), v0=side * v0)
        at_start = int(np.count_nonzero(found["impact_tau"].values == 0.0))
        stays = v0 == 0.0 and delta <= -0.5
        yield at_start != (v0 > 0.0) or (found.sizes["rest"] > 0) != stays


@count
def ends_on_impact(solver: Solver) -> Iterator[bool]:
    """Wrong numbers of impacts when the end falls on an impact, 1e-9 before it, and 1e-9 after it."""
    for R, x0 in itertools.product((0.0, 0.6), (0.0, 0.2)):
        exciter = Exciter(l=0.5, R1=R, nu=1.3, f=0.2, h=0.1)
        struck = solver.motion(exciter, 4.0, x0=x0, v0=1.0)["impact_tau"].values
        expect(struck.size > 0)
        for off, expected in ((-1e-9, 0), (0.0, 1), (1e-9, 1)):
            found = solver.motion(exciter, float(struck[0]) + off, x0=x0, v0=1.0)
            yield found.sizes["impact"] != expected


@count
def strikes_at_release(solver: Solver) -> Iterator[bool]:
    """Wrong outcomes of a mass that reaches a plastic support as the force turns, 1e-9 before it, 1e-9 after it.

    It must strike once, and be off the support a little later.
    """
    exciter = Exciter(f=1.0, l=0.5, R1=0.0, R2=0.0)
    release, ahead = math.pi - math.asin(0.5), 0.3
    for off in (0.0, 1e-9, -1e-9):
        tau = release + off
        at_contact = np.array([0.5, 1.0, exciter.f * math.sin(tau), exciter.f * math.cos(tau)])
        x0, v0 = (propagators(exciter, np.array([-ahead]))[0] @ at_contact)[:2]
        found = solver.motion(exciter, release + 1.0, float(x0), float(v0), tau_start=tau - ahead)
        yield found["impact_support"].values.tolist() != [1]
        yield not float(found["displacement_end"]) < 0.5


@largest
def supports_together(solver: Solver) -> Iterator[float]:
    """Error of the times of 100 ideal impacts between supports 2l apart, l from 1e-3 to 1e-12."""
    for length in (1e-3, 1e-6, 1e-9, 1e-12):
        flight = 2.0 * math.asin(length)
        # a force too small to move the mass keeps the motion off its closed form
        exciter = Exciter(l=length, f=1e-300)
        found = solver.motion(exciter, 100.0 * flight, v0=1.0)
        expected = flight * (np.arange(100) + 0.5)
        expect(found["impact_support"].values.tolist() == [1, 2] * 50)
        yield float(np.max(np.abs(found["impact_tau"].values - expected))) / flight
