"""Flights of the orbits in closed form: which orbits an exciter has, and whether they leave the supports."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating
from vibropipe.physics import closed_orbits as closed
from vibropipe.physics.effects import Effects, all_effects, effect_names
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.flow import (
    DEGREE,
    REACH,
    fastest_rate,
    motion_with_curvature,
    steps_for_exact,
    taylor,
)
from vibropipe.physics.load import force_at, forcing_period
from vibropipe.solve.checks import check_whole
from vibropipe.solve.equilibrium import about_equilibrium
from vibropipe.solve.motion.run import MotionRequest, run_motion
from vibropipe.words.status import Status

# Largest period multiple.
MAX_MULTIPLE = 1000
# Steps of the march of a flight: some seconds.
MAX_FLIGHT_STEPS = 1e8
# Distance from the support, as a share of the motion's size, within which a contact at the end of a flight is the
# impact of the orbit itself: well above the rounding of a flight.
CONTACT_TOLERANCE = 1e-12
# Bisections of a step: the last interval is below the rounding of theta.
BISECTIONS = 54


class Family(NamedTuple):
    """One family of orbits on an exciter that is mirrored, if needed, so that the impact is on support 1.

    exciter : without load: x counts from the equilibrium
    n : half forcing periods from an impact to the next
    sign : 1, or -1 if x is mirrored
    """

    exciter: Exciter
    n: int
    sign: float
    given: Exciter

    @property
    def effects(self) -> tuple[str, ...]:
        """Effects of the closed forms: all but rest, which no orbit with one impact in a flight has."""
        return effect_names(Effects(rest=None), vars(self.given))

    @property
    def is_symmetric(self) -> bool:
        """Whether the impacts alternate between the supports."""
        return self.n % 2 == 1

    def solve(self) -> tuple[closed.FlightTerms, closed.Response]:
        """Return the terms of the closed forms."""
        e = self.exciter
        terms = closed.flight_terms(e.nu, e.h, self.n)
        return terms, closed.response(e.nu, e.h, e.R1, terms)


def symmetric_family(exciter: Exciter, m: int) -> Family:
    """Return the symmetric orbits of an exciter, or raise a ParameterError."""
    if exciter.delta != exciter.load:
        got = f"delta = {exciter.delta!r}, load = {exciter.load!r}" if exciter.load else None
        must = f"must be {'the load' if exciter.load else '0'} for a symmetric orbit"
        raise ParameterError("delta", exciter.delta, must=must, got=got)
    if exciter.R1 != exciter.R2:
        got = f"R1 = {exciter.R1!r}, R2 = {exciter.R2!r}"
        raise ParameterError("R2", exciter.R2, must="must equal R1 for a symmetric orbit", got=got)
    m = check_whole("m", m, (1, MAX_MULTIPLE))
    if m % 2 == 0:
        raise ParameterError("m", m, must="must be odd for a symmetric orbit")
    return Family(_forced(exciter), m, 1.0, exciter)


def one_sided_family(exciter: Exciter, support: int, m: int) -> Family:
    """Return the one-sided orbits of an exciter, or raise a ParameterError."""
    support = check_whole("support", support, (1, 2))
    m = check_whole("m", m, (1, MAX_MULTIPLE))
    about = _forced(exciter)
    if support == 1:
        return Family(about, 2 * m, 1.0, exciter)
    return Family(about.mirrored(), 2 * m, -1.0, exciter)


def _forced(exciter: Exciter) -> Exciter:
    """Return the exciter about its equilibrium; ParameterError if it has no force or an effect that is not computed."""
    all_effects(vars(exciter))
    if exciter.f2 != 0.0:
        raise ParameterError("f2", exciter.f2, must="must be 0 for an orbit in closed form")
    if exciter.f == 0.0:
        must = "must not be 0, since these orbits have the period of the force (free motions: amplitude_frequency)"
        raise ParameterError("f", exciter.f, must=must)
    return about_equilibrium(exciter)


class Flight(NamedTuple):
    """A flight from one impact to the next: whether it is admissible, its clearance, and the state at tau = 0."""

    admissible: bool = False
    clearance: float = math.nan
    strobe: tuple[float, float] = (math.nan, math.nan)


def _check_steps(exciter: Exciter, periods: float) -> None:
    """Raise a ParameterError if the march of a flight over some forcing periods takes too long."""
    steps = periods * exciter.period * fastest_rate(exciter.nu, exciter.h) / REACH
    if not steps < MAX_FLIGHT_STEPS:
        must = "must give a flight of less than 1e8 steps of the march"
        raise ParameterError(
            "nu", exciter.nu, must=must, got=f"{exciter.nu!r} with {steps:.3g} steps"
        )


def fly(family: Family, phase: float, v: float) -> Flight:
    """March the flight that follows an impact on support 1."""
    if not math.isfinite(v):
        return Flight()
    e, half = family.exciter, 0.5 * family.n
    _check_steps(e, half)
    least, most = flight_extremes(e.parameters(), phase, e.upper, -e.R1 * v, family.n)
    clearance = min(e.upper - most, least - e.lower)
    start, end = phase * e.period, (phase + half) * e.period
    request = MotionRequest(start, end, e.upper, -e.R1 * v, samples_per_period=0)
    run = run_motion(e, request)
    contacts = np.concatenate([run.contacts["impact_tau"], run.contacts["rest_start"]])
    admissible = (
        run.status == Status.OK
        and not ((end - contacts) * v > CONTACT_TOLERANCE * (e.l + abs(e.upper) + v)).any()
    )
    strobe = math.nan, math.nan
    if admissible:
        # The section within the flight; a symmetric orbit is at its mirror image after every flight.
        flights = math.floor(phase / half) + 1
        section = run_motion(e, request._replace(tau_end=flights * half * e.period)).end
        sign = (-1.0) ** (family.n * flights)
        strobe = sign * section[0], sign * section[1]
    return Flight(admissible, clearance if math.isfinite(clearance) else math.nan, strobe)


@jit
def _zero(c: np.ndarray, derivative: int, low: float, high: float) -> float:
    """Return a zero on [low, high] of the first or second derivative of a polynomial, which changes sign there."""
    slope, curvature = motion_with_curvature(c, low)[1:]
    positive = (slope if derivative == 1 else curvature) > 0.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        slope, curvature = motion_with_curvature(c, middle)[1:]
        if ((slope if derivative == 1 else curvature) > 0.0) == positive:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@jit_allocating
def flight_extremes(p: Parameters, turn: float, x: float, v: float, n: int) -> tuple[float, float]:
    """Return the least minimum and the largest maximum of x within a flight that passes through supports.

    They are over the points strictly within the flight where x' changes sign; inf and -inf without such a point. A step
    is at most half of the shortest time scale, so that x'' changes sign at most once in it: x' has a zero on either
    side of that point, or none.

    turn, x, v : phase, in turns, and state at its start
    n : its length in half forcing periods
    """
    steps = math.ceil(0.5 * n * steps_for_exact(p.nu, p.h))
    dt = 0.5 * n * forcing_period(p) / steps
    c, least, most = np.empty(DEGREE + 1), math.inf, -math.inf
    for step in range(steps):
        at = turn + 0.5 * n * step / steps
        taylor(c, x, v, force_at(p, 1.0, at - math.floor(at)), 0.0, p.h, p.nu, dt)
        _x, slope, curvature = motion_with_curvature(c, 0.0)
        end, end_slope, end_curvature = motion_with_curvature(c, 1.0)
        bend = _zero(c, 2, 0.0, 1.0) if curvature * end_curvature < 0.0 else 1.0
        bend_slope = motion_with_curvature(c, bend)[1]
        for low, high, before, after in (
            (0.0, bend, slope, bend_slope),
            (bend, 1.0, bend_slope, end_slope),
        ):
            if before * after < 0.0 or (before != 0.0 and after == 0.0 and low < high):
                extreme = motion_with_curvature(c, _zero(c, 1, low, high))[0]
                if before < 0.0:
                    least = min(least, extreme)
                else:
                    most = max(most, extreme)
        x, v = end, end_slope / dt
    return least, most
