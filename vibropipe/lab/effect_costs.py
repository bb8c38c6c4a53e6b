"""Run time and storage of each physical effect and output.

Every motion is timed with the kernel of its own effects and with that of all effects. Times are CPU times of one core
without compilation and tables; all cases are timed in every round (`timing`), and ratios are taken round by round, so
that both times of a ratio are close to each other.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numba
import numpy as np

from vibropipe.compiler.client import compile_side_by_side
from vibropipe.lab.effect_bytes import stored_bytes
from vibropipe.lab.effect_work import TimedWork, TimingCase, kernel_calls, works_by_kernel
from vibropipe.lab.timing import Timer, quartiles, time_in_rounds
from vibropipe.lab.work_precision import motion_coordinates
from vibropipe.lab.work_precision_methods import BenchmarkMotion
from vibropipe.physics.effects import effect_names
from vibropipe.words.measurements import Passed
from vibropipe.words.progress import Progress
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

# Names of the kernels that are compared (`works_by_kernel`).
KERNELS = ("own", "all", "full")
NOT_PASSED, PASSED, NOT_ASKED = Passed

Size = Callable[[BenchmarkMotion, bool, tuple[str, ...]], float]


def solve_effects(
    cases: Mapping[str, TimingCase],
    full: BenchmarkMotion,
    rounds: int,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Compile the kernels of the cases, then measure run time and stored bytes.

    Parameters and result as of `measure_effects`, with the bytes that `stored_bytes` measures.
    """
    calls = [call for case in cases.values() for call in kernel_calls(case)]
    calls += [
        partial(stored_bytes, motion._replace(periods=1), case.row, case.outputs)
        for case in cases.values()
        for motion in (case.motion, full)
    ]
    compile_side_by_side(calls, numba.get_num_threads())
    return measure_effects(cases, full, stored_bytes, rounds, progress)


def measure_effects(
    cases: Mapping[str, TimingCase],
    full: BenchmarkMotion,
    size: Size,
    rounds: int,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Measure run time and stored bytes of each case.

    Parameters
    ----------
    cases : mapping of str to TimingCase
        Timed cases by name.
    full : BenchmarkMotion
        Motion that contains all effects.
    size : callable
        Returns the bytes of a row or forcing period; called as `size(motion, row, outputs)` like `stored_bytes`.
    rounds : int
        Timings of each case and kernel.
    progress : callable, optional
        Called as `progress(done, total)` with the number of timings.

    Returns
    -------
    xarray.Dataset
        Over `motion` (names of the cases) and `kernel` (KERNELS): `kernel_time` per forcing period (ns), `time_ratio`
        (the case's own kernel over each), bytes, and `target_ratio` over `motion`. Ratios refer to whole rows, or to
        forcing periods of motions. Times differ from run to run; bytes depend on the versions of the packages only.
    """
    import xarray as xr

    works = {name: works_by_kernel(case, full) for name, case in cases.items()}
    timers = {
        name: {kernel: Timer(work.repeat, work.units) for kernel, work in by_kernel.items()}
        for name, by_kernel in works.items()
    }
    time_in_rounds(
        [timer for by_kernel in timers.values() for timer in by_kernel.values()], rounds, progress
    )
    columns = []
    for name, case in cases.items():
        own_timers = timers[name]
        reference = timers[case.against]["own"] if case.against else own_timers["all"]
        sizes = [
            size(motion, case.row, case.outputs) for motion in (case.motion, case.motion, full)
        ]
        columns.append(case_values(case, works[name], own_timers, reference, sizes))
    variables = {}
    for name in columns[0]:
        array = np.array([values[name] for values in columns])
        variables[name] = (("motion", "kernel")[: array.ndim], array)
    coords = motion_coordinates({name: case.motion for name, case in cases.items()})
    comment = (
        "kernel_time*, time_ratio* and target_ratio* differ from run to run; kernel: own (effects of the "
        "motion, closed forms where they exist), all (all effects; motions by time marching, rows as a sweep solves "
        "them) or full (as all, on the motion that contains all effects)"
    )
    attrs = {"comment": comment}
    return describe(xr.Dataset(variables, {**coords, "kernel": list(KERNELS)}, attrs))


def case_values(
    case: TimingCase,
    works: Mapping[str, TimedWork],
    timers: Mapping[str, Timer],
    reference: Timer,
    sizes: list[float],
) -> dict[str, Any]:
    """Return the values of one case by variable: a number, or one for each kernel."""
    work_by_kernel = [works[kernel] for kernel in KERNELS]
    times = [np.array(timers[kernel].quartiles()) / works[kernel].periods for kernel in KERNELS]
    ratios = [quartiles(timers["own"].over(timers[kernel])) for kernel in KERNELS]
    target = quartiles(timers["own"].over(reference))
    met = NOT_ASKED if math.isnan(case.at_most) else int(target[0] <= case.at_most)
    return {
        **quartile_columns("kernel_time", times), **quartile_columns("time_ratio", ratios),
        "bytes_per_row": sizes, "bytes_ratio": [sizes[0] / size for size in sizes],
        **quartile_columns("target_ratio", target), "target": case.at_most, "target_met": np.int8(met),
        "target_against": case.against or "all effects",
        "periods_timed": [work.units * work.periods for work in work_by_kernel],
        "impacts_per_period": [work.impacts for work in work_by_kernel],
        "rests_per_period": [work.rests for work in work_by_kernel],
        "effects_present": ", ".join(effect_names(case.effects, vars(case.motion.exciter))),
        "outputs_asked": ", ".join([*(["steady state"] if case.row else []), *case.outputs]),
    }  # fmt: skip


def quartile_columns(name: str, values: Any) -> dict[str, Any]:
    """Split median and quartiles, the last dimension of the values, into three named columns."""
    columns = np.moveaxis(np.asarray(values), -1, 0)
    return dict(zip((name, f"{name}_low", f"{name}_high"), columns, strict=True))
