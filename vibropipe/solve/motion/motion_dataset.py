"""The result of a motion under the names of dataset variables."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.effects import effect_names
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.load_harmonics import force_values
from vibropipe.physics.start import start_text
from vibropipe.solve.motion.energy import balance, support_energy
from vibropipe.solve.motion.run import MotionRequest, MotionResult
from vibropipe.solve.origin_attrs import origin_attrs
from vibropipe.words.vocabulary import describe, quantity

if TYPE_CHECKING:
    import xarray as xr


def to_dataset(
    exciter: Exciter,
    request: MotionRequest,
    run: MotionResult,
    steps_per_period: int | None = None,
    errors: Mapping[str, np.ndarray] | None = None,
    variables: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Return the result of a motion as the dataset described in `simulate`.

    steps_per_period : of Newmark's method; None for the exact method
    errors : of each quantity, which stand beside it
    variables : the motion as of `to_variables`, if it is known
    """
    import xarray as xr

    variables = dict(variables or to_variables(exciter, request, run))
    dims = {name: variables[name][0] for name in errors or ()}
    variables |= {f"{name}_error": (dims[name], error) for name, error in (errors or {}).items()}
    coords: dict[str, Any] = {name: ((), value) for name, value in exciter.stated().items()}
    if run.energy_terms is not None:
        coords["support"] = ("support", [1, 2])
    if "tau" in variables:
        coords["tau"] = variables.pop("tau")
    start = start_text(exciter.parameters()._asdict(), request.x, request.v)
    attrs = origin_attrs(effect_names(request.effects, vars(exciter)), start, steps_per_period)
    return describe(xr.Dataset(variables, coords, attrs))


def _energy_roots(exciter: Exciter, x: float, v: float, velocity: float) -> tuple[float, ...]:
    """Return what the stored energy is half the sum of squares of: that of the spring, and of motion."""
    kappa = exciter.mass_ratio
    if kappa == 0.0:
        return x - exciter.load, v
    momentum = velocity + v * kappa / (1.0 + kappa)
    return x - exciter.load, v / math.sqrt(1.0 + kappa), momentum * math.sqrt((1.0 + kappa) / kappa)


def to_variables(exciter: Exciter, request: MotionRequest, run: MotionResult) -> dict[str, Any]:
    """Return the result of a motion as (dimensions, values) by name."""
    variables: dict[str, Any] = {
        name: (quantity(name).dims, values) for name, values in run.contacts.items()
    }
    variables["displacement_end"] = ((), run.end[0])
    variables["velocity_end"] = ((), run.end[1])
    if run.housing is not None:
        variables["housing_velocity_end"] = ((), run.housing[-1, 0])
        variables["housing_displacement_end"] = ((), run.housing[-1, 1])
    variables["status"] = ((), np.int8(run.status))
    if run.energy_terms is not None:
        # The spring and the load together pull towards the equilibrium.
        velocities = (0.0, 0.0) if run.housing is None else (request.housing_v0, run.housing[-1, 0])
        states = zip(((request.x, request.v), run.end), velocities, strict=True)
        first, last = (_energy_roots(exciter, *state, velocity) for state, velocity in states)
        stored = support_energy(exciter, run.end[0]) - support_energy(exciter, request.x)
        variables |= balance(run.energy_terms, first, last, stored, exciter.friction > 0.0)
    if request.samples_per_period > 0:
        start, end = run.turns
        tau = np.append(request.tau_start + run.after * exciter.period, request.tau_end)
        phase = np.append((start % 1.0 + run.after) % 1.0, end % 1.0)
        variables["tau"] = ("tau", tau)
        variables["displacement"] = ("tau", np.append(run.displacement, run.end[0]))
        variables["velocity"] = ("tau", np.append(run.velocity, run.end[1]))
        if run.housing is not None:
            variables["housing_velocity"] = ("tau", run.housing[:, 0])
            variables["housing_displacement"] = ("tau", run.housing[:, 1])
        variables["force"] = ("tau", force_values(exciter.f, phase, exciter.f2, exciter.phi2))
    return variables
