"""What law follows where a housing ceases to keep to its own: slips and stops that begin, vanish or change places."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from vibropipe.march.piece_log import CAUSE, HOUSING_SLIP, HOUSING_STOP, IMPACT
from vibropipe.orbits.law import least as of
from vibropipe.orbits.law.flights import momentum_within, state_within
from vibropipe.orbits.law.happenings import Happening, followed_by
from vibropipe.orbits.law.law import SECTION, Law
from vibropipe.orbits.law.sliding import way_of
from vibropipe.physics.contact import support_position, to_displacement, to_velocity
from vibropipe.physics.effects import Effects

# Difference of times, in forcing periods, that are one.
SAME_TIME = 1e-9


def housing_edits(
    events: list[Happening], i: int, side: int, time: float, margin: int
) -> Iterator[list[Happening]]:
    """Yield the events of the laws that may follow where a margin of a housing is zero.

    Arguments are those of the margin, as `housing_margins` notes it; events without states are completed later.
    """
    if not events:
        way = 1 if side == of.UPPER else -1
        yield [_slip(time, way), _stop(time, 0)]
        return
    if margin == of.HOUSING_SLIDE:
        yield from _of_speed(events, i, side, time)
    elif side:
        yield from _of_hold(events, i, 1 if side == of.UPPER else -1, time)
    else:
        yield from _of_push(events, i)


def _slip(time: float, way: int) -> Happening:
    """Return a slip of a housing, whose state is not known yet."""
    return Happening(HOUSING_SLIP, 0, time, np.nan, np.nan, way)


def _stop(time: float, way: int) -> Happening:
    """Return a stop of a housing, whose state is not known yet."""
    return Happening(HOUSING_STOP, 0, time, np.nan, np.nan, way)


def _without(events: list[Happening], *left: int) -> list[Happening]:
    """Return events without some."""
    n = len(events)
    return [each for k, each in enumerate(events) if k not in {j % n for j in left}]


def _changed(events: list[Happening], i: int, way: int | None) -> list[Happening]:
    """Return events one of which leads to another way."""
    return [each._replace(way=way) if k == i else each for k, each in enumerate(events)]


def _of_hold(events: list[Happening], i: int, way: int, time: float) -> Iterator[list[Happening]]:
    """Yield what follows where the force on a housing that is held during piece i exceeds its friction this way."""
    event, following = events[i], (i + 1) % len(events)
    if abs(time - event.t) < SAME_TIME:
        moved = _changed(events, i, way)
        yield followed_by(moved, i, [_stop(event.t, 0)])
        if events[following].kind == HOUSING_SLIP and events[following].way == way:
            if event.kind == HOUSING_STOP:
                yield _without(events, i, following)
            yield _without(moved, following)
        return
    yield followed_by(events, i, [_slip(time, way), _stop(time, 0)])
    slipped = followed_by(events, i, [_slip(time, way)])
    if following == 0:
        yield [*events, _slip(time, way)]
        return
    if events[following].kind != IMPACT:
        slipped = _changed(slipped, i + 2, way)
    yield slipped
    yield followed_by(slipped, i + 2, [_stop(events[following].t, 0)])


def _of_push(events: list[Happening], i: int) -> Iterator[list[Happening]]:
    """Yield what follows where the force that moves a housing from event i on no longer exceeds its friction."""
    event, following = events[i], (i + 1) % len(events)
    stops = events[following].kind == HOUSING_STOP
    if event.kind == HOUSING_SLIP:
        if stops:
            yield _without(events, i, following)
        return
    held = _changed(events, i, 0)
    if stops:
        yield _changed(_without(events, following), i - (following < i), events[following].way)
    if event.way:
        yield followed_by(held, i, [_slip(event.t, event.way)])


def _of_speed(events: list[Happening], i: int, side: int, time: float) -> Iterator[list[Happening]]:
    """Yield what follows where a housing that slides during piece i loses its velocity."""
    event, following = events[i], (i + 1) % len(events)
    way = next(each.way for each in reversed([*events[i + 1 :], *events[: i + 1]]) if each.way)
    if side == of.NO_SIDE:
        yield followed_by(events, i, [_stop(time, 0), _slip(time, way)])
        return
    if side == of.LOWER:
        for new in (0, -way):
            if following:
                yield followed_by(events, i, [_stop(time, new)])
            else:
                yield [*events, _stop(time, new)]
        return
    turned = _changed(events, i, -way)
    if events[following].kind == HOUSING_STOP:
        if events[following].way == -way:
            yield _changed(_without(events, following), i - (following < i), -way)
        else:
            yield turned
        return
    for new in (way, 0):
        yield followed_by(turned, i, [_stop(event.t, new)])


def without_slide(events: list[Happening], i: int) -> Iterator[list[Happening]]:
    """Yield events without a piece that begins or ends with an event of a housing and has vanished."""
    n = len(events)
    j = (i + 1) % n
    one, two = events[i], events[j]
    ours = (HOUSING_SLIP, HOUSING_STOP)
    if one.kind in ours and two.kind in ours:
        yield _without(events, i, j)
        merged = _changed(events, i, two.way)
        yield _without(merged, j)
    elif one.kind == IMPACT and two.kind == HOUSING_STOP:
        yield _without(events, i, j)
        yield _changed(_without(events, j), i - (j < i), two.way)
        if one.way:
            yield _changed(events, i, -one.way)
    elif one.kind == HOUSING_STOP and two.kind == IMPACT:
        kept = _without(events, i)
        at = j - (i < j)
        yield [each._replace(third=each.own) if k == at else each for k, each in enumerate(kept)]
    if one.kind in ours or two.kind in ours:
        # They change places.
        first, last = (two, one) if two.kind in ours else (two._replace(way=None), one)
        if last.kind not in ours:
            last = last._replace(way=None)
        if j:
            yield [*events[:i], first._replace(t=one.t), last, *events[j + 1 :]]
        elif n > 2:
            yield [last._replace(t=two.t), *events[1:i], first._replace(t=one.t)]


def without_push(events: list[Happening], i: int) -> Iterator[list[Happening]]:
    """Yield events without an impact that pushes a held housing off, where it has lost its speed, and its stop."""
    following = (i + 1) % len(events)
    if events[i].kind == IMPACT and events[following].kind == HOUSING_STOP:
        yield _without(events, i, following)


def completed(
    e: Effects, law: Law, p: Any, u: np.ndarray, events: list[Happening]
) -> list[Happening]:
    """Return events in which those that are new, or have moved, know the housing that the orbit has there.

    An impact that pushes a held housing off without velocity leaves it held.
    """
    made = list[Happening]()
    for event in events:
        at = _piece_at(law, u, event.t)
        is_new = event.own != event.own or event.third != event.third or event.way is None
        if not is_new:
            made.append(event)
            continue
        x, v, q = _state_at(e, law, p, u, at, event.t)
        own = event.own
        if event.kind == HOUSING_SLIP:
            own = v
        elif event.kind == HOUSING_STOP:
            own = x
        made.append(event._replace(own=own, third=v if event.kind == HOUSING_STOP else q))
        if event.kind == IMPACT and way_of(law, at) == 0 and event.own == 0.0:
            made.append(
                Happening(HOUSING_STOP, 0, event.t, support_position(p, event.side), 0.0, 0)
            )
    return made


def _piece_at(law: Law, u: np.ndarray, time: float) -> int:
    """Return the piece during which a time is."""
    if law.codes[0, CAUSE] == SECTION:
        return 0
    times = u[:, 0]
    begun = np.flatnonzero(times <= times[0] + (time - times[0]) % law.span + SAME_TIME)
    return int(begun[-1]) if begun.size else len(times) - 1


def _state_at(
    e: Effects, law: Law, p: Any, u: np.ndarray, i: int, time: float
) -> tuple[float, float, float]:
    """Return displacement, velocity and the momentum q, where a housing slides, on piece i at a time."""
    home = int(law.codes[i, 2])
    y, w = state_within(e, p, law, i, u, time)
    v = to_velocity(home, float(w))
    q = v
    if way_of(law, i):
        q = to_velocity(home, float(momentum_within(e, p, law, i, u, time)))
    return to_displacement(p, home, float(y)), v, q
