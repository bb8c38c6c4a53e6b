"""What a motion left, by the names of a dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.effects import names_of
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.load import force_values
from vibropipe.physics.start import start_text
from vibropipe.solve.energy import TERMS, balance
from vibropipe.solve.run import Run, Task
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr


def to_dataset(exciter: Exciter, task: Task, run: Run) -> xr.Dataset:
    """What a motion left as the dataset that `simulate` describes."""
    import xarray as xr

    variables = to_variables(exciter, task, run)
    coords: dict[str, Any] = {
        name: ((), value) for name, value in exciter.parameters()._asdict().items()
    }
    if run.work is not None:
        coords["support"] = ("support", [1, 2])
    if "tau" in variables:
        coords["tau"] = variables.pop("tau")
    attrs = {
        "effects": ", ".join(names_of(task.effects)),
        "start": start_text(exciter.parameters()._asdict(), task.x, task.v),
    }
    return describe(xr.Dataset(variables, coords, attrs))


def to_variables(exciter: Exciter, task: Task, run: Run) -> dict[str, Any]:
    """What a motion left by name: (dimensions, values)."""
    variables: dict[str, Any] = {
        name: (name.split("_")[0], values) for name, values in run.contacts.items()
    }
    variables["displacement_end"] = ((), run.end[0])
    variables["velocity_end"] = ((), run.end[1])
    variables["status"] = ((), np.int8(run.status))
    if run.work is not None:
        terms = balance(run.work, (task.x, task.v), run.end)
        variables |= dict(zip(TERMS, terms, strict=True))
    if task.samples_per_period > 0:
        start, end = run.turns
        tau = np.append(task.tau_start + run.after * exciter.period, task.tau_end)
        phase = np.append((start % 1.0 + run.after) % 1.0, end % 1.0)
        variables["tau"] = ("tau", tau)
        variables["displacement"] = ("tau", np.append(run.displacement, run.end[0]))
        variables["velocity"] = ("tau", np.append(run.velocity, run.end[1]))
        variables["force"] = ("tau", force_values(exciter.f, phase))
    return variables
