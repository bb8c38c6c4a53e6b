"""The motion on a ramp: the frequency of the force changes linearly from the start to the end."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.march.grid import grid_time
from vibropipe.march.log import Samples, allow_work, new_log
from vibropipe.march.ramp import grid_on_ramp, march_on_ramp, steps_on_ramp
from vibropipe.march.state import REST, initial_state
from vibropipe.physics.contact import to_displacement, to_velocity
from vibropipe.physics.effects import all_effects
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.flow import DEGREE
from vibropipe.physics.limits import MAX_MARCH_STEPS, MAX_PIECE_STEPS, SAMPLES_PER_PERIOD
from vibropipe.physics.load_harmonics import force_values
from vibropipe.physics.parameter_error import as_float
from vibropipe.physics.ramp import Ramp
from vibropipe.physics.stated import check_untied
from vibropipe.solve.checks import check_whole, sample_times, span_in_turns
from vibropipe.solve.equilibrium import about_equilibrium, displaced, from_equilibrium
from vibropipe.solve.motion.contacts import contacts_of, drain_log
from vibropipe.solve.motion.motion_dataset import to_dataset, to_variables
from vibropipe.solve.motion.run import EVENTS, MARCH_LOG_CAPACITY, MotionRequest, MotionResult
from vibropipe.words.progress import Progress, WorkCount
from vibropipe.words.records import POSITIVE
from vibropipe.words.status import Status

if TYPE_CHECKING:
    import xarray as xr

TIMES = ("impact_tau", "rest_start", "rest_end", "grazing_tau")


def simulate_ramp(
    exciter: Exciter, request: MotionRequest, nu_end: Any, progress: Progress | None
) -> xr.Dataset:
    """Compute the motion of a request, whose effects are not read, while the frequency changes to `nu_end`.

    Raises
    ------
    ParameterError
        If `nu_end` is out of range, the motion has no length or too many steps or samples, or the exciter has an effect
        that is not computed on a ramp.
    """
    ramp = check_ramp(exciter, request.tau_start, request.tau_end, nu_end)
    effects = all_effects(exciter.parameters()._asdict())
    request = request._replace(x=from_equilibrium(exciter, request.x), effects=effects)
    span = request.tau_end - request.tau_start
    if progress is not None:
        n_periods = int(turns_on_ramp(ramp, span)) - int(ramp.turn)
        request = request._replace(marched=WorkCount(n_periods, progress))
    run = _march(about_equilibrium(exciter), request, ramp, span)
    end = float(displaced(exciter, run.end[0])), run.end[1]
    run = run._replace(displacement=displaced(exciter, run.displacement), end=end)
    request = request._replace(x=float(displaced(exciter, request.x)))
    variables = to_variables(exciter, request, run)
    if "tau" in variables:
        s = np.append(run.after * exciter.period, span)
        force = force_values(exciter.f, turns_on_ramp(ramp, s), exciter.f2, exciter.phi2)
        variables["force"] = ("tau", force)
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
    shaker = exciter.numbers().shaker
    if shaker != 0.0:
        must = (
            "must be 0 with nu_end: a force that grows with the frequency is not computed on a ramp"
        )
        raise ParameterError("shaker", shaker, must=must)
    return Ramp(exciter.nu, (end - exciter.nu) / (tau_end - tau_start), turn)


def turns_on_ramp(ramp: Ramp, s: Any) -> Any:
    """Return the phase, in turns, at times s after the start of a ramp."""
    return ramp.turn + s * (ramp.nu + 0.5 * ramp.change * s) / (2 * math.pi)


def _march(exciter: Exciter, request: MotionRequest, ramp: Ramp, span: float) -> MotionResult:
    """March to the end; the log is emptied, and progress reported, whenever it is full."""
    check_whole("samples_per_period", request.samples_per_period, SAMPLES_PER_PERIOD)
    highest = max(ramp.nu, ramp.nu + ramp.change * span)
    e, p = request.effects, replace(exciter, nu=highest).parameters()
    per_period = steps_on_ramp(e, p, ramp)
    grid = grid_on_ramp(e, p, ramp, per_period)
    steps = span / grid.dt
    if steps > MAX_PIECE_STEPS:
        must = f"must be reached in at most {MAX_PIECE_STEPS:g} steps of the march"
        got = f"{request.tau_end!r} with {steps:.3g} steps"
        raise ParameterError("tau_end", request.tau_end, must=must, got=got)
    state = initial_state(e, p, grid, ramp.turn % 1.0, request.x, request.v, None)
    state = state._replace(period=0, theta=0.0, rest_start=0.0)
    samples, after = None, np.empty(0)
    if request.samples_per_period > 0:
        turns = 0.0, span * highest / (2 * math.pi)
        after = sample_times(turns, request.samples_per_period) * (exciter.nu / highest)
        unfilled = np.full(after.size, np.nan), np.full(after.size, np.nan)
        samples = Samples(*unfilled, per_period, int(request.samples_per_period), 0, 0.0)
    log = new_log(MARCH_LOG_CAPACITY, MARCH_LOG_CAPACITY)
    allow_work(log, MAX_MARCH_STEPS)
    c, end = np.empty(DEGREE + 1), grid_time(steps, 1)
    parts: list[dict[str, np.ndarray]] = []
    events, marched = 0, int(ramp.turn)
    while True:
        left = request.max_impacts - events
        state, status = march_on_ramp(e, p, ramp, grid, state, end, log, samples, c, left)
        parts.append(drain_log(log))
        events += sum(len(parts[-1][name]) for name in EVENTS)
        if request.marched is not None:
            now = int(turns_on_ramp(ramp, state.period * grid.dt))
            request.marched.add(now - marched)
            marched = now
        if events > request.max_impacts:
            status = Status.MAX_IMPACTS
        if status != Status.LOG_FULL:
            break
    if state.mode == REST:
        rest = {"rest_start": state.rest_start, "rest_end": math.inf, "rest_support": state.home}
        parts.append({name: np.array([value]) for name, value in rest.items()})
    columns = {name: np.concatenate([q[name] for q in parts if name in q]) for name in parts[0]}
    contacts = contacts_of(columns, grid.dt)
    for name in TIMES:
        contacts[name] = contacts[name] + request.tau_start
    end_state = math.nan, math.nan
    if status == Status.OK:
        end_state = to_displacement(p, state.home, state.y), to_velocity(state.home, state.w)
    xs, vs = (np.empty(0),) * 2 if samples is None else (samples.displacement, samples.velocity)
    # The first sample is the requested start: on a support, the state before the impact.
    xs[:1], vs[:1] = request.x, request.v
    turns = ramp.turn, turns_on_ramp(ramp, span)
    return MotionResult(
        Status(status), contacts, xs, vs, end_state, log.counts.copy(), turns, after
    )
