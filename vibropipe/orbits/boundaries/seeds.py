"""Where boundaries begin: the bifurcations of branches, written as points of a boundary."""

from __future__ import annotations

from typing import Any

import numpy as np

from vibropipe.continuation.curve import Point
from vibropipe.continuation.path import Event
from vibropipe.march.piece_log import CAUSE, HOME
from vibropipe.orbits.boundaries.curve import NO_TOUCH, BoundaryCurve, Box, Touch
from vibropipe.orbits.boundaries.law_curve import LawBoundary
from vibropipe.orbits.boundaries.system import FLIPS, GRAZINGS, KINDS, PITCHFORKS
from vibropipe.orbits.boundaries.touches import Grazing, grazing_at, in_least_periods, touching
from vibropipe.orbits.branches.following import Branch
from vibropipe.orbits.branches.linear import linear_state, linear_touch
from vibropipe.orbits.branches.sequence import Sequence
from vibropipe.orbits.branches.symmetry import halved
from vibropipe.orbits.law.curve import NO_TOUCH as BY_LAW
from vibropipe.orbits.law.law import SECTION, Law, without_events
from vibropipe.orbits.law.marching import Marcher
from vibropipe.orbits.law.problem import Scales
from vibropipe.orbits.row import row_parameters

# Orbits with more contacts are left out: towards chatter, and in cascades of flips, there are any number of them.
MAX_CONTACTS = 24
# Distance of a seed from the bifurcation that it begins at, weighted.
SEED_REACH = 1e-3


def begin(box: Box, branch: Branch, event: Event) -> tuple[BoundaryCurve, Point] | None:
    """Return the boundary that passes through a bifurcation of a branch, and its point there; None if there is none.

    Parameters
    ----------
    box : Box
    branch : Branch
        Along one of the parameters of the box; its problem holds the other.
    event : Event
    """
    if branch.curve is None:
        values = branch.problem.values_at(branch.values[event.point])
        return begin_linear(box, values[box.along], values)
    kind, values = KINDS[event.kind], branch.problem.values_at(branch.points[event.point].value)
    ends, orbit = values[box.along], _orbit_at(branch, event, kind)
    if orbit is None:
        return None
    if orbit.law.codes[0, CAUSE] == SECTION:
        return begin_linear(box, ends, values)
    if kind == GRAZINGS:
        weights = np.repeat([1.0, 1.0 / branch.curve.speed], len(orbit.u))
        orbit = in_least_periods(orbit, weights, box.symmetric) or orbit
    law, u, (flight, side, time) = orbit
    sequence = Sequence(law.m, law.mirrored, law.codes[:, HOME].copy())
    touch, timed = NO_TOUCH, []
    if kind == GRAZINGS:
        touch, timed = Touch(int(flight), int(side)), [time]
    # Velocities of the orbit itself: a branch may have begun with others.
    curve = BoundaryCurve(box, kind, sequence, touch, float(np.abs(u[:, 1]).max()))
    return settled(curve, np.concatenate([u.T.ravel(), timed, ends]))


def _orbit_at(branch: Branch, event: Event, kind: int) -> Grazing | None:
    """Return the orbit of a bifurcation of a branch; None where it should touch a support and does not."""
    point = branch.points[event.point]
    curve: Any = branch.curve if point.curve is None else point.curve
    if kind == GRAZINGS:
        return grazing_at(point._replace(curve=curve))
    law, u = curve.sequence, point.u
    if event.reason == "doubled":
        law, u = halved(law, u, event.kind)
    return Grazing(law, u[: law.width * len(law.codes)].reshape(law.width, -1).T, BY_LAW)


def begin_law(
    box: Box, branch: Branch, event: Event, kind: int, marcher: Marcher
) -> tuple[LawBoundary, Point] | None:
    """Return the boundary by its law that passes through a bifurcation of a branch, and its point there, or None.

    Parameters
    ----------
    box, branch, event
        As for `begin`.
    kind : int
        A `Bifurcation`.
    marcher : Marcher
    """
    if branch.curve is None:
        values = branch.problem.values_at(branch.values[event.point])
        p = row_parameters(values.reshape(1, -1), 0)
        law, u, touch = linear_grazing(p)
        scales = Scales(p.l, p.l * p.nu)
        return begin_at(box, kind, law, u.ravel(), touch, values[box.along], scales, marcher)
    orbit, point = _orbit_at(branch, event, kind), branch.points[event.point]
    if orbit is None:
        return None
    scales = (point.curve or branch.curve).scales
    ends = branch.problem.values_at(point.value)[box.along]
    return begin_at(box, kind, orbit.law, orbit.u.T.ravel(), orbit.touch, ends, scales, marcher)


def linear_grazing(p: Any) -> Grazing:
    """Return the motion without impacts where it touches the support that it comes nearest to; p : its parameters."""
    return touching(without_events(1.0, 0), np.array([linear_state(p)]), *linear_touch(p))


def begin_at(
    box: Box,
    kind: int,
    law: Law,
    u: np.ndarray,
    touch: tuple[float, float, float],
    ends: np.ndarray,
    scales: Scales,
    marcher: Marcher,
) -> tuple[LawBoundary, Point] | None:
    """Return the boundary of a law near some events and both parameters, and its point there; None if there is none."""
    # A pitchfork is that of a law of half of the orbit.
    if (kind == PITCHFORKS) != bool(law.mirrored) and kind in (PITCHFORKS, FLIPS):
        return None
    curve = LawBoundary(box, kind, law, touch, scales, marcher)
    if sum(curve.contacts()) > MAX_CONTACTS:
        return None
    begun = settled(curve, np.concatenate([u, ends]))
    if begun is None or kind != GRAZINGS or law.has_contacts:
        return begun
    last = law.width * len(law.codes)
    orbit = Grazing(law, begun[1].u[:last].reshape(law.width, -1).T, curve.touched)
    least = in_least_periods(orbit, curve.weights[:last], box.symmetric)
    if least is None:
        return begun
    again = LawBoundary(box, kind, least.law, least.touch, scales, marcher)
    return settled(again, np.concatenate([least.u.T.ravel(), begun[1].u[-2:]]))


def settled(curve: Any, u: np.ndarray, reach: float = SEED_REACH) -> tuple[Any, Point] | None:
    """Return a boundary and its point within reach of u, with one of both parameters held; None if there is none."""
    for fixed in (-1, -2):
        point = curve.settle(u, fixed)
        if point is not None and curve.weighted(point.u - u) < reach:
            return curve, point
    return None


def begin_linear(
    box: Box, ends: np.ndarray, values: np.ndarray
) -> tuple[BoundaryCurve, Point] | None:
    """Return the boundary of the motion without impacts near some parameters."""
    side, time = linear_touch(row_parameters(values.reshape(1, -1), 0))
    sequence = Sequence(1, 0, np.zeros(0, np.int8))
    curve = BoundaryCurve(box, GRAZINGS, sequence, Touch(0, side), 1.0)
    return settled(curve, np.array([time, *ends]))
