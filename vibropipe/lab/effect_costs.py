"""What each effect and each output costs: every motion by the kernel of its own effects and by that of all.

Times are those of a core, compilation and tables left out, all in turn in each round (`timing`). Ratios are
taken round by round, so that both sides of each stand next to each other in time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numba
import numpy as np

from vibropipe.compiler.client import compile_side_by_side
from vibropipe.lab.effect_bytes import bytes_of
from vibropipe.lab.effect_work import TimedWork, TimingCase, kernel_calls, works_by_kernel
from vibropipe.lab.timing import Timer, quartiles, time_in_rounds
from vibropipe.lab.work_precision import motion_coordinates
from vibropipe.lab.work_precision_methods import BenchmarkMotion
from vibropipe.physics.effects import effect_names
from vibropipe.words.measurements import Passed
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

# What stands beside each other (`works_by_kernel`).
KERNELS = ("own", "all", "full")
NOT_PASSED, PASSED, NOT_ASKED = Passed

Progress = Callable[[int, int], None]
Size = Callable[[BenchmarkMotion, bool, tuple[str, ...]], float]


def solve_effects(
    trials: Mapping[str, TimingCase],
    full: BenchmarkMotion,
    rounds: int,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Compile what trials need, then `measure_effects` with the bytes of results on disk."""
    calls = [call for trial in trials.values() for call in kernel_calls(trial)]
    compile_side_by_side(calls, numba.get_num_threads())
    return measure_effects(trials, full, bytes_of, rounds, progress)


def measure_effects(
    trials: Mapping[str, TimingCase],
    full: BenchmarkMotion,
    size: Size,
    rounds: int,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Measure time and size of each trial, over `motion` (its name) and `kernel` (KERNELS).

    Parameters
    ----------
    trials : mapping of str to TimingCase
        What is timed, by name.
    full : Motion
        The motion that has all effects.
    size : callable
        Bytes of a row about a motion, or of its forcing period, with some outputs (`bytes_of`).
    rounds : int
        Timings of each.
    progress : callable, optional
        Called as progress(done, total) with the number of timings.

    Returns
    -------
    xarray.Dataset
        `kernel_time` is per forcing period (ns); `time_ratio`, of the trial's own kernel over each, and
        `target_ratio` are of whole rows, or of forcing periods of motions, round by round. Times differ from run to
        run; bytes are the same with the same versions of the packages.
    """
    import xarray as xr

    timed = {name: works_by_kernel(trial, full) for name, trial in trials.items()}
    timers = {
        name: {kernel: Timer(work.repeat, work.units) for kernel, work in by.items()}
        for name, by in timed.items()
    }
    time_in_rounds([timer for by in timers.values() for timer in by.values()], rounds, progress)
    found = []
    for name, trial in trials.items():
        mine = timers[name]
        against = timers[trial.against]["own"] if trial.against else mine["all"]
        sizes = [size(at, trial.row, trial.outputs) for at in (trial.motion, trial.motion, full)]
        found.append(described(trial, timed[name], mine, against, sizes))
    variables = {}
    for name in found[0]:
        array = np.array([one[name] for one in found])
        variables[name] = (("motion", "kernel")[: array.ndim], array)
    coords = motion_coordinates({name: trial.motion for name, trial in trials.items()})
    comment = (
        "kernel_time*, time_ratio* and target_ratio* are of the run that took them; a kernel is own (the "
        "effects of the motion, closed forms where it has them), all (all effects, marched) or full (as all, on "
        "the motion that has all effects)"
    )
    attrs = {"comment": comment}
    return describe(xr.Dataset(variables, {**coords, "kernel": list(KERNELS)}, attrs))


def described(
    trial: TimingCase,
    works: Mapping[str, TimedWork],
    timers: Mapping[str, Timer],
    against: Timer,
    sizes: list[float],
) -> dict[str, Any]:
    """One trial by the names of the dataset, a number or one for each kernel."""
    listed = [works[kernel] for kernel in KERNELS]
    times = [np.array(timers[kernel].quartiles()) / works[kernel].periods for kernel in KERNELS]
    ratios = [quartiles(timers["own"].over(timers[kernel])) for kernel in KERNELS]
    target = quartiles(timers["own"].over(against))
    met = NOT_ASKED if math.isnan(trial.at_most) else int(target[0] <= trial.at_most)
    return {
        **spread("kernel_time", times), **spread("time_ratio", ratios),
        "bytes_per_row": sizes, "bytes_ratio": [sizes[0] / size for size in sizes],
        **spread("target_ratio", target), "target": trial.at_most, "target_met": np.int8(met),
        "target_against": trial.against or "all effects",
        "periods_timed": [one.units * one.periods for one in listed],
        "impacts_per_period": [one.impacts for one in listed],
        "rests_per_period": [one.rests for one in listed],
        "effects_present": ", ".join(effect_names(trial.effects)),
        "outputs_asked": ", ".join([*(["steady state"] if trial.row else []), *trial.outputs]),
    }  # fmt: skip


def spread(name: str, values: Any) -> dict[str, Any]:
    """Median and quartiles, the last dimension, as three columns."""
    columns = np.moveaxis(np.asarray(values), -1, 0)
    return dict(zip((name, f"{name}_low", f"{name}_high"), columns, strict=True))
