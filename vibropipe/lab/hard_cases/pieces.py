"""Hard cases of soft supports, friction, load, second harmonic: closed forms, wrong outcomes, motions of 40 digits."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from decimal import Decimal
from typing import TYPE_CHECKING

import numpy as np

from vibropipe.lab.hard_cases.analytic import first_peak
from vibropipe.lab.hard_cases.case import Solver, count_wrong, end_state, expect, largest_error
from vibropipe.lab.reference_solver import ReferenceSolver
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.restitution import SUPPORTS

if TYPE_CHECKING:
    import xarray as xr

Task = tuple[Exciter, float, float, float]
# Speed below which impacts are not compared.
SLOWEST = 1e-4
STRUCK = {"nu": 1.0, "f": -1.0, "h": 0.2, "l": 0.5, "R1": 0.7, "R2": 0.7}


def task(tau_end: float, x0: float = 0.0, v0: float = 0.0, **parameters: float) -> Task:
    """Return a motion of the struck exciter with other parameters."""
    return struck(**parameters), tau_end, x0, v0


def struck(**parameters: float) -> Exciter:
    """Return the struck exciter with other parameters; soft supports have their own damping, and no restitution."""
    soft = {R: 1.0 for R, k, _h in SUPPORTS if k in parameters}
    return Exciter(**{**STRUCK, **soft, **parameters})


def damped(k: float, z: float = 0.2) -> dict[str, float]:
    """Return soft supports of a stiffness, with z times the critical damping."""
    h = 2.0 * z * math.sqrt(k)
    return {"k1": k, "k2": k, "h1": h, "h2": h}


@largest_error
def agrees_with_reference(solver: Solver, tasks: Sequence[Task]) -> Iterator[float]:
    """Largest error of times and velocities of events, and of the end states, against motions of 40 digits.

    Impacts slower than SLOWEST belong to a chatter, of which the exact method completes the last ones in one piece; a
    soft support that is touched with no velocity is entered and left by rounding alone.
    """
    for exciter, tau_end, x0, v0 in tasks:
        motion = solver.motion(exciter, tau_end, x0, v0)
        exact = ReferenceSolver(exciter).run(x0, v0, [Decimal(tau_end)])
        yield from np.abs(np.subtract(end_state(motion), np.array(exact.states[0], float)))
        events = events_of(motion)
        for name in ("impact", "out", "stick", "slip"):
            kinds = ("in", "impact") if name == "impact" else (name,)
            # A start on a soft support leaves it, but no contact ends there.
            listed = [event for event in exact.events if event[1] != "out" or event[0] > 0]
            expected = [(float(t), float(v)) for t, kind, _s, v in listed if kind in kinds]
            one, other = expected, events[name]
            if name in ("impact", "out"):
                one, other = fast(one), fast(other)
            expect(len(one) == len(other))
            if one:
                yield float(np.max(np.abs(np.subtract(one, other))))


def fast(events: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the impacts that are compared."""
    return [event for event in events if abs(event[1]) > SLOWEST]


def events_of(motion: xr.Dataset) -> dict[str, list[tuple[float, float]]]:
    """Return (tau, velocity) of the events of a motion by kind: impact, out, stick, slip."""
    taus, before = motion["impact_tau"].values, motion["impact_velocity"].values
    events = {"impact": list(zip(taus, before, strict=True)), "out": [], "stick": [], "slip": []}
    if "contact_duration" in motion:
        ends = taus + motion["contact_duration"].values
        over = np.isfinite(ends)
        after = motion["impact_velocity_after"].values[over]
        events["out"] = list(zip(ends[over], after, strict=True))
    if "stick_start" in motion:
        for kind, name in (("stick", "stick_start"), ("slip", "stick_end")):
            events[kind] = [(tau, 0.0) for tau in motion[name].values if math.isfinite(tau)]
    return events


@count_wrong
def grazes_soft(solver: Solver) -> Iterator[bool]:
    """Wrong answers to whether a forced motion touches a soft support, its peak 1e-4 to 1e-12 beyond it or short."""
    forced = {"nu": 1.7, "f": 1.0, "h": 0.2, "k1": 50.0, "k2": 50.0}
    tau, peak = first_peak(Exciter(nu=1.7, f=1.0, h=0.2, l=1.0), None)
    for n, sign in itertools.product((4, 6, 8, 10, 12), (1, -1)):
        motion = solver.motion(Exciter(**forced, l=peak - sign * 10.0**-n), tau + 0.2)
        yield (motion.sizes["impact"] > 0) != (sign > 0)


@largest_error
def shallow_contacts(solver: Solver) -> Iterator[float]:
    """Relative error of the depth of contacts 1e-2 to 1e-8 deep: free motion, energy at the peak."""
    for n in (2, 4, 6, 8):
        exciter = Exciter(l=1.0, k1=1e4)
        energy_above = 10.0**-n
        # (1 + d)^2 + k d^2 = 1 + energy_above
        depth = energy_above / (1.0 + math.sqrt(1.0 + (1.0 + exciter.k1) * energy_above))
        motion = solver.motion(exciter, 3.0, 0.0, math.sqrt(1.0 + energy_above))
        expect(motion.sizes["impact"] == 1)
        yield abs(float(motion["contact_depth_max"][0]) / depth - 1.0)


@largest_error
def keeps_energy(solver: Solver) -> Iterator[float]:
    """Relative change of the impact velocity without loss, k = 1 to 1e8, over 40 units of time."""
    for n in range(9):
        motion = solver.motion(Exciter(l=0.5, k1=10.0**n, k2=10.0**n), 40.0, 0.0, 1.0)
        yield from np.abs(np.abs(motion["impact_velocity"].values) / math.sqrt(0.75) - 1.0)


@largest_error
def tends_to_rigid(solver: Solver) -> Iterator[float]:
    """Distance of the order in 1/k, from k = 1e4 to 1e8, in which v+/v- tends to exp(-pi z / sqrt(1 - z^2)), to 1/2.

    The contact ends where x returns, at the half wave of the damped oscillation; the spring between the supports and
    the force shift it by a share of 1/sqrt(k).
    """
    z = 0.2
    limit = math.exp(-math.pi * z / math.sqrt(1.0 - z * z))
    errors = []
    for k in (1e4, 1e6, 1e8):
        motion = solver.motion(struck(**damped(k, z)), 3.0)
        ratio = -float(motion["impact_velocity_after"][0] / motion["impact_velocity"][0])
        errors.append(abs(ratio - limit))
    for coarse, fine in itertools.pairwise(errors):
        yield abs(math.log(coarse / fine, 100.0) - 0.5)


@count_wrong
def starts_on_soft(solver: Solver) -> Iterator[bool]:
    """Wrong numbers of contacts of a mass that starts on a soft support: moving in, at rest, out; pressed or pulled."""
    for delta, v0 in itertools.product((-0.8, 0.0), (0.3, 0.0, -0.3)):
        exciter = Exciter(l=0.5, delta=delta, k1=100.0)
        motion = solver.motion(exciter, 0.1, exciter.upper, v0)
        enters = v0 > 0.0 or (v0 == 0.0 and exciter.upper < 0.0)
        yield int(np.count_nonzero(motion["impact_tau"].values == 0.0)) != enters


@largest_error
def sinks_in(solver: Solver) -> Iterator[float]:
    """Relative depth of a mass pressed on a soft support for ever, k = 10 to 1e4, against load / (1 + k)."""
    for k in (10.0, 1e2, 1e3, 1e4):
        exciter = Exciter(l=0.5, delta=-0.8, k1=k, h1=2.0 * math.sqrt(k))
        motion = solver.motion(exciter, 40.0, exciter.upper, 0.0)
        depth = float(motion["displacement_end"]) - exciter.upper
        yield abs(depth * (1.0 + k) / 0.3 - 1.0)


@largest_error
def decays_by_friction(solver: Solver) -> Iterator[float]:
    """Error of the turning points of a free mass, which lose 2 d each, over hundreds of turns."""
    for d in (0.1, 1e-2, 1e-3):
        turns = int(1.0 / (2.0 * d))
        motion = solver.motion(Exciter(l=2.0, friction=d), math.pi * (turns + 2), 1.0 + 0.5 * d)
        times = motion["turn_tau"].values
        expect(times.size == turns)
        yield from np.abs(times / (math.pi * np.arange(1, turns + 1)) - 1.0)
        yield abs(abs(float(motion["displacement_end"])) - (1.0 + 0.5 * d - 2.0 * d * turns))


@count_wrong
def edge_of_slipping(solver: Solver) -> Iterator[bool]:
    """Wrong answers to whether a mass slips whose largest force is the friction, or 1e-12 of it more or less."""
    for d, share, place in itertools.product((0.3, 1e-6), (-1e-12, 0.0, 1e-12), (0.0, 0.1)):
        # f + x0 is the largest pull at x = -x0
        exciter = Exciter(l=2.0, nu=1.3, f=d * (1.0 + share) - place * d, friction=d)
        motion = solver.motion(exciter, 10.0, -place * d, 0.0)
        slips = bool(np.isfinite(motion["stick_end"].values).any())
        pull = exciter.f + place * d
        yield slips != (pull > d) and abs(pull / d - 1.0) > 4e-16


@count_wrong
def edge_of_sticking(solver: Solver) -> Iterator[bool]:
    """Wrong answers to whether a mass at rest at x0 = d, or 1e-12 of it more or less, is held by the friction d."""
    for d, share, side in itertools.product((0.3, 1e-6, 1e3), (-1e-12, 0.0, 1e-12), (1.0, -1.0)):
        x0 = side * d * (1.0 + share)
        motion = solver.motion(Exciter(l=1e4, friction=d), 1.0, x0)
        moves = float(motion["displacement_end"]) != x0
        yield moves != (share > 0.0)


@count_wrong
def turns_at_support(solver: Solver) -> Iterator[bool]:
    """Wrong numbers of impacts of a mass whose turning point is the support, or 1e-9 before or beyond it."""
    for offset, soft in itertools.product((-1e-9, 0.0, 1e-9), (0.0, 100.0)):
        # from -1 friction takes 2 d: it turns at 0.8
        exciter = Exciter(l=1.0, delta=-0.2 - offset, friction=0.1, R1=0.5, k1=soft)
        motion = solver.motion(exciter, 4.0, -1.0)
        yield motion.sizes["impact"] != (offset > 0.0) and offset != 0.0


@largest_error
def released_late(solver: Solver) -> Iterator[float]:
    """Error of the release of a mass that rests on a support: f sin(nu tau) = pull + friction."""
    for d in (0.0, 0.1, 0.4):
        exciter = Exciter(l=1.0, delta=-1.5, f=-1.0, nu=0.8, friction=d)
        motion = solver.motion(exciter, 4.0, -0.5)
        expect(motion.sizes["rest"] >= 1)
        yield abs(float(motion["rest_end"][0]) - math.asin(0.5 + d) / 0.8)


@largest_error
def frictionless_limit(solver: Solver) -> Iterator[float]:
    """Distance of motions with a friction of 1e-6 to 1e-12 from the one without, over the friction and 1e4."""
    plain = end_state(solver.motion(Exciter(**STRUCK), 30.0))
    for d in (1e-6, 1e-9, 1e-12):
        end = end_state(solver.motion(Exciter(**STRUCK, friction=d), 30.0))
        yield float(np.max(np.abs(np.subtract(end, plain)))) / (1e4 * d + 1e-12)


@count_wrong
def held_for_ever(solver: Solver) -> Iterator[bool]:
    """Wrong outcomes of a mass that friction holds: its steady state is where it starts, without impacts."""
    for x0 in (-0.1, 0.0, 0.05):
        orbit = solver.solve_steady(Exciter(l=0.5, nu=1.3, f=0.2, friction=0.4), x0, 0.0)
        yield int(orbit["period_multiple"]) != 1 or float(orbit["displacement_strobe"]) != x0


@largest_error
def orbit_balances(solver: Solver) -> Iterator[float]:
    """Energy balance of orbits with contacts, turns and sticks, over the work of the force."""
    for exciter, *_ in ORBITS:
        orbit = solver.solve_steady(exciter, outputs=("energy", "stability"))
        expect(int(orbit["period_multiple"]) > 0)
        yield abs(float(orbit["energy_residual"] / orbit["energy_input"]))


ORBITS = (
    task(0.0, **damped(400.0)),
    task(0.0, friction=0.15),
    task(0.0, nu=0.6, f=0.7, h=0.05, friction=0.35),
    task(0.0, k1=200.0, h1=2.0, delta=-0.05, friction=0.08),
)
STIFF = tuple(task(8.0, **damped(10.0**n)) for n in (5, 6, 8))
OVERDAMPED = tuple(task(6.0, **damped(100.0, z)) for z in (1.0, 1.0001, 8.0))
BOUNCES = (
    (Exciter(l=0.5, delta=-0.8, k1=1e4, h1=20.0), 8.0, -0.6, 0.0),
    (Exciter(l=0.5, delta=-0.8, k1=300.0, h1=1.0, friction=0.02), 12.0, -0.6, 0.0),
)
TOGETHER = tuple(task(2.0, l=10.0**-n, k1=100.0, k2=400.0, h1=1.0) for n in (2, 4, 6))
ONE_SOFT = (
    task(20.0, k2=30.0, h2=1.0, delta=0.05),
    task(20.0, k1=1e5, h1=100.0, delta=-0.3, R2=0.9),
)
CHATTER = tuple(
    (Exciter(l=1.0, delta=-1.5, R1=R, friction=d), 12.0, -0.8, 0.0)
    for R, d in ((0.5, 0.1), (0.9, 0.2), (1.0, 0.1), (0.8, 0.49))
)
PLASTIC = (task(20.0, R1=0.0, R2=0.0, friction=0.2), task(20.0, R1=0.0, delta=-0.45, friction=0.3))
STICKS = (
    task(20.0, friction=0.15),
    task(20.0, nu=0.6, f=0.7, h=0.05, friction=0.35),
    task(40.0, nu=0.1, friction=0.3),
)
STUCK_IN_SUPPORT = (
    task(20.0, nu=0.7, k1=3.0, k2=3.0, h1=0.5, friction=0.5),
    task(20.0, nu=0.4, f=0.9, k1=20.0, k2=20.0, h1=4.0, h2=4.0, friction=0.6),
)
RESONANT = (
    task(30.0, nu=1.0, f=0.2, h=0.0, friction=0.1),
    task(30.0, nu=1.0, f=0.2, h=0.0, friction=0.15, l=5.0),
)
SECOND_ALONE = (
    task(20.0, f=0.0, f2=0.9, phi2=0.4),
    task(40.0, f=0.0, nu=0.2, f2=0.9, phi2=2.0),
    task(20.0, f=0.0, f2=0.9, friction=0.15),
    task(20.0, f=0.0, f2=0.9, phi2=1.0, **damped(400.0)),
)
PRESSED = (
    task(20.0, load=0.8),
    task(20.0, load=-0.8, nu=0.5, friction=0.1),
    task(12.0, load=0.8, **damped(1e4)),
    task(20.0, load=0.45, f=-0.2, friction=0.03),
)
FAST = (
    task(2.0, nu=40.0, f=-30.0, friction=5.0),
    task(2.0, nu=40.0, f=-30.0, friction=5.0, **damped(1e5)),
)
