"""What each effect and each output costs: every motion by the kernel of its own effects and by that of all.

Times are those of a core, compilation and tables left out, all in turn in each round (`timing`). Ratios are
taken round by round, so that both sides of each stand next to each other in time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibropipe.compiler import jit_allocating
from vibropipe.lab.timing import Timer, quartiles, take_turns
from vibropipe.lab.work_precision import motion_coordinates
from vibropipe.lab.work_precision_methods import MOST_CONTACTS, March, Motion
from vibropipe.march.grid import exact_grid
from vibropipe.march.log import IMPACTS, RESTS, Log, new_log
from vibropipe.orbits.outputs import Rows
from vibropipe.orbits.row import march_row, row_parameters, sample_row
from vibropipe.physics.effects import ALL_EFFECTS, Effects, effects_of, names_of
from vibropipe.physics.flow import ORDER
from vibropipe.solve.rows import (
    ORBIT_LOG_CAPACITY,
    ORBIT_REST_CAPACITY,
    ROWS_PER_CALL,
    drive,
    new_room,
    new_rows,
)
from vibropipe.solve.run import Task, has_closed_form, run_motion
from vibropipe.solve.sweep import MAX_PERIODS
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

# What stands beside each other: the kernel of the motion's own effects (a closed form where there is one); on the
# same motion, the kernel of all effects; the same work by that kernel on the motion that has all effects.
KERNELS = ("own", "all", "full")
HARMONICS = 3
SAMPLES = 256
NOT_PASSED, PASSED, NOT_ASKED = 0, 1, 2


class Trial(NamedTuple):
    """What is timed: a motion marched over its periods, or, with `row`, the steady state that settles from
    its start; outputs: of a motion any of motion, impacts, of a row any of harmonics, impacts, stability, energy.

    against: the trial whose time is the 1 of its target, "" for the kernel of all effects on the same motion;
    at_most: the target, nan for none.
    """

    motion: Motion
    row: bool = False
    outputs: tuple[str, ...] = ("impacts",)
    against: str = ""
    at_most: float = math.nan


class Work(NamedTuple):
    """What a timer repeats: so many units (rows, or forcing periods of a motion) of so many forcing periods
    each, with so many impacts and rests in a forcing period."""

    repeat: Callable[[int], object]
    units: int
    periods: int
    impacts: float
    rests: float


@jit_allocating
def march_rows_often(
    e: Effects, row: np.ndarray, x: float, v: float, log: Log, c: np.ndarray, out: Rows, often: int
) -> None:
    """Solve a row (1, 7) so many times, marched whatever it is."""
    p = row_parameters(row, 0)
    for _ in range(often):
        out.impacts[0, :] = 0.0
        out.rests[0, :] = 0.0
        march_row(e, p, x, v, MAX_PERIODS, MAX_PERIODS, log, c, out, 0)


@jit_allocating
def sample_often(
    e: Effects,
    row: np.ndarray,
    x: float,
    v: float,
    periods: int,
    log: Log,
    c: np.ndarray,
    samples: np.ndarray,
    often: int,
) -> None:
    """March the motion of a row (1, 7) so many times with samples, from tau = 0."""
    p = row_parameters(row, 0)
    for _ in range(often):
        sample_row(e, p, x, v, periods, log, c, samples, 0)


def own_effects(motion: Motion, row: bool) -> Effects:
    """The effects that a motion calls for, as a scene of it would derive them."""
    span = math.inf if row else motion.tau_end
    return effects_of(motion.exciter.parameters()._asdict(), motion.x0, motion.v0, span)


def row_calls(
    trial: Trial, motion: Motion, effects: Effects
) -> tuple[Callable[[int], None], Callable[[int], None], Rows]:
    """What solves the row of a motion so many times, marched whatever it is and as a sweep solves it, and where
    its results go."""
    row = np.tile(motion.exciter.parameters(), (ROWS_PER_CALL, 1))
    starts = np.tile((motion.x0, motion.v0), (ROWS_PER_CALL, 1))
    out = new_rows(ROWS_PER_CALL, HARMONICS, trial.outputs, new_room(ROWS_PER_CALL))
    work = new_log(ORBIT_LOG_CAPACITY, ORBIT_REST_CAPACITY), np.empty(ORDER + 1), out

    def march(often: int) -> None:
        march_rows_often(ALL_EFFECTS, row, motion.x0, motion.v0, *work, often)

    def solve(often: int) -> None:
        for first in range(0, often, ROWS_PER_CALL):
            part = slice(min(often - first, ROWS_PER_CALL))
            out.impacts[part] = 0.0
            out.rests[part] = 0.0
            drive(effects, row[part], starts[part], 1, MAX_PERIODS, MAX_PERIODS, out)

    return march, solve, out


def row_work(trial: Trial, motion: Motion, effects: Effects, closed: bool) -> Work:
    """The steady state of a motion: a row of as many periods as its march takes to settle, as a sweep solves it
    or marched whatever it is."""
    march, solve, out = row_calls(trial, motion, effects)
    march(1)
    periods, m = max(1, int(out.settled_after[0])), max(1, int(out.period_multiple[0]))
    impacts, rests = out.impacts[0].sum() / m, out.rests[0].sum() / m
    return Work(solve if closed else march, 1, periods, impacts, rests)


def motion_work(trial: Trial, motion: Motion, effects: Effects, closed: bool) -> Work:
    """A motion over its periods, with samples where they are asked for."""
    sampled = "motion" in trial.outputs
    task = Task(0.0, motion.tau_end, motion.x0, motion.v0, SAMPLES * sampled, MOST_CONTACTS)
    if closed and has_closed_form(motion.exciter, task):
        return closed_work(motion, task)
    # Of the effects a grid knows the force alone: two kernels of it are enough.
    grid = exact_grid(ALL_EFFECTS._replace(forcing=effects.forcing), motion.exciter.parameters())
    march = March(motion, grid, effects)
    march.repeat(1)
    impacts, rests = (float(march.log.counts[k]) / motion.periods for k in (IMPACTS, RESTS))
    if not sampled:
        return Work(march.repeat, motion.periods, 1, impacts, rests)
    row, start = np.array([motion.exciter.parameters()]), (motion.x0, motion.v0)
    samples = np.empty((1, 2, SAMPLES * motion.periods))

    def repeat(often: int) -> None:
        log, work = march.log, march.work
        sample_often(effects, row, *start, motion.periods, log, work, samples, often)

    return Work(repeat, motion.periods, 1, impacts, rests)


def closed_work(motion: Motion, task: Task) -> Work:
    """A motion in closed form."""

    def repeat(often: int) -> None:
        for _ in range(often):
            run_motion(motion.exciter, task)

    impacts = run_motion(motion.exciter, task).contacts["impact_tau"].size
    return Work(repeat, motion.periods, 1, impacts / motion.periods, 0.0)


def own_work(trial: Trial) -> Work:
    """The work of a trial by the kernel of its motion's own effects."""
    build = row_work if trial.row else motion_work
    return build(trial, trial.motion, own_effects(trial.motion, trial.row), True)


def kernel_calls(trial: Trial) -> list[Callable[[], object]]:
    """Calls of each kernel that a trial needs, with next to no work."""
    own = own_effects(trial.motion, trial.row)
    if trial.row:
        march, solve, _out = row_calls(trial, trial.motion, own)
        return [partial(march, 1), partial(solve, 1)]

    def call(effects: Effects, closed: bool) -> None:
        motion_work(trial, trial.motion, effects, closed).repeat(1)

    return [partial(call, own, True), partial(call, ALL_EFFECTS, False)]


def works_of(trial: Trial, full: Motion) -> dict[str, Work]:
    """The work of a trial by each of KERNELS."""
    build = row_work if trial.row else motion_work
    return {
        "own": own_work(trial),
        "all": build(trial, trial.motion, ALL_EFFECTS, False),
        "full": build(trial, full, ALL_EFFECTS, False),
    }


def measure_effects(
    trials: Mapping[str, Trial],
    full: Motion,
    bytes_of: Callable[[Trial, Motion], float],
    rounds: int,
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Time and size of each trial, over `motion` (its name) and `kernel` (KERNELS).

    full: the motion that has all effects; bytes_of: bytes that a trial stores on disk in a row of a sweep, or
    in a forcing period of a motion, if it is about the motion given; progress: is told the times taken and all.
    `kernel_time` is per forcing period; `time_ratio`, of the trial's own kernel over each, and `target_ratio` are
    of whole rows, or of forcing periods of motions, round by round. Times differ from run to run; bytes are
    the same with the same versions of the packages.
    """
    works = {name: works_of(trial, full) for name, trial in trials.items()}
    timers = {
        name: {kernel: Timer(work.repeat, work.units) for kernel, work in by.items()}
        for name, by in works.items()
    }
    take_turns([timer for by in timers.values() for timer in by.values()], rounds, progress)
    columns: dict[str, list[Any]] = {}

    def note(**values: Any) -> None:
        for name, value in values.items():
            columns.setdefault(name, []).append(value)

    for name, trial in trials.items():
        mine, work = timers[name], [works[name][kernel] for kernel in KERNELS]
        times = [
            [time / one.periods for time in mine[kernel].quartiles()]
            for kernel, one in zip(KERNELS, work, strict=True)
        ]
        ratios = [quartiles(ratio(mine["own"], mine[kernel])) for kernel in KERNELS]
        asked = mine["all"] if not trial.against else timers[trial.against]["own"]
        target = quartiles(ratio(mine["own"], asked))
        sizes = [bytes_of(trial, motion) for motion in (trial.motion, trial.motion, full)]
        met = NOT_ASKED if math.isnan(trial.at_most) else int(target[0] <= trial.at_most)
        note(
            **spread("kernel_time", times), **spread("time_ratio", ratios),
            bytes_per_row=sizes, bytes_ratio=[sizes[0] / size for size in sizes],
            target_ratio=target[0], target_ratio_low=target[1], target_ratio_high=target[2],
            target=trial.at_most, target_met=met, target_against=trial.against or "all effects",
            periods_timed=[one.units * one.periods for one in work],
            impacts_per_period=[one.impacts for one in work],
            rests_per_period=[one.rests for one in work],
            effects_present=", ".join(names_of(own_effects(trial.motion, trial.row))),
            outputs_asked=", ".join([*(["steady state"] if trial.row else []), *trial.outputs]),
        )  # fmt: skip
    return labelled(trials, columns)


def ratio(mine: Timer, other: Timer) -> list[float]:
    """Times over each other, round by round."""
    return [a / b for a, b in zip(mine.times, other.times, strict=False)]


def spread(name: str, values: list[list[float]]) -> dict[str, list[float]]:
    """Medians and quartiles as three columns."""
    return {
        f"{name}{suffix}": [value[place] for value in values]
        for place, suffix in enumerate(("", "_low", "_high"))
    }


def labelled(trials: Mapping[str, Trial], columns: Mapping[str, list[Any]]) -> xr.Dataset:
    """The columns as a dataset, with the exciters as coordinates over `motion`."""
    import xarray as xr

    variables: dict[str, Any] = {}
    for name, values in columns.items():
        array = np.array(values, np.int8) if name == "target_met" else np.array(values)
        variables[name] = (("motion", "kernel")[: array.ndim], array)
    coords = motion_coordinates({name: trial.motion for name, trial in trials.items()})
    comment = (
        "kernel_time*, time_ratio* and target_ratio* are of the run that took them; a kernel is own (the "
        "effects of the motion, closed forms where it has them), all (all effects, marched) or full (as all, on "
        "the motion that has all effects)"
    )
    attrs = {"comment": comment}
    return describe(xr.Dataset(variables, {**coords, "kernel": list(KERNELS)}, attrs))
