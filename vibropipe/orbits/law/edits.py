"""What law follows where a margin of another reaches zero: the orbit of the end is an orbit of both."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from vibropipe.march.piece_log import (
    CAUSE,
    CONTACT,
    ENTER,
    FREE,
    HELD,
    HOME,
    IMPACT,
    LEAVE,
    RELEASE,
    REST_BEGINS,
    RESTING,
    SLIP,
    STICK,
    TURN,
)
from vibropipe.orbits.law import margins as of
from vibropipe.orbits.law.law import SECTION, Law, acts_in
from vibropipe.orbits.law.states import state_within
from vibropipe.orbits.law.steps import GAP_FLIGHT, GAP_SIDE, GAP_TIME, SLOW_EVENT
from vibropipe.physics.contact import support_position
from vibropipe.physics.effects import Effects

# Difference of times, in forcing periods, and of displacements that are one.
SAME_TIME, SAME_X = 1e-9, 1e-9


class Happening(NamedTuple):
    """An event without the frame that it is written in.

    Attributes
    ----------
    kind : int
    side : int
        Support of a contact; direction of x' after a slip; else 0.
    t : float
        Time in forcing periods.
    own : float
        Velocity x' just before a contact; displacement at a turn or a stick.
    """

    kind: int | np.int64
    side: int
    t: float
    own: float

    def image(self, span: float) -> Happening:
        """Return the mirror image, a span later."""
        side = -self.side if self.kind == SLIP else 3 - self.side if self.side else 0
        return Happening(self.kind, side, self.t + span, -self.own)


def happenings(law: Law, p: Any, u: np.ndarray) -> list[Happening]:
    """Return the events of an orbit, from its unknowns (n, 2)."""
    listed = []
    for i, (kind, _form, home, direction) in enumerate(law.codes.tolist()):
        t, own = u[i].tolist()
        if kind in (ENTER, LEAVE, IMPACT, REST_BEGINS, RELEASE):
            listed.append(Happening(kind, home, t, own))
        elif kind == SLIP:
            listed.append(Happening(kind, -direction if home == 1 else direction, t, 0.0))
        else:
            listed.append(Happening(kind, 0, t, own + _reference(p, home)))
    return listed


def _reference(p: Any, home: int) -> float:
    """Return the displacement from which a frame counts."""
    return float(support_position(p, home)) if home > 0 else 0.0


def law_from(
    events: list[Happening], p: Any, span: float, mirrored: int
) -> tuple[Law, np.ndarray] | None:
    """Return the law of some events and its unknowns (n, 2); None if they cannot follow each other."""
    events = _rotated(events, span, mirrored)
    home, inside, way = 0, False, 0
    # What precedes the first event follows from the last: the second pass knows it.
    for passed in range(3):
        if passed and mirrored:
            home, way = 3 - home if home else 0, -way
        codes, u = np.zeros((len(events), 4), np.int8), np.zeros((len(events), 2))
        is_held = rests = False
        for i, (kind, side, t, own) in enumerate(events):
            if passed and not _may_follow(kind, side, (home, inside, is_held, rests, way), p):
                return None
            u[i] = t, own
            if kind in (ENTER, LEAVE, IMPACT, REST_BEGINS, RELEASE):
                home, inside, rests = side, kind == ENTER, kind == REST_BEGINS
                way = (1 if side == 1 else -1) * (1 if kind == ENTER else -1)
                if rests:
                    way = 0
            elif kind == SLIP:
                u[i, 1], is_held, way = 0.0, False, side
            else:
                u[i, 1] = own - _reference(p, home)
                is_held = kind == STICK
                way = 0 if is_held else -way
            form = RESTING if rests else HELD if is_held else CONTACT if inside else FREE
            codes[i] = kind, form, home, -way if home == 1 else way
    return Law(codes, span, mirrored), u


def _may_follow(kind: Any, side: int, piece: tuple[int, bool, bool, bool, int], p: Any) -> bool:
    """Return whether an event may happen in a piece: its frame, contact, hold, rest, and direction of x'."""
    home, inside, is_held, rests, way = piece
    if rests or kind == RELEASE:
        return rests and kind == RELEASE and side == home
    if kind == SLIP:
        return is_held
    if is_held:
        return False
    if side and p.friction > 0.0 and way != (1 if (side == 1) == (kind != LEAVE) else -1):
        return False
    is_soft = side > 0 and (p.k1 if side == 1 else p.k2) > 0.0
    if kind in (ENTER, IMPACT, REST_BEGINS):
        return not inside and is_soft == (kind == ENTER)
    return (inside and side == home) if kind == LEAVE else True


def _rotated(events: list[Happening], span: float, mirrored: int) -> list[Happening]:
    """Return events from the first one on that may come first: a contact, or a turn or stick where there is none."""
    for kinds in ((ENTER, IMPACT, REST_BEGINS), (TURN, STICK)):
        for i, event in enumerate(events):
            if event.kind in kinds:
                back = [e.image(span) if mirrored else e._replace(t=e.t + span) for e in events[:i]]
                return [*events[i:], *back]
    return events


def edits(
    e: Effects, law: Law, p: Any, u: np.ndarray, tests: np.ndarray, margin: int
) -> Iterator[list[Happening]]:
    """Yield the events of the laws that may follow the end of another.

    Parameters
    ----------
    e, law, p : Effects, Law, Parameters
    u : (n, 2) float
        Unknowns at the end.
    tests : (TESTS + 2,) float
        Tests of the point there, as `LawCurve` has them.
    margin : int
        The kind of the margin that is zero.
    """
    events = happenings(law, p, u)
    index = int(tests[SLOW_EVENT] if margin == of.SPEED else tests[GAP_FLIGHT])
    time, side, n = float(tests[GAP_TIME]), int(tests[GAP_SIDE]), len(events)
    if law.codes[0, CAUSE] == SECTION:
        events, index, n = [], -1, 0
    if margin == of.SPEED:
        yield from without_contact(events, index, p)
    elif margin == of.SPAN:
        yield from _without_piece(events, index)
    elif margin == of.GAP:
        # A flight that turns against friction turns at its end.
        for later, event in ((0.0, events[(index + 1) % n]), (law.span, events[0])) if n else ():
            is_turn = event.kind in (TURN, STICK) and abs(event.t + later - time) < SAME_TIME
            if is_turn:
                index, time = events.index(event), event.t
                if later and law.mirrored:
                    side = 3 - side
        inside = bool(acts_in(law, index))
        touched = list(_with_touch(p, events, index, side, time, inside))
        yield from touched
        if not law.mirrored:
            # A motion that is its own mirror image touches both supports, whose contacts may differ.
            for each in touched:
                yield from _with_opposite_touch(law, p, each, side, time)
    elif margin == of.SLIDE:
        x = _displacement_near(e, law, p, u, index, time)
        way = _way(law, index)
        yield _with(events, index, [Happening(STICK, 0, time, x), Happening(SLIP, way, time, 0.0)])
        yield _with(events, index, [Happening(TURN, 0, time, x)] * 2)
    elif margin == of.HOLD:
        kind = events[index].kind
        if side:
            home = int(law.codes[index, HOME])
            way = -side if home == 1 else side
            x = next(e.own for e in reversed(events[: index + 1]) if e.kind == STICK)
            yield _with(
                events, index, [Happening(SLIP, way, time, 0.0), Happening(STICK, 0, time, x)]
            )
        elif kind == STICK:
            turn = events[index]._replace(kind=TURN)
            yield [*events[:index], turn, *events[index:]]
            yield [*events[:index], turn, *events[index + 2 :]]
        elif kind == TURN:
            way = _way(law, index)
            slip = Happening(SLIP, way, events[index].t, 0.0)
            yield [*events[:index], events[index]._replace(kind=STICK), slip, *events[index + 1 :]]


def _way(law: Law, i: int) -> int:
    """Return the direction of x' during piece i."""
    _kind, _form, home, direction = law.codes[i].tolist()
    return -direction if home == 1 else direction


def _with(events: list[Happening], index: int, new: list[Happening]) -> list[Happening]:
    """Return events with others after one of them."""
    return [*events[: index + 1], *new, *events[index + 1 :]]


def _displacement_near(e: Effects, law: Law, p: Any, u: np.ndarray, i: int, time: float) -> float:
    """Return the displacement on piece i at a time."""
    y, _w = state_within(e, p, law, i, u, time)
    home = int(law.codes[i, HOME])
    return _reference(p, home) + (-float(y) if home == 1 else float(y))


def without_contact(events: list[Happening], i: int, p: Any) -> Iterator[list[Happening]]:
    """Yield events without a contact, or a flight between two, that has lost its speed."""
    event, n = events[i], len(events)
    if event.kind == IMPACT:
        if p.friction > 0.0:
            x = _reference(p, event.side)
            yield [*events[:i], Happening(TURN, 0, event.t, x), *events[i + 1 :]]
        yield [*events[:i], *events[i + 1 :]]
        return
    if event.kind == LEAVE and events[(i + 1) % n].kind == STICK and i + 2 < n:
        # It is held before it leaves, and leaves once it slips.
        slip = next(k for k in range(i + 1, i + 1 + n) if events[k % n].kind == SLIP) % n
        later = event._replace(t=events[slip].t)
        yield [e for k, e in enumerate([*events[: slip + 1], later, *events[slip + 1 :]]) if k != i]
    # The other end of the contact, or of the flight: the next or the last event of the other kind at this support.
    other = LEAVE if event.kind == ENTER else ENTER
    order = [(i + k) % n for k in range(1, n)]
    for j in (
        next((k for k in order if events[k].kind == other), None),
        next((k for k in reversed(order) if events[k].kind == other), None),
    ):
        if j is not None and events[j].side == event.side:
            yield [e for k, e in enumerate(events) if k not in (i, j)]


def _without_piece(events: list[Happening], i: int) -> Iterator[list[Happening]]:
    """Yield events without both ends of a piece that has vanished, or with a turn in their place."""
    n = len(events)
    j = (i + 1) % n
    if events[i].kind == SLIP and events[j].kind == LEAVE:
        yield from _leaving_first(events, i, j)
    yield [e for k, e in enumerate(events) if k not in (i, j)]
    if events[i].kind == STICK and events[j].kind == SLIP:
        turned = [e for k, e in enumerate(events) if k != j]
        turned[turned.index(events[i])] = events[i]._replace(kind=TURN)
        yield turned
    for k in (i, j):
        yield [e for number, e in enumerate(events) if number != k]


def _leaving_first(events: list[Happening], slip: int, leave: int) -> Iterator[list[Happening]]:
    """Yield events with a contact left before the stick at its surface, in place of after the slip."""
    stick = next((k for k in range(slip - 1, -1, -1) if events[k].kind == STICK), None)
    if stick is not None and leave > slip:
        first = events[leave]._replace(t=events[stick].t)
        yield [*events[:stick], first, *events[stick:leave], *events[leave + 1 :]]


def _with_opposite_touch(
    law: Law, p: Any, events: list[Happening], side: int, time: float
) -> Iterator[list[Happening]]:
    """Yield events with a touch of the other support, too, half an orbit from the first."""
    other, x = 3 - side, _reference(p, 3 - side)
    turns = [k for k, each in enumerate(events) if each.kind == TURN and abs(each.own - x) < SAME_X]
    if turns:
        yield from _with_touch(p, events, turns[0], other, events[turns[0]].t)
    elif not any(each.kind in (TURN, STICK) for each in events):
        at = time + 0.5 * law.span
        begin = events[0].t if events else time
        at = begin + (at - begin) % law.span
        before = sum(each.t <= at for each in events) - 1
        yield from _with_touch(p, events, before, other, at)


def _with_touch(
    p: Any, events: list[Happening], i: int, side: int, time: float, inside: bool = False
) -> Iterator[list[Happening]]:
    """Yield events with a contact that begins at a touch or, inside a contact, with a flight that does."""
    is_soft = (p.k1 if side == 1 else p.k2) > 0.0
    begin, end = (
        Happening(ENTER if is_soft else IMPACT, side, time, 0.0),
        Happening(LEAVE, side, time, 0.0),
    )
    if inside and is_soft:
        begin, end = end, begin
    if inside and events[i].kind == STICK:
        slip = next((k for k in range(i + 1, len(events)) if events[k].kind == SLIP), -1)
        if 0 <= slip < len(events) - 1 and events[slip + 1].kind == LEAVE:
            yield from _leaving_first(events, slip, slip + 1)
    at_turn = 0 <= i < len(events) and events[i].kind in (TURN, STICK) and events[i].t == time
    if not at_turn:
        yield _with(events, i, [begin, end] if is_soft else [begin])
        return
    if is_soft:
        yield [*events[:i], begin, events[i], end, *events[i + 1 :]]
    else:
        yield [*events[:i], begin, *events[i + 1 :]]
        yield [*events[:i], begin, *events[i:]]
    if is_soft and events[i].kind == STICK:
        k = next((k for k in range(i + 1, len(events)) if events[k].kind == SLIP), i)
        # Held at the surface, it leaves once it slips.
        yield [
            *events[:i],
            begin,
            *events[i : k + 1],
            end._replace(t=events[k].t),
            *events[k + 1 :],
        ]
