"""Price list: run time and stored bytes of each physical effect and each output, beside those of one motion.

Times are CPU times of one core without compilation and tables. All cases are timed in every round (`timing`), and
ratios are taken round by round, so that both times of a ratio are close to each other. What a ratio of 1 scatters by is
measured as well: the cases that others are compared with are timed twice.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numba
import numpy as np

from vibropipe.lab.effect_bytes import stored_bytes
from vibropipe.lab.effect_work import TimingCase, kernel_call, timed_work
from vibropipe.lab.timing import Timer, compile_side_by_side, quartiles, time_in_rounds
from vibropipe.lab.work_precision import motion_coordinates
from vibropipe.lab.work_precision_methods import BenchmarkMotion
from vibropipe.physics.effects import effect_names
from vibropipe.words.progress import Progress
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr

Size = Callable[[BenchmarkMotion, bool, tuple[str, ...]], float]


def solve_effects(
    cases: Mapping[str, TimingCase], rounds: int, progress: Progress | None = None
) -> xr.Dataset:
    """Compile the kernels of the cases, then measure run time and stored bytes.

    Parameters and result as of `measure_effects`, with the bytes that `stored_bytes` measures.
    """
    calls: list[Callable[[], object]] = [kernel_call(case) for case in cases.values()]
    calls += [
        partial(stored_bytes, case.motion._replace(periods=1), case.row, case.outputs)
        for case in cases.values()
    ]
    compile_side_by_side(calls, numba.get_num_threads())
    return measure_effects(cases, stored_bytes, rounds, progress)


def measure_effects(
    cases: Mapping[str, TimingCase],
    size: Size,
    rounds: int,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Measure run time and stored bytes of each case.

    Parameters
    ----------
    cases : mapping of str to TimingCase
        Timed cases by name.
    size : callable
        Returns the bytes of a row or forcing period; called as `size(motion, row, outputs)` like `stored_bytes`.
    rounds : int
        Timings of each case.
    progress : callable, optional
        Called as `progress(done, total)` with the number of timings.

    Returns
    -------
    xarray.Dataset
        Over `motion` (names of the cases): `time_per_unit` (ns per forcing period of a motion, or per row), with
        quartiles; `time_ratio`, that time over the one of `compared_with`, and `time_scatter`, the largest deviation
        from 1 of the quartiles of the ratio of `compared_with` to itself; bytes, impacts and rests. The ratio of a case
        that others are compared with is that of its two times. Times differ from run to run; bytes depend on the
        versions of the packages only.
    """
    import xarray as xr

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
