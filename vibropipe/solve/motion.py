"""One motion as a labelled dataset: the face `simulate`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from vibropipe.march.grid import Grid, newmark_grid
from vibropipe.physics.effects import Effects, asked_effects
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.limits import STEPS_PER_PERIOD
from vibropipe.solve.accuracy.request import simulate_to_accuracy
from vibropipe.solve.motion_dataset import to_dataset
from vibropipe.solve.run import Task, check_whole, run_motion, turns_of
from vibropipe.words.methods import METHODS

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
    values, span = exciter.parameters()._asdict(), tau_end - tau_start
    is_exact = method == "exact" and accuracy is None
    task = Task(
        tau_start,
        tau_end,
        x,
        v,
        samples_per_period,
        max_impacts,
        effects=asked_effects(effects, values, x, v, span, exact=is_exact),
        energy=energy,
        progress=progress,
    )
    if accuracy is not None:
        if method != "exact" or steps_per_period is not None:
            raise ParameterError(
                f"accuracy = {accuracy!r}: allowed without method and steps_per_period, which it chooses"
            )
        return simulate_to_accuracy(exciter, task, accuracy)
    grid = _grid(exciter, task.effects, method, steps_per_period)
    return to_dataset(exciter, task, run_motion(exciter, task, grid))


def _grid(
    exciter: Exciter, effects: Effects, method: str, steps_per_period: int | None
) -> Grid | None:
    """Return the grid of Newmark's method; None for the exact method, which chooses its own."""
    if method not in METHODS:
        raise ParameterError(f"method = {method!r}: allowed is one of {', '.join(METHODS)}")
    if method == "newmark":
        return newmark_grid(effects, exciter.parameters(), check_steps(steps_per_period))
    if steps_per_period is not None:
        raise ParameterError(
            f"steps_per_period = {steps_per_period!r}: allowed with method 'newmark' only; "
            "the exact method has no step to choose"
        )
    return None


def check_steps(steps_per_period: Any) -> int:
    """Return a number of Newmark steps in a forcing period, or raise a ParameterError."""
    why = " (method 'newmark' needs it)"
    return check_whole("steps_per_period", steps_per_period, STEPS_PER_PERIOD, why)
