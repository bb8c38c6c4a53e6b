"""How far a motion can be trusted: an error beside each of its quantities, found on that very motion.

The exact method errs by rounding alone, amplified along the motion. So it is run again on grids of
other steps, which round elsewhere, from numbers nudged by one unit in the last place, which is how
far they are known: SAFETY times the largest difference to COPIES such runs is the error. Where a
motion touches a support within rounding, so that an impact and no impact cannot be told apart, the
supports are nudged by that much instead. Newmark's error is its distance to the exact motion plus
that motion's own error.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from vibropipe.march.grid import exact_grid_with_steps
from vibropipe.march.roots import GRAZING_TOLERANCE
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.flow import steps_for_exact
from vibropipe.solve.energy import TERMS
from vibropipe.solve.motion_dataset import to_variables
from vibropipe.solve.run import MotionRequest, MotionResult, closed_form_solver, run_motion
from vibropipe.words.parameters import PARAMETERS

ULP = 2.0**-52
COPIES = 3
SAFETY = 2.0
# Signs of the nudges of nu, f, h, l, delta, R1, R2, x0, v0, copy by copy.
SIGNS = (
    (1, -1, 1, 1, 1, -1, -1, 1, 1),
    (-1, -1, -1, -1, 1, -1, 1, 1, -1),
    (1, 1, -1, 1, -1, 1, -1, -1, -1),
)

Variables = dict[str, Any]
Errors = dict[str, np.ndarray]
# Times and velocities of contacts: what stands at a contact, by the name of its dimension.
CONTACT_COLUMNS = {
    "impact": ("impact_tau", "impact_velocity", "impact_velocity_after"),
    "rest": ("rest_start", "rest_end"),
    "grazing": ("grazing_tau",),
}
CONTACT_TIMES = {"impact": "impact_tau", "rest": "rest_start", "grazing": "grazing_tau"}


class Scales(NamedTuple):
    """Sizes of a motion's displacement and velocity, and its unit of time."""

    displacement: float
    velocity: float
    time: float


def motion_scales(exciter: Exciter, request: MotionRequest, variables: Variables) -> Scales:
    """The largest displacement and velocity known of a motion without a record of it, and the shorter
    of the forcing period and 1."""
    struck = {*variables["impact_support"][1].tolist(), *variables["rest_support"][1].tolist()}
    reached = [abs(exciter.upper if support == 1 else exciter.lower) for support in struck]
    nu, clearance = exciter.nu, 2 * exciter.l
    forced = clearance * (exciter.f != 0)
    if (stiffness := abs(complex((1 - nu) * (1 + nu), exciter.h * nu))) > 0:
        forced = min(abs(exciter.f) / stiffness, forced)
    x = max(abs(request.x), abs(variables["displacement_end"][1]), forced, *reached, 0.0)
    speeds = np.abs(variables["impact_velocity"][1])
    v = max(abs(request.v), abs(variables["velocity_end"][1]), nu * forced, speeds.max(initial=0.0))
    return Scales(x, v, min(1.0, exciter.period))


def exact_errors(exciter: Exciter, request: MotionRequest, run: MotionResult) -> Errors:
    """Error of each quantity of an exact motion, by its name and in its shape."""
    variables = to_variables(exciter, request, run)
    errors = rounding_floor(exciter, request, variables)
    touches = run.contacts["grazing_tau"].size > 0
    steps = steps_for_exact(exciter.nu, exciter.h)
    for copy in range(COPIES):
        other, start = perturbed(exciter, request, copy, touches)
        grid = None
        if closed_form_solver(other, start) is None:
            grid = exact_grid_with_steps(request.effects, other.parameters(), steps + copy + 1)
        perturbed_variables = to_variables(other, start, run_motion(other, start, grid))
        for name, value in deviation(variables, perturbed_variables, {}).items():
            errors[name] = np.maximum(errors[name], SAFETY * value)
    return errors


def perturbed(
    exciter: Exciter, request: MotionRequest, copy: int, touches: bool
) -> tuple[Exciter, MotionRequest]:
    """The exciter and the start with every number moved by one unit in its last place, or by its doubt.

    Effects that are absent (0) and restitution 1 stay so; a start on a support stays on it, and an
    equilibrium at a support stays there.
    """
    signs = dict(zip((*PARAMETERS, "x", "v"), SIGNS[copy], strict=True))
    values = {name: getattr(exciter, name) * (1 + ULP * signs[name]) for name in PARAMETERS}
    if touches:
        # The search for contacts sets its tolerance by the lengths at hand in a step.
        lengths = exciter.l + abs(exciter.delta) + abs(exciter.f) / max(1.0, exciter.nu) ** 2
        values["l"] = exciter.l + 8 * GRAZING_TOLERANCE * lengths * (-1) ** copy
    if abs(exciter.delta) == exciter.l:
        values["delta"] = math.copysign(values["l"], exciter.delta)
    for name in ("R1", "R2"):
        values[name] = 1.0 if getattr(exciter, name) == 1.0 else min(values[name], 1.0)
    other = Exciter(**values)
    x = request.x + signs["x"] * max(ULP * abs(request.x), request.x_uncertainty)
    x = min(max(x, other.lower), other.upper)
    v = request.v + signs["v"] * max(ULP * abs(request.v), request.v_uncertainty)
    if request.x in (exciter.lower, exciter.upper):
        x = other.lower if request.x == exciter.lower else other.upper
        v = request.v if request.v == 0.0 else v
    return other, request._replace(x=x, v=v)


def rounding_floor(exciter: Exciter, request: MotionRequest, variables: Variables) -> Errors:
    """The least error of each quantity: a few roundings of its size, and its change over one of tau."""
    size = motion_scales(exciter, request, variables)
    pull = size.displacement + exciter.h * size.velocity + abs(exciter.f)
    late = ULP * request.tau_end
    x = 4 * ULP * size.displacement + late * size.velocity
    v = 4 * ULP * size.velocity + late * pull
    least = dict.fromkeys(
        ("velocity", "velocity_end", "impact_velocity", "impact_velocity_after"), v
    )
    least |= {"displacement": x, "displacement_end": x}
    energy = size.velocity * v + size.displacement * x
    contacts = variables["impact_tau"][1].size + 1
    least |= dict.fromkeys(TERMS, energy * contacts)
    least["force"] = abs(exciter.f) * (4 * ULP + 2 * exciter.nu * late)
    return {
        name: np.full(np.shape(values), least.get(name, 4 * late + 64 * ULP * size.time))
        for name, (_dims, values) in variables.items()
        if name not in ("tau", "status") and not name.endswith("support")
    }


def deviation(variables: Variables, others: Variables, own: Errors) -> Errors:
    """Distance of each quantity of a motion to that of another one, plus that one's own errors."""
    differences: Errors = {}
    for name in ("displacement", "velocity", "force", "displacement_end", "velocity_end", *TERMS):
        if name in variables and name in others:
            differences[name] = distance(variables[name][1], others[name][1]) + own.get(name, 0.0)
    for kind, names in CONTACT_COLUMNS.items():
        support = f"{kind}_support"
        when = CONTACT_TIMES[kind]
        partner = match_contacts(
            variables[when][1], variables[support][1], others[when][1], others[support][1]
        )
        for name in names:
            mine, theirs = variables[name][1], others[name][1]
            # A contact that the other motion does not have: it may not be, at any time.
            lone = np.abs(mine) if "velocity" in name else np.full(mine.shape, np.inf)
            differences[name] = lone
            there = partner >= 0
            expected = (
                own[name][partner[there]] if name in own and own[name].size == theirs.size else 0.0
            )
            differences[name][there] = distance(mine[there], theirs[partner[there]]) + expected
    if "velocity" in differences:
        differences["velocity"] = widen_at_jumps(variables, differences)
    return differences


def distance(one: Any, other: Any) -> np.ndarray:
    """|one - other|, 0 where both are infinite, inf where either is nan."""
    with np.errstate(invalid="ignore"):
        difference = np.abs(np.subtract(one, other))
    difference = np.where(np.asarray(one) == np.asarray(other), 0.0, difference)
    return np.where(np.isnan(difference), np.inf, difference)


def match_contacts(times: Any, supports: Any, other_times: Any, other_supports: Any) -> np.ndarray:
    """For each contact its place in another motion, -1 if it has none: one by one where both have
    the same contacts, else the nearest one in time on the same support."""
    if np.array_equal(supports, other_supports):
        return np.arange(len(times))
    partner = np.full(len(times), -1)
    for support in (1, 2):
        mine, theirs = (
            np.flatnonzero(supports == support),
            np.flatnonzero(other_supports == support),
        )
        if mine.size == 0 or theirs.size == 0:
            continue
        candidates = other_times[theirs]
        after = np.clip(np.searchsorted(candidates, times[mine]), 1, max(1, theirs.size - 1))
        before = after - 1
        after = np.minimum(after, theirs.size - 1)
        nearer = np.abs(candidates[before] - times[mine]) <= np.abs(candidates[after] - times[mine])
        partner[mine] = theirs[np.where(nearer, before, after)]
    return partner


def widen_at_jumps(variables: Variables, differences: Errors) -> np.ndarray:
    """Errors of the recorded velocity, with the whole jump where an impact may come before or after."""
    error, tau = differences["velocity"], variables["tau"][1]
    times, doubt = variables["impact_tau"][1], differences["impact_tau"]
    jumps = np.abs(variables["impact_velocity_after"][1] - variables["impact_velocity"][1])
    doubt = SAFETY * np.where(np.isfinite(doubt), doubt, 0.0) + 4 * ULP * np.abs(times)
    first = np.searchsorted(tau, times - doubt)
    last = np.searchsorted(tau, times + doubt, side="right")
    for i in np.flatnonzero(last > first):
        error[first[i] : last[i]] = np.maximum(error[first[i] : last[i]], jumps[i])
    return error


def largest_relative_error(
    variables: Variables, errors: Errors, sizes: Scales, accuracy: float
) -> float:
    """The largest error of the end state, of the rests, and of the impacts that are faster than
    `accuracy` of the motion's velocity, absolute or relative to its quantity's size, whichever is more.

    Slower impacts belong to a chatter, in which their number itself is a matter of accuracy.
    """
    fast = np.abs(variables["impact_velocity"][1]) > accuracy * min(1.0, sizes.velocity)
    kept = {
        "displacement": [errors["displacement_end"]],
        "velocity": [errors["velocity_end"], errors["impact_velocity"][fast]],
        "time": [errors["impact_tau"][fast], errors["rest_start"], errors["rest_end"]],
    }
    worst = 0.0
    for kind, values in kept.items():
        largest = max(float(np.max(value, initial=0.0)) for value in values)
        size = min(1.0, getattr(sizes, kind))
        if largest > 0.0:
            worst = max(worst, largest / size if size > 0.0 else math.inf)
    return worst
