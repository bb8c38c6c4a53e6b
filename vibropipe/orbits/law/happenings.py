"""The events of an orbit without the frames that they are written in, and the law that they make."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from vibropipe.march.piece_log import (
    BEYOND,
    CONTACT,
    ENTER,
    FREE,
    HELD,
    HOUSING_SLIP,
    HOUSING_STOP,
    IMPACT,
    LEAVE,
    RELEASE,
    RELOAD,
    REST_BEGINS,
    RESTING,
    SLIP,
    STICK,
    TURN,
    UNLOAD,
)
from vibropipe.orbits.law.law import WAY, Law
from vibropipe.orbits.law.sliding import way_of
from vibropipe.physics.contact import support_position
from vibropipe.physics.stiffness import lets_go


class Happening(NamedTuple):
    """An event without the frame that it is written in.

    side : support of a contact, or of its force; direction of x' after a slip; else 0
    t : time in forcing periods
    own : velocity x' just before a contact, an end of its force or a slip of the housing; displacement at a turn, a
        stick or its stop
    third : momentum q just before it where a housing slides; velocity x' where that stops
    way : direction in which a housing slides after it, 0 where that is held; None: that of an impact that pushes it
        off, else the one before
    """

    kind: int | np.int64
    side: int
    t: float
    own: float
    third: float = 0.0
    way: int | None = None

    def image(self, span: float) -> Happening:
        """Return the mirror image, a span later."""
        side = -self.side if self.kind == SLIP else 3 - self.side if self.side else 0
        way = None if self.way is None else -self.way
        return Happening(self.kind, side, self.t + span, -self.own, -self.third, way)


def followed_by(events: list[Happening], index: int, new: list[Happening]) -> list[Happening]:
    """Return events with others after one of them."""
    return [*events[: index + 1], *new, *events[index + 1 :]]


def happenings(law: Law, p: Any, u: np.ndarray) -> list[Happening]:
    """Return the events of an orbit, from its unknowns (n, w)."""
    listed = []
    for i, (kind, _form, home, direction, *_way) in enumerate(law.codes.tolist()):
        t, own, *third = u[i].tolist()
        if kind in (ENTER, UNLOAD, RELOAD, LEAVE, IMPACT, REST_BEGINS, RELEASE):
            event = Happening(kind, home, t, own)
        elif kind == SLIP:
            event = Happening(kind, -direction if home == 1 else direction, t, 0.0)
        elif kind == HOUSING_SLIP:
            event = Happening(kind, 0, t, own)
        else:
            event = Happening(kind, 0, t, own + reference_of(p, home))
        if third:
            event = event._replace(third=third[0], way=int(way_of(law, i)))
        listed.append(event)
    return listed


def reference_of(p: Any, home: int) -> float:
    """Return the displacement from which a frame counts."""
    return float(support_position(p, home)) if home > 0 else 0.0


def law_from(
    events: list[Happening], p: Any, span: float, mirrored: int
) -> tuple[Law, np.ndarray] | None:
    """Return the law of some events and its unknowns (n, w); None if they cannot follow each other."""
    events = _rotated(events, span, mirrored)
    home, inside, way, goes = 0, FREE, 0, 0
    if events and events[0].kind in (TURN, STICK):
        # Without contacts nothing else says which way it comes: from the equilibrium.
        way = 1 if events[0].own > 0.0 else -1
    width = 3 if p.mass_ratio > 0.0 else 2
    # What precedes the first event follows from the last: the second pass knows it.
    for passed in range(3):
        if passed and mirrored:
            home, way, goes = 3 - home if home else 0, -way, -goes
        codes, u = np.zeros((len(events), 2 + width), np.int8), np.zeros((len(events), width))
        is_held = rests = False
        for i, event in enumerate(events):
            kind, side, t, own, third, _way = event
            goes_on = _way_after(event, goes)
            if passed and not (
                _may_follow(kind, side, (home, inside, is_held, rests, way), p)
                and _may_move(event, goes, goes_on)
            ):
                return None
            u[i, :2] = t, own
            if width > 2 and goes:
                u[i, 2] = third
            if kind in (ENTER, LEAVE, IMPACT, REST_BEGINS, RELEASE):
                home, inside, rests = side, CONTACT if kind == ENTER else FREE, kind == REST_BEGINS
                way = (1 if side == 1 else -1) * (1 if kind == ENTER else -1)
                if rests:
                    way = 0
            elif kind in (UNLOAD, RELOAD):
                home, inside = side, BEYOND if kind == UNLOAD else CONTACT
                way = -1 if side == 1 else 1
            elif kind == SLIP:
                u[i, 1], is_held, way = 0.0, False, side
            elif kind != HOUSING_SLIP:
                u[i, 1] = own - reference_of(p, home)
                if kind != HOUSING_STOP:
                    is_held = kind == STICK
                    way = 0 if is_held else -way
            form = RESTING if rests else HELD if is_held else inside
            codes[i, :4] = kind, form, home, -way if home == 1 else way
            if width > 2:
                goes = goes_on
                codes[i, WAY] = -goes if home == 1 else goes
    return Law(codes, span, mirrored), u


def _way_after(event: Happening, before: int) -> int:
    """Return in which direction a housing slides after an event; before : that before it."""
    if event.way is not None:
        return event.way
    if event.kind in (IMPACT, REST_BEGINS) and before == 0:
        return 1 if event.side == 1 else -1
    return before


def _may_move(event: Happening, before: int, after: int) -> bool:
    """Return whether an event may change the direction in which a housing slides from one to another."""
    kind, pushed = event.kind, 1 if event.side == 1 else -1
    if kind == HOUSING_SLIP:
        return before == 0 and after != 0
    if kind == HOUSING_STOP:
        return before != 0 and after != before
    if kind in (IMPACT, REST_BEGINS):
        return after == pushed or (before != 0 and after == before)
    return before in (0, after)


def _may_follow(kind: Any, side: int, piece: tuple[int, int, bool, bool, int], p: Any) -> bool:
    """Return whether an event may happen in a piece: its frame, form, hold, rest, and direction of x'."""
    home, inside, is_held, rests, way = piece
    if kind in (HOUSING_SLIP, HOUSING_STOP):
        return not rests or kind == HOUSING_STOP
    if rests or kind == RELEASE:
        return rests and kind == RELEASE and side == home
    if kind == SLIP:
        return is_held
    if is_held:
        return False
    if inside == BEYOND or kind in (UNLOAD, RELOAD):
        follows = {UNLOAD: CONTACT, RELOAD: BEYOND, LEAVE: BEYOND}.get(kind)
        outwards = p.friction == 0.0 or way == (-1 if home == 1 else 1)
        return side == home and inside == follows and lets_go(p, home) and outwards
    if side and p.friction > 0.0 and way != (1 if (side == 1) == (kind != LEAVE) else -1):
        return False
    is_soft = side > 0 and (p.k1 if side == 1 else p.k2) > 0.0
    if kind in (ENTER, IMPACT, REST_BEGINS):
        return inside == FREE and is_soft == (kind == ENTER)
    leaves = inside == CONTACT and side == home and not lets_go(p, home)
    return leaves if kind == LEAVE else True


def _rotated(events: list[Happening], span: float, mirrored: int) -> list[Happening]:
    """Return events from one on that may be first: a contact, else an end of its force, a turn or stick, or a stop."""
    for kinds in ((ENTER, IMPACT, REST_BEGINS), (UNLOAD,), (TURN, STICK), (HOUSING_STOP,)):
        for i, event in enumerate(events):
            if event.kind in kinds:
                back = [e.image(span) if mirrored else e._replace(t=e.t + span) for e in events[:i]]
                return [*events[i:], *back]
    return events
