"""Error estimates of a marched motion from its impacts alone, by a model of its rounding: no further motion is solved.

Every flight rounds, and what it rounds follows the flights after it (`orbits.sensitivity.along`). Along the impacts of
a settled motion, which repeat, errors are followed until they repeat too. Times round once more when they are written
as tau; that error is known to the digit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_allocating, jit_inline
from vibropipe.march.log import POLYNOMIALS, STEPS
from vibropipe.orbits.sensitivity.along import (
    AFTER,
    COVERED,
    DELAY,
    ERRORS,
    LEAVING,
    PER_TAU,
    SECOND,
    SPEED,
    follow_repeated,
    longer_by,
)
from vibropipe.orbits.sensitivity.errors import ULP
from vibropipe.physics.exciter import Exciter, Parameters
from vibropipe.physics.flow import free_flow
from vibropipe.physics.load import force_at, force_value, forcing_period, largest_force
from vibropipe.physics.turns import TWO_PI
from vibropipe.solve.motion.run import MotionRequest, MotionResult
from vibropipe.words.status import Status

# Largest error, relative to the motion, that is followed to first order; beyond it the motion is solved again.
SMALL = 1e-12
# Errors of an impact within which a sample may lie on its other side.
NEAR = 2.0
# What TWO_PI lacks of 2 pi, and the factor that splits a float into halves whose products are exact.
TWO_PI_REST, SPLIT = 2.4492935982947064e-16, 2.0**27 + 1.0

Errors = dict[str, np.ndarray]
# Present (1) or absent.
Effect = int | None


class Ends(NamedTuple):
    """Start and end of a motion: times in tau and in turns, states, and what the state at the start is off."""

    tau_start: float
    tau_end: float
    turn_start: float
    turn_end: float
    x: float
    v: float
    x_end: float
    v_end: float
    x_off: float
    v_off: float


def rounding_errors(
    exciter: Exciter, request: MotionRequest, run: MotionResult, floor: tuple[float, float] = (0, 0)
) -> Errors | None:
    """Return the errors of end state and impacts of an exact motion; None if the model does not hold.

    It holds of motions between rigid supports, without rests and touches, whose errors stay small. With samples, the
    errors of their displacement and velocity are added, which are by `floor` larger.

    floor : error of displacement and velocity of a sample whose tau is rounded
    """
    contacts, effects = run.contacts, request.effects
    is_plain = not effects.has_pieces and not request.energy and run.status == Status.OK
    has_doubt = contacts["grazing_tau"].size + contacts["rest_start"].size > 0
    # A motion in closed form has no steps.
    if not is_plain or has_doubt or run.counts[STEPS] + run.counts[POLYNOMIALS] == 0:
        return None
    x_off = max(ULP * abs(request.x), request.x_uncertainty)
    v_off = max(ULP * abs(request.v), request.v_uncertainty)
    taus, start = (request.tau_start, request.tau_end), (request.x, request.v)
    ends = Ends(*taus, *run.turns, *start, *run.end, x_off, v_off)
    p, tau = exciter.parameters(), contacts["impact_tau"]
    impacts = tau, contacts["impact_velocity"], contacts["impact_support"]
    out, leaving, end = np.empty((ERRORS, tau.size)), np.empty(tau.size + 1), np.empty(2)
    if not _fill_errors(p, ends, *impacts, out, leaving, end, effects.second_harmonic):
        return None
    errors = {
        "impact_tau": out[DELAY],
        "impact_velocity": out[SPEED],
        "impact_velocity_after": out[AFTER],
        "displacement_end": end[0],
        "velocity_end": end[1],
    }
    if request.samples_per_period > 0:
        of_samples = np.empty((2, run.after.size + 1))
        turns = (tau - request.tau_start) / exciter.period
        _fill_samples(turns, leaving, end, run.after, floor, of_samples)
        late = (NEAR * out[DELAY] + 4 * ULP * tau) / exciter.period
        jumps = np.abs(contacts["impact_velocity_after"] - contacts["impact_velocity"])
        _widen_at_jumps(turns, late, jumps, run.after, run.turns[1] - run.turns[0], of_samples[1])
        errors |= {"displacement": of_samples[0], "velocity": of_samples[1]}
    return errors


@jit_allocating
def _fill_errors(
    p: Parameters,
    ends: Ends,
    tau: np.ndarray,
    velocity: np.ndarray,
    support: np.ndarray,
    out: np.ndarray,
    leaving: np.ndarray,
    end: np.ndarray,
    second: Effect,
) -> bool:
    """Fill the errors of impacts (ERRORS, n), of the states that leave start and impacts (n + 1), and of the end (2).

    Returns whether they are so small that they are linear.
    """
    period, n, slowest = forcing_period(p), tau.size, 1.0
    for i in range(n):
        slowest = min(slowest, abs(velocity[i]))
    if not slowest > 0.0:
        return False
    position = tau / period
    slip = _turns_off(p, ends.tau_start, ends.turn_start)
    first = _first_flight(p, ends, tau, velocity, slip, second)
    largest = follow_repeated(p, first / COVERED, position, velocity, support, out, second)
    if not max(largest, first) < SMALL * slowest:
        return False
    period_off = _period_off(p)
    leaving[0] = first
    for i in range(n):
        out[DELAY, i] += 0.5 * (_spacing(tau[i]) + period * _spacing(position[i]))
        out[DELAY, i] += tau[i] * period_off + slip
        leaving[i + 1] = out[LEAVING, i]
    late = _turns_off(p, ends.tau_end, ends.turn_end) + slip
    end[0], end[1] = _end_error(p, ends, tau, velocity, leaving[n], late, second)
    return True


@jit
def _fill_samples(
    turns: np.ndarray,
    leaving: np.ndarray,
    end: np.ndarray,
    after: np.ndarray,
    floor: tuple[float, float],
    errors: np.ndarray,
) -> None:
    """Fill the errors of the samples of a motion and of its end (2, n + 1), from those of what leaves the impacts.

    No flight increases sqrt(dx^2 + dx'^2), and its own rounding is part of what meets the next impact.
    """
    j, n = 0, turns.size
    for i in range(n + 1):
        within = leaving[i] + (leaving[i + 1] if i < n else max(end[0], end[1]))
        of_x, of_v = within + floor[0], within + floor[1]
        until = turns[i] if i < n else math.inf
        while j < after.size and after[j] < until:
            errors[0, j], errors[1, j] = of_x, of_v
            j += 1
    errors[0, j], errors[1, j] = end[0] + floor[0], end[1] + floor[1]


@jit
def _widen_at_jumps(
    turns: np.ndarray,
    late: np.ndarray,
    jumps: np.ndarray,
    after: np.ndarray,
    span: float,
    errors: np.ndarray,
) -> None:
    """Raise the errors (n + 1) of the sampled velocity to the whole jump where an impact may be `late` or early.

    turns, late, jumps : of each impact; after : (n,) times of the samples; span : of the end; in turns from the start.
    """
    first = 0
    for i in range(turns.size):
        while first < after.size and after[first] < turns[i] - late[i]:
            first += 1
        j = first
        while j < after.size and after[j] <= turns[i] + late[i]:
            errors[j] = max(errors[j], jumps[i])
            j += 1
        if span <= turns[i] + late[i]:
            errors[after.size] = max(errors[after.size], jumps[i])


@jit_inline
def _push(p: Parameters) -> float:
    """Return a bound of force, load and spring at the supports."""
    return largest_force(p) + abs(p.delta) + abs(p.load) + p.l


@jit_inline
def _acceleration(p: Parameters, x: float, v: float, turns: float, second: Effect) -> float:
    """Return a bound of the acceleration of a state."""
    return (
        abs(force_value(force_at(p, 1.0, turns % 1.0, second), second))
        + abs(x - p.load)
        + p.h * abs(v)
    )


@jit_inline
def _spacing(x: float) -> float:
    """Return the distance of a positive float to the next one, from which the sum is less than half of it away."""
    return (x + 0.75 * ULP * x) - x


@jit
def _product(a: float, b: float) -> tuple[float, float]:
    """Return a product as its nearest float and the exact rest [1]_.

    References
    ----------
    .. [1] T. J. Dekker, A floating-point technique for extending the available precision, Numer. Math. 18 (1971) 224.
    """
    product = a * b
    a_high, b_high = a * SPLIT - (a * SPLIT - a), b * SPLIT - (b * SPLIT - b)
    a_low, b_low = a - a_high, b - b_high
    rest = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low
    return product, rest


@jit
def _turns_off(p: Parameters, tau: float, turns: float) -> float:
    """Return by how much a time in turns is off, in tau."""
    angle, rest = _product(turns, TWO_PI)
    phase, phase_rest = _product(tau, p.nu)
    return abs((angle - phase) + (rest - phase_rest) + turns * TWO_PI_REST) / p.nu


@jit
def _period_off(p: Parameters) -> float:
    """Return the relative error of the forcing period in double precision."""
    angle, rest = _product(forcing_period(p), p.nu)
    return abs((angle - TWO_PI) + (rest - TWO_PI_REST)) / TWO_PI


@jit_inline
def _first_flight(
    p: Parameters, ends: Ends, tau: np.ndarray, velocity: np.ndarray, slip: float, second: Effect
) -> float:
    """Return the error of the state that ends the first flight; slip : by how much the start is off in tau."""
    arrival, span = ends.v_end, ends.tau_end - ends.tau_start
    if tau.size > 0:
        arrival, span = velocity[0], tau[0] - ends.tau_start
    e11, e12, e21, e22 = free_flow(p.h, span)
    left = min(1.0, math.hypot(math.hypot(e11, e12), math.hypot(e21, e22)))
    size = left * (abs(ends.x) + abs(ends.v)) * (1.0 + PER_TAU * span * max(1.0, p.nu))
    size += (abs(arrival) + min(1.0, span) * _push(p)) * longer_by(p, span)
    moved = abs(ends.v) + _acceleration(p, ends.x, ends.v, ends.turn_start, second)
    turned = 1.0 if second is None else SECOND * SECOND
    off = math.hypot(ends.x_off, ends.v_off) + slip * moved
    return left * off + turned * ULP * size


@jit_inline
def _end_error(
    p: Parameters,
    ends: Ends,
    tau: np.ndarray,
    velocity: np.ndarray,
    leaving: float,
    late: float,
    second: Effect,
) -> tuple[float, float]:
    """Return the errors of displacement and velocity at the end.

    leaving : error of the state after the last impact, or of the first flight; late : by how much the end is off.
    """
    x, v = ends.x_end, ends.v_end
    acceleration = _acceleration(p, x, v, ends.turn_end, second)
    own, to_x, to_v = ULP * (abs(x) + abs(v) + _push(p)), leaving, leaving
    if tau.size > 0:
        span = max(0.0, ends.tau_end - tau[-1])
        e11, e12, e21, e22 = free_flow(p.h, span)
        to_x, to_v = math.hypot(e11, e12) * leaving, math.hypot(e21, e22) * leaving
        own = (own + ULP * abs(velocity[-1])) * longer_by(p, span)
    return to_x + own + abs(v) * late, to_v + own + acceleration * late
