"""Work-precision comparison: error and run time of every method at every setting on every motion.

Errors are measured against the 40-digit reference. Times are CPU times of one core without compilation and tables of
the grid; all methods are timed in every round, so that drift of the machine affects all alike.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numba
import numpy as np

from vibropipe.lab import work_precision_methods as own_methods
from vibropipe.lab.motion_reference import ERRORS, MotionReference
from vibropipe.lab.peers.packages import heyoka_peer, is_for_nivp, nivp_peer
from vibropipe.lab.peers.solve_ivp import scipy_peer
from vibropipe.lab.timing import Timer, compile_side_by_side, repeated, time_in_rounds
from vibropipe.lab.work_precision_methods import BenchmarkMotion, Candidate
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.limits import MAX_TABLE
from vibropipe.solve.motion.simulate import simulate
from vibropipe.words.measurements import COMPARED_METHODS, OWN_METHODS, Outcome, is_installed
from vibropipe.words.parameters import DEFAULTS, FURTHER, PARAMETERS
from vibropipe.words.progress import Progress
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr


TIME_SIDES = ("", "_low", "_high")


def solve_quietly(exciter: Exciter, tau_end: float, x0: float, v0: float, **settings: Any) -> Any:
    """Return the dataset of `simulate` without samples; what it cannot reach stands in its status, not in warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return simulate(exciter, tau_end, x0, v0, samples_per_period=0, **settings)


def true_error(dataset: Any, load: float, reference: MotionReference) -> float:
    """Return the largest error of end state and impacts: absolute, or relative to the motion where that is larger.

    Times are relative to the smaller of 1 and the forcing period. The reference counts from the equilibrium under
    `load`.
    """
    x, v = float(dataset["displacement_end"]) - load, float(dataset["velocity_end"])
    end = np.abs(np.array([x, v]) - reference.end)
    columns = (dataset[f"impact_{name}"].values for name in ("tau", "support", "velocity"))
    is_same, lag, velocity = reference.impact_errors(*columns)
    if not is_same:
        return float("inf")
    size, speed = min(1.0, reference.size), min(1.0, reference.speed)
    return max(
        end[0] / size,
        max(end[1], velocity) / speed,
        lag / min(1.0, reference.motion.exciter.period),
    )


def ask(
    motion: BenchmarkMotion, reference: MotionReference, accuracies: Sequence[float], repeats: int
) -> dict[str, np.ndarray]:
    """Ask `simulate` for each accuracy on one motion.

    Over the accuracies: `asked_estimate`, `asked_error`, `asked_steps` (0 for the exact method), `asked_status`,
    `asked_time*` (ns per forcing period); for the motion `plain_time*`, of the same call without an accuracy.
    """
    rows: dict[str, list[float]] = {
        name: [] for name in ("asked_estimate", "asked_error", "asked_steps", "asked_status")
    }
    given = motion.exciter, motion.tau_end, motion.x0, motion.v0
    timers = [Timer(repeated(partial(solve_quietly, *given)), motion.periods)]
    for accuracy in accuracies:
        dataset = solve_quietly(*given, accuracy=accuracy)
        method = str(dataset.attrs["method"])
        row = (
            float(dataset.attrs["accuracy_reached"]),
            true_error(dataset, motion.exciter.load, reference),
            float(method.split()[1]) if method.startswith("newmark") else 0.0,
            float(dataset["status"]),
        )
        for name, value in zip(rows, row, strict=True):
            rows[name].append(value)
        call = repeated(partial(solve_quietly, *given, accuracy=accuracy))
        timers.append(Timer(call, motion.periods, is_warm=True))
    time_in_rounds(timers, repeats)
    plain, *asked = (timer.quartiles() for timer in timers)
    columns = {name: np.array(values) for name, values in rows.items()}
    for k, side in enumerate(TIME_SIDES):
        columns[f"plain_time{side}"] = np.array(plain[k])
        columns[f"asked_time{side}"] = np.array([times[k] for times in asked])
    return columns


# Steps of a motion above which a method of this package is not tried: at some ns per step, a run takes 0.1 s.
MAX_STEPS = 20_000_000
WORK = ("work_steps", "work_evaluations", "work_iterations")
TIMES = ("time_per_period", "time_per_period_low", "time_per_period_high")


class Entry(NamedTuple):
    """A method at one of its settings: index of the setting and its value (steps or tolerance)."""

    method: str
    setting: int
    value: float


def entries(
    methods: Sequence[str], steps: Sequence[int], tolerances: Sequence[float]
) -> list[Entry]:
    """Return all settings of all methods."""
    settings = {"crude": steps, "newmark": steps, "solve_nivp": steps, "exact": [math.nan]}
    return [
        Entry(method, setting, float(value))
        for method in methods
        for setting, value in enumerate(settings.get(method, tolerances))
    ]


def build_method(method: str, value: float, motion: BenchmarkMotion) -> Candidate | Outcome:
    """Return a method with its setting on a motion, or the outcome that states why it cannot run."""
    if method in OWN_METHODS and value * motion.periods > MAX_STEPS:
        return Outcome.NOT_TRIED
    if not is_installed(method):
        return Outcome.NOT_INSTALLED
    if method == "solve_nivp" and not is_for_nivp(motion, value):
        return Outcome.NOT_TRIED
    e = motion.exciter
    if method not in (*OWN_METHODS, "exact") and max(e.contact_1, e.contact_2) > 0.0:
        return Outcome.NOT_TRIED  # none of them is told when a support lets go
    return build(method, value, motion)


def build(method: str, value: float, motion: BenchmarkMotion) -> Candidate:
    """Return an installed method with its setting on a motion, counted from its equilibrium."""
    motion = motion.about_equilibrium()
    if method == "exact":
        return own_methods.exact(motion)
    if method in OWN_METHODS:
        own_method = own_methods.newmark if method == "newmark" else own_methods.newmark_crude
        return own_method(motion, int(value))
    if method == "heyoka":
        return heyoka_peer(motion, value)
    if method == "solve_nivp":
        return nivp_peer(motion, int(value))
    return scipy_peer(motion, method, value)


def run_methods(
    motion: BenchmarkMotion, reference: MotionReference, listed: Sequence[Entry], repeats: int
) -> dict[Entry, dict[str, float]]:
    """Run each method on one motion.

    listed : methods with their settings
    Returns outcome, errors, work and times of each entry, by the names of the dataset.
    """
    results, timers = {}, {}
    for entry in listed:
        candidate = build_method(entry.method, entry.value, motion)
        if isinstance(candidate, Outcome):
            results[entry] = {"outcome": float(candidate)}
            continue
        result = candidate.show()
        outcome, errors = reference.errors(result)
        work = [count / motion.periods for count in result.effort]
        names = ("outcome", *ERRORS, *WORK)
        results[entry] = dict(zip(names, (outcome, *errors, *work), strict=True))
        if outcome != Outcome.DID_NOT_END:
            # Peers show and repeat by the same code, a second of it where they are slow.
            is_warm = entry.method not in OWN_METHODS
            timers[entry] = Timer(candidate.repeat, motion.periods, is_warm=is_warm)
    time_in_rounds(timers.values(), repeats)
    for entry, timer in timers.items():
        results[entry] |= zip(TIMES, timer.quartiles(), strict=True)
    return results


def compile_methods(methods: Sequence[str], motions: Iterable[BenchmarkMotion]) -> None:
    """Compile the kernels of this package's methods, in as many processes as there are threads."""
    short = [motion._replace(periods=1) for motion in motions]

    def show(method: str, motion: BenchmarkMotion) -> None:
        build(method, 8.0, motion).show()

    def repeat(method: str, motion: BenchmarkMotion) -> None:
        build(method, 8.0, motion).repeat(1)

    # The calls of a method share most of their code, which side by side would be compiled twice.
    own = [method for method in methods if method in OWN_METHODS]
    groups = [
        [partial(call, method, motion) for motion in short for call in (show, repeat)]
        for method in own
    ]
    compile_side_by_side(groups, numba.get_num_threads())


def solve_accuracy(
    motions: Mapping[str, BenchmarkMotion],
    methods: Sequence[str] = COMPARED_METHODS,
    steps: Sequence[int] = (16, 64, 256, 1024, 4096, 16384),
    tolerances: Sequence[float] = (1e-4, 1e-7, 1e-10),
    accuracies: Sequence[float] = (),
    repeats: int = 7,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Measure error, run time and work of methods over (motion, method, setting), all over the same periods.

    methods : any of METHODS, each once; packages that are not installed are left out
    steps : steps per forcing period of crude, newmark and solve_nivp
    tolerances : relative and absolute tolerances of the other packages
    accuracies : accuracies that `simulate` is asked for on each motion
    progress : called as `progress(done, total)` with the number of runs, each a motion by a method at a setting
    Returns errors relative to the motion, work and times per forcing period (ns), `outcome`, `setting_value`; of each
    motion `periods_run` and `impacts_per_period`. With `accuracies`, those of `ask` over (motion, accuracy). Only
    times differ from run to run with the same versions of the packages. The attribute `tabulated_steps` is the
    largest number of steps per period whose force is read from a table: with more, a step costs several times as
    much, since sine and cosine are computed in each.
    """
    import xarray as xr

    methods = [m for m in methods if is_installed(m)]
    compile_methods(methods, motions.values())
    listed = entries(methods, steps, tolerances)
    dims = ("motion", "method", "setting")
    shape = (len(motions), len(methods), max(entry.setting for entry in listed) + 1)
    columns = {name: np.full(shape, np.nan) for name in (*ERRORS, *WORK, *TIMES)}
    columns["outcome"] = np.full(shape, Outcome.NOT_TRIED, np.int8)
    values = np.full(shape[1:], np.nan)
    impacts, asked = [], []
    for i, motion in enumerate(motions.values()):
        reference = MotionReference(motion)
        impacts.append(reference.tau.size / motion.periods)
        for entry, measured in run_methods(motion, reference, listed, repeats).items():
            index = (i, methods.index(entry.method), entry.setting)
            values[index[1:]] = entry.value
            for name, value in measured.items():
                columns[name][index] = value
        if accuracies:
            asked.append(ask(motion, reference, accuracies, repeats))
        if progress is not None:
            progress((i + 1) * len(listed), len(motions) * len(listed))
    variables: dict[str, Any] = {name: (dims, column) for name, column in columns.items()}
    variables |= {
        "setting_value": (dims[1:], values),
        "periods_run": ("motion", [motion.periods for motion in motions.values()]),
        "impacts_per_period": ("motion", impacts),
    }
    coords = {**motion_coordinates(motions), "method": ("method", methods)}
    if accuracies:
        coords["accuracy"] = ("accuracy", np.array(accuracies, float))
        for name in asked[0]:
            column = np.array([each[name] for each in asked])
            variables[name] = (("motion", "accuracy")[: column.ndim], column)
        variables["asked_status"] = (
            ("motion", "accuracy"),
            variables["asked_status"][1].astype(np.int8),
        )
    comment = (
        "time_per_period*, asked_time* and plain_time* differ from run to run; all else is the same with the same "
        "versions of the packages, since methods that do not end are stopped by their work, not by time"
    )
    return describe(
        xr.Dataset(variables, coords, {"comment": comment, "tabulated_steps": MAX_TABLE})
    )


def motion_coordinates(motions: Mapping[str, BenchmarkMotion]) -> dict[str, Any]:
    """Return names, exciters and starts of motions as coordinates over `motion`."""
    all_motions = motions.values()
    columns = {
        name: values
        for name in PARAMETERS
        for values in [[getattr(motion.exciter, name) for motion in all_motions]]
        if name not in FURTHER or any(value != DEFAULTS[name] for value in values)
    } | {
        "displacement_start": [motion.x0 for motion in all_motions],
        "velocity_start": [motion.v0 for motion in all_motions],
        "motion": list(motions),
    }
    return {name: ("motion", values) for name, values in columns.items()}
