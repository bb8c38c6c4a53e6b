"""One motion from its start to its end: in closed form where there is one, else marched on a grid."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from vibropipe.march.grid import Grid, exact_grid, locate
from vibropipe.march.log import (
    COUNTS,
    GRAZINGS,
    IMPACTS,
    RESTS,
    SHORT_FLIGHTS,
    Log,
    Samples,
    new_log,
)
from vibropipe.march.loop import march
from vibropipe.march.state import REST, State, begin
from vibropipe.physics.conservative import arc, is_free
from vibropipe.physics.contact import to_displacement, to_velocity
from vibropipe.physics.effects import ALL_EFFECTS, Effects
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters, number
from vibropipe.physics.flow import ORDER
from vibropipe.physics.limits import MAX_MARCH_STEPS, MAX_SAMPLES, SAMPLES_PER_PERIOD, within_text
from vibropipe.physics.linear import keeps_off
from vibropipe.solve import linear_motion as linear
from vibropipe.solve.conservative_motion import contacts, positions
from vibropipe.solve.energy import work_of_flights, work_of_steps
from vibropipe.words.status import Status

# Contacts that a march keeps until its log is emptied, between two words of progress: any number does.
MARCH_LOG_CAPACITY = 1024


class Task(NamedTuple):
    """What is wanted of a motion: from (x, v) at tau_start to tau_end, and how it is recorded.

    x_doubt, v_doubt: how far the start itself may be wrong; energy: whether its balance is drawn up; progress:
    is told, now and then, how many more forcing periods have been marched.
    """

    tau_start: float
    tau_end: float
    x: float
    v: float
    samples_per_period: int = 256
    max_impacts: int = 10_000_000
    x_doubt: float = 0.0
    v_doubt: float = 0.0
    effects: Effects = ALL_EFFECTS
    energy: bool = False
    progress: Callable[[int], None] | None = None


class Run(NamedTuple):
    """What a motion left: Status, contacts by name of variable, samples before the end, (x, v) at the end,
    counts of work (`march.log`; none for a motion in closed form), and work of the force, loss by damping
    and at each support (4,), nan of a motion that broke off, where they are asked for."""

    status: Status
    contacts: dict[str, np.ndarray]
    displacement: np.ndarray
    velocity: np.ndarray
    end: tuple[float, float]
    counts: np.ndarray
    work: np.ndarray | None = None


def run_motion(exciter: Exciter, task: Task, grid: Grid | None = None) -> Run:
    """One motion, marched on a grid; without one by the exact method. ParameterError for bad times."""
    if not task.energy:
        return _run(exciter, task, grid)
    turns = turns_of(exciter, task.tau_start, task.tau_end)
    if grid is not None and grid.exact is None:
        return _run_newmark_with_work(exciter, task, grid, turns)
    run = _run(exciter, task, grid)
    if not math.isfinite(run.end[0]):
        return run._replace(work=np.full(4, math.nan))
    start = task.x, task.v
    return run._replace(work=work_of_flights(exciter, task.effects, start, turns, run.contacts))


def _run_newmark_with_work(
    exciter: Exciter, task: Task, grid: Grid, turns: tuple[float, float]
) -> Run:
    """A motion by Newmark's method, with its works from the state at every step."""
    steps = _run(exciter, task._replace(samples_per_period=grid.steps), grid)
    if task.samples_per_period > 0:
        run = _run(exciter, task, grid)
    else:
        # Recorded or not a motion rounds differently, and one with many impacts shows it: so it is the one recorded.
        run = steps._replace(displacement=np.empty(0), velocity=np.empty(0))
    if not math.isfinite(run.end[0]):
        return run._replace(work=np.full(4, math.nan))
    at = np.append(turns[0] + sample_times(turns, grid.steps), turns[1])
    states = (np.append(steps.displacement, run.end[0]), np.append(steps.velocity, run.end[1]))
    return run._replace(work=work_of_steps(exciter, at, *states, run.contacts))


def _run(exciter: Exciter, task: Task, grid: Grid | None) -> Run:
    turns = turns_of(exciter, task.tau_start, task.tau_end)
    _check_samples(task.samples_per_period)
    p, e = exciter.parameters(), task.effects
    closed = has_closed_form(exciter, task) if grid is None else None
    if closed is not None:
        run = closed(exciter, task, sample_times(turns, task.samples_per_period))
    else:
        grid = exact_grid(e, p) if grid is None else grid
        _check_steps(task, (turns[1] - turns[0]) * grid.steps)
        samples = _samples(grid, turns, task.samples_per_period)
        state = begin(e, p, grid, turns[0], task.x, task.v)
        run = _march(e, p, grid, state, turns[1], samples, task.max_impacts, task.progress)
    if run.displacement.size > 0:
        # The start as it was given, on a support before the impact.
        run.displacement[0], run.velocity[0] = task.x, task.v
    return run


def has_closed_form(exciter: Exciter, task: Task) -> Callable[..., Run] | None:
    """What solves a motion without a march: one that is conservative, or one that strikes nothing."""
    p = exciter.parameters()
    if task.effects.watched is None and is_free(p, task.x, task.v):
        return _free
    turn = task.tau_start * exciter.nu / (2 * math.pi) % 1.0
    return _linear if keeps_off(p, task.x, task.v, turn) else None


def _linear(exciter: Exciter, task: Task, turns: np.ndarray) -> Run:
    """A motion that strikes nothing, in closed form; turns as for `_free`."""
    start, end = turns_of(exciter, task.tau_start, task.tau_end)
    after = np.append(turns, end - start)
    xs, vs = linear.positions(exciter.parameters(), task.x, task.v, start % 1.0, after)
    if after[0] == 0.0:
        xs[0], vs[0] = task.x, task.v
    none, worked = _contacts(_take(new_log(1, 1)), 1.0), np.zeros(COUNTS, np.int64)
    return Run(Status.OK, none, xs[:-1], vs[:-1], (float(xs[-1]), float(vs[-1])), worked)


def _free(exciter: Exciter, task: Task, turns: np.ndarray) -> Run:
    """A conservative motion, in closed form; turns: times of samples after the start, in forcing periods."""
    x, v, span = task.x, task.v, task.tau_end - task.tau_start
    a = arc(exciter.parameters(), x, v)
    times = np.append(turns * exciter.period, span)
    xs, vs = positions(a, times)
    xs = np.clip(xs, exciter.lower, exciter.upper)
    struck = contacts(a, span, x, v, exciter.upper, exciter.lower)
    for name in ("impact_tau", "grazing_tau"):
        struck[name] += task.tau_start
    end, worked = (float(xs[-1]), float(vs[-1])), np.zeros(COUNTS, np.int64)
    return Run(Status.OK, struck, xs[:-1], vs[:-1], end, worked)


def turns_of(exciter: Exciter, tau_start: float, tau_end: float) -> tuple[float, float]:
    """Beginning and end in forcing periods; ParameterError for times that cannot be."""
    start = number("tau_start", tau_start, "a finite number >= 0")
    end = number("tau_end", tau_end, "a finite number >= tau_start")
    if not (math.isfinite(start) and start >= 0):
        raise ParameterError(f"tau_start = {start!r}: allowed is a finite number >= 0")
    if not (math.isfinite(end) and end >= start):
        raise ParameterError(f"tau_end = {end!r}: allowed is a finite number >= {start!r}")
    turns = (start * exciter.nu / (2 * math.pi), end * exciter.nu / (2 * math.pi))
    if turns[1] > 2**52:
        raise ParameterError(f"tau_end = {end!r}: allowed are at most 2**52 forcing periods")
    return turns


def _check_steps(task: Task, steps: float) -> None:
    if steps > MAX_MARCH_STEPS:
        raise ParameterError(
            f"tau_end = {task.tau_end!r}: {steps:.3g} steps of the march; allowed are {MAX_MARCH_STEPS:g}"
        )


def _check_samples(per_period: Any) -> None:
    whole = isinstance(per_period, (int, np.integer)) and not isinstance(per_period, bool)
    least, most = SAMPLES_PER_PERIOD
    if not whole or not least <= per_period <= most:
        allowed = within_text(SAMPLES_PER_PERIOD)
        raise ParameterError(f"samples_per_period = {per_period!r}: allowed is {allowed}")


def sample_times(turns: tuple[float, float], per_period: int) -> np.ndarray:
    """Times of the samples before the end, in forcing periods after the start."""
    span = (turns[1] - turns[0]) * per_period
    # A regular sample within rounding of tau_end would stand beside the one at tau_end itself.
    count = max(1, math.ceil(span - 1e-6)) if span > 0 else 0
    if count > MAX_SAMPLES:
        raise ParameterError(
            f"samples_per_period = {per_period!r}: {count} samples up to tau_end; allowed are {MAX_SAMPLES}"
        )
    return np.arange(count) / max(per_period, 1)


def _samples(grid: Grid, turns: tuple[float, float], per_period: int) -> Samples | None:
    if per_period == 0:
        return None
    count = sample_times(turns, per_period).size
    period, step, theta = locate(turns[0], grid.steps)
    empty = np.full(count, np.nan), np.full(count, np.nan)
    return Samples(*empty, 1, int(per_period), period * grid.steps + step, theta)


def _march(
    e: Effects,
    p: Parameters,
    grid: Grid,
    state: State,
    turns_end: float,
    samples: Samples | None,
    max_impacts: int,
    progress: Callable[[int], None] | None,
) -> Run:
    """March to the end, emptying the log, and telling of it, whenever it is full."""
    log = new_log(MARCH_LOG_CAPACITY, MARCH_LOG_CAPACITY)
    work = np.empty(3 if grid.exact is None else ORDER + 1)
    end = locate(turns_end, grid.steps)
    pieces: list[dict[str, np.ndarray]] = []
    events, told = 0, int(state.period)
    while True:
        state, status = march(
            e,
            p,
            grid,
            state,
            end[0],
            end[1],
            end[2],
            log,
            samples,
            work,
            max_impacts - events,
        )
        pieces.append(_take(log))
        events += sum(len(pieces[-1][name]) for name in ("position", "rest_start", "grazing"))
        if progress is not None:
            progress(int(state.period) - told)
            told = int(state.period)
        if events > max_impacts:
            status = Status.MAX_IMPACTS
        if status != Status.LOG_FULL:
            break
    if grid.exact is None and status == Status.OK and log.counts[SHORT_FLIGHTS] > 0:
        status = Status.SHORT_FLIGHTS
    if state.order == REST:
        ended = {"rest_start": state.rest_start, "rest_end": math.inf, "rest_support": state.home}
        pieces.append({name: np.array([value]) for name, value in ended.items()})
    columns = {name: np.concatenate([q[name] for q in pieces if name in q]) for name in pieces[0]}
    place = (to_displacement(p, state.home, state.y), to_velocity(state.home, state.w))
    finished = status in (Status.OK, Status.SHORT_FLIGHTS)
    none = np.empty(0)
    return Run(
        Status(status),
        _contacts(columns, 2 * math.pi / p.nu),
        none if samples is None else samples.displacement,
        none if samples is None else samples.velocity,
        place if finished else (math.nan, math.nan),
        log.counts.copy(),
    )


def _contacts(columns: dict[str, np.ndarray], period: float) -> dict[str, np.ndarray]:
    """Columns of a log by the names of a dataset, in tau."""
    struck = columns["support"] > 0
    before = columns["velocity"][struck]
    return {
        "impact_tau": columns["position"][struck] * period,
        "impact_support": columns["support"][struck],
        "impact_velocity": before,
        "impact_velocity_after": before + columns["impulse"][struck],
        "rest_start": columns["rest_start"] * period,
        "rest_end": columns["rest_end"] * period,
        "rest_support": columns["rest_support"].astype(np.int8),
        "grazing_tau": columns["grazing"] * period,
        "grazing_support": columns["grazing_support"],
    }


def _take(log: Log) -> dict[str, np.ndarray]:
    """Copy the entries of a log and empty it."""
    n, rests, grazings = (int(log.counts[k]) for k in (IMPACTS, RESTS, GRAZINGS))
    taken = {
        name: getattr(log, name)[:n].copy()
        for name in ("position", "velocity", "impulse", "support")
    }
    taken |= {
        name: getattr(log, name)[:rests].copy()
        for name in ("rest_start", "rest_end", "rest_support")
    }
    taken |= {name: getattr(log, name)[:grazings].copy() for name in ("grazing", "grazing_support")}
    log.counts[[IMPACTS, RESTS, GRAZINGS]] = 0
    return taken
