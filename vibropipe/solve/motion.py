"""One motion as a labelled dataset: the face `simulate`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.march.grid import Grid, exact_grid, newmark_grid
from vibropipe.physics.effects import Effects, asked_effects, names_of
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.limits import STEPS_PER_PERIOD, within_text
from vibropipe.physics.start import start_text
from vibropipe.solve.energy import TERMS, balance
from vibropipe.solve.run import Run, Task, run_motion, sample_times, turns_of
from vibropipe.words.methods import METHODS
from vibropipe.words.vocabulary import describe

if TYPE_CHECKING:
    import xarray as xr


def simulate(
    exciter: Exciter,
    tau_end: float = 60.0,
    x0: float | None = None,
    v0: float = 0.0,
    method: str = "exact",
    steps_per_period: int | None = None,
    accuracy: float | None = None,
    samples_per_period: int = 256,
    *,
    tau_start: float = 0.0,
    max_impacts: int = 10_000_000,
    effects: Sequence[str] | None = None,
    energy: bool = False,
    progress: Callable[[int], None] | None = None,
) -> xr.Dataset:
    """The motion of eqs. (5), (6) from (x0, v0) at tau_start to tau_end.

    x0: left out, the equilibrium, or the support nearest to it where that lies beyond; within 4 ulps of a support
    it lies on it (`vibropipe.physics.start`).
    method: "exact" (first impacts certified, errors of rounding only) or "newmark" (constant average
    acceleration with `steps_per_period` steps, impacts located inside the step).
    accuracy: error allowed, in place of method and steps_per_period, which are then chosen (`choose` in
    `vibropipe.solve.accuracy.method_choice`); `<name>_error` stands beside every quantity, and attributes say
    what was reached.
    samples_per_period: samples of the motion per forcing period 2 pi / nu; 0 records none.
    effects: any of damping, forcing, support_1, support_2, restitution, rest; the motion is marched by a
    kernel without the others, compiled when it is first called for. All of them if left out.
    energy: whether the balance of energy from start to end is drawn up.
    progress: is told, now and then, how many more forcing periods have been marched.

    Returns a dataset (all non-dimensional): `displacement, velocity, force` over `tau` (from tau_start, the
    last sample exactly tau_end); `impact_tau, impact_support, impact_velocity` (before, signed),
    `impact_velocity_after` over `impact`; `rest_start, rest_end` (inf if not released before tau_end),
    `rest_support` over `rest`; `grazing_tau, grazing_support` over `grazing`; `displacement_end, velocity_end`
    (after an impact at tau_end itself); with `energy`, `energy_input` (work of the force), `energy_damping` and
    `energy_impact` over `support` (lost), `energy_change` (stored) and `energy_residual`, the first less the
    others: the rounding of the motion; `status`: `short_flights` when Newmark flights were shorter than a step,
    `support_reached` when it reaches a support that `effects` leaves out, `max_impacts` when more contacts
    happen than allowed (then the motion is nan from there on).
    Raises ParameterError for a value outside what is allowed, or an effect left out that the parameters have.
    """
    x, v = exciter.check_start(x0, v0)
    turns_of(exciter, tau_start, tau_end)
    with_effects = asked_effects(
        effects,
        exciter.parameters()._asdict(),
        x,
        v,
        tau_end - tau_start,
        exact=method == "exact" and accuracy is None,
    )
    task = Task(
        tau_start,
        tau_end,
        x,
        v,
        samples_per_period,
        max_impacts,
        effects=with_effects,
        energy=energy,
        progress=progress,
    )
    if accuracy is not None:
        from vibropipe.solve.accuracy.request import simulate_to_accuracy

        if method != "exact" or steps_per_period is not None:
            raise ParameterError(
                f"accuracy = {accuracy!r}: allowed without method and steps_per_period, which it chooses"
            )
        return simulate_to_accuracy(exciter, task, accuracy)
    exact = method == "exact" and steps_per_period is None
    grid = None if exact else _grid(exciter, with_effects, method, steps_per_period)
    return to_dataset(exciter, task, run_motion(exciter, task, grid))


def _grid(exciter: Exciter, effects: Effects, method: str, steps_per_period: int | None) -> Grid:
    if method not in METHODS:
        raise ParameterError(f"method = {method!r}: allowed is one of {', '.join(METHODS)}")
    if method == "exact":
        if steps_per_period is not None:
            raise ParameterError(
                f"steps_per_period = {steps_per_period!r}: allowed with method 'newmark' only; "
                "the exact method has no step to choose"
            )
        return exact_grid(effects, exciter.parameters())
    return newmark_grid(effects, exciter.parameters(), check_steps(steps_per_period))


def check_steps(steps_per_period: Any) -> int:
    """A number of Newmark steps per forcing period, or a ParameterError."""
    whole = isinstance(steps_per_period, (int, np.integer)) and not isinstance(
        steps_per_period, bool
    )
    least, most = STEPS_PER_PERIOD
    if not whole or not least <= steps_per_period <= most:
        raise ParameterError(
            f"steps_per_period = {steps_per_period!r}: allowed is {within_text(STEPS_PER_PERIOD)} "
            "(method 'newmark' needs it)"
        )
    return int(steps_per_period)


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
        turns = turns_of(exciter, task.tau_start, task.tau_end)
        offsets = sample_times(turns, task.samples_per_period)
        tau = np.append(task.tau_start + offsets * exciter.period, task.tau_end)
        phase = np.append((turns[0] % 1.0 + offsets) % 1.0, turns[1] % 1.0)
        variables["tau"] = ("tau", tau)
        variables["displacement"] = ("tau", np.append(run.displacement, run.end[0]))
        variables["velocity"] = ("tau", np.append(run.velocity, run.end[1]))
        variables["force"] = ("tau", exciter.f * np.sin(2 * math.pi * phase))
    return variables
