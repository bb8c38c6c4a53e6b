"""The function `simulate`: one motion as a labelled dataset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from vibropipe.march.grid import StepGrid, newmark_grid
from vibropipe.physics.effects import Effects, grid_effects, resolve_effects
from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.limits import STEPS_PER_PERIOD, within_text
from vibropipe.solve.accuracy.request import simulate_to_accuracy
from vibropipe.solve.checks import check_housing, check_whole, span_in_turns
from vibropipe.solve.motion.motion_dataset import to_dataset
from vibropipe.solve.motion.ramp import simulate_ramp
from vibropipe.solve.motion.run import MotionRequest, run_motion
from vibropipe.solve.physical import to_physical
from vibropipe.solve.warn import warn_unsolved
from vibropipe.solve.with_units import are_with_units, plain_time, plain_values, plain_velocity
from vibropipe.words.methods import METHODS
from vibropipe.words.progress import Progress, WorkCount

if TYPE_CHECKING:
    import xarray as xr

DEFAULT_END = 60.0


def simulate(
    exciter: Exciter,
    tau_end: float | None = None,
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
    housing_v0: float = 0.0,
    nu_end: float | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Compute the motion of eqs. (5), (6) from `tau_start` to `tau_end`.

    All numbers are non-dimensional: displacements in the unit chosen for `l`, times tau in 1/p with p = sqrt(C/m),
    velocities in that unit times p, forces in that unit times C, energies in its square times C. Of an exciter of
    `from_physical` times, start and `nu_end` may have units, as text or quantities of pint; other numbers among them,
    and the dataset, are then in SI.

    Parameters
    ----------
    exciter : Exciter
    tau_end : float, optional
        End, at least `tau_start` (default: 60).
    x0 : float, optional
        Displacement at `tau_start`. The default is the equilibrium, x = load, or, if that lies beyond a support, that
        support. A value within 4 ulps of a support is moved onto it.
    v0 : float
        Velocity at `tau_start`.
    method : {"exact", "newmark"}
        "exact" certifies every first impact; its only error is rounding [1]_. "newmark" uses steps of constant average
        acceleration [2]_ and locates impacts within the step [3]_.
    steps_per_period : int, optional
        Newmark steps per forcing period 2 pi/nu; required with "newmark", not accepted otherwise.
    accuracy : float, optional
        Maximum error of end state, impacts and rests, from 1e-15 to 0.1: the larger of the absolute error and the
        error relative to the size of the quantity. Impacts slower than this share of the fastest, or of 1 if that is
        less, do not count. Selects `method` and `steps_per_period`.
    samples_per_period : int
        Samples of the motion per forcing period; 0 records none.
    tau_start : float
        Start; at least 0.
    max_impacts : int
        Largest number of impacts, rests and grazings; the motion stops there.
    effects : sequence of str, optional
        Any of damping, forcing, support_1, support_2, restitution, rest, load, soft, friction, second_harmonic,
        housing, no_pull, shaker (default: the first six, and those of the others that the parameters have). A
        specialised kernel without the others, but with restitution and rest at any support, marches the motion; it is
        compiled on first use.
    energy : bool
        Whether to compute the energy balance from start to end.
    housing_v0 : float
        Velocity of the housing at `tau_start`, where it may slide; its displacement counts from there.
    nu_end : float, optional
        Frequency at `tau_end`: the frequency changes linearly from that of the exciter at `tau_start`, a ramp. The
        phase there is nu tau_start; f and f2 stay, and a shaker drives with -shaker (sin(phase))'', which
        is shaker (nu^2 sin(phase) - nu' cos(phase)). `method`, `steps_per_period`, `accuracy`, `effects` and `energy`
        are then left out.
    progress : callable, optional
        Called repeatedly as progress(done, total), in forcing periods marched; total is 0, unknown, with `accuracy`. A
        motion in closed form never calls it.

    Returns
    -------
    xarray.Dataset
        Every variable has the attribute `units`, which is "1".

        displacement, velocity, force (tau)
            Samples from `tau_start` on; the last is at `tau_end` exactly. Absent with samples_per_period = 0.
        impact_tau, impact_support, impact_velocity, impact_velocity_after (impact)
            Time, support (1, 2), and signed velocity before and after each impact.
        rest_start, rest_end, rest_support (rest)
            Rests on a support; `rest_end` is inf without a release before `tau_end`.
        grazing_tau, grazing_support (grazing)
            Contacts of zero velocity.
        frequency (tau), nu_end
            With `nu_end`: the frequency at the samples, whose number per period is that of the highest frequency.
        contact_duration, contact_force_max, contact_depth_max (impact)
            With soft supports: duration of each contact, and largest force of the support and depth in it; NaN for an
            impact on a rigid one.
        turn_tau (turn), stick_start, stick_end (stick)
            With friction: turning points, and times for which it holds the mass; inf for a stick without end.
        housing_velocity, housing_displacement (tau)
            With a housing that may slide: its motion, beside the displacement of the mass relative to it.
        housing_slip_start, housing_slip_end, housing_slip_direction (housing_slip)
            With a housing that may slide: times for which it slides one way, 1 along x or -1 against it; the end is inf
            where the motion ends before.
        displacement_end, velocity_end, housing_velocity_end, housing_displacement_end
            State at `tau_end`, after an impact at `tau_end` itself.
        energy_input, energy_damping, energy_impact (support), energy_friction, energy_change, energy_residual
            With `energy`: work of the force, losses (by friction if there is any), change of stored energy (of motion,
            spring and load), and the residual of the balance, which is rounding.
        energy_housing_friction, energy_housing_load
            With `energy` and a housing that may slide: loss by friction of the ground, and work of both constant forces
            over the displacement of the housing.
        status
            `short_flights`: Newmark flights were shorter than a step. `support_reached`: the motion reaches a
            support that `effects` leaves out. `max_impacts`: more contacts than `max_impacts`; the motion is NaN from
            there on. `inaccurate`: rounding errors grow beyond `accuracy`.
        <name>_error
            With `accuracy`: error estimate of each quantity, in its dimensions. The attributes `accuracy_asked` and
            `accuracy_reached` give the requested and the estimated error.

        The attributes `method`, `steps_per_period` (of newmark), `effects`, `start` and `version` say how it was made.

    Raises
    ------
    ParameterError
        If an argument is out of range, or `effects` leaves out an effect that the parameters have.

    Warns
    -----
    UnsolvedWarning
        If the status is not `ok`, with the remedy.

    References
    ----------
    .. [1] T. Park, P. I. Barton, State event location in differential-algebraic models, ACM Trans. Model. Comput.
       Simul. 6 (1996) 137 (no earlier event exists).
    .. [2] N. M. Newmark, A method of computation for structural dynamics, J. Eng. Mech. Div. ASCE 85 (1959) 67.
    .. [3] L. F. Shampine, S. Thompson, Event location for ordinary differential equations, Comput. Math. Appl. 39
       (2000) 43.
    """
    if are_with_units(exciter, tau_end, x0, v0, tau_start, housing_v0, nu_end):
        found = simulate(
            exciter,
            tau_end if tau_end is None else plain_time(exciter, "tau_end", tau_end),
            plain_values(exciter, "x0", x0),
            plain_values(exciter, "v0", v0),
            method,
            steps_per_period,
            accuracy,
            samples_per_period,
            tau_start=plain_time(exciter, "tau_start", tau_start),
            max_impacts=max_impacts,
            effects=effects,
            energy=energy,
            housing_v0=plain_velocity(exciter, "housing_v0", housing_v0),
            nu_end=plain_values(exciter, "omega", nu_end),
            progress=progress,
        )
        return to_physical(found, exciter)
    tau_end = DEFAULT_END if tau_end is None else tau_end
    x, v = exciter.check_start(x0, v0)
    turns = span_in_turns(exciter, tau_start, tau_end)
    if nu_end is not None:
        _check_alone(
            method=method != "exact" and method,
            steps_per_period=steps_per_period,
            accuracy=accuracy,
            effects=effects,
            energy=energy,
        )
        check_housing(exciter, housing_v0)
        request = MotionRequest(tau_start, tau_end, x, v, samples_per_period, max_impacts)
        return warn_unsolved(simulate_ramp(exciter, request, nu_end, progress))
    values, span = exciter.parameters()._asdict(), tau_end - tau_start
    is_exact = method == "exact" and accuracy is None
    # Newmark's energy balance marches the motion with its samples a second time.
    marches = 2 if energy and not is_exact and samples_per_period > 0 else 1
    n_periods = marches * (int(turns[1]) - int(turns[0])) if accuracy is None else 0
    request = MotionRequest(
        tau_start,
        tau_end,
        x,
        v,
        samples_per_period,
        max_impacts,
        effects=resolve_effects(effects, values, x - exciter.load, v, span, exact=is_exact),
        energy=energy,
        housing_v0=check_housing(exciter, housing_v0, accuracy=accuracy is not None),
        marched=None if progress is None else WorkCount(n_periods, progress),
    )
    if accuracy is not None:
        if method != "exact" or steps_per_period is not None:
            must = "must not be combined with method or steps_per_period, which it selects"
            got = f"method = {method!r}, steps_per_period = {steps_per_period!r}"
            raise ParameterError("accuracy", accuracy, must=must, got=got)
        motion = simulate_to_accuracy(exciter, request, accuracy)
    else:
        grid = _grid(exciter, request.effects, method, steps_per_period)
        steps = None if grid is None else grid.steps
        motion = to_dataset(exciter, request, run_motion(exciter, request, grid), steps)
    return warn_unsolved(motion)


def _check_alone(**given: Any) -> None:
    """Raise a ParameterError for the first argument that a ramp does not take."""
    for name, value in given.items():
        if value is not None and value is not False:
            must = "must be left out with nu_end: a ramp is marched by the exact method alone"
            raise ParameterError(name, value, must=must)


def _grid(
    exciter: Exciter, effects: Effects, method: str, steps_per_period: int | None
) -> StepGrid | None:
    """Return the grid of Newmark's method, or None for the exact method, which determines its own."""
    if method not in METHODS:
        raise ParameterError("method", method, " or ".join(METHODS))
    if method == "newmark":
        return newmark_grid(
            grid_effects(effects), exciter.parameters(), check_steps(steps_per_period)
        )
    if steps_per_period is not None:
        must = "must be left out unless method is newmark; the exact method has no step"
        raise ParameterError("steps_per_period", steps_per_period, must=must)
    return None


def check_steps(steps_per_period: Any) -> int:
    """Return a number of Newmark steps in a forcing period, or raise a ParameterError."""
    if steps_per_period is None:
        must = f"is required ({within_text(STEPS_PER_PERIOD)}), since method is newmark"
        raise ParameterError("steps_per_period", None, must=must, got="")
    return check_whole("steps_per_period", steps_per_period, STEPS_PER_PERIOD)
