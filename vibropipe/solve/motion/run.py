"""One motion from start to end: in closed form if there is one, otherwise marched on a grid."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vibropipe.march.grid import Instant, StepGrid, exact_grid, exact_steps, grid_time
from vibropipe.march.log import COUNTS, SHORT_FLIGHTS, Log, Samples, allow_work, new_log
from vibropipe.march.loop import march_repeatedly
from vibropipe.march.piece_log import piece_log_of
from vibropipe.march.piece_state import start_state
from vibropipe.march.state import REST, STUCK, State
from vibropipe.orbits.forces import Integrals
from vibropipe.orbits.harmonics import ONE_PERIOD
from vibropipe.orbits.housing import N_ENERGIES
from vibropipe.orbits.outputs import add_energies
from vibropipe.physics.contact import to_displacement, to_velocity
from vibropipe.physics.effects import (
    ALL_EFFECTS,
    Effects,
    grid_effects,
    kernel_effects,
    shared_effects,
)
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters
from vibropipe.physics.flow import DEGREE
from vibropipe.physics.limits import (
    MAX_MARCH_STEPS,
    MAX_PIECE_STEPS,
    SAMPLES_PER_PERIOD,
    max_march_steps,
)
from vibropipe.solve.checks import check_whole, sample_times, span_in_turns
from vibropipe.solve.equilibrium import about_equilibrium, displaced, from_equilibrium
from vibropipe.solve.motion.closed_motion import closed_form_solver
from vibropipe.solve.motion.contacts import (
    Contacts,
    contacts_of,
    contacts_of_pieces,
    drain_log,
    housing_of,
)
from vibropipe.solve.motion.energy import work_of_flights, work_of_steps
from vibropipe.words.progress import WorkCount
from vibropipe.words.status import Status

# Columns of a log that count as contacts.
EVENTS = ("position", "rest_start", "grazing")
# Contacts in the log of a march, which is emptied when full and at each progress report. Results do not depend on it.
MARCH_LOG_CAPACITY = 1024


class MotionRequest(NamedTuple):
    """A motion from (x, v) at `tau_start` to `tau_end`, and what is recorded of it.

    x_uncertainty, v_uncertainty : error bounds of the start
    marched : counts the forcing periods marched
    Other attributes are those of `simulate`.
    """

    tau_start: float
    tau_end: float
    x: float
    v: float
    samples_per_period: int = 256
    max_impacts: int = 10_000_000
    x_uncertainty: float = 0.0
    v_uncertainty: float = 0.0
    effects: Effects = ALL_EFFECTS
    energy: bool = False
    housing_v0: float = 0.0
    marched: WorkCount | None = None


class MotionResult(NamedTuple):
    """The result of a motion.

    contacts : impacts, rests and grazings by variable
    displacement, velocity : (n,), samples before the end
    end : (x, x') at the end; NaN if the motion was stopped
    counts : of steps and evaluations (`march.log`); zero for a motion in closed form
    turns : start and end, in forcing periods
    after : (n,), times of the samples after the start, in forcing periods
    energy_terms : (4,) or (5,), work of the force, loss by damping, at each support and by friction; NaN if the motion
        was stopped
    housing : (n + 1, 2), velocity and displacement of a housing that may slide, at the samples and, last, at the end
    """

    status: Status
    contacts: Contacts
    displacement: np.ndarray
    velocity: np.ndarray
    end: tuple[float, float]
    counts: np.ndarray
    turns: tuple[float, float]
    after: np.ndarray
    energy_terms: np.ndarray | None = None
    housing: np.ndarray | None = None


def run_motion(
    exciter: Exciter, request: MotionRequest, grid: StepGrid | None = None
) -> MotionResult:
    """Compute one motion.

    grid : of the march; the default is the exact method, in closed form if possible
    Raises ParameterError if the times, or the number of steps or samples, are out of range.
    """
    if exciter.load != 0.0:
        return _run_about_equilibrium(exciter, request, grid)
    if not request.energy or request.effects.has_pieces:
        if request.energy and grid is not None and grid.exact is None:
            must = "must be left out with newmark where there are soft supports or friction"
            raise ParameterError("energy", True, must=must, got="")
        return _run(exciter, request, grid)
    newmark = None if grid is None or grid.exact is not None else grid
    if newmark is None:
        run = steps = _run(exciter, request, grid)
    else:
        steps = _run(exciter, request._replace(samples_per_period=newmark.steps), grid)
        # Sampling changes the rounding, which many impacts amplify. Without samples, contacts are those of this run.
        empty = np.empty(0)
        run = steps._replace(displacement=empty, velocity=empty, after=empty)
        if request.samples_per_period > 0:
            run = _run(exciter, request, grid)
    if not math.isfinite(run.end[0]):
        return run._replace(energy_terms=np.full(4, math.nan))
    if newmark is None:
        start = request.x, request.v
        energy_terms = work_of_flights(exciter, request.effects, start, run.turns, run.contacts)
    else:
        step_turns = np.append(run.turns[0] + steps.after, run.turns[1])
        states = np.append(steps.displacement, run.end[0]), np.append(steps.velocity, run.end[1])
        energy_terms = work_of_steps(exciter, step_turns, *states, run.contacts)
    return run._replace(energy_terms=energy_terms)


def _run_about_equilibrium(
    exciter: Exciter, request: MotionRequest, grid: StepGrid | None
) -> MotionResult:
    """Compute one motion under a constant load."""
    about = request._replace(x=from_equilibrium(exciter, request.x))
    run = run_motion(about_equilibrium(exciter), about, grid)
    xs = displaced(exciter, run.displacement)
    xs[:1] = request.x
    return run._replace(displacement=xs, end=(float(displaced(exciter, run.end[0])), run.end[1]))


def _run(exciter: Exciter, request: MotionRequest, grid: StepGrid | None) -> MotionResult:
    """Compute one motion without its energy terms."""
    turns = span_in_turns(exciter, request.tau_start, request.tau_end)
    check_whole("samples_per_period", request.samples_per_period, SAMPLES_PER_PERIOD)
    solve_closed_form = closed_form_solver(exciter, request) if grid is None else None
    if solve_closed_form is None:
        if grid is None:
            grid = exact_grid(grid_effects(request.effects), exciter.parameters())
        _check_steps(request, turns[1] - turns[0], grid.steps)
        run = _march(exciter, request, grid, turns)
    else:
        if request.energy:
            # Energies are integrated step by step, also of a motion in closed form.
            steps = exact_steps(grid_effects(request.effects), exciter.parameters())
            _check_steps(request, turns[1] - turns[0], steps)
        after = sample_times(turns, request.samples_per_period)
        columns, xs, vs = solve_closed_form(exciter, request, turns, after)
        end, counts = (float(xs[-1]), float(vs[-1])), np.zeros(COUNTS, np.int64)
        run = MotionResult(Status.OK, columns, xs[:-1], vs[:-1], end, counts, turns, after)
    if run.displacement.size > 0:
        # The first sample is the requested start: on a support, the state before the impact.
        run.displacement[0], run.velocity[0] = request.x, request.v
    return run


def _check_steps(request: MotionRequest, periods: float, per_period: int) -> None:
    """Raise a ParameterError if a march has too many steps, whatever happens in it."""
    steps = periods * per_period
    has_polynomials = request.effects.has_pieces or request.energy
    most = MAX_PIECE_STEPS if has_polynomials else max_march_steps(per_period)
    if steps > most:
        must = f"must be reached in at most {most:g} steps of the march"
        got = f"{request.tau_end!r} with {steps:.3g} steps"
        raise ParameterError("tau_end", request.tau_end, must=must, got=got)


def march_to_end(
    march: Callable[[State, int], tuple[State, int]],
    log: Log,
    state: State,
    request: MotionRequest,
    period_of: Callable[[State], float],
) -> tuple[State, int, dict[str, np.ndarray]]:
    """March a motion; the log is emptied, and progress reported, whenever it is full.

    march : from a state, with the contacts that are left, until the end or a full log: returns (state, status)
    period_of : the time of a state in forcing periods
    Returns (state, status, columns that `drain_log` returned, of the whole motion).
    """
    allow_work(log, MAX_MARCH_STEPS)
    held_since = state.rest_start if state.mode == STUCK else None
    parts: list[dict[str, np.ndarray]] = []
    events, reported_period = 0, int(period_of(state))
    while True:
        state, status = march(state, request.max_impacts - events)
        parts.append(drain_log(log))
        events += sum(len(parts[-1][name]) for name in EVENTS)
        if request.marched is not None:
            request.marched.add(int(period_of(state)) - reported_period)
            reported_period = int(period_of(state))
        if events > request.max_impacts:
            status = Status.MAX_IMPACTS
        if status != Status.LOG_FULL:
            break
    if state.mode == REST:
        rest = {"rest_start": state.rest_start, "rest_end": math.inf, "rest_support": state.home}
        parts.append({name: np.array([value]) for name, value in rest.items()})
    columns = {name: np.concatenate([q[name] for q in parts if name in q]) for name in parts[0]}
    if held_since is not None:
        columns["stick"] = np.append(held_since, columns["stick"])
    return state, status, columns


def end_of(p: Parameters, state: State, status: int) -> tuple[float, float]:
    """Return (x, x') at the end of a march; NaN if it was stopped."""
    if status not in (Status.OK, Status.SHORT_FLIGHTS):
        return math.nan, math.nan
    return to_displacement(p, state.home, state.y), to_velocity(state.home, state.w)


def _march(
    exciter: Exciter, request: MotionRequest, grid: StepGrid, turns: tuple[float, float]
) -> MotionResult:
    """March one motion."""
    e, p = kernel_effects(request.effects), exciter.parameters()
    degree = 2 if grid.exact is None else DEGREE
    pieces, plain = piece_log_of(e, 2 * MARCH_LOG_CAPACITY, degree)
    start = request.x, request.v, request.housing_v0
    state = start_state(pieces, shared_effects(e), p, grid, turns[0], *start)
    after, samples = np.empty(0), None
    if request.samples_per_period > 0:
        after = sample_times(turns, request.samples_per_period)
        unfilled = np.full(after.size, np.nan), np.full(after.size, np.nan)
        housing = None if e.housing is None else np.full((after.size, 2), np.nan)
        every = 1, int(request.samples_per_period), state.period * grid.steps + state.step
        samples = Samples(*unfilled, *every, state.theta, housing)
    log = new_log(MARCH_LOG_CAPACITY, MARCH_LOG_CAPACITY, pieces, plain)
    c = np.empty(degree + 1)
    end: Instant = grid_time(turns[1], grid.steps)
    n_terms = 5 if e.housing is None else N_ENERGIES - 1
    terms = None if pieces is None or not request.energy else np.zeros(n_terms)

    def march(state: State, left: int) -> tuple[State, int]:
        state, status = march_repeatedly(e, p, grid, state, end, log, samples, c, left, 1)
        if terms is not None:
            sums = Integrals(terms, np.zeros(0), np.zeros(0, complex), ONE_PERIOD)
            add_energies(e, p, log, sums)
        return state, status

    state, status, columns = march_to_end(march, log, state, request, lambda state: state.period)
    if grid.exact is None and status == Status.OK and log.counts[SHORT_FLIGHTS] > 0:
        status = Status.SHORT_FLIGHTS
    end_state = end_of(p, state, status)
    if terms is not None and math.isnan(end_state[0]):
        terms[:] = math.nan
    return MotionResult(
        Status(status),
        contacts_of(columns, exciter.period)
        if pieces is None
        else contacts_of_pieces(columns, exciter, exciter.period),
        np.empty(0) if samples is None else samples.displacement,
        np.empty(0) if samples is None else samples.velocity,
        end_state,
        log.counts.copy(),
        turns,
        after,
        terms,
        housing_of(p, state, end_state[1], samples, request.housing_v0),
    )
