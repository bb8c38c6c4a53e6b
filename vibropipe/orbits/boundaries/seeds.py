"""Where boundaries begin: the bifurcations of branches, written as points of a boundary."""

from __future__ import annotations

from typing import Any

import numpy as np

from vibropipe.continuation.curve import Point
from vibropipe.continuation.path import Event
from vibropipe.orbits.boundaries.curve import FLIPS, GRAZINGS, PITCHFORKS, Box
from vibropipe.orbits.boundaries.law_curve import LawBoundary
from vibropipe.orbits.boundaries.touches import Grazing, grazing_at, in_least_periods, touching
from vibropipe.orbits.branches.following import Branch
from vibropipe.orbits.branches.linear import linear_state, linear_touch
from vibropipe.orbits.branches.symmetry import halved
from vibropipe.orbits.law.curve import NO_TOUCH as BY_LAW
from vibropipe.orbits.law.law import Law, without_events
from vibropipe.orbits.law.marching import Marcher
from vibropipe.orbits.law.problem import Scales
from vibropipe.orbits.row import row_parameters

# Orbits with more contacts are left out: towards chatter, and in cascades of flips, there are any number of them.
MAX_CONTACTS = 24
# Distance of a seed from the bifurcation that it begins at, weighted.
SEED_REACH = 1e-3


def begin(
    box: Box, branch: Branch, event: Event, kind: int, marcher: Marcher
) -> tuple[LawBoundary, Point] | None:
    """Return the boundary that passes through a bifurcation of a branch, and its point there; None if there is none.

    branch : along one of the parameters of the box; its problem holds the other
    kind : a `Bifurcation`
    """
    if branch.curve is None:
        values = branch.problem.values_at(branch.values[event.point])
        p = row_parameters(values.reshape(1, -1), 0)
        law, u, touch = linear_grazing(p)
        scales = Scales(p.l, p.l * p.nu)
        return begin_at(box, kind, law, u.ravel(), touch, values[box.along], scales, marcher)
    point = branch.points[event.point]
    law, u, touch = point.curve.sequence, point.u, BY_LAW
    ends = branch.problem.values_at(point.value)[box.along]
    if kind == GRAZINGS:
        grazing = grazing_at(point)
        if grazing is None:
            return None
        law, u, touch = grazing.law, grazing.u.T.ravel(), grazing.touch
    elif event.reason == "doubled":
        law, u = halved(law, u, event.kind)
    u = u[: law.width * len(law.codes)]
    return begin_at(box, kind, law, u, touch, ends, point.curve.scales, marcher)


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
    least = in_least_periods(*begun) if begun is not None and kind == GRAZINGS else None
    if begun is None or least is None:
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
