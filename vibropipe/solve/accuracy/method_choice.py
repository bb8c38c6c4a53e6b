"""The cheapest method and step that reach an accuracy, selected by trial runs on the same exciter.

The exact motion is computed first. Its cost is the upper limit for any other method, and it is their reference:
Newmark's method is tried with more and more steps until it is accurate enough or would cost more. Costs are
operation counts times fixed prices, so that the same exciter always gets the same method.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.grid import newmark_grid
from vibropipe.march.log import EVALUATIONS, POLYNOMIALS, STEPS
from vibropipe.physics.effects import grid_effects
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.flow import steps_for_exact
from vibropipe.physics.limits import ACCURACY, STEPS_PER_PERIOD, within_text
from vibropipe.physics.parameter_error import as_float
from vibropipe.solve.accuracy.motion_errors import (
    Errors,
    Scales,
    Variables,
    deviation,
    exact_errors,
    largest,
    motion_scales,
)
from vibropipe.solve.motion.motion_dataset import to_variables
from vibropipe.solve.motion.run import MotionRequest, MotionResult, run_motion
from vibropipe.words.status import Status

# Newmark steps per forcing period of the first trial.
MIN_STEPS = 4
# Ratio of the steps of successive trials: the first accurate one has at most this many times the least steps.
GROWTH = 2**0.5
# Error of Newmark's method over the square of its step, in radians of the force, that no motion has stayed below; slow
# forces excepted, whose error is smaller by the square of nu.
LEAST_ERROR = 1e-4


class Prices(NamedTuple):
    """Nanoseconds per step, polynomial, evaluation of it, impact, and step of the tables of a grid.

    The prices are fitted to 200 motions on one machine; most of these take within a third of the predicted time. Only
    ratios of prices matter, and these hardly differ between machines.
    """

    step: float
    polynomial: float
    evaluation: float
    impact: float
    table: float


EXACT_PRICES = Prices(5.4, 135.0, 62.0, 41.0, 6.0)
NEWMARK_PRICES = Prices(4.7, 31.0, 82.0, 302.0, 6.0)


class Choice(NamedTuple):
    """The selected method.

    method : "exact" or "newmark"
    steps_per_period : None for the exact method
    error : of the motion, as measured by `largest_relative_error`
    reached : whether the error is within the requested accuracy
    nanoseconds : cost of the march, by the prices
    """

    method: str
    steps_per_period: int | None
    error: float
    reached: bool
    nanoseconds: float


def check_accuracy(accuracy: Any) -> float:
    """Return an accuracy as a float, or raise a ParameterError."""
    allowed, (least, most) = within_text(ACCURACY, whole=False), ACCURACY
    value = as_float("accuracy", accuracy, allowed)
    if not least <= value <= most:
        raise ParameterError("accuracy", accuracy, allowed)
    return value


def choose_method(
    exciter: Exciter, request: MotionRequest, accuracy: float
) -> tuple[Choice, MotionResult, Variables, Errors]:
    """Select the method for a motion, to a maximum error.

    Returns (the choice, the exact motion, its quantities by `to_variables`, their error estimates).
    """
    exact = run_motion(exciter, request)
    variables = to_variables(exciter, request, exact)
    scales = motion_scales(exciter, request, variables)
    errors = exact_errors(exciter, request, exact, variables, scales)
    exact_error = largest_relative_error(variables, errors, scales, accuracy)
    unsampled, counts = request._replace(samples_per_period=0), exact.counts.copy()
    if request.samples_per_period > 0 and not request.effects.has_pieces:
        # Trials have no samples: without them, whole steps of the exact march have no polynomial.
        counts[POLYNOMIALS] -= counts[STEPS]
    marched = exact._replace(counts=counts)
    nanoseconds = cost(EXACT_PRICES, steps_for_exact(exciter.nu, exciter.h), marched)
    best = Choice("exact", None, exact_error, exact_error <= accuracy, nanoseconds)
    # By pieces a step of Newmark's method costs as much as an exact one, and more of them are needed.
    if not best.reached or exact.status != Status.OK or request.effects.has_pieces:
        return best, exact, variables, errors
    periods = (request.tau_end - request.tau_start) / exciter.period
    if (
        accuracy
        < LEAST_ERROR
        * (min(1.0, exciter.nu) * 2 * math.pi / most_steps(nanoseconds, periods, exact)) ** 2
    ):
        return best, exact, variables, errors
    steps = MIN_STEPS
    while least_cost(steps, periods, exact) < nanoseconds and steps <= STEPS_PER_PERIOD[1]:
        grid = newmark_grid(grid_effects(request.effects), exciter.parameters(), steps)
        run = run_motion(exciter, unsampled, grid)
        trial_cost = cost(NEWMARK_PRICES, steps, run)
        if trial_cost < nanoseconds and run.status == Status.OK:
            trial = to_variables(exciter, unsampled, run)
            # In both directions: either motion may have impacts that the other does not have.
            error = max(
                largest_relative_error(one, deviation(one, other, errors), scales, accuracy)
                for one, other in ((trial, variables), (variables, trial))
            )
            if error <= accuracy:
                return Choice("newmark", steps, error, True, trial_cost), exact, variables, errors
        steps = math.ceil(steps * GROWTH)
    return best, exact, variables, errors


def largest_relative_error(
    variables: Variables, errors: Errors, scales: Scales, accuracy: float
) -> float:
    """Return the largest error of end state, rests and fast impacts, the larger of absolute and relative.

    Impacts slower than `accuracy` times the velocity scale are ignored: they belong to a chatter, in which the number
    of impacts itself depends on the accuracy.

    variables : the motion (`to_variables`)
    scales : what errors are relative to
    """
    slow, of_impacts = accuracy * min(1.0, scales.velocity), variables["impact_velocity"][1]
    of_tau, of_speed = _of_fast(of_impacts, slow, errors["impact_tau"], errors["impact_velocity"])
    by_kind = (
        float(errors["displacement_end"]),
        max(float(errors["velocity_end"]), of_speed),
        max(of_tau, largest(errors["rest_start"]), largest(errors["rest_end"])),
    )
    worst = 0.0
    for error, scale in zip(by_kind, scales, strict=True):
        if error > 0.0:
            worst = max(worst, error / min(1.0, scale) if scale > 0.0 else math.inf)
    return worst


@jit
def _of_fast(
    velocity: np.ndarray, slow: float, of_tau: np.ndarray, of_velocity: np.ndarray
) -> tuple[float, float]:
    """Return the largest errors of times and of velocities of the impacts that are not `slow`."""
    late = change = 0.0
    for i in range(velocity.size):
        if abs(velocity[i]) > slow:
            late, change = max(late, of_tau[i]), max(change, of_velocity[i])
    return late, change


def cost(prices: Prices, steps: int, run: MotionResult) -> float:
    """Return the nanoseconds of a march with so many steps per period, from its counts; 0 for a closed form."""
    counts = run.counts.tolist()
    if counts[STEPS] + counts[POLYNOMIALS] == 0:
        return 0.0
    march = counts[STEPS], counts[POLYNOMIALS], counts[EVALUATIONS]
    effort = *march, run.contacts["impact_tau"].size, steps
    return sum(n * price for n, price in zip(effort, prices, strict=True))


def least_cost(steps: int, periods: float, exact: MotionResult) -> float:
    """Return a lower limit on the nanoseconds of Newmark's method: its steps, its tables and the impacts."""
    prices, n_impacts = NEWMARK_PRICES, exact.contacts["impact_tau"].size
    impact_cost = n_impacts * (prices.polynomial + prices.impact)
    return periods * steps * prices.step + steps * prices.table + impact_cost


def most_steps(nanoseconds: float, periods: float, exact: MotionResult) -> float:
    """Return the steps per period of which Newmark's method may take no more for that price, at least one."""
    spent = least_cost(0, periods, exact)
    return max(1.0, (nanoseconds - spent) / (least_cost(1, periods, exact) - spent))
