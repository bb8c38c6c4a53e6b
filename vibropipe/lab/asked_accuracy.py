"""What is asked of `simulate(..., accuracy=)`, estimated by it and reached against 40 digits, and its time."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from vibropipe.lab.motion_reference import MotionReference
from vibropipe.lab.timing import Timer, repeated, time_in_rounds
from vibropipe.lab.work_precision_methods import BenchmarkMotion
from vibropipe.solve.motion.simulate import simulate

TIME_SIDES = ("", "_low", "_high")


def solve_quietly(motion: BenchmarkMotion, **settings: Any) -> Any:
    """Return the dataset of `simulate` without samples; what it cannot reach stands in its status, not in warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return simulate(
            motion.exciter, motion.tau_end, motion.x0, motion.v0, samples_per_period=0, **settings
        )


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

    Over the accuracies: `asked_estimate`, `asked_error`, `asked_steps` (0 for the exact method),
    `asked_status`, `asked_time*` (ns per forcing period); for the motion `plain_time*`, of the same call without an
    accuracy.
    """
    rows: dict[str, list[float]] = {
        name: [] for name in ("asked_estimate", "asked_error", "asked_steps", "asked_status")
    }
    timers = [Timer(repeated(partial(solve_quietly, motion)), motion.periods)]
    for accuracy in accuracies:
        dataset = solve_quietly(motion, accuracy=accuracy)
        method = str(dataset.attrs["method"])
        row = (
            float(dataset.attrs["accuracy_reached"]),
            true_error(dataset, motion.exciter.load, reference),
            float(method.split()[1]) if method.startswith("newmark") else 0.0,
            float(dataset["status"]),
        )
        for name, value in zip(rows, row, strict=True):
            rows[name].append(value)
        call = repeated(partial(solve_quietly, motion, accuracy=accuracy))
        timers.append(Timer(call, motion.periods, is_warm=True))
    time_in_rounds(timers, repeats)
    plain, *asked = (timer.quartiles() for timer in timers)
    columns = {name: np.array(values) for name, values in rows.items()}
    for k, side in enumerate(TIME_SIDES):
        columns[f"plain_time{side}"] = np.array(plain[k])
        columns[f"asked_time{side}"] = np.array([times[k] for times in asked])
    return columns
