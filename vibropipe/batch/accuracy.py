"""A motion to an accuracy: the cheapest method that reaches it, with the error of every quantity beside it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.batch.choice import check_accuracy, choose_for
from vibropipe.batch.errors import deviation
from vibropipe.batch.motion import Task, run_motion, to_dataset, to_variables
from vibropipe.kernels.grid import newmark_grid
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.physics.exciter import Exciter
from vibropipe.status import Status
from vibropipe.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr


def simulate_to_accuracy(exciter: Exciter, task: Task, accuracy: Any) -> xr.Dataset:
    """The dataset of `simulate` with `<name>_error` beside every quantity.

    Attributes: `method` and `steps_per_period` (of newmark) that were chosen, `accuracy_asked`, and
    `accuracy_reached`: the largest error of end, impacts and rests, absolute or relative to the size of
    its quantity, whichever is more. Where that is larger than what was asked, the motion amplifies
    rounding beyond it: `status` is then `inaccurate`, and the errors still hold.
    """
    asked = check_accuracy(accuracy)
    choice, exact, errors = choose_for(exciter, task, asked)
    run = exact
    if choice.steps_per_period is not None:
        grid = newmark_grid(ALL_EFFECTS, exciter.parameters(), choice.steps_per_period)
        run = run_motion(exciter, task, grid)
        found = to_variables(exciter, task, run)
        errors = deviation(found, to_variables(exciter, task, exact), errors)
    dataset = to_dataset(exciter, task, run)
    if dataset["status"] == Status.OK and not choice.reached:
        dataset["status"] = np.int8(Status.INACCURATE)
    for name, error in errors.items():
        dataset[f"{name}_error"] = (dataset[name].dims, error)
    dataset.attrs |= {
        "method": choice.method,
        "accuracy_asked": asked,
        "accuracy_reached": choice.error,
    }
    if choice.steps_per_period is not None:
        dataset.attrs["steps_per_period"] = choice.steps_per_period
    return describe(dataset)
