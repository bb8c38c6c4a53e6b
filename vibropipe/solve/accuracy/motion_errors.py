"""Error estimates for the quantities of a motion.

The only error of the exact method is rounding, amplified along the motion. While it stays small, a model of rounding
tells it from the impacts (`accuracy.rounding`). Else, and with rests, touches, soft supports, friction or a balance of
energy, the motion is computed COPIES more times, on grids with other steps, which round differently, and from
parameters perturbed by one unit in the last place, their own uncertainty. The estimate is SAFETY times the largest
difference. If the motion touches a support within rounding, so that impact and miss cannot be distinguished, the
supports are perturbed by that tolerance. The error of a Newmark motion is its distance to the exact motion plus the
error of that.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.grid import exact_grid_with_steps
from vibropipe.orbits.sensitivity.errors import ULP
from vibropipe.physics.contact import GRAZING_TOLERANCE
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.flow import steps_for_exact
from vibropipe.physics.load import fastest_of_row
from vibropipe.physics.start import within_room
from vibropipe.solve.accuracy.rounding import rounding_errors
from vibropipe.solve.motion.closed_motion import closed_form_solver
from vibropipe.solve.motion.motion_dataset import to_variables
from vibropipe.solve.motion.run import MotionRequest, MotionResult, run_motion
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.vocabulary import ENERGIES, EVENTS

COPIES = 3
SAFETY = 2.0
# Numbers of a motion that each copy perturbs.
PERTURBED = (*PARAMETERS, "x", "v")

Variables = dict[str, Any]
Errors = dict[str, np.ndarray]


class Scales(NamedTuple):
    """Scales of displacement and velocity of a motion, and its unit of time."""

    displacement: float
    velocity: float
    time: float


def motion_scales(exciter: Exciter, request: MotionRequest, variables: Variables) -> Scales:
    """Return the scales of a motion, from what is available without samples.

    They are the largest displacement and velocity at the start, the end and the contacts and of the forced vibration,
    and the smaller of the forcing period and 1.
    """
    support, velocity = variables["impact_support"][1], variables["impact_velocity"][1]
    upper, lower, fastest = _touched(support, variables["rest_support"][1], velocity)
    support_x = max(upper * abs(exciter.upper), lower * abs(exciter.lower))
    nu, clearance = exciter.nu, 2 * exciter.l
    forced = clearance * (exciter.f != 0)
    if (stiffness := abs(complex((1 - nu) * (1 + nu), exciter.h * nu))) > 0:
        forced = min(abs(exciter.f) / stiffness, forced)
    if exciter.f2:
        nu *= 2
        forced = clearance
    x = max(abs(request.x), abs(variables["displacement_end"][1]), forced, support_x)
    v = max(abs(request.v), abs(variables["velocity_end"][1]), nu * forced, fastest)
    return Scales(x, v, min(1.0, exciter.period))


@jit
def _touched(
    struck: np.ndarray, rested: np.ndarray, velocity: np.ndarray
) -> tuple[bool, bool, float]:
    """Return whether either support is touched, from the supports of impacts and of rests, and the largest speed."""
    upper, lower, fastest = False, False, 0.0
    for supports in (struck, rested):
        for support in supports:
            upper, lower = upper or support == 1, lower or support == 2
    for v in velocity:
        fastest = max(fastest, abs(v))
    return upper, lower, fastest


def largest(values: np.ndarray) -> float:
    """Return the largest magnitude of an array; 0 of an empty one."""
    return float(max(values.max(), -values.min())) if values.size else 0.0


def exact_errors(
    exciter: Exciter,
    request: MotionRequest,
    run: MotionResult,
    variables: Variables,
    scales: Scales,
) -> Errors:
    """Return the error estimate of each quantity of an exact motion, by name and in its shape.

    variables : the motion (`to_variables`); scales : of it (`motion_scales`).
    """
    least = rounding_floor(exciter, request, variables, scales)
    # A sample lies where its tau does, which is rounded.
    floor = least.get("displacement", 0.0), least.get("velocity", 0.0)
    known = rounding_errors(exciter, request, run, floor) or {}
    errors = filled({name: least[name] for name in least if name not in known}, variables)
    if known:
        return errors | known
    touches = run.contacts["grazing_tau"].size > 0
    steps = steps_for_exact(exciter.nu, exciter.h, fastest_of_row(exciter.parameters()))
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
    """Return exciter and start with every number moved by one unit in the last place, or by its uncertainty.

    Numbers at an end of their range are kept. A start on a support stays on it, and so does an equilibrium.
    """
    # bits of 0, 3, 6, ...: neighbours, such as l and delta, differ in some copies and agree in others
    signs = {name: 1 - 2 * (3 * n >> copy & 1) for n, name in enumerate(PERTURBED)}
    stated = exciter.numbers()._asdict()
    values = {name: value * (1 + ULP * signs[name]) for name, value in stated.items()}
    if touches:
        # The tolerance of the search for contacts scales with the lengths that occur in a step.
        offsets = abs(exciter.delta) + abs(exciter.load)
        force = abs(exciter.f) + abs(exciter.f2)
        lengths = exciter.l + offsets + force / max(1.0, exciter.nu) ** 2
        values["l"] = exciter.l + 8 * GRAZING_TOLERANCE * lengths * (-1) ** copy
    offset = exciter.delta - exciter.load
    if abs(offset) == exciter.l:
        values["delta"] = values["load"] + math.copysign(values["l"], offset)
    for name, value in stated.items():
        low, high = PARAMETERS[name].range.low, PARAMETERS[name].range.high
        values[name] = value if value in (low, high) else min(max(low, values[name]), high)
    other = Exciter(**values)
    x = request.x + signs["x"] * max(ULP * abs(request.x), request.x_uncertainty)
    x = within_room(other, x)
    v = request.v + signs["v"] * max(ULP * abs(request.v), request.v_uncertainty)
    if request.x in (exciter.lower, exciter.upper):
        x = other.lower if request.x == exciter.lower else other.upper
        v = request.v if request.v == 0.0 else v
    return other, request._replace(x=x, v=v)


def rounding_floor(
    exciter: Exciter, request: MotionRequest, variables: Variables, scales: Scales
) -> dict[str, float]:
    """Return the least error of each quantity: some roundings of its scale, and its change over one rounding of tau."""
    max_acceleration = scales.displacement + exciter.h * scales.velocity + abs(exciter.f)
    max_acceleration += abs(exciter.load) + abs(exciter.f2)
    tau_error = ULP * request.tau_end
    x = 4 * ULP * scales.displacement + tau_error * scales.velocity
    v = 4 * ULP * scales.velocity + tau_error * max_acceleration
    least = dict.fromkeys(
        ("velocity", "velocity_end", "impact_velocity", "impact_velocity_after"), v
    )
    least |= {"displacement": x, "displacement_end": x, "contact_depth_max": x}
    least["contact_force_max"] = max(
        k * x + h * v for k, h in ((exciter.k1, exciter.h1), (exciter.k2, exciter.h2))
    )
    energy = scales.velocity * v + scales.displacement * x
    contacts = variables["impact_tau"][1].size + 1
    least |= dict.fromkeys(ENERGIES, energy * contacts)
    force = abs(exciter.f) + 2 * abs(exciter.f2)
    least["force"] = force * (4 * ULP + 2 * exciter.nu * tau_error)
    return {
        name: least.get(name, 4 * tau_error + 64 * ULP * scales.time)
        for name in variables
        if name not in ("tau", "status") and not name.endswith("support")
    }


def filled(least: dict[str, float], variables: Variables) -> Errors:
    """Return errors that are the same in all entries of a quantity, in its shape, each stored once (read-only)."""
    shapes = {name: np.shape(variables[name][1]) for name in least}
    return {
        name: np.broadcast_to(value, shapes[name]) if shapes[name] != (0,) else np.empty(0)
        for name, value in least.items()
    }


def deviation(variables: Variables, others: Variables, errors: Errors) -> Errors:
    """Return the distance of each quantity of a motion to that of another, plus the errors of the other.

    They are in the shape of each quantity. `variables` and `others` are as of `to_variables`; `errors`, of the other
    motion, may be empty.
    """
    differences: Errors = {}
    for name in (
        "displacement",
        "velocity",
        "force",
        "displacement_end",
        "velocity_end",
        *ENERGIES,
    ):
        if name in variables and name in others:
            own = errors.get(name, 0.0)
            differences[name] = distance(variables[name][1], others[name][1]) + own
    for kind, names in EVENTS.items():  # matched by the first, their times
        support_name = f"{kind}_support"
        time = names[0]
        if time not in variables:
            continue
        times, other_times = variables[time][1], others[time][1]
        # Turning points and sticks are at no support.
        supports, other_supports = np.ones(times.size, int), np.ones(other_times.size, int)
        if support_name in variables:
            supports, other_supports = variables[support_name][1], others[support_name][1]
        partner = match_contacts(times, supports, other_times, other_supports)
        for name in names:
            if name not in variables:
                continue
            mine, theirs = variables[name][1], others[name][1]
            # Contact without counterpart: its time error is infinite, its velocity error the full velocity.
            error = np.abs(mine) if "velocity" in name else np.full(mine.shape, np.inf)
            matched = partner >= 0
            nearest = partner[matched]
            has_errors = name in errors and errors[name].size == theirs.size
            own = errors[name][nearest] if has_errors else 0.0
            error[matched] = distance(mine[matched], theirs[nearest]) + own
            # Neither an impact on a rigid support nor a contact that has not ended has a duration.
            error[matched] += np.where(
                np.isnan(mine[matched]) & np.isnan(theirs[nearest]), np.nan, 0
            )
            differences[name] = error
    if "velocity" in differences:
        differences["velocity"] = widen_at_jumps(variables, differences)
    return differences


def distance(one: Any, other: Any) -> np.ndarray:
    """Return |one - other|: 0 where both are infinite, inf where either is NaN."""
    with np.errstate(invalid="ignore"):
        difference = np.abs(np.subtract(one, other))
    difference = np.where(np.asarray(one) == np.asarray(other), 0.0, difference)
    return np.where(np.isnan(difference), np.inf, difference)


def match_contacts(times: Any, supports: Any, other_times: Any, other_supports: Any) -> np.ndarray:
    """Match the contacts of a motion with those of another.

    If both motions touch the same supports in the same order, contacts are matched one by one, otherwise with the
    nearest in time on the same support.

    times, supports : (n,), contacts of the motion, in order of time
    other_times, other_supports : (k,), contacts of the other motion, in order of time
    Returns the index (n,) of each counterpart, -1 if there is none.
    """
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
    """Return the errors of the sampled velocity, with the whole jump near the times of uncertain impacts."""
    error, tau = differences["velocity"], variables["tau"][1]
    times, spread = variables["impact_tau"][1], differences["impact_tau"]
    jumps = np.abs(variables["impact_velocity_after"][1] - variables["impact_velocity"][1])
    if "contact_duration" in variables:  # the velocity is continuous at a soft support
        jumps[np.isnan(jumps) | ~np.isnan(variables["contact_duration"][1])] = 0.0
    spread = SAFETY * np.where(np.isfinite(spread), spread, 0.0) + 4 * ULP * np.abs(times)
    first = np.searchsorted(tau, times - spread)
    last = np.searchsorted(tau, times + spread, side="right")
    for i in np.flatnonzero(last > first):
        error[first[i] : last[i]] = np.maximum(error[first[i] : last[i]], jumps[i])
    return error
