"""Price list: run time and stored bytes of each physical effect and each output, beside those of one motion.

Times are CPU times of one core without compilation and tables. All cases are timed in every round (`timing`), and
ratios are taken round by round, so that both times of a ratio are close to each other. What a ratio of 1 scatters by is
measured as well: the cases that others are compared with are timed twice.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from functools import cache, partial
from typing import Any, NamedTuple

import numba
import numpy as np
import xarray as xr

from vibropipe.lab.timing import (
    Repeat,
    Timer,
    compile_side_by_side,
    quartiles,
    repeated,
    time_in_rounds,
)
from vibropipe.lab.work_precision import motion_coordinates
from vibropipe.lab.work_precision_methods import BenchmarkMotion, March
from vibropipe.march.grid import exact_grid
from vibropipe.march.log import IMPACTS, RESTS
from vibropipe.march.piece_log import piece_log_of
from vibropipe.physics.effects import (
    Effects,
    all_effects,
    effect_names,
    effects_of,
    grid_effects,
    kernel_effects,
)
from vibropipe.solve.motion.closed_motion import closed_form_solver
from vibropipe.solve.motion.run import run_motion
from vibropipe.solve.motion.simulate import simulate
from vibropipe.solve.rows.many import RowLimits, solve_piece
from vibropipe.solve.rows.row_results import ORBIT_LOG_CAPACITY, new_impact_buffer, new_rows
from vibropipe.solve.sweep.blocks import MAX_PERIODS
from vibropipe.solve.sweep.sweep import sweep
from vibropipe.solve.threads import ROWS_PER_CALL
from vibropipe.store.encoding import encode
from vibropipe.words.progress import Progress
from vibropipe.words.vocabulary import describe

# Harmonics of a row, and samples per forcing period of a motion, where a case includes them.
HARMONICS = 3
SAMPLES = 256


class TimingCase(NamedTuple):
    """What is timed: a motion over its periods or, with `row`, the steady state that it settles to.

    `outputs` of a motion: any of motion, impacts; of a row: any of a steady state's. `kernel`: "own", of the motion's
    effects, or "all", of all effects. `against` names the case whose time is the 1 of its ratio, "" for
    itself. `group`, `title`: words for readers.
    """

    motion: BenchmarkMotion
    row: bool = False
    outputs: tuple[str, ...] = ("impacts",)
    kernel: str = "own"
    against: str = ""
    group: str = ""
    title: str = ""

    @property
    def effects(self) -> Effects:
        """Effects of the motion, derived as for a scene."""
        return effects_about(self.motion, span=math.inf if self.row else self.motion.tau_end)

    @property
    def all_effects(self) -> Effects:
        """Effects of the all-effects kernel: those of eqs. (5), (6), and all of pieces where the motion has pieces."""
        values = self.motion.exciter.parameters()._asdict()
        return all_effects(values, pieces=True, housing=True)


def effects_about(
    motion: BenchmarkMotion, over: Mapping[str, Any] | None = None, span: float = math.inf
) -> Effects:
    """Return the effects of a motion, or of all steady states that differ from it in parameters `over`."""
    values = {**motion.exciter.parameters()._asdict(), **(over or {})}
    return effects_of(values, motion.x0 - motion.exciter.load, motion.v0, span)


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


def row_work(case: TimingCase, motion: BenchmarkMotion, effects: Effects) -> TimedWork:
    """Return the work of a steady state as a sweep solves it: one row of as many periods as its transient takes."""
    motion, effects = motion.about_equilibrium(), kernel_effects(effects)
    row = np.tile(motion.exciter.parameters(), (ROWS_PER_CALL, 1))
    starts = np.tile((motion.x0, motion.v0), (ROWS_PER_CALL, 1))
    buffer = new_impact_buffer(ROWS_PER_CALL)
    out = new_rows(ROWS_PER_CALL, HARMONICS, case.outputs, buffer, effects)
    pieces, plain = piece_log_of(effects, ORBIT_LOG_CAPACITY)
    limits = RowLimits(MAX_PERIODS, MAX_PERIODS)

    def solve(n_calls: int) -> None:
        for first in range(0, n_calls, ROWS_PER_CALL):
            piece = slice(min(n_calls - first, ROWS_PER_CALL))
            out.impacts[piece] = 0.0
            out.rests[piece] = 0.0
            solve_piece(effects, row[piece], starts[piece], 1, limits, out, pieces, plain)

    solve(1)
    periods, m = max(1, int(out.settled_after[0])), max(1, int(out.period_multiple[0]))
    impacts, rests = out.impacts[0].sum() / m, out.rests[0].sum() / m
    return TimedWork(solve, 1, periods, impacts, rests)


def samples_of(outputs: Collection[str]) -> int:
    """Return the samples per forcing period of a motion with some outputs."""
    return SAMPLES if "motion" in outputs else 0


def march_work(case: TimingCase, motion: BenchmarkMotion, effects: Effects) -> TimedWork:
    """Return the work of marching a motion over its periods, sampled if its outputs include the motion."""
    motion = motion.about_equilibrium()
    grid = exact_grid(grid_effects(effects), motion.exciter.parameters())
    march = March(motion, grid, effects, samples_of(case.outputs))
    march.repeat(1)
    impacts, rests = (float(march.log.counts[k]) / motion.periods for k in (IMPACTS, RESTS))
    return TimedWork(march.repeat, motion.periods, 1, impacts, rests)


def motion_work(case: TimingCase, motion: BenchmarkMotion, effects: Effects) -> TimedWork:
    """Return the work of a motion in closed form, or of marching it if there is none."""
    about = motion.about_equilibrium()
    exciter, request = about.exciter, about.request(samples_of(case.outputs))
    if not closed_form_solver(exciter, request):
        return march_work(case, motion, effects)
    solve = partial(run_motion, exciter, request)
    impact_tau = solve().contacts["impact_tau"]
    return TimedWork(repeated(solve), about.periods, 1, impact_tau.size / about.periods, 0.0)


def compile_kernel(case: TimingCase) -> None:
    """Compile the kernel of a case with a minimum of work."""
    timed_work(case).repeat(1)


def timed_work(case: TimingCase) -> TimedWork:
    """Return the work of a case by its kernel: in closed form where its own kernel has one; rows as a sweep does."""
    is_own = case.kernel == "own"
    effects = case.effects if is_own else case.all_effects
    if case.row:
        return row_work(case, case.motion, effects)
    return (motion_work if is_own else march_work)(case, case.motion, effects)


# Rows of the larger of two encoded sweeps: their difference excludes what does not grow with rows (parameters, grids).
MANY_ROWS = 64
# Relative half width of the interval of f (of nu, without force) that the rows sample, so that no two are equal.
WIDTH = 0.01


@cache
def stored_bytes(motion: BenchmarkMotion, row: bool, outputs: tuple[str, ...]) -> float:
    """Return the bytes of a row or of a forcing period, encoded for the disk before compression.

    motion : motion, or centre of the swept exciters
    row : whether a row of a sweep is measured, not a forcing period of the motion
    """
    solve, few, many = (sweep_rows, 1, MANY_ROWS) if row else (march_periods, 0, motion.periods)
    sizes = [
        sum(np.asarray(stored.values).nbytes for stored in encode(solve(motion, outputs, count))[0])
        for count in (few, many)
    ]
    return (sizes[1] - sizes[0]) / (many - few)


def sweep_rows(motion: BenchmarkMotion, outputs: tuple[str, ...], count: int) -> xr.Dataset:
    """Return a sweep of `count` rows about the exciter of a motion, by the kernel of its effects."""
    name = "f" if motion.exciter.f else "nu"
    centre = getattr(motion.exciter, name)
    over = {name: centre * (1 + WIDTH * np.linspace(-1, 1, count))}
    effects = effects_about(motion, {name: centre * np.array([1 - WIDTH, 1 + WIDTH])})
    names = effect_names(effects, vars(motion.exciter))
    return sweep(motion.exciter, over, x0=motion.x0, v0=motion.v0, outputs=outputs, effects=names)


def march_periods(motion: BenchmarkMotion, outputs: tuple[str, ...], count: int) -> xr.Dataset:
    """Return the first `count` forcing periods of a motion."""
    names = effect_names(effects_about(motion, span=motion.tau_end), vars(motion.exciter))
    given = motion.exciter, count * motion.exciter.period, motion.x0, motion.v0
    dataset = simulate(*given, samples_per_period=samples_of(outputs), effects=names)
    return dataset if "impacts" in outputs else dataset.drop_dims(["impact", "grazing"])


Size = Callable[[BenchmarkMotion, bool, tuple[str, ...]], float]


def solve_effects(
    cases: Mapping[str, TimingCase], rounds: int, progress: Progress | None = None
) -> xr.Dataset:
    """Compile the kernels of the cases, then measure run time and stored bytes.

    Parameters and result as of `measure_effects`, with the bytes that `stored_bytes` measures.
    """
    groups: dict[tuple[bool, bool], list[Callable[[], object]]] = {}
    for case in cases.values():
        # Kernels of one group share most of their code, which side by side would be compiled twice.
        group = groups.setdefault((case.row, case.effects.has_pieces), [])
        group += [
            partial(compile_kernel, case),
            partial(stored_bytes, case.motion, case.row, case.outputs),
        ]
    compile_side_by_side(list(groups.values()), numba.get_num_threads())
    return measure_effects(cases, stored_bytes, rounds, progress)


def measure_effects(
    cases: Mapping[str, TimingCase], size: Size, rounds: int, progress: Progress | None = None
) -> xr.Dataset:
    """Measure run time and stored bytes of each case.

    size : returns the bytes of a row or forcing period; called as `size(motion, row, outputs)` like `stored_bytes`
    rounds : timings of each case
    progress : called as `progress(done, total)` with the number of timings
    Over `motion` (names of the cases): `time_per_unit` (ns per forcing period of a motion, or per row), with
    quartiles; `time_ratio`, that time over the one of `compared_with`, and `time_scatter`, the largest deviation from
    1 of the quartiles of the ratio of `compared_with` to itself; bytes, impacts and rests. The ratio of a case that
    others are compared with is that of its two times. Times differ from run to run; bytes depend on the versions of
    the packages only.
    """
    works = {name: timed_work(case) for name, case in cases.items()}
    compared = {name: case.against or name for name, case in cases.items()}
    timers = {name: Timer(work.repeat, work.units) for name, work in works.items()}
    twins = {
        name: Timer(works[name].repeat, works[name].units)
        for name in dict.fromkeys(compared.values())
    }
    time_in_rounds([*timers.values(), *twins.values()], rounds, progress)
    scatter = {
        name: max(abs(q - 1.0) for q in quartiles(twin.over(timers[name])))
        for name, twin in twins.items()
    }
    columns = []
    for name, case in cases.items():
        other, work = compared[name], works[name]
        ratios = (twins[name] if other == name else timers[name]).over(timers[other])
        columns.append(
            {
                **quartile_columns("time_per_unit", timers[name].quartiles()),
                **quartile_columns("time_ratio", quartiles(ratios)),
                "time_scatter": scatter[other],
                "bytes_per_row": size(case.motion, case.row, case.outputs),
                "impacts_per_period": work.impacts,
                "rests_per_period": work.rests,
                "unit": "row" if case.row else "period",
                "compared_with": other,
                "kernel": case.kernel,
                "group": case.group,
                "label": case.title or name.replace("_", " "),
                "effects_present": ", ".join(effect_names(case.effects, vars(case.motion.exciter))),
                "outputs_asked": ", ".join(case.outputs),
            }
        )
    variables = {name: ("motion", np.array([c[name] for c in columns])) for name in columns[0]}
    coords = motion_coordinates({name: case.motion for name, case in cases.items()})
    comment = (
        "time_* differ from run to run; kernel: own (effects of the motion, closed forms where they exist) or all (all "
        "effects, marched)"
    )
    return describe(xr.Dataset(variables, coords, {"comment": comment}))


def quartile_columns(name: str, values: Any) -> dict[str, float]:
    """Return median and quartiles as three named columns."""
    return dict(zip((name, f"{name}_low", f"{name}_high"), values, strict=True))
