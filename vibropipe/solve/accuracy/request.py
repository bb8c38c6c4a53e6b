"""A motion to an accuracy: the cheapest method that reaches it, with the error of every quantity beside it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.march.grid import newmark_grid
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.limits import ACCURACY
from vibropipe.solve.accuracy.method_choice import check_accuracy, choose_method
from vibropipe.solve.accuracy.motion_errors import deviation
from vibropipe.solve.motion_dataset import to_dataset, to_variables
from vibropipe.solve.run import MotionRequest, run_motion
from vibropipe.words.status import Status
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr


def simulate_to_accuracy(exciter: Exciter, request: MotionRequest, accuracy: Any) -> xr.Dataset:
    """The dataset of `simulate` with `<name>_error` beside every quantity.

    Attributes: `method` and `steps_per_period` (of newmark) that were chosen, `accuracy_asked`, and
    `accuracy_reached`: the largest error of end, impacts and rests, absolute or relative to the size of
    its quantity, whichever is more. Where that is larger than what was asked, the motion amplifies
    rounding beyond it: `status` is then `inaccurate`, and the errors still hold.
    """
    asked = check_accuracy(accuracy)
    choice, exact, errors = choose_method(exciter, request, asked)
    run = exact
    if choice.steps_per_period is not None:
        grid = newmark_grid(request.effects, exciter.parameters(), choice.steps_per_period)
        run = run_motion(exciter, request, grid)
        found = to_variables(exciter, request, run)
        errors = deviation(found, to_variables(exciter, request, exact), errors)
    dataset = to_dataset(exciter, request, run)
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


def settle_to_accuracy(exciter: Exciter, request: MotionRequest, accuracy: Any) -> xr.Dataset:
    """The dataset of a task that begins after a settling: (x, v) is the start at tau = 0, the record runs from
    tau_start to tau_end, and what the settling leaves in doubt is carried on into its errors."""
    if request.tau_start == 0.0:
        return simulate_to_accuracy(exciter, request, accuracy)
    settling = request._replace(
        tau_start=0.0, tau_end=request.tau_start, samples_per_period=0, energy=False
    )
    # What is left of its error is then small beside that of the record.
    end = simulate_to_accuracy(exciter, settling, max(check_accuracy(accuracy) / 10, ACCURACY[0]))
    names = ("displacement_end", "velocity_end", "displacement_end_error", "velocity_end_error")
    x, v, x_uncertainty, v_uncertainty = (float(end[name]) for name in names)
    rest_of_it = request._replace(
        x=x, v=v, x_uncertainty=x_uncertainty, v_uncertainty=v_uncertainty
    )
    return simulate_to_accuracy(exciter, rest_of_it, accuracy)
