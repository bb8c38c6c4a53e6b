"""Timed work of effects and outputs: a motion or a row, with its own kernel and with the kernel of all effects."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit_allocating
from vibropipe.lab.timing import Repeat, repeated
from vibropipe.lab.work_precision_methods import BenchmarkMotion, March
from vibropipe.march.grid import exact_grid
from vibropipe.march.log import IMPACTS, RESTS, Log, new_log
from vibropipe.march.piece_log import piece_log_of
from vibropipe.orbits.results import RowResults
from vibropipe.orbits.room import new_room
from vibropipe.orbits.row import march_row, row_parameters, sample_row
from vibropipe.physics.effects import ALL_EFFECTS, Effects, all_effects, effects_of
from vibropipe.physics.flow import DEGREE
from vibropipe.solve.row_results import (
    ORBIT_LOG_CAPACITY,
    ORBIT_REST_CAPACITY,
    new_impact_buffer,
    new_rows,
)
from vibropipe.solve.rows import solve_piece
from vibropipe.solve.run import closed_form_solver, run_motion
from vibropipe.solve.sweep import MAX_PERIODS
from vibropipe.solve.sweep_grid import ROWS_PER_CALL

# Harmonics of a row, and samples per forcing period of a motion, where a case includes them.
HARMONICS = 3
SAMPLES = 256


class TimingCase(NamedTuple):
    """What is timed: a motion over its periods or, with `row`, the steady state that it settles to.

    `outputs` of a motion: any of motion, impacts; of a row: any of harmonics, impacts, stability, energy. `against`
    names the case whose time is the reference of the target ratio, "" for the all-effects kernel on the same motion.
    `at_most` is the target, nan for none.
    """

    motion: BenchmarkMotion
    row: bool = False
    outputs: tuple[str, ...] = ("impacts",)
    against: str = ""
    at_most: float = math.nan

    @property
    def effects(self) -> Effects:
        """Effects of the motion, derived as for a scene."""
        exciter, x0, v0, _periods = self.motion
        span = math.inf if self.row else self.motion.tau_end
        return effects_of(exciter.parameters()._asdict(), x0 - exciter.load, v0, span)

    @property
    def all_effects(self) -> Effects:
        """Effects of the all-effects kernel: those of eqs. (5), (6), and all of pieces where the motion has pieces."""
        return all_effects(self.motion.exciter.parameters()._asdict(), pieces=True)


class TimedWork(NamedTuple):
    """What a timer repeats.

    One call of `repeat` does `units` units (rows, or forcing periods of a motion) of `periods` forcing periods each;
    `impacts` and `rests` are mean numbers per forcing period.
    """

    repeat: Repeat
    units: int
    periods: int
    impacts: float
    rests: float


@jit_allocating
def solve_row_repeatedly(
    e: Effects,
    row: np.ndarray,
    x: float,
    v: float,
    log: Log,
    c: np.ndarray,
    out: RowResults,
    n_calls: int,
) -> None:
    """Solve a row `n_calls` times by time marching, without a closed form, for timing.

    e : Effects; row : (1, n) parameters; x, v : start; log : Log of an orbit; c : (DEGREE + 1,) scratch; out : results
    of one row.
    """
    p, room = row_parameters(row, 0), new_room(e, MAX_PERIODS, out)
    for _ in range(n_calls):
        out.impacts[0, :] = 0.0
        out.rests[0, :] = 0.0
        march_row(e, p, x, v, MAX_PERIODS, MAX_PERIODS, log, c, room, out, 0, 0)


@jit_allocating
def sample_repeatedly(
    e: Effects,
    row: np.ndarray,
    x: float,
    v: float,
    periods: int,
    log: Log,
    c: np.ndarray,
    samples: np.ndarray,
    n_calls: int,
) -> None:
    """March the motion of a row `n_calls` times from tau = 0 and sample it, for timing.

    e : Effects; row : (1, n) parameters; x, v : start; periods : forcing periods; log : Log with capacity for all
    contacts; c : (DEGREE + 1,) scratch; samples : (1, 2, n) receives displacement and velocity.
    """
    p = row_parameters(row, 0)
    for _ in range(n_calls):
        sample_row(e, p, x, v, periods, log, c, samples, 0)


def row_calls(
    case: TimingCase, motion: BenchmarkMotion, effects: Effects
) -> tuple[Repeat, Repeat, RowResults]:
    """Return the call that marches the row of a motion, the one that solves it as a sweep does, and their results."""
    motion = motion.about_equilibrium()
    row = np.tile(motion.exciter.parameters(), (ROWS_PER_CALL, 1))
    starts = np.tile((motion.x0, motion.v0), (ROWS_PER_CALL, 1))
    buffer = new_impact_buffer(ROWS_PER_CALL)
    out = new_rows(ROWS_PER_CALL, HARMONICS, case.outputs, buffer, effects)
    pieces = piece_log_of(effects, ORBIT_LOG_CAPACITY)
    log = new_log(ORBIT_LOG_CAPACITY, ORBIT_REST_CAPACITY, *pieces)
    arrays = log, np.empty(DEGREE + 1), out

    def solve(n_calls: int) -> None:
        for first in range(0, n_calls, ROWS_PER_CALL):
            piece = slice(min(n_calls - first, ROWS_PER_CALL))
            out.impacts[piece] = 0.0
            out.rests[piece] = 0.0
            limits = 1, MAX_PERIODS, MAX_PERIODS
            solve_piece(effects, row[piece], starts[piece], *limits, out, *pieces)

    return (
        partial(solve_row_repeatedly, case.all_effects, row, motion.x0, motion.v0, *arrays),
        solve,
        out,
    )


def row_work(
    case: TimingCase, motion: BenchmarkMotion, effects: Effects, closed: bool
) -> TimedWork:
    """Return the work of a steady state: one row of as many periods as its transient takes.

    `closed`: as a sweep solves it, in closed form where there is one; else by time marching.
    """
    march, solve, out = row_calls(case, motion, effects)
    march(1)
    periods, m = max(1, int(out.settled_after[0])), max(1, int(out.period_multiple[0]))
    impacts, rests = out.impacts[0].sum() / m, out.rests[0].sum() / m
    return TimedWork(solve if closed else march, 1, periods, impacts, rests)


def motion_work(
    case: TimingCase, motion: BenchmarkMotion, effects: Effects, closed: bool
) -> TimedWork:
    """Return the work of a motion over its periods, sampled if its outputs include the motion."""
    motion = motion.about_equilibrium()
    (exciter, x0, v0, periods), sampled = motion, "motion" in case.outputs
    request = motion.request(SAMPLES * sampled)
    if closed and closed_form_solver(exciter, request):
        solve = partial(run_motion, exciter, request)
        impact_tau = solve().contacts["impact_tau"]
        return TimedWork(repeated(solve), periods, 1, impact_tau.size / periods, 0.0)
    # A grid depends on the force alone: few kernels build all grids.
    force = {"forcing": effects.forcing, "second_harmonic": effects.second_harmonic}
    grid = exact_grid(ALL_EFFECTS._replace(**force), exciter.parameters())
    march = March(motion, grid, effects)
    march.repeat(1)
    impacts, rests = (float(march.log.counts[k]) / periods for k in (IMPACTS, RESTS))
    repeat: Repeat = march.repeat
    if sampled:
        row, samples = np.array([exciter.parameters()]), np.empty((1, 2, SAMPLES * periods))
        arrays = march.log, march.scratch, samples
        repeat = partial(sample_repeatedly, effects, row, x0, v0, periods, *arrays)
    return TimedWork(repeat, periods, 1, impacts, rests)


def kernel_calls(case: TimingCase) -> list[Callable[[], object]]:
    """Return calls that compile each kernel of a case with a minimum of work."""
    if case.row:
        march, solve, _out = row_calls(case, case.motion, case.effects)
        return [partial(march, 1), partial(solve, 1)]

    def call(effects: Effects, closed: bool) -> None:
        motion_work(case, case.motion, effects, closed).repeat(1)

    return [partial(call, case.effects, True), partial(call, case.all_effects, False)]


def works_by_kernel(case: TimingCase, full: BenchmarkMotion) -> dict[str, TimedWork]:
    """Return the work of a case for each kernel.

    "own": the kernel of its effects, or a closed form where there is one; "all": the all-effects kernel on the same
    motion; "full": the all-effects kernel on the motion that contains all effects.
    """
    build = row_work if case.row else motion_work
    return {
        "own": build(case, case.motion, case.effects, True),
        "all": build(case, case.motion, case.all_effects, False),
        "full": build(case, full, ALL_EFFECTS, False),
    }
