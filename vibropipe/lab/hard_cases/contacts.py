"""Hard cases of contact: grazing, starts on a support, coincident events."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np

from vibropipe.lab.hard_cases.analytic import first_peak, propagators
from vibropipe.lab.hard_cases.case import Solver, count_wrong, expect, largest_error
from vibropipe.physics.exciter import Exciter

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
