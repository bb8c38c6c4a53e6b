"""What law follows where a margin of another reaches zero: the orbit of the end is an orbit of both."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from vibropipe.march.piece_log import CAUSE, ENTER, HOME, IMPACT, LEAVE, SLIP, STICK, TURN
from vibropipe.orbits.law import least as of
from vibropipe.orbits.law.flights import state_within
from vibropipe.orbits.law.happenings import Happening, followed_by, happenings, reference_of
from vibropipe.orbits.law.housing_edits import completed, housing_edits, without_push, without_slide
from vibropipe.orbits.law.law import SECTION, Law, acts_in
from vibropipe.orbits.law.push_edits import let_go, with_short_contact, without_slow
from vibropipe.orbits.law.steps import GAP_FLIGHT, GAP_SIDE, GAP_TIME, SLOW_EVENT
from vibropipe.physics.effects import Effects
from vibropipe.physics.stiffness import lets_go

# Difference of times, in forcing periods, and of displacements that are one.
SAME_TIME, SAME_X = 1e-9, 1e-9


def edits(
    e: Effects, law: Law, p: Any, u: np.ndarray, tests: np.ndarray, margin: int
) -> Iterator[list[Happening]]:
    """Yield the events of the laws that may follow the end of another, as `edits_of_mass`."""
    if e.housing is None:
        yield from edits_of_mass(e, law, p, u, tests, margin)
        return
    events = happenings(law, p, u)
    index, time = int(tests[GAP_FLIGHT]), float(tests[GAP_TIME])
    if margin in (of.HOUSING_HOLD, of.HOUSING_SLIDE):
        listed = [] if law.codes[0, CAUSE] == SECTION else events
        candidates = housing_edits(listed, index, int(tests[GAP_SIDE]), time, int(margin))
    elif margin == of.SPAN:
        candidates = without_slide(events, index)
    elif margin == of.SPEED:
        candidates = without_push(events, int(tests[SLOW_EVENT]))
    else:
        candidates = iter(())
    for each in candidates:
        yield completed(e, law, p, u, each)
    if margin not in (of.HOUSING_HOLD, of.HOUSING_SLIDE):
        for each in edits_of_mass(e, law, p, u, tests, margin):
            yield completed(e, law, p, u, each)


def edits_of_mass(
    e: Effects, law: Law, p: Any, u: np.ndarray, tests: np.ndarray, margin: int
) -> Iterator[list[Happening]]:
    """Yield the events of the laws that may follow the end of another, by what the mass does there.

    u : (n, w), unknowns at the end
    tests : (N_TESTS,), tests of the point there, as `LawCurve` has them
    margin : the kind of the margin that is zero
    """
    events = happenings(law, p, u)
    index = int(tests[SLOW_EVENT] if margin == of.SPEED else tests[GAP_FLIGHT])
    time, side, n = float(tests[GAP_TIME]), int(tests[GAP_SIDE]), len(events)
    if law.codes[0, CAUSE] == SECTION:
        events, index, n = [], -1, 0
    if margin == of.SPEED and lets_go(p, events[index].side):
        yield from without_slow(events, index)
    elif margin == of.SPEED:
        yield from without_contact(events, index, p)
    elif margin == of.SPAN:
        yield from _without_piece(events, index)
    elif margin == of.GAP and side == of.FORCE:
        yield followed_by(events, index, let_go(e, law, p, u, index, time))
    elif margin == of.GAP:
        # A flight that turns against friction turns at its end.
        for later, event in ((0.0, events[(index + 1) % n]), (law.span, events[0])) if n else ():
            is_turn = event.kind in (TURN, STICK) and abs(event.t + later - time) < SAME_TIME
            if is_turn:
                index, time = events.index(event), event.t
                if later and law.mirrored:
                    side = 3 - side
        inside = bool(acts_in(law, index))
        if lets_go(p, side) and not inside:
            yield with_short_contact(e, law, p, u, events, index, side, time)
            return
        touched = list(_with_touch(p, events, index, side, time, inside))
        yield from touched
        if not law.mirrored:
            # A motion that is its own mirror image touches both supports, whose contacts may differ.
            for each in touched:
                yield from _with_opposite_touch(law, p, each, side, time)
    elif margin == of.SLIDE:
        x = _displacement_near(e, law, p, u, index, time)
        way = _way(law, index)
        yield followed_by(
            events, index, [Happening(STICK, 0, time, x), Happening(SLIP, way, time, 0.0)]
        )
        yield followed_by(events, index, [Happening(TURN, 0, time, x)] * 2)
    elif margin == of.HOLD and events:
        kind = events[index].kind
        if side:
            home = int(law.codes[index, HOME])
            way = -side if home == 1 else side
            x = next(e.own for e in reversed(events[: index + 1]) if e.kind == STICK)
            yield followed_by(
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
    _kind, _form, home, direction = law.codes[i, :4].tolist()
    return -direction if home == 1 else direction


def _displacement_near(e: Effects, law: Law, p: Any, u: np.ndarray, i: int, time: float) -> float:
    """Return the displacement on piece i at a time."""
    y, _w = state_within(e, p, law, i, u, time)
    home = int(law.codes[i, HOME])
    return reference_of(p, home) + (-float(y) if home == 1 else float(y))


def without_contact(events: list[Happening], i: int, p: Any) -> Iterator[list[Happening]]:
    """Yield events without a contact, or a flight between two, that has lost its speed."""
    event, n = events[i], len(events)
    if event.kind == IMPACT:
        if p.friction > 0.0:
            x = reference_of(p, event.side)
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
    other, x = 3 - side, reference_of(p, 3 - side)
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
    if inside and events and events[i].kind == STICK:
        slip = next((k for k in range(i + 1, len(events)) if events[k].kind == SLIP), -1)
        if 0 <= slip < len(events) - 1 and events[slip + 1].kind == LEAVE:
            yield from _leaving_first(events, slip, slip + 1)
    at_turn = 0 <= i < len(events) and events[i].kind in (TURN, STICK) and events[i].t == time
    if not at_turn:
        yield followed_by(events, i, [begin, end] if is_soft else [begin])
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
