"""Motions in closed form: conservative ones (h = f = 0, R1 = R2 = 1), and linear ones, which reach no support."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from vibropipe.compiler import jit
from vibropipe.march.log import new_log
from vibropipe.physics.conservative import (
    Arc,
    arc,
    arc_state,
    is_conservative,
    speed_at,
    top_support,
)
from vibropipe.physics.exciter import Exciter, Parameters
from vibropipe.physics.flow import free_flow
from vibropipe.physics.linear import stays_off_supports, steady_at
from vibropipe.physics.load import forcing_period
from vibropipe.solve.motion.contacts import Contacts, contacts_of, drain_log

if TYPE_CHECKING:
    from vibropipe.solve.motion.run import MotionRequest

# Contacts, and displacement and velocity at the samples and at the end.
Solution = tuple[Contacts, np.ndarray, np.ndarray]
# Times, supports and velocities before contact of the contacts with one support.
Columns = tuple[np.ndarray, np.ndarray, np.ndarray]
NO_CONTACTS: Columns = np.empty(0), np.empty(0, np.int8), np.empty(0)


def closed_form_solver(exciter: Exciter, request: MotionRequest) -> Callable[..., Solution] | None:
    """Return the function that solves a motion in closed form, or None if it has to be marched.

    A conservative motion and one that reaches no support have a closed form: f(exciter, request, turns, after) returns
    contacts and the states at the samples and at the end.
    """
    p, x, effects = exciter.parameters(), request.x - exciter.load, request.effects
    if effects.friction is not None or effects.housing is not None:
        return None
    is_rigid = effects.soft is None and effects.watched is None
    if is_rigid and is_conservative(p, x, request.v):
        return _conservative
    phase = request.tau_start * exciter.nu / (2 * math.pi) % 1.0
    return _linear if stays_off_supports(p, x, request.v, phase) else None


def _linear(
    exciter: Exciter, request: MotionRequest, turns: tuple[float, float], after: np.ndarray
) -> Solution:
    """Return a motion that reaches no support."""
    start, end = turns
    after = np.append(after, end - start)
    xs, vs = np.empty(after.size), np.empty(after.size)
    _sample_linear(exciter.parameters(), request.x, request.v, start % 1.0, after, xs, vs)
    if end == start:
        xs[-1], vs[-1] = request.x, request.v
    return contacts_of(drain_log(new_log(1, 1)), 1.0), xs, vs


def _conservative(
    exciter: Exciter, request: MotionRequest, _turns: tuple[float, float], after: np.ndarray
) -> Solution:
    """Return a conservative motion."""
    x, v, span = request.x, request.v, request.tau_end - request.tau_start
    motion = arc(exciter.parameters(), x, v)
    tau = np.append(after * exciter.period, span)
    xs, vs = np.empty(tau.size), np.empty(tau.size)
    _sample(motion, tau, xs, vs)
    impacts = contacts(motion, span, x, v, exciter.upper, exciter.lower)
    for name in ("impact_tau", "grazing_tau"):
        impacts[name] += request.tau_start
    return impacts, np.clip(xs, exciter.lower, exciter.upper), vs


@jit
def _sample(a: Arc, tau: np.ndarray, x: np.ndarray, v: np.ndarray) -> None:
    """Fill x and v with the motion at the times tau (n,) after its start."""
    for i in range(tau.size):
        x[i], v[i] = arc_state(a, tau[i])


def _times(a: Arc, offset: float, span: float, moves_outwards: bool) -> np.ndarray:
    """Return the times in [0, span] at which the mass is at one end of the motion.

    `offset` is the time from the upper end to this end. A contact at the start counts if the mass moves outwards.
    """
    period = 2 * a.half
    first = offset - a.time_from_top
    if first < 0 or (first == 0 and not moves_outwards):
        first += period
    return first + period * np.arange(max(0, math.floor((span - first) / period) + 1))


def contacts(a: Arc, span: float, x: float, v: float, upper: float, lower: float) -> Contacts:
    """Compute the impacts and grazings of a free motion.

    They are the columns of `simulate` in order of time, with times from the start and no rests.

    span : length of the motion, in tau
    x, v : its start
    upper, lower : displacement of support 1 and of support 2
    """
    impacts: list[Columns] = []
    grazings: list[Columns] = []
    top = top_support(a)
    for support, offset, meets in ((top, 0.0, a.meets_top), (3 - top, a.half, a.meets_bottom)):
        if meets == 0:
            continue
        sign, support_x = (1, upper) if support == 1 else (-1, lower)
        times = _times(a, offset, span, sign * v > 0 or meets == 2)
        before = np.full(times.size, sign * speed_at(x, v, support_x))
        columns = times, np.full(times.size, support, np.int8), before
        (grazings if meets == 2 else impacts).append(columns)
    impact_tau, impact_support, before = _in_order(impacts)
    grazing_tau, grazing_support, _ = _in_order(grazings)
    return {
        "impact_tau": impact_tau,
        "impact_support": impact_support,
        "impact_velocity": before,
        "impact_velocity_after": -before,
        "rest_start": np.empty(0),
        "rest_end": np.empty(0),
        "rest_support": np.empty(0, np.int8),
        "grazing_tau": grazing_tau,
        "grazing_support": grazing_support,
    }


def _in_order(contacts: list[Columns]) -> list[np.ndarray]:
    """Merge the contacts with each support into columns in order of time."""
    # The motion reaches its ends alternately, so that interleaving replaces sorting.
    ordered = sorted((each for each in contacts if each[0].size > 0), key=lambda each: each[0][0])
    columns = []
    for parts in zip(*ordered or [NO_CONTACTS], strict=True):
        column = np.empty(sum(part.size for part in parts), parts[0].dtype)
        for i, part in enumerate(parts):
            column[i :: len(parts)] = part
        columns.append(column)
    return columns


@jit
def _sample_linear(
    p: Parameters,
    x: float,
    v: float,
    phase: float,
    after: np.ndarray,
    xs: np.ndarray,
    vs: np.ndarray,
) -> None:
    """Fill xs and vs with the motion from (x, v) at a phase, in turns, at the times `after` (n,) in forcing periods."""
    steady_x, steady_v = steady_at(p, phase)
    dx, dv = x - steady_x, v - steady_v
    for i in range(after.size):
        e11, e12, e21, e22 = free_flow(p.h, after[i] * forcing_period(p))
        steady_x, steady_v = steady_at(p, phase + after[i] % 1.0)
        xs[i] = steady_x + (e11 * dx + e12 * dv)
        vs[i] = steady_v + (e21 * dx + e22 * dv)
