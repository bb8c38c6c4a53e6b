"""What a method of the comparison shows of a motion, and our own methods in that form."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from vibropipe.lab.crude import crude, crude_often
from vibropipe.lab.repeat import march_often
from vibropipe.lab.timing import Repeat, repeated
from vibropipe.march.grid import Grid, exact_grid, locate, newmark_grid
from vibropipe.march.log import EVALUATIONS, IMPACTS, POLYNOMIALS, STEPS, new_log
from vibropipe.physics.conservative import is_free
from vibropipe.physics.effects import ALL_EFFECTS, Effects
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.flow import ORDER
from vibropipe.solve.run import MARCH_LOG_CAPACITY, Task, run_motion
from vibropipe.words.measurements import Outcome
from vibropipe.words.status import Status

SAMPLES = 64
MOST_CONTACTS = 2_000_000


class Motion(NamedTuple):
    """A motion to be measured: whole forcing periods from (x0, v0) at tau = 0."""

    exciter: Exciter
    x0: float
    v0: float
    periods: int

    @property
    def tau_end(self) -> float:
        """End of the motion."""
        return self.periods * self.exciter.period

    def task(self, samples_per_period: int = 0) -> Task:
        """Return the motion as a solver takes it."""
        return Task(0.0, self.tau_end, self.x0, self.v0, samples_per_period, MOST_CONTACTS)


class Shown(NamedTuple):
    """What a method shows of a motion: end state, impacts in order of time, displacement at SAMPLES equal
    fractions of the last period, and its work: steps, evaluations of a solution or of the equation,
    iterations for impacts (nan if it does not tell)."""

    outcome: Outcome
    end: tuple[float, float]
    impact_tau: np.ndarray
    impact_support: np.ndarray
    impact_velocity: np.ndarray
    samples: np.ndarray
    work: tuple[float, float, float]


class Contestant(NamedTuple):
    """A method with its setting on one motion: `show` solves it once, `repeat` so many times in a row."""

    show: Callable[[], Shown]
    repeat: Repeat


def failed(outcome: Outcome) -> Shown:
    """What is left of a method that did not get through."""
    none = np.empty(0)
    return Shown(outcome, (math.nan,) * 2, none, none, none, none, (math.nan,) * 3)


def exact(motion: Motion) -> Contestant:
    """The exact method; a conservative motion in its closed form."""
    p = motion.exciter.parameters()
    if is_free(p, motion.x0, motion.v0):
        solve = partial(run_motion, motion.exciter, motion.task())
        return Contestant(partial(shown, motion, None), repeated(solve))
    return marched(motion, exact_grid(ALL_EFFECTS, p))


def newmark(motion: Motion, steps: int) -> Contestant:
    """Newmark's method with impacts located inside the step."""
    return marched(motion, newmark_grid(ALL_EFFECTS, motion.exciter.parameters(), steps))


def marched(motion: Motion, grid: Grid) -> Contestant:
    """The marching loop on a grid; its tables are built before the time is taken."""
    return Contestant(partial(shown, motion, grid), March(motion, grid).repeat)


class March:
    """A march of a motion with a kernel of some effects, done so many times in one call; `log` holds the
    contacts of the last one."""

    def __init__(self, motion: Motion, grid: Grid, effects: Effects = ALL_EFFECTS) -> None:
        self.work = np.empty(3 if grid.exact is None else ORDER + 1)
        self.log = new_log(MARCH_LOG_CAPACITY, MARCH_LOG_CAPACITY)
        end = locate(float(motion.periods), grid.steps)
        start = motion.exciter.parameters(), grid, motion.x0, motion.v0
        self.march = partial(march_often, effects, *start, end)

    def repeat(self, often: int) -> None:
        """March so many times; the log grows until all contacts of the motion have room."""
        while True:
            status = self.march(self.log, self.work, MOST_CONTACTS, often)
            room = 4 * self.log.position.size
            if status != Status.LOG_FULL or room > 2 * MOST_CONTACTS:
                return
            self.log = new_log(room, room)


def shown(motion: Motion, grid: Grid | None) -> Shown:
    """One march with samples of its last period."""
    run = run_motion(motion.exciter, motion.task(), grid)
    if run.status not in (Status.OK, Status.SHORT_FLIGHTS):
        return failed(Outcome.DID_NOT_END)
    sampled = run_motion(motion.exciter, motion.task(SAMPLES), grid)
    struck, counts = run.contacts, run.counts
    return Shown(
        Outcome.OK,
        run.end,
        struck["impact_tau"],
        struck["impact_support"],
        struck["impact_velocity"],
        sampled.displacement[-SAMPLES:],
        (float(counts[STEPS]), float(counts[POLYNOMIALS]), float(counts[EVALUATIONS])),
    )


def newmark_crude(motion: Motion, steps: int) -> Contestant:
    """Newmark's method with impacts taken at the end of the step."""
    p = motion.exciter.parameters()
    what = (p, newmark_grid(ALL_EFFECTS, p, steps), motion.periods, motion.x0, motion.v0)
    room = MARCH_LOG_CAPACITY

    def show() -> Shown:
        nonlocal room
        samples = np.empty(SAMPLES)
        while True:
            log = new_log(room, 1)
            end = crude(*what, log, samples)
            n = int(log.counts[IMPACTS])
            if n <= room:
                break
            room = n
        return Shown(
            Outcome.OK if all(map(math.isfinite, end)) else Outcome.DID_NOT_END,
            end,
            log.position[:n] * motion.exciter.period,
            log.support[:n],
            log.velocity[:n],
            samples,
            (float(log.counts[STEPS]), 0.0, 0.0),
        )

    def repeat(often: int) -> None:
        crude_often(*what, new_log(room, 1), np.empty(0), often)

    return Contestant(show, repeat)
