"""The law of an orbit, and its unknowns, read from the log of a march."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from vibropipe.march.piece_log import (
    AT,
    BEGIN,
    BEYOND,
    CAUSE,
    CONTACT,
    DIRECTION,
    ENTER,
    FORM,
    FREE,
    HOME,
    HOUSING_SLIP,
    HOUSING_STOP,
    IMPACT,
    LEAVE,
    P_END,
    PIECES,
    RELEASE,
    RELOAD,
    REST_BEGINS,
    RESTING,
    SLIP,
    SPAN,
    STICK,
    TOUCH,
    TURN,
    UNLOAD,
    W_END,
    HousingLog,
    PieceLog,
    W,
    Y,
)
from vibropipe.orbits.law.landing import landing_of, least_slide
from vibropipe.orbits.law.law import WAY, Law, width_of
from vibropipe.physics.contact import to_displacement, to_velocity
from vibropipe.physics.effects import Effects
from vibropipe.physics.housing import momentum_share

# Difference of two phases, in forcing periods, and of two velocities or displacements, relative, that are one.
SAME_PHASE, SAME_STATE = 1e-5, 1e-4
# Relative change of the pressing force over a flight of a chatter below which no event counts it.
COUNTED = 0.1
# Speed of the last impact of a chatter, relative to the fastest, that is rounding.
ENDLESS = 1e-9


class Read(NamedTuple):
    """A law and its unknowns (n, w), as `equations` has them."""

    law: Law
    u: np.ndarray


class _Event(NamedTuple):
    """An event of a march: codes of the event and its piece, time, and what is free of the state before it."""

    codes: np.ndarray
    at: float
    own: float
    piece: int
    third: float = 0.0


def law_of(
    e: Effects, pieces: PieceLog, p: Any, m: int, symmetric: bool, slow: float = 0.0
) -> Read | None:
    """Return the law of an orbit and its unknowns.

    pieces : of a march over 2 m periods
    symmetric : whether the exciter is its own mirror image: an orbit that is, is then known by its half
    slow : speed below which a support is only touched

    Returns None if the march has no event twice that repeats with the orbit; beside a housing also if of two events at
    once one changes the other, or a chatter pushes it off without end.
    """
    events = _events_of(pieces, p, slow)
    housing = pieces.housing
    if housing is not None:
        beside = _with_housing(events, pieces, housing, p)
        if beside is None:
            return None
        events = beside
    events = _without_tails(e, events, p)
    if housing is not None and _is_endless(events):
        return None
    first = _first(events)
    if first is None:
        if housing is not None and housing.way[0] != 0:
            return None
        return _without_events(e, pieces, p, m)
    if symmetric and m % 2:
        half = _again(events, first, 0.5 * m, True)
        if half is not None:
            return _cut(events[first:half], 0.5 * m, 1)
    last = _again(events, first, float(m), False)
    return None if last is None else _cut(events[first:last], float(m), 0)


def _events_of(pieces: PieceLog, p: Any, slow: float) -> list[_Event]:
    """Return the events of a march after its start, in frames of the support last met."""
    n = int(pieces.counts[PIECES])
    codes, values = pieces.codes[:n].copy(), pieces.values[:n]
    events: list[_Event] = []
    home, inside = int(codes[0, HOME]), codes[0, FORM] in (CONTACT, BEYOND)
    for i in range(1, n):
        cause, there = int(codes[i, CAUSE]), int(codes[i, HOME])
        before = int(codes[i - 1, HOME])
        speed = to_velocity(before, float(values[i - 1, W_END]))
        approach = speed if there == 1 else -speed
        if cause in (ENTER, LEAVE, IMPACT, REST_BEGINS):
            is_slow = abs(approach) < slow
            ends = cause == LEAVE and not inside
            if cause != LEAVE:
                inside = cause == ENTER and not is_slow
            elif not ends:
                inside = False
            if (is_slow and cause != LEAVE) or ends:
                if cause == IMPACT and p.friction > 0.0:
                    # It turns there, as it would without the support.
                    way = int(codes[i, DIRECTION]) * (1 if (home == 1) == (there == 1) else -1)
                    turn = np.array([TURN, FREE, home, way], np.int8)
                    x = to_displacement(p, there, 0.0) - to_displacement(p, home, 0.0)
                    events.append(_Event(turn, float(values[i, AT]), x, i))
                continue
            event = codes[i].copy()
            events.append(_Event(event, float(values[i, AT]), speed, i))
            home = there
            continue
        if cause in (TOUCH, BEGIN):
            continue
        if cause in (UNLOAD, RELOAD):
            if inside:
                events.append(_Event(codes[i].copy(), float(values[i, AT]), speed, i))
            continue
        if cause == RELEASE:
            events.append(_Event(codes[i].copy(), float(values[i, AT]), 0.0, i))
            continue
        event = codes[i].copy()
        if event[FORM] in (CONTACT, BEYOND) and not inside:
            event[FORM] = FREE
        x = to_displacement(p, there, float(values[i, Y]))
        own = x - to_displacement(p, home, 0.0)
        if (home == 1) != (there == 1):
            event[DIRECTION] *= -1
        event[HOME] = home
        if cause == HOUSING_SLIP:
            own = to_velocity(there, float(values[i, W]))
        events.append(_Event(event, float(values[i, AT]), own, i))
    return events


def _with_housing(
    events: list[_Event], pieces: PieceLog, log: HousingLog, p: Any
) -> list[_Event] | None:
    """Return events with the way of the housing after each, and what is free of its motion before.

    None if a mass slips, or is released, where the housing stops that carries it along: two events, of which one
    changes the other.
    """
    kept = list[_Event]()
    for event in events:
        i, codes = event.piece, event.codes
        before, v = (
            int(log.way[i - 1]),
            to_velocity(int(pieces.codes[i, HOME]), pieces.values[i, W]),
        )
        way = -log.way[i] if codes[HOME] == 1 else log.way[i]
        kind, at_once = codes[CAUSE], bool(kept) and kept[-1].piece == i - 1
        at_once = at_once and pieces.values[i - 1, SPAN] == 0.0
        if at_once and kind == HOUSING_STOP:
            kept[-1].codes[WAY] = way  # it did not start
            continue
        if at_once and kind in (SLIP, RELEASE):
            return None
        if p.friction == 0.0 and kind in (HOUSING_SLIP, HOUSING_STOP):
            # Which way the mass moves there is no part of the law.
            codes[DIRECTION] = kept[-1].codes[DIRECTION] if kept else 0
        if codes[FORM] == RESTING:
            codes[DIRECTION] = 0
        third = float(log.values[i - 1, P_END]) / momentum_share(p) if before else 0.0
        third = float(v) if kind == HOUSING_STOP else third
        kept.append(event._replace(codes=np.append(codes, np.int8(way)), third=third))
    return kept


def _without_tails(e: Effects, events: list[_Event], p: Any) -> list[_Event]:
    """Return events with each chatter cut before its first short flight, where the rest then counts as begun."""
    kept, tail = list[_Event](), False
    for n, event in reversed([*enumerate(events)]):
        kind, home = int(event.codes[CAUSE]), int(event.codes[HOME])
        if kind == REST_BEGINS:
            tail = True
        elif tail and kind == TURN:
            kept.append(event)
            continue
        elif tail and kind == IMPACT and home == kept_home(kept):
            begun = event._replace(codes=event.codes.copy())
            begun.codes[:WAY] = REST_BEGINS, RESTING, home, 0
            held = n > 0 and len(begun.codes) > WAY and events[n - 1].codes[WAY] == 0
            if is_short(e, begun._replace(third=begun.own) if held else begun, p):
                while kept and kept[-1].codes[CAUSE] in (TURN, REST_BEGINS):
                    kept.pop()
                kept.append(begun)
                continue
            tail = False
        else:
            tail = False
        kept.append(event)
    return kept[::-1]


def _is_endless(events: list[_Event]) -> bool:
    """Return whether events count a chatter down to rounding, each impact of which pushes a held housing off."""
    fastest = max((abs(each.own) for each in events if each.codes[CAUSE] == IMPACT), default=0.0)
    return any(
        each.codes[CAUSE] == REST_BEGINS and abs(each.own) < ENDLESS * fastest for each in events
    )


def kept_home(kept: list[_Event]) -> int:
    """Return the support of the rest that the last events kept lead to."""
    return int(
        next(each.codes[HOME] for each in reversed(kept) if each.codes[CAUSE] == REST_BEGINS)
    )


def is_short(e: Effects, begun: _Event, p: Any) -> bool:
    """Return whether the first flight after an impact is so short that no event needs to count it.

    A housing has to slide on through all that follow.
    """
    home = int(begun.codes[HOME])
    speed = (p.R1 if home == 1 else p.R2) * abs(begun.own)
    law = Law(begun.codes[np.newaxis], 1.0, 0)
    landing, share = landing_of(e, p, law, 0, begun.at, speed)
    if e.housing is not None:
        u = np.array([[begun.at, begun.own, begun.third]])
        if not least_slide(e, p, law, 0, u, speed, landing, share) > 0.0:
            return False
    return bool(share < COUNTED)


def _first(events: list[_Event]) -> int | None:
    """Return the index of the first contact after another, or of the first turn or stick where there is none."""
    for causes in ((ENTER, IMPACT), (REST_BEGINS,), (UNLOAD,), (TURN, STICK), (HOUSING_STOP,)):
        for i, event in enumerate(events):
            if event.codes[CAUSE] in causes:
                return i
    return None


def _again(events: list[_Event], first: int, span: float, mirrored: bool) -> int | None:
    """Return where the first event, or its mirror image, happens again after `span` periods."""
    begin = events[first]
    home = int(begin.codes[HOME])
    towards = 3 - home if mirrored and home > 0 else home
    sign = -1.0 if mirrored else 1.0
    for i in range(first + 1, len(events)):
        event = events[i]
        if abs(event.at - begin.at - span) > SAME_PHASE or event.codes[HOME] != towards:
            continue
        scale = SAME_STATE * abs(begin.own)
        same = abs(sign * event.own - begin.own) <= scale
        if event.codes[CAUSE] == begin.codes[CAUSE] and same:
            return i
    return None


def _cut(events: list[_Event], span: float, mirrored: int) -> Read:
    """Return the law of some events in turn, whose frames are those of the support last met."""
    codes = np.array([each.codes for each in events], np.int8)
    begin = float(np.floor(events[0].at))
    u = np.zeros((len(events), codes.shape[1] - 2))
    u[:, 0] = [each.at - begin for each in events]
    u[:, 1] = [0.0 if each.codes[CAUSE] == SLIP else each.own for each in events]
    u[:, 2:] = [[each.third][: u.shape[1] - 2] for each in events]
    return Read(Law(codes, span, mirrored), u)


def _without_events(e: Effects, pieces: PieceLog, p: Any, m: int) -> Read:
    """Return the law of an orbit on which nothing happens, with its section at phase 0."""
    form, home = int(pieces.codes[0, FORM]), int(pieces.codes[0, HOME])
    codes = np.array(
        [[BEGIN, FREE if form == FREE else form, 0, pieces.codes[0, DIRECTION]]], np.int8
    )
    own = home if form in (CONTACT, RESTING) else 0
    codes[0, HOME] = own
    x = to_displacement(p, home, float(pieces.values[0, Y])) - to_displacement(p, own, 0.0)
    width = width_of(e.housing)
    u = np.zeros((1, width))
    u[0, :2] = x, to_velocity(home, float(pieces.values[0, W]))
    return Read(Law(np.pad(codes, ((0, 0), (0, width - 2))), float(m), 0), u)
