"""Where common methods fail: four questions, each to the exact method and to what is used in its place.

Energy of a free motion over many impacts, velocity of a grazing impact over its depth, end of a chatter over the
coefficient of restitution, and error of a motion over the steps. The truth is a closed form or a solution of forty
digits. Methods: impacts at the end of a step (crude), Newmark's method with located impacts, DOP853 of scipy with an
event for each support, and the exact method.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from decimal import Decimal, localcontext
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vibropipe.lab.hard_cases.contacts import FALL, FIRST_TAU, PRESSED, chatter_series
from vibropipe.lab.motion_reference import MotionReference
from vibropipe.lab.peers.solve_ivp import Recorder, WorkError, solve_by_scipy
from vibropipe.lab.work_precision import Entry, build, solve_quietly
from vibropipe.lab.work_precision_methods import BenchmarkMotion, newmark_crude
from vibropipe.physics.exciter import Exciter
from vibropipe.words.measurements import Outcome

METHODS = ("crude", "newmark", "DOP853", "DOP853_loose", "DOP853_short", "exact", "closed")
# Steps per forcing period of both step methods; of energy by Newmark's method, of which flights are longer.
STEPS, ENERGY_STEPS = 1024, 60
# Tolerances of DOP853: energy (two), grazing, chatter.
LOOSE, TIGHT, FINEST = 1e-6, 1e-10, 1e-12
IMPACTS = 1_000_000
COUNTS = np.unique(np.round(np.logspace(0, 6, 61)).astype(int))
# Impacts after which DOP853 is stopped: it takes a millisecond for each.
MAX_IMPACTS = 1000
DEPTHS = np.logspace(-2, -13, 23)
RESTITUTIONS = np.array([0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.97, 0.99])
STEPS_TRIED = np.array([16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192])
TOLERANCES = tuple(10.0**-k for k in range(3, 13))
FIGURE_6 = Exciter(nu=1.0, f=-1.0, h=0.2, l=0.5, R1=0.7, R2=0.7)
# A force that changes nothing, but keeps the closed form of the free motion from being used.
NO_FORCE = 1e-300

Values = dict[str, NDArray[np.float64]]


class Found(NamedTuple):
    """Error of a method over the abscissa, nan where it has none, and its outcome at each point."""

    error: NDArray[np.float64]
    outcome: NDArray[np.int8]


def of_errors(errors: Sequence[float], missing: Outcome) -> Found:
    """Return errors with outcomes: `missing` where an error is nan."""
    error = np.array(errors, float)
    return Found(error, np.where(np.isnan(error), missing, Outcome.OK).astype(np.int8))


# -- impacts of each method --------------------------------------------------------------------------


def scipy_impacts(
    motion: BenchmarkMotion, tolerance: float, max_impacts: int, longest: float = math.inf
) -> list[tuple[float, int, float]]:
    """Return the impacts (tau, support, velocity) by DOP853 until the end, too many of them, or no progress."""
    recorder = LimitedRecorder(motion, max_impacts)
    with suppress(WorkError):
        solve_by_scipy(motion, "DOP853", tolerance, recorder=recorder, longest=longest)
    return recorder.impacts


class LimitedRecorder(Recorder):
    """A record that stops a run after so many impacts, or at a second impact at one instant."""

    def __init__(self, motion: BenchmarkMotion, max_impacts: int) -> None:
        super().__init__(motion, bounded=False)
        self.max_impacts = max_impacts

    def meet(self, tau: float, support: int, velocity: float) -> float:
        """Strike a support, as `Recorder.meet`."""
        stuck = bool(self.impacts) and tau - self.impacts[-1][0] <= math.ulp(tau)
        after = super().meet(tau, support, velocity)
        if stuck or len(self.impacts) >= self.max_impacts:
            raise WorkError
        return after


# -- energy ------------------------------------------------------------------------------------------


def energy() -> Mapping[str, Found]:
    """Return the largest relative error of the energy of a free motion up to each number of COUNTS impacts.

    Without losses, from x = 0 with the velocity -0.51, at supports at -0.5 and 0.5.
    """
    speed, flight = 0.51, 2.0 * math.asin(0.5 / 0.51)
    free = Exciter(l=0.5)
    pushed = Exciter(l=0.5, nu=1.0, f=NO_FORCE)

    def growth(velocity: Any) -> Found:
        """Return the errors, with what comes after the last impact as missed."""
        error = np.abs((np.asarray(velocity) ** 2 + 0.25) / speed**2 - 1.0)
        largest = np.maximum.accumulate(error)
        reached = largest.size >= COUNTS
        return of_errors(
            np.where(reached, largest[np.minimum(COUNTS, largest.size) - 1], math.nan).tolist(),
            Outcome.DID_NOT_END,
        )

    def program(exciter: Exciter, **settings: Any) -> Found:
        end = 1.01 * flight * IMPACTS
        motion = solve_quietly(exciter, end, 0.0, -speed, **settings)
        return growth(motion["impact_velocity"].values[:IMPACTS])

    def scipy(tolerance: float) -> Found:
        periods = math.ceil(1.01 * flight * MAX_IMPACTS / free.period)
        impacts = scipy_impacts(BenchmarkMotion(free, 0.0, -speed, periods), tolerance, MAX_IMPACTS)
        return growth([velocity for _tau, _support, velocity in impacts])

    crude = newmark_crude(BenchmarkMotion(free, 0.0, -speed, MAX_IMPACTS), STEPS).show()
    return {
        "crude": growth(crude.impact_velocity),
        "newmark": program(pushed, method="newmark", steps_per_period=ENERGY_STEPS),
        "DOP853": scipy(TIGHT),
        "DOP853_loose": scipy(LOOSE),
        "exact": program(pushed),
        "closed": program(free),
    }


# -- grazing -----------------------------------------------------------------------------------------


def grazing() -> Mapping[str, Found]:
    """Return the relative error of the velocity of one impact, DEPTHS beyond the support, of a free motion.

    It starts at x = 0 with a velocity larger than l = 0.5 by the depth, as rounded: the truth is sqrt(v0^2 - l^2).
    """
    exciter = Exciter(l=0.5, R1=0.7, R2=0.7)
    short = exciter.period / STEPS

    def program(v0: float, **settings: Any) -> float:
        motion = solve_quietly(exciter, 2.0, 0.0, v0, **settings)
        return float(motion["impact_velocity"][0]) if motion.sizes["impact"] else math.nan

    def crude(v0: float) -> float:
        result = newmark_crude(BenchmarkMotion(exciter, 0.0, v0, 1), STEPS).show()
        first = result.impact_velocity[result.impact_tau < 2.0]
        return float(first[0]) if first.size else math.nan

    def scipy(v0: float, longest: float = math.inf) -> float:
        # A third of a period: the support is met at a quarter.
        impacts = scipy_impacts(BenchmarkMotion(exciter, 0.0, v0, 1), FINEST, 1, longest)
        return impacts[0][2] if impacts and impacts[0][0] < 2.0 else math.nan

    by_method: Mapping[str, Callable[[float], float]] = {
        "crude": crude,
        "newmark": lambda v0: program(v0, method="newmark", steps_per_period=STEPS),
        "DOP853": scipy,
        "DOP853_short": lambda v0: scipy(v0, short),
        "exact": program,
    }
    starts = 0.5 + DEPTHS
    return {
        name: of_errors(
            [relative_error(found(v0), grazing_velocity(v0)) for v0 in starts.tolist()],
            Outcome.MISSED_IMPACT,
        )
        for name, found in by_method.items()
    }


def grazing_velocity(v0: float) -> Decimal:
    """Return the velocity at which a free motion from x = 0 meets the support at 0.5."""
    with localcontext(prec=50):
        return (Decimal(v0) ** 2 - Decimal("0.25")).sqrt()


def relative_error(value: float, truth: Decimal) -> float:
    """Return the relative error of a value, nan for nan."""
    with localcontext(prec=50):
        return abs(float(Decimal(value) / truth - 1)) if math.isfinite(value) else math.nan


# -- chatter -----------------------------------------------------------------------------------------


def chatter() -> Mapping[str, Found]:
    """Return the relative error of the time at which a chatter ends, over RESTITUTIONS.

    A mass falls on a support into which its spring presses it; the truth is a sum of half turns. DOP853 never comes to
    rest: its error is the distance of its last impact from the end, and its outcome that it did not end.
    """
    rows: dict[str, list[tuple[float, Outcome]]] = {
        name: [] for name in ("crude", "newmark", "DOP853", "exact")
    }
    for R in RESTITUTIONS.tolist():
        exciter = Exciter(**PRESSED, R1=R, R2=0.7)
        end = float(chatter_series(R, 40 + math.ceil(math.log(1e-20) / math.log(R)))[0])
        motion = BenchmarkMotion(exciter, FALL, 0.0, math.ceil(1.5 * end / exciter.period) + 1)
        settings = {"newmark": {"method": "newmark", "steps_per_period": STEPS}, "exact": {}}
        for name, options in settings.items():
            run = solve_quietly(exciter, 2.0 * end, FALL, 0.0, **options)
            rests = run["rest_start"].values
            error = abs(float(rests[0]) / end - 1.0) if rests.size else math.nan
            rows[name].append((error, Outcome.OK if rests.size else Outcome.DID_NOT_END))
        rows["crude"].append(crude_rest(motion, end))
        last = scipy_impacts(motion, TIGHT, MAX_IMPACTS)[-1][0]
        rows["DOP853"].append((abs(last / end - 1.0), Outcome.DID_NOT_END))
    return {
        name: Found(np.array([e for e, _ in found]), np.array([o for _, o in found], np.int8))
        for name, found in rows.items()
    }


def crude_rest(motion: BenchmarkMotion, end: float) -> tuple[float, Outcome]:
    """Return the error of the first of two impacts in successive steps, which is how a step method comes to rest."""
    times = newmark_crude(motion, STEPS).show().impact_tau
    successive = np.flatnonzero(np.diff(times) < 1.5 * motion.exciter.period / STEPS)
    if not successive.size or times[successive[0]] < FIRST_TAU:
        return math.nan, Outcome.DID_NOT_END
    return abs(float(times[successive[0]]) / end - 1.0), Outcome.OK


# -- step --------------------------------------------------------------------------------------------


def step() -> Values:
    """Return steps per forcing period and errors of the motion of figure 6 of the paper, by method.

    Of both step methods over STEPS_TRIED, of DOP853 over its tolerances, of the exact method once; nan beyond.
    """
    motion = BenchmarkMotion(FIGURE_6, 0.0, 0.0, 20)
    reference = MotionReference(motion)
    settings: Mapping[str, Sequence[float]] = {
        "crude": STEPS_TRIED.tolist(),
        "newmark": STEPS_TRIED.tolist(),
        "DOP853": TOLERANCES,
        "exact": [math.nan],
    }
    steps, errors = (np.full((len(METHODS), STEPS_TRIED.size), math.nan) for _ in "12")
    for name, values in settings.items():
        for k, value in enumerate(values):
            entry = Entry(name, k, value)
            candidate: Any = build(entry.method, entry.value, motion)
            result = candidate.show()
            row = METHODS.index(name), k
            steps[row] = result.effort[0] / motion.periods
            errors[row] = max(reference.errors(result)[1])
    return {"step_count": steps, "step_error": errors}


# -- all ---------------------------------------------------------------------------------------------

QUESTIONS: Mapping[str, tuple[Callable[[], Mapping[str, Found]], str, NDArray[Any]]] = {
    "energy": (energy, "impact_count", COUNTS),
    "grazing": (grazing, "depth", DEPTHS),
    "chatter": (chatter, "restitution", RESTITUTIONS),
}


def answer_questions(questions: Sequence[str]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return variables and coordinates of the dataset of some questions: `<question>_error` and `_outcome`."""
    variables: dict[str, Any] = {}
    coords: dict[str, Any] = {"method": list(METHODS)} if questions else {}
    for question in questions:
        if question == "step":
            variables |= {n: (("method", "setting"), v) for n, v in step().items()}
            continue
        solve, abscissa, values = QUESTIONS[question]
        error = np.full((len(METHODS), values.size), math.nan)
        outcome = np.full(error.shape, Outcome.NOT_TRIED, np.int8)
        for name, found in solve().items():
            error[METHODS.index(name)], outcome[METHODS.index(name)] = found
        coords[abscissa] = values
        variables[f"{question}_error"] = (("method", abscissa), error)
        variables[f"{question}_outcome"] = (("method", abscissa), outcome)
    return variables, coords
