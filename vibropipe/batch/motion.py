"""One motion as a labelled dataset: the face `simulate`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibropipe.batch import linear
from vibropipe.batch.free import contacts, positions
from vibropipe.kernels.grid import Grid, exact_grid, locate, newmark_grid
from vibropipe.kernels.march import march
from vibropipe.kernels.record import (
    COUNTS,
    GRAZINGS,
    IMPACTS,
    RESTS,
    SHORT_FLIGHTS,
    Log,
    Samples,
    new_log,
)
from vibropipe.kernels.state import REST, State, begin
from vibropipe.physics.conservative import arc, is_free
from vibropipe.physics.contact import to_displacement, to_velocity
from vibropipe.physics.effects import ALL_EFFECTS, Effects, asked_effects, names_of
from vibropipe.physics.exciter import Exciter, ParameterError, Parameters, number
from vibropipe.physics.flow import ORDER
from vibropipe.physics.linear import keeps_off
from vibropipe.status import Status
from vibropipe.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

METHODS = ("exact", "newmark")
LOG_ROOM = 1024
MAX_SAMPLES = 200_000_000


def simulate(
    exciter: Exciter,
    tau_end: float = 60.0,
    x0: float = 0.0,
    v0: float = 0.0,
    method: str = "exact",
    steps_per_period: int | None = None,
    accuracy: float | None = None,
    samples_per_period: int = 256,
    *,
    tau_start: float = 0.0,
    max_impacts: int = 10_000_000,
    effects: Sequence[str] | None = None,
) -> xr.Dataset:
    """The motion of eqs. (5), (6) from (x0, v0) at tau_start to tau_end.

    method: "exact" (first impacts certified, errors of rounding only) or "newmark" (constant average
    acceleration with `steps_per_period` steps, impacts located inside the step).
    accuracy: error allowed, in place of method and steps_per_period, which are then chosen (`choose` in
    `vibropipe.batch.choice`); `<name>_error` stands beside every quantity, and attributes say what was reached.
    samples_per_period: samples of the motion per forcing period 2 pi / nu; 0 records none.
    effects: any of damping, forcing, support_1, support_2, restitution, rest; the motion is marched by a
    kernel without the others, compiled when it is first called for. All of them if left out.

    Returns a dataset (all non-dimensional): `displacement, velocity, force` over `tau` (from tau_start, the
    last sample exactly tau_end); `impact_tau, impact_support, impact_velocity` (before, signed),
    `impact_velocity_after` over `impact`; `rest_start, rest_end` (inf if not released before tau_end),
    `rest_support` over `rest`; `grazing_tau, grazing_support` over `grazing`; `displacement_end, velocity_end`
    (after an impact at tau_end itself); `status`: `short_flights` when Newmark flights were shorter than a
    step, `support_reached` when it reaches a support that `effects` leaves out, `max_impacts` when more
    contacts happen than allowed (then the motion is nan from there on).
    Raises ParameterError for a value outside what is allowed, or an effect left out that the parameters have.
    """
    x, v = exciter.check_start(x0, v0)
    turns_of(exciter, tau_start, tau_end)
    with_effects = asked_effects(
        effects,
        exciter.parameters()._asdict(),
        x,
        v,
        tau_end - tau_start,
        exact=method == "exact" and accuracy is None,
    )
    task = Task(tau_start, tau_end, x, v, samples_per_period, max_impacts, effects=with_effects)
    if accuracy is not None:
        from vibropipe.batch.accuracy import simulate_to_accuracy

        if method != "exact" or steps_per_period is not None:
            raise ParameterError(
                f"accuracy = {accuracy!r}: allowed without method and steps_per_period, which it chooses"
            )
        return simulate_to_accuracy(exciter, task, accuracy)
    exact = method == "exact" and steps_per_period is None
    grid = None if exact else _grid(exciter, with_effects, method, steps_per_period)
    return to_dataset(exciter, task, run_motion(exciter, task, grid))


class Task(NamedTuple):
    """What is wanted of a motion: from (x, v) at tau_start to tau_end, and how it is recorded.

    x_doubt, v_doubt: how far the start itself may be wrong.
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


class Run(NamedTuple):
    """What a motion left: Status, contacts by name of variable, samples before the end, (x, v) at the end,
    counts of work (`kernels.record`; none for a motion in closed form)."""

    status: Status
    contacts: dict[str, np.ndarray]
    displacement: np.ndarray
    velocity: np.ndarray
    end: tuple[float, float]
    counts: np.ndarray


def run_motion(exciter: Exciter, task: Task, grid: Grid | None = None) -> Run:
    """One motion, marched on a grid; without one by the exact method. ParameterError for bad times."""
    turns = turns_of(exciter, task.tau_start, task.tau_end)
    _check_samples(task.samples_per_period)
    p, e = exciter.parameters(), task.effects
    closed = has_closed_form(exciter, task) if grid is None else None
    if closed is not None:
        return closed(exciter, task, _sample_times(turns, task.samples_per_period))
    if grid is None:
        grid = exact_grid(e, p)
    samples = _samples(grid, turns, task.samples_per_period)
    state = begin(e, p, grid, turns[0], task.x, task.v)
    return _march(e, p, grid, state, turns[1], samples, task.max_impacts)


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
    # The start as it was given, on a support before the impact.
    xs[0], vs[0] = (x, v) if times[0] == 0.0 and times.size > 1 else (xs[0], vs[0])
    struck = contacts(a, span, x, v, exciter.upper, exciter.lower)
    for name in ("impact_tau", "grazing_tau"):
        struck[name] += task.tau_start
    end, worked = (float(xs[-1]), float(vs[-1])), np.zeros(COUNTS, np.int64)
    return Run(Status.OK, struck, xs[:-1], vs[:-1], end, worked)


def turns_of(exciter: Exciter, tau_start: float, tau_end: float) -> tuple[float, float]:
    """Start and end in forcing periods, or a ParameterError."""
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


def _grid(exciter: Exciter, effects: Effects, method: str, steps_per_period: int | None) -> Grid:
    if method not in METHODS:
        raise ParameterError(f"method = {method!r}: allowed is one of {', '.join(METHODS)}")
    if method == "exact":
        if steps_per_period is not None:
            raise ParameterError(
                f"steps_per_period = {steps_per_period!r}: allowed with method 'newmark' only; "
                "the exact method has no step to choose"
            )
        return exact_grid(effects, exciter.parameters())
    return newmark_grid(effects, exciter.parameters(), check_steps(steps_per_period))


def check_steps(steps_per_period: Any) -> int:
    """A number of Newmark steps per forcing period, or a ParameterError."""
    whole = isinstance(steps_per_period, (int, np.integer)) and not isinstance(
        steps_per_period, bool
    )
    if not whole or not 1 <= steps_per_period <= 10**8:
        raise ParameterError(
            f"steps_per_period = {steps_per_period!r}: allowed is a whole number from 1 to 10**8 "
            "(method 'newmark' needs it)"
        )
    return int(steps_per_period)


def _check_samples(per_period: Any) -> None:
    whole = isinstance(per_period, (int, np.integer)) and not isinstance(per_period, bool)
    if not whole or per_period < 0:
        raise ParameterError(f"samples_per_period = {per_period!r}: allowed is a whole number >= 0")


def _sample_times(turns: tuple[float, float], per_period: int) -> np.ndarray:
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
    count = _sample_times(turns, per_period).size
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
) -> Run:
    """March to the end, emptying the log whenever it is full."""
    log = new_log(LOG_ROOM, LOG_ROOM)
    work = np.empty(3 if grid.exact is None else ORDER + 1)
    end = locate(turns_end, grid.steps)
    pieces: list[dict[str, np.ndarray]] = []
    events = 0
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
        events += len(pieces[-1]["position"]) + len(pieces[-1]["rest_start"])
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


def to_dataset(exciter: Exciter, task: Task, run: Run) -> xr.Dataset:
    """What a motion left as the dataset that `simulate` describes."""
    import xarray as xr

    variables = to_variables(exciter, task, run)
    coords: dict[str, Any] = {
        name: ((), value) for name, value in exciter.parameters()._asdict().items()
    }
    if "tau" in variables:
        coords["tau"] = variables.pop("tau")
    attrs = {"effects": ", ".join(names_of(task.effects))}
    return describe(xr.Dataset(variables, coords, attrs))


def to_variables(exciter: Exciter, task: Task, run: Run) -> dict[str, Any]:
    """What a motion left by name: (dimensions, values)."""
    variables: dict[str, Any] = {
        name: (name.split("_")[0], values) for name, values in run.contacts.items()
    }
    variables["displacement_end"] = ((), run.end[0])
    variables["velocity_end"] = ((), run.end[1])
    variables["status"] = ((), np.int8(run.status))
    if task.samples_per_period > 0:
        turns = turns_of(exciter, task.tau_start, task.tau_end)
        offsets = _sample_times(turns, task.samples_per_period)
        tau = np.append(task.tau_start + offsets * exciter.period, task.tau_end)
        phase = np.append((turns[0] % 1.0 + offsets) % 1.0, turns[1] % 1.0)
        variables["tau"] = ("tau", tau)
        variables["displacement"] = ("tau", np.append(run.displacement, run.end[0]))
        variables["velocity"] = ("tau", np.append(run.velocity, run.end[1]))
        variables["force"] = ("tau", exciter.f * np.sin(2 * math.pi * phase))
    return variables
