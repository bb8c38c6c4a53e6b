"""Where an orbit touches a support: from the end of a law, in its least number of periods, and on which piece."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibropipe.continuation.curve import Point
from vibropipe.march.piece_log import CAUSE, HOUSING_SLIP, HOUSING_STOP, IMPACT, STICK, TURN
from vibropipe.orbits.branches.grazing import NO_SPEED
from vibropipe.orbits.branches.symmetry import primitive
from vibropipe.orbits.law import least as of
from vibropipe.orbits.law.edits import edits
from vibropipe.orbits.law.happenings import Happening, happenings, law_from
from vibropipe.orbits.law.law import SECTION, Law, acts_in, without_events
from vibropipe.orbits.law.steps import (
    GAP,
    GAP_FLIGHT,
    GAP_SIDE,
    GAP_TIME,
    MARGIN,
    SLOW_EVENT,
    SPEED,
)

if TYPE_CHECKING:
    from vibropipe.orbits.boundaries.law_curve import LawBoundary

# Least margin of an orbit at the end of a law, and difference of the times of a turn and a touch that are one.
AT_END, SAME_TURN = 1e-6, 1e-4


def touch_beside(
    law: Law, events: np.ndarray, piece: int, side: int, time: float
) -> tuple[float, float, float] | None:
    """Return a touch as that of the piece beside, of the same flight, where its time lies on that; None if not.

    events : (n, w), the unknowns of events
    """
    kinds, n = law.codes[:, CAUSE], len(law.codes)
    following = (piece + 1) % n
    end = events[following, 0] + (law.span if following == 0 else 0.0)
    if time > end and kinds[following] in (HOUSING_SLIP, HOUSING_STOP):
        back = following == 0
        side = 3 - side if back and law.mirrored else side
        return following, side, time - law.span if back else time
    if time <= events[piece, 0] and kinds[piece] in (HOUSING_SLIP, HOUSING_STOP):
        back = piece == 0
        side = 3 - side if back and law.mirrored else side
        return (piece - 1) % n, side, time + law.span if back else time
    return None


class Grazing(NamedTuple):
    """An orbit that touches a support: its law, the unknowns of its events, and where it touches."""

    law: Law
    u: np.ndarray
    touch: tuple[float, float, float]


def _is_still(event: Happening, speed: float) -> bool:
    """Return whether an event is an impact without speed: what repeats strikes so in several of its periods."""
    return event.kind == IMPACT and abs(event.own) < NO_SPEED * speed


def grazing_at(point: Point) -> Grazing | None:
    """Return the orbit at the end of a law as one that touches a support there; None if it does not."""
    curve, law = point.curve, point.curve.sequence
    p, u = curve.parameters_of(point.u), curve.events_of(point.u)
    events = [] if law.codes[0, CAUSE] == SECTION else happenings(law, p, u)
    if abs(point.tests[SPEED]) < AT_END:
        slow = events[int(point.tests[SLOW_EVENT])]
        for kept in edits(curve.effects, law, p, u, point.tests, int(of.SPEED)):
            struck = [each for each in kept if not _is_still(each, curve.speed)]
            made = law_from(struck, p, law.span, law.mirrored)
            if not struck:
                empty = without_events(law.span, law.mirrored, law.codes.shape[1])
                made = empty, curve.state_at(point)[np.newaxis]
            if made is not None:
                return touching(*made, slow.side, slow.t)
        return None
    if int(point.tests[MARGIN]) != of.GAP or abs(point.tests[GAP]) > AT_END:
        return None
    piece, side, time = point.tests[[GAP_FLIGHT, GAP_SIDE, GAP_TIME]]
    if acts_in(law, int(piece)) or side == of.FORCE:
        return None
    return touching(law, u, int(side), float(time))


def in_least_periods(curve: LawBoundary, point: Point) -> Grazing | None:
    """Return a motion that touches a support in its least number of periods; None if it is written so already.

    Without contacts laws of any number of periods end in them; with some, those that strike once in several periods.
    """
    law, kinds = curve.sequence, curve.sequence.codes[:, CAUSE]
    if kinds[0] == SECTION:
        return None
    last = law.width * len(kinds)
    # A number in place of the parameter that ends the unknowns of a branch.
    u, weights = np.append(point.u[:last], 0.0), np.append(curve.weights[:last], 0.0)
    least, events = primitive(law, u, weights, curve.box.symmetric)
    if least is law:
        return None
    _turn, side, time = curve.touched
    return touching(least, events[:-1].reshape(law.width, -1).T, int(side), float(time))


def touching(law: Law, u: np.ndarray, side: int, time: float) -> Grazing:
    """Return an orbit that touches a support at a time, of whichever turn or piece."""
    n, kinds = len(u), law.codes[:, CAUSE]
    if kinds[0] == SECTION:  # a linear motion has the period of the force
        return Grazing(law._replace(span=1.0, mirrored=0), u, (0.0, float(side), time % 1.0))
    laps, at = divmod(time - float(u[0, 0]), law.span)
    at += float(u[0, 0])
    if law.mirrored and int(laps) % 2:
        side = 3 - side
    turns = np.flatnonzero(np.isin(kinds, (TURN, STICK)))
    if turns.size:
        away = np.abs((u[turns, 0] - at + 0.5 * law.span) % law.span - 0.5 * law.span)
        nearest = int(turns[away.argmin()])
        if away.min() < SAME_TURN:
            if law.mirrored and abs(u[nearest, 0] - at) > 0.5 * law.span:
                side = 3 - side
            return Grazing(law, u, (float(nearest), float(side), float(u[nearest, 0])))
    piece = int(np.searchsorted(u[:, 0], at, "right")) - 1
    return Grazing(law, u, (float(max(0, min(piece, n - 1))), float(side), at))
