"""The cheapest method and step that reach an accuracy, found by trial on the very exciter.

The exact motion is tried first. Its cost bounds what any other method may cost, and it judges them:
Newmark's method is tried with ever more steps until it is accurate enough or would cost more. Costs
are counts of work times fixed prices, so the same exciter is always given the same method.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from vibropipe.march.grid import newmark_grid
from vibropipe.march.log import EVALUATIONS, POLYNOMIALS, STEPS
from vibropipe.physics.exciter import Exciter, ParameterError, as_float
from vibropipe.physics.flow import steps_for_exact
from vibropipe.physics.limits import ACCURACY, STEPS_PER_PERIOD, within_text
from vibropipe.solve.accuracy.motion_errors import (
    Errors,
    deviation,
    exact_errors,
    largest_relative_error,
    motion_scales,
)
from vibropipe.solve.motion_dataset import to_variables
from vibropipe.solve.run import MotionRequest, MotionResult, run_motion
from vibropipe.words.status import Status

MIN_STEPS = 4
# Each trial takes so many times the steps of the one before: the first that does is near the fewest.
GROWTH = 2**0.5


class Prices(NamedTuple):
    """Nanoseconds of a step, a polynomial, an evaluation of it, an impact, and a step of the grid's tables.

    Fitted to 200 motions on one machine, of which they meet most within a third; only their ratios decide, and
    those hardly differ between machines.
    """

    step: float
    polynomial: float
    evaluation: float
    impact: float
    table: float


EXACT_PRICES = Prices(5.4, 135.0, 62.0, 41.0, 6.0)
NEWMARK_PRICES = Prices(4.7, 31.0, 82.0, 302.0, 6.0)


class Choice(NamedTuple):
    """method: "exact" or "newmark"; steps_per_period: None for exact; error: what is reached, in the measure
    of `largest_relative_error`; reached: whether that is as accurate as asked; nanoseconds: of the march, by the
    prices."""

    method: str
    steps_per_period: int | None
    error: float
    reached: bool
    nanoseconds: float


def choose(
    exciter: Exciter,
    tau_end: float,
    x0: float | None = None,
    v0: float = 0.0,
    accuracy: float = 1e-8,
    *,
    tau_start: float = 0.0,
) -> Choice:
    """The cheapest way to this motion with errors of at most `accuracy`, absolute and relative to the size
    of the quantity; the exact method, and `reached` False, where double precision can not do it.

    Raises ParameterError for what `simulate` does not take either.
    """
    x, v = exciter.check_start(x0, v0)
    request = MotionRequest(tau_start, tau_end, x, v, samples_per_period=0)
    choice, _run, _errors = choose_method(exciter, request, check_accuracy(accuracy))
    return choice


def check_accuracy(accuracy: Any) -> float:
    """An accuracy as a float, or a ParameterError."""
    allowed, (least, most) = within_text(ACCURACY, "a finite number"), ACCURACY
    value = as_float("accuracy", accuracy, allowed)
    if not least <= value <= most:
        raise ParameterError("accuracy", accuracy, allowed)
    return value


def choose_method(
    exciter: Exciter, request: MotionRequest, accuracy: float
) -> tuple[Choice, MotionResult, Errors]:
    """The choice for a task, with the exact motion and its errors, on which it rests."""
    exact = run_motion(exciter, request)
    errors = exact_errors(exciter, request, exact)
    variables = to_variables(exciter, request, exact)
    sizes = motion_scales(exciter, request, variables)
    reached = largest_relative_error(variables, errors, sizes, accuracy)
    nanoseconds = cost(EXACT_PRICES, steps_for_exact(exciter.nu, exciter.h), exact)
    best = Choice("exact", None, reached, reached <= accuracy, nanoseconds)
    if not best.reached or exact.status != Status.OK:
        return best, exact, errors
    steps = MIN_STEPS
    short = request._replace(samples_per_period=0)
    periods = (request.tau_end - request.tau_start) / exciter.period
    while least_cost(steps, periods, exact) < nanoseconds and steps <= STEPS_PER_PERIOD[1]:
        grid = newmark_grid(request.effects, exciter.parameters(), steps)
        run = run_motion(exciter, short, grid)
        spent = cost(NEWMARK_PRICES, steps, run)
        if spent < nanoseconds and run.status == Status.OK:
            found = to_variables(exciter, short, run)
            error = max(
                largest_relative_error(found, deviation(found, variables, errors), sizes, accuracy),
                # Impacts of the exact motion that the method does not have.
                largest_relative_error(
                    variables, deviation(variables, found, errors), sizes, accuracy
                ),
            )
            if error <= accuracy:
                return Choice("newmark", steps, error, True, spent), exact, errors
        steps = math.ceil(steps * GROWTH)
    return best, exact, errors


def cost(prices: Prices, steps: int, run: MotionResult) -> float:
    """Nanoseconds of a march on a grid of so many steps a period, by its counts; 0 for a closed form."""
    counts, struck = run.counts, run.contacts["impact_tau"].size
    worked = np.array([counts[STEPS], counts[POLYNOMIALS], counts[EVALUATIONS], struck, steps])
    return float(worked @ np.array(prices)) if counts[STEPS] + counts[POLYNOMIALS] else 0.0


def least_cost(steps: int, periods: float, exact: MotionResult) -> float:
    """Nanoseconds that Newmark's method takes at least: its steps, its tables, its impacts."""
    prices, struck = NEWMARK_PRICES, exact.contacts["impact_tau"].size
    met = struck * (prices.polynomial + prices.impact)
    return periods * steps * prices.step + steps * prices.table + met
