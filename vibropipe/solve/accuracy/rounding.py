"""Error estimates of a marched motion from its impacts alone, by a model of its rounding: no further motion is solved.

Every flight rounds, and what it rounds follows the flights after it (`orbits.sensitivity.along`). Along the impacts of
a settled motion, which repeat, errors are followed until they repeat too. Times round once more when they are written
as tau; that error is known to the digit.
"""

from __future__ import annotations

import math
from decimal import Decimal, localcontext

import numpy as np

from vibropipe.orbits.sensitivity.along import (
    AFTER,
    COVERED,
    DELAY,
    ERRORS,
    LEAVING,
    SECOND,
    SPEED,
    follow_errors,
    longer_by,
    repeats_from,
)
from vibropipe.orbits.sensitivity.errors import ULP
from vibropipe.physics.effects import Effects
from vibropipe.physics.exciter import Exciter, Parameters
from vibropipe.physics.flow import free_flow
from vibropipe.physics.load_harmonics import force_values
from vibropipe.solve.motion.run import MotionRequest, MotionResult, closed_form_solver
from vibropipe.words.status import Status

# Largest error, relative to the motion, that is followed to first order; beyond it the motion is solved again.
SMALL = 1e-12
# Largest number of impacts that repeat, repetitions along which errors are followed first, and the largest share of an
# error that its last change makes if it goes on.
MAX_LAG, FIRST_REPETITIONS, GOES_ON = 32, 32, 0.1
TURN = Decimal("6.28318530717958647692528676655900576839433879875")

Errors = dict[str, np.ndarray]


def rounding_errors(exciter: Exciter, request: MotionRequest, run: MotionResult) -> Errors | None:
    """Return the errors of end state and impacts of an exact motion; None if the model does not hold.

    It holds of motions between rigid supports, without rests and touches, whose errors stay small. With samples, the
    errors of their displacement and velocity are added.

    Parameters
    ----------
    exciter : Exciter
    request : MotionRequest
    run : MotionResult
        The exact motion.
    """
    contacts, effects = run.contacts, request.effects
    is_plain = not effects.has_pieces and not request.energy and run.status == Status.OK
    has_doubt = contacts["grazing_tau"].size + contacts["rest_start"].size > 0
    if not is_plain or has_doubt or closed_form_solver(exciter, request) is not None:
        return None
    velocity, support = contacts["impact_velocity"], contacts["impact_support"]
    if not np.all(np.abs(velocity) > 0.0):
        return None
    period, p = exciter.period, exciter.parameters()
    position = contacts["impact_tau"] / period
    first, slip = _first_flight(exciter, request, run)
    out, largest = _followed(p, first / COVERED, position, velocity, support, effects)
    size = min(1.0, np.abs(velocity).min(initial=1.0))
    if not max(largest, first) < SMALL * size:
        return None
    tau = contacts["impact_tau"]
    out[DELAY] += 0.5 * np.spacing(tau)
    out[DELAY] += (0.5 * period) * np.spacing(position)
    out[DELAY] += tau * _period_error(exciter) + slip
    leaving = np.append(first, out[LEAVING])
    late = _turns_off(exciter, request.tau_end, run.turns[1]) + slip
    end = _end_error(exciter, run, leaving[-1], late)
    errors = {
        "impact_tau": out[DELAY],
        "impact_velocity": out[SPEED],
        "impact_velocity_after": out[AFTER],
        "displacement_end": np.float64(end[0]),
        "velocity_end": np.float64(end[1]),
    }
    if request.samples_per_period > 0:
        # No flight increases sqrt(dx^2 + dx'^2), and its own rounding is part of what meets the next impact.
        times = request.tau_start + run.after * period
        within = leaving + np.append(leaving[1:], max(end))
        next_sample = np.searchsorted(times, tau)
        samples = np.repeat(within, np.diff(next_sample, prepend=0, append=times.size + 1))
        errors["displacement"], errors["velocity"] = samples, samples.copy()
        samples[-1], errors["velocity"][-1] = end
    return errors


def _followed(
    p: Parameters,
    first: float,
    position: np.ndarray,
    velocity: np.ndarray,
    support: np.ndarray,
    effects: Effects,
) -> tuple[np.ndarray, float]:
    """Return the errors (ERRORS, n) of `follow_errors`, whose arguments these are, and the largest."""
    n, second = velocity.size, effects.second_harmonic
    lags = range(1, min(MAX_LAG, n // FIRST_REPETITIONS) + 1)
    starts = ((repeats_from(position[-2 * lag :], velocity[-2 * lag :], lag), lag) for lag in lags)
    lag = next((lag for start, lag in starts if start == 0), 0)
    followed = repeats_from(position, velocity, lag) + FIRST_REPETITIONS * lag if lag else n
    while followed < n:
        repetitions = -(-(n - followed) // lag)
        out = np.empty((ERRORS, followed + repetitions * lag))
        part = slice(followed)
        largest = follow_errors(
            p, first, position[part], velocity[part], support[part], out, second
        )
        before, last = out[:, followed - 2 * lag : followed].reshape(ERRORS, 2, lag).swapaxes(0, 1)
        if (repetitions * np.abs(last - before) <= GOES_ON * last).all():
            out[:, followed:].reshape(ERRORS, repetitions, lag)[:] = last[:, None]
            return out[:, :n], largest
        followed *= 2
    out = np.empty((ERRORS, n))
    return out, follow_errors(p, first, position, velocity, support, out, second)


def _push(exciter: Exciter) -> float:
    """Return a bound of force, load and spring at the supports."""
    offsets = abs(exciter.delta) + abs(exciter.load) + exciter.l
    return abs(exciter.f) + abs(exciter.f2) + offsets


def _acceleration(exciter: Exciter, x: float, v: float, turns: float) -> float:
    """Return a bound of the acceleration of a state."""
    force = float(force_values(exciter.f, np.array([turns]), exciter.f2, exciter.phi2)[0])
    return abs(force) + abs(x - exciter.load) + exciter.h * abs(v)


def _turns_off(exciter: Exciter, tau: float, turns: float) -> float:
    """Return by how much a time in turns is off, in tau."""
    with localcontext() as context:
        context.prec = 40
        exact = Decimal(tau) * Decimal(exciter.nu) / TURN
        return float(abs(Decimal(turns) - exact) * TURN / Decimal(exciter.nu))


def _period_error(exciter: Exciter) -> float:
    """Return the relative error of the forcing period in double precision."""
    with localcontext() as context:
        context.prec = 40
        return float(abs(Decimal(exciter.period) * Decimal(exciter.nu) / TURN - 1))


def _first_flight(
    exciter: Exciter, request: MotionRequest, run: MotionResult
) -> tuple[float, float]:
    """Return the error of the state that ends the first flight, and by how much the start is off in tau."""
    tau, velocity = run.contacts["impact_tau"], run.contacts["impact_velocity"]
    end = tau[0] if tau.size else request.tau_end
    arrival = velocity[0] if tau.size else run.end[1]
    span = end - request.tau_start
    slip = _turns_off(exciter, request.tau_start, run.turns[0])
    size = abs(request.x) + abs(request.v) + abs(arrival) + min(1.0, span) * _push(exciter)
    start = math.hypot(
        max(ULP * abs(request.x), request.x_uncertainty),
        max(ULP * abs(request.v), request.v_uncertainty),
    )
    moved = abs(request.v) + _acceleration(exciter, request.x, request.v, run.turns[0])
    turned = SECOND**2 if exciter.f2 else 1.0
    return start + turned * ULP * size * longer_by(exciter.nu, span) + slip * moved, slip


def _end_error(
    exciter: Exciter, run: MotionResult, leaving: float, late: float
) -> tuple[float, float]:
    """Return the errors of displacement and velocity at the end.

    leaving : error of the state after the last impact, or of the first flight; late : by how much the end is off.
    """
    x, v = run.end
    acceleration = _acceleration(exciter, x, v, run.turns[1])
    tau, tau_end = run.contacts["impact_tau"], run.turns[1] * exciter.period
    own = ULP * (abs(x) + abs(v) + _push(exciter))
    if not tau.size:
        return leaving + own + abs(v) * late, leaving + own + acceleration * late
    span = max(0.0, tau_end - tau[-1])
    e11, e12, e21, e22 = free_flow(exciter.h, span)
    to_x, to_v = math.hypot(e11, e12) * leaving, math.hypot(e21, e22) * leaving
    own = (own + ULP * abs(run.contacts["impact_velocity"][-1])) * longer_by(exciter.nu, span)
    return to_x + own + abs(v) * late, to_v + own + acceleration * late
