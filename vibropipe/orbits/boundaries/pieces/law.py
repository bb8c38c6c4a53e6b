"""Sequences of events of orbits with soft supports or friction, from the log of a march."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable
from typing import Any, NamedTuple

import numpy as np

from vibropipe.march.piece_log import (
    AT,
    BEGIN,
    CAUSE,
    CONTACT,
    DIRECTION,
    ENTER,
    FORM,
    FREE,
    HOME,
    IMPACT,
    LEAVE,
    PIECES,
    RELEASE,
    REST_BEGINS,
    SPAN,
    STICK,
    TOUCH,
    TURN,
    W_END,
    PieceLog,
    Y,
)

# Difference of two phases, in forcing periods, and of two velocities or displacements, relative, that are one.
SAME_PHASE, SAME_STATE = 1e-5, 1e-4


class Law(NamedTuple):
    """What happens in an orbit, from its first contact on, or from its first turn where it has none.

    Attributes
    ----------
    codes : (n + 1, 4) int8
        Of its pieces, as in a `PieceLog`; row 0 is free.
    spans : (n + 1,) float
        How long they last, in tau.
    span : float
        Length in forcing periods.
    mirrored : int
        1 where the orbit goes on with the mirror image of all this.
    at, start : float
        Phase of the first event, and the velocity before it in its frame; of a turn the displacement.
    """

    codes: np.ndarray
    spans: np.ndarray
    span: float
    mirrored: int
    at: float
    start: float

    @property
    def m(self) -> int:
        """Period multiple of the orbit."""
        return round(self.span * (1 + self.mirrored))

    @property
    def n_contacts(self) -> int:
        """Number of contacts of the orbit."""
        return sum(contacts_of(events_of(self.codes[1:], self.mirrored)))


class Row(NamedTuple):
    """A piece of a march that may be changed."""

    values: np.ndarray
    codes: np.ndarray
    arrival: float


def rows_of(pieces: PieceLog, slow: float, rubs: bool) -> list[Row] | None:
    """Return the pieces of a march without touches slower than a speed; None if the mass rests on a support.

    rubs : whether there is friction, against which a flight ends where it turns
    """
    n = int(pieces.counts[PIECES])
    codes, values = pieces.codes[:n].copy(), pieces.values[:n].copy()
    if np.isin(codes[:, CAUSE], [REST_BEGINS, RELEASE]).any():
        return None
    rows: list[Row] = []
    # Whether a contact is under way that is more than a touch, which may begin where the mass turns.
    inside = bool(n) and codes[0, FORM] == CONTACT
    for i in range(n):
        cause, home = int(codes[i, CAUSE]), int(codes[i, HOME])
        arrival = 0.0
        if i > 0 and cause in (ENTER, IMPACT):
            before = int(codes[i - 1, HOME])
            sign = 1.0 if (before == 1) == (home == 1) else -1.0
            arrival = sign * float(values[i - 1, W_END])
        is_slow = i > 0 and cause in (ENTER, IMPACT, TOUCH) and abs(arrival) < slow
        joins = is_slow or (cause == LEAVE and not inside)
        if cause in (ENTER, LEAVE):
            inside = cause == ENTER and not is_slow
        if codes[i, FORM] == CONTACT and not inside:
            codes[i, FORM] = FREE
        if joins and rubs and _turns(rows[-1], codes[i]):
            codes[i, CAUSE], joins = TURN, False
        if joins:
            rows[-1].values[SPAN] += values[i, SPAN]
            rows[-1].values[W_END] = values[i, W_END]
        else:
            rows.append(Row(values[i], codes[i], arrival))
    return rows


def _turns(row: Row, codes: np.ndarray) -> bool:
    """Return whether a piece slides against the direction of the one before."""
    same_frame = (row.codes[HOME] == 1) == (codes[HOME] == 1)
    return bool((row.codes[DIRECTION] == codes[DIRECTION]) != same_frame)


def law_of(pieces: PieceLog, m: int, symmetric: bool, slow: float, rubs: bool) -> Law | None:
    """Return what happens in an orbit.

    Parameters
    ----------
    pieces : PieceLog
        Of a march over 2 m periods.
    m : int
        Period multiple.
    symmetric : bool
        Whether the exciter is its own mirror image: an orbit that is, is then known by its half.
    slow : float
        Speed below which a support is only touched.
    rubs : bool
        Whether there is friction.

    Returns
    -------
    Law or None
        None if the orbit has rests, or nothing happens.
    """
    rows = rows_of(pieces, slow, rubs)
    first = _first(rows or [])
    if rows is None or first is None:
        return None
    if symmetric and m % 2:
        half = _again(rows, first, 0.5 * m, True)
        if half is not None:
            return _cut(rows, first, half, 0.5 * m, 1)
    # Of an orbit that touches, so does each of its repeated parts.
    for span in range(1 if slow > 0.0 else m, m + 1):
        last = _again(rows, first, float(span), False) if m % span == 0 else None
        if last is not None:
            return _cut(rows, first, last, float(span), 0)
    return None


def _first(rows: list[Row]) -> int | None:
    """Return the index of the first contact, or of the first turn or stick where there is none."""
    for causes in ((ENTER, IMPACT), (TURN, STICK)):
        for i, row in enumerate(rows):
            if i > 0 and row.codes[CAUSE] in causes:
                return i
    return None


def _state(row: Row, mirrored: bool) -> float:
    """Return what tells an event from others of its kind: its velocity, or its displacement."""
    if row.codes[CAUSE] in (ENTER, IMPACT):
        return row.arrival
    return float(row.values[Y]) * (-1.0 if mirrored and row.codes[HOME] == 0 else 1.0)


def _again(rows: list[Row], first: int, span: float, mirrored: bool) -> int | None:
    """Return where the first event, or its mirror image, happens again after `span` periods."""
    begin = rows[first]
    home = int(begin.codes[HOME])
    towards = 3 - home if mirrored and home > 0 else home
    for i in range(first + 1, len(rows)):
        if abs(rows[i].values[AT] - begin.values[AT] - span) > SAME_PHASE:
            continue
        same = rows[i].codes[CAUSE] == begin.codes[CAUSE] and rows[i].codes[HOME] == towards
        there, here = _state(rows[i], mirrored), _state(begin, False)
        if same and abs(there - here) <= SAME_STATE * abs(here):
            return i
    return None


def _cut(rows: list[Row], first: int, last: int, span: float, mirrored: int) -> Law:
    """Return the law of the pieces from one event up to another."""
    part = rows[first:last]
    codes = np.array([part[0].codes, *(row.codes for row in part)], np.int8)
    spans = np.array([0.0, *(row.values[SPAN] for row in part)])
    at = float(part[0].values[AT])
    return Law(codes, spans, span, mirrored, at - np.floor(at), _state(part[0], False))


def events_of(codes: np.ndarray, mirrored: int = 0) -> Counter[Hashable]:
    """Return how often each event happens in the pieces (n, 4); with `mirrored` also in their mirror image."""
    counts: Counter[Hashable] = Counter()
    for cause, _form, home, direction in codes.tolist():
        if cause == BEGIN:
            continue
        for side in range(1 + mirrored):
            if cause in (ENTER, LEAVE, IMPACT):
                what = home if side == 0 else 3 - home
            else:
                what = -direction if (home == 1) != (side == 1) else direction
            counts[cause, what] += 1
    return counts


def contacts_of(events: Counter[Any]) -> tuple[int, int]:
    """Return the number of contacts with each support."""
    first, second = (
        sum(events[int(cause), support] for cause in (ENTER, IMPACT)) for support in (1, 2)
    )
    return first, second


def without_start(pieces: PieceLog, slow: float, rubs: bool) -> np.ndarray | None:
    """Return the codes of a march without its start and without slow touches; None if the mass rests."""
    rows = rows_of(pieces, slow, rubs)
    return (
        None if rows is None else np.array([row.codes for row in rows[1:]], np.int8).reshape(-1, 4)
    )
