"""The motion on a ramp: the frequency of the force changes linearly from the start to the end."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.march.grid import RampGrid, grid_time
from vibropipe.march.log import Samples, new_log
from vibropipe.march.piece_log import piece_log_of
from vibropipe.march.piece_state import start_state
from vibropipe.march.pieces import march_pieces
from vibropipe.physics.effects import Effects, all_effects
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.flow import DEGREE
from vibropipe.physics.frequency import Ramp
from vibropipe.physics.limits import MAX_PIECE_STEPS, SAMPLES_PER_PERIOD
from vibropipe.physics.load_harmonics import force_values
from vibropipe.physics.parameter_error import as_float
from vibropipe.physics.ramp import steps_on_ramp
from vibropipe.physics.stated import check_untied
from vibropipe.solve.checks import check_whole, sample_times, span_in_turns
from vibropipe.solve.equilibrium import about_equilibrium, displaced, from_equilibrium
from vibropipe.solve.motion.contacts import contacts_of_pieces
from vibropipe.solve.motion.motion_dataset import to_dataset, to_variables
from vibropipe.solve.motion.run import (
    MARCH_LOG_CAPACITY,
    MotionRequest,
    MotionResult,
    end_of,
    march_to_end,
)
from vibropipe.words.progress import Progress, WorkCount
from vibropipe.words.records import POSITIVE
from vibropipe.words.status import Status

if TYPE_CHECKING:
    import xarray as xr

TIMES = {
    "impact_tau", "rest_start", "rest_end", "grazing_tau", "turn_tau", "stick_start", "stick_end",
}  # fmt: skip


def simulate_ramp(
    exciter: Exciter, request: MotionRequest, nu_end: Any, progress: Progress | None
) -> xr.Dataset:
    """Compute the motion of a request, whose effects are not read, while the frequency changes to `nu_end`.

    Raises ParameterError if `nu_end` is out of range, the motion has no length or too many steps or samples, or the
    exciter has an effect that is not computed on a ramp.
    """
    ramp = check_ramp(exciter, request.tau_start, request.tau_end, nu_end)
    values = exciter.parameters()._asdict()
    effects = all_effects(values, pieces=True)
    request = request._replace(x=from_equilibrium(exciter, request.x), effects=effects)
    span = request.tau_end - request.tau_start
    if progress is not None:
        n_periods = int(turns_on_ramp(ramp, span)) - int(ramp.turn)
        request = request._replace(marched=WorkCount(n_periods, progress))
    run = _march(about_equilibrium(exciter), request, ramp)
    end = float(displaced(exciter, run.end[0])), run.end[1]
    run = run._replace(displacement=displaced(exciter, run.displacement), end=end)
    request = request._replace(x=float(displaced(exciter, request.x)))
    variables = to_variables(exciter, request, run)
    if "tau" in variables:
        s = np.append(run.after * exciter.period, span)
        variables["force"] = ("tau", force_of_ramp(exciter, ramp, s))
        variables["frequency"] = ("tau", np.append(ramp.nu + ramp.change * s[:-1], float(nu_end)))
    variables["nu_end"] = ((), float(nu_end))
    return to_dataset(exciter, request, run, variables=variables)


def check_ramp(exciter: Exciter, tau_start: float, tau_end: float, nu_end: Any) -> Ramp:
    """Return the ramp from the frequency of an exciter to `nu_end`, or raise a ParameterError."""
    end = as_float("nu_end", nu_end, POSITIVE.text)
    if not POSITIVE.contains(end):
        raise ParameterError("nu_end", nu_end, POSITIVE.text)
    turn, _end = span_in_turns(exciter, tau_start, tau_end)
    if not tau_end > tau_start:
        raise ParameterError("tau_end", tau_end, must="must be above tau_start with nu_end")
    check_untied(exciter, "nu_end", ["nu"])
    span, stated = tau_end - tau_start, exciter.numbers()
    if stated.mass_ratio != 0.0:
        must = "must be 0 with nu_end: a housing that slides is not computed on a ramp"
        raise ParameterError("mass_ratio", stated.mass_ratio, must=must)
    return Ramp(exciter.nu, (end - exciter.nu) / span, turn, stated.f, stated.shaker, span)


def turns_on_ramp(ramp: Ramp, s: Any) -> Any:
    """Return the phase, in turns, at times s after the start of a ramp."""
    return ramp.turn + s * (ramp.nu + 0.5 * ramp.change * s) / (2 * math.pi)


def march_effects(exciter: Exciter) -> Effects:
    """Return the effects that motions of an exciter on a ramp are marched with: always by pieces."""
    effects = all_effects(exciter.parameters()._asdict(), pieces=True)
    return effects if effects.has_pieces else effects._replace(soft=1)


def highest_parameters(exciter: Exciter, ramp: Ramp) -> Parameters:
    """Return the parameters at the highest frequency of a ramp, with a bound of the first harmonic as f."""
    highest = max(ramp.nu, ramp.nu + ramp.change * ramp.span)
    p = replace(exciter, nu=highest).parameters()
    if ramp.shaker == 0.0:
        return p
    return p._replace(f=abs(ramp.f) + abs(ramp.shaker) * (highest**2 + abs(ramp.change)))


def force_of_ramp(exciter: Exciter, ramp: Ramp, s: np.ndarray) -> np.ndarray:
    """Return the force at times s after the start of a ramp, (n,)."""
    turns, nu = turns_on_ramp(ramp, s), ramp.nu + ramp.change * s
    force = force_values(ramp.f, turns, exciter.f2, exciter.phi2)
    if ramp.shaker == 0.0:
        return force
    angles = 2 * math.pi * turns
    return force + ramp.shaker * (nu**2 * np.sin(angles) - ramp.change * np.cos(angles))


def _march(exciter: Exciter, request: MotionRequest, ramp: Ramp) -> MotionResult:
    """March one motion on a grid with one step per "period": its times count steps since the start."""
    check_whole("samples_per_period", request.samples_per_period, SAMPLES_PER_PERIOD)
    e, p = march_effects(exciter), highest_parameters(exciter, ramp)
    pieces, plain = piece_log_of(e, 2 * MARCH_LOG_CAPACITY)
    per_period = steps_on_ramp(e, p, ramp)
    dt = 2.0 * math.pi / p.nu / per_period
    steps = ramp.span / dt
    if steps > MAX_PIECE_STEPS:
        must = f"must be reached in at most {MAX_PIECE_STEPS:g} steps of the march"
        got = f"{request.tau_end!r} with {steps:.3g} steps"
        raise ParameterError("tau_end", request.tau_end, must=must, got=got)
    grid, end = RampGrid(1, 1, dt, ramp), grid_time(steps, 1)
    state = start_state(pieces, e, p, grid, 0.0, request.x, request.v, 0.0)
    samples, after = _new_samples(request, ramp, p.nu, per_period)
    log, c = new_log(MARCH_LOG_CAPACITY, MARCH_LOG_CAPACITY, pieces, plain), np.empty(DEGREE + 1)
    state, status, columns = march_to_end(
        lambda state, left: march_pieces(e, p, grid, state, end, log, samples, c, left),
        log, state, request, lambda state: turns_on_ramp(ramp, state.period * dt),
    )  # fmt: skip
    contacts = contacts_of_pieces(columns, exciter, dt)
    for name in TIMES & contacts.keys():
        contacts[name] = contacts[name] + request.tau_start
    xs, vs = (np.empty(0),) * 2 if samples is None else (samples.displacement, samples.velocity)
    # The first sample is the requested start: on a support, the state before the impact.
    xs[:1], vs[:1] = request.x, request.v
    turns = ramp.turn, turns_on_ramp(ramp, ramp.span)
    return MotionResult(
        Status(status), contacts, xs, vs, end_of(p, state, status), log.counts.copy(), turns, after
    )


def _new_samples(
    request: MotionRequest, ramp: Ramp, highest: float, per_period: int
) -> tuple[Samples | None, np.ndarray]:
    """Return arrays for samples, and their times in periods of the frequency at the start."""
    if request.samples_per_period == 0:
        return None, np.empty(0)
    turns = 0.0, ramp.span * highest / (2 * math.pi)
    after = sample_times(turns, request.samples_per_period) * (ramp.nu / highest)
    unfilled = np.full(after.size, np.nan), np.full(after.size, np.nan)
    every = per_period, int(request.samples_per_period), 0
    return Samples(*unfilled, *every, 0.0), after
