"""What law follows where a support that only pushes begins or ceases to be struck, or to let go."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from vibropipe.march.piece_log import CONTACT, ENTER, FORM, HOME, LEAVE, RELOAD, STICK, TURN, UNLOAD
from vibropipe.orbits.law.flights import state_within
from vibropipe.orbits.law.happenings import Happening
from vibropipe.orbits.law.law import Law
from vibropipe.physics.effects import Effects

# Half the length, in forcing periods, of a contact, or of a time without force, that is about to begin. Without any
# length its equations are singular.
SHORT = 1e-4


def with_short_contact(
    e: Effects,
    law: Law,
    p: Any,
    u: np.ndarray,
    events: list[Happening],
    i: int,
    side: int,
    time: float,
) -> list[Happening]:
    """Return events with a short contact in place of a touch on piece i, or at the turn that begins it.

    To leading order the mass swings past the support with its acceleration there, and is let go where it turns. Under
    friction that differs after the turn.
    """
    event = events[i] if events else None
    turns = event is not None and event.kind in (TURN, STICK) and event.t == time
    before = _velocity_near(e, law, p, u, i - 1 if turns else i, time - SHORT)
    after, share = _velocity_near(e, law, p, u, i, time + SHORT), 1.0
    if turns and before * after < 0.0:
        share = math.sqrt(-before / after)
    elif not turns:
        after = 0.5 * (after - before)
        before = -after
    swings = [
        Happening(ENTER, side, time - SHORT, before),
        *([event._replace(kind=TURN)] if event is not None and turns else []),
        Happening(UNLOAD, side, time, 0.0),
        Happening(LEAVE, side, time + share * SHORT, share * after),
    ]
    return [*events[: i if turns else i + 1], *swings, *events[i + 1 :]]


def let_go(e: Effects, law: Law, p: Any, u: np.ndarray, i: int, time: float) -> list[Happening]:
    """Return a short time without a force, or with one, in place of a touch of zero by the force on piece i."""
    kinds = (UNLOAD, RELOAD) if law.codes[i, FORM] == CONTACT else (RELOAD, UNLOAD)
    times = time - SHORT, time + SHORT
    return [
        Happening(kind, int(law.codes[i, HOME]), at, _velocity_near(e, law, p, u, i, at))
        for kind, at in zip(kinds, times, strict=True)
    ]


def _velocity_near(e: Effects, law: Law, p: Any, u: np.ndarray, i: int, time: float) -> float:
    """Return x' on piece i at a time."""
    _y, w = state_within(e, p, law, i, u, time)
    return -float(w) if law.codes[i, HOME] == 1 else float(w)


def without_slow(events: list[Happening], i: int) -> Iterator[list[Happening]]:
    """Yield events without a contact, or a flight between two, that has lost its speed, or with such a flight."""
    event, n = events[i], len(events)
    if event.kind == RELOAD:
        flight = [event._replace(kind=kind, own=0.0) for kind in (LEAVE, ENTER)]
        yield [*events[:i], *flight, *events[i + 1 :]]
        return
    enters = event.kind == ENTER
    other, ahead = LEAVE if enters else ENTER, [(i + k) % n for k in range(1, n)]
    for is_flight, order in ((not enters, ahead), (enters, ahead[::-1])):
        j = next((k for k in order if events[k].kind == other), None)
        if j is None or events[j].side != event.side:
            continue
        if is_flight:
            leaves, back = (j, i) if enters else (i, j)
            again = [
                each._replace(kind=RELOAD) if k == leaves else each
                for k, each in enumerate(events)
                if k != back
            ]
            yield again
            continue
        first, last = (i, j) if enters else (j, i)
        within = {(first + k) % n for k in range((last - first) % n + 1)}
        # Under friction it turns where it would have struck.
        yield [
            each
            for k, each in enumerate(events)
            if k not in within or each.kind not in (ENTER, UNLOAD, RELOAD, LEAVE)
        ]
