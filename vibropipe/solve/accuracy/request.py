"""A motion to an accuracy: the cheapest method that reaches it, with an error estimate for every quantity."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.march.grid import newmark_grid
from vibropipe.physics.effects import grid_effects
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.limits import ACCURACY
from vibropipe.solve.accuracy.method_choice import check_accuracy, choose_method
from vibropipe.solve.accuracy.motion_errors import deviation
from vibropipe.solve.motion.motion_dataset import to_dataset, to_variables
from vibropipe.solve.motion.run import MotionRequest, run_motion
from vibropipe.words.status import Status

if TYPE_CHECKING:
    import xarray as xr


def simulate_to_accuracy(exciter: Exciter, request: MotionRequest, accuracy: Any) -> xr.Dataset:
    """Compute the dataset of `simulate` with `<name>_error` for every quantity.

    Its attributes are the selected `method` and `steps_per_period` (of newmark), `accuracy_asked`, and
    `accuracy_reached`, the measured error (`largest_relative_error`). If rounding errors exceed the requested accuracy,
    `status` is `inaccurate` and the error estimates remain valid.

    accuracy : maximum error of end state, impacts and rests
    Raises ParameterError if the accuracy or the times are out of range.
    """
    requested_error = check_accuracy(accuracy)
    choice, run, variables, errors = choose_method(exciter, request, requested_error)
    if choice.steps_per_period is not None:
        grid = newmark_grid(
            grid_effects(request.effects), exciter.parameters(), choice.steps_per_period
        )
        run = run_motion(exciter, request, grid)
        exact, variables = variables, to_variables(exciter, request, run)
        errors = deviation(variables, exact, errors)
    if run.status == Status.OK and not choice.reached:
        variables["status"] = ((), np.int8(Status.INACCURATE))
    dataset = to_dataset(exciter, request, run, choice.steps_per_period, errors, variables)
    dataset.attrs |= {"accuracy_asked": requested_error, "accuracy_reached": float(choice.error)}
    return dataset


def settle_to_accuracy(exciter: Exciter, request: MotionRequest, accuracy: Any) -> xr.Dataset:
    """Compute a motion, as `simulate_to_accuracy`, after a transient from tau = 0 to `tau_start`.

    The uncertainty of the state at the end of the transient is carried into the errors of the record.

    request : (x, v) is the start at tau = 0; the record extends from `tau_start` to `tau_end`
    """
    if request.tau_start == 0.0:
        return simulate_to_accuracy(exciter, request, accuracy)
    transient = request._replace(
        tau_start=0.0, tau_end=request.tau_start, samples_per_period=0, energy=False
    )
    # With a tenth of the error the transient contributes little to the error of the record.
    end = simulate_to_accuracy(exciter, transient, max(check_accuracy(accuracy) / 10, ACCURACY[0]))
    names = ("displacement_end", "velocity_end", "displacement_end_error", "velocity_end_error")
    x, v, x_uncertainty, v_uncertainty = (float(end[name]) for name in names)
    record = request._replace(x=x, v=v, x_uncertainty=x_uncertainty, v_uncertainty=v_uncertainty)
    return simulate_to_accuracy(exciter, record, accuracy)
