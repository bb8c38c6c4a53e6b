"""A law of motion: the events of an orbit in turn, and what its linear pieces are between them, as data."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from vibropipe.compiler import jit, jit_inline
from vibropipe.march.piece_log import (
    CAUSE,
    CONTACT,
    DIRECTION,
    ENTER,
    FORM,
    FREE,
    HELD,
    HOME,
    HOUSING_SLIP,
    HOUSING_STOP,
    IMPACT,
    LEAVE,
    RELEASE,
    RELOAD,
    REST_BEGINS,
    SLIP,
    STICK,
    TURN,
    UNLOAD,
)
from vibropipe.physics.friction import jumps_at_slip

# What begins the only piece of an orbit without events: its section, at a given phase.
SECTION = np.int64(0)
# Column of `Law.codes` beside those of a `PieceLog`, of laws with a housing.
WAY = 4


class Law(NamedTuple):
    """The events of an orbit, which repeat after a span; each begins a piece that the next one ends.

    codes : (n, 4) int8, with a housing (n, 5), of each event and the piece after it, as in a `PieceLog`: what happens,
        what the piece is, the frame that it is written in (that of the support last met; 0 without any), and the
        direction of sliding in this frame; and the direction, in this frame, in which a housing slides, 0 where it is
        held
    span : length in forcing periods
    mirrored : 1 where the orbit goes on with the mirror image of all this, half an orbit later
    """

    codes: np.ndarray
    span: float
    mirrored: int

    @property
    def m(self) -> int:
        """Period multiple of the orbit."""
        return round(self.span * (1 + self.mirrored))

    @property
    def width(self) -> int:
        """Number of unknowns of an event."""
        return self.codes.shape[1] - 2

    @property
    def supports(self) -> np.ndarray:
        """The events, as `Sequence` has its supports."""
        return self.codes

    @property
    def on_first(self) -> np.ndarray:
        """Whether each event is the beginning of a contact with support 1."""
        return np.isin(self.codes[:, CAUSE], (ENTER, IMPACT, REST_BEGINS)) & (
            self.codes[:, HOME] == 1
        )

    @property
    def has_contacts(self) -> bool:
        """Whether a support acts: the mass strikes one, rests on one, or one that only pushes lets go of it."""
        kinds = (ENTER, UNLOAD, IMPACT, REST_BEGINS)
        return bool(np.isin(self.codes[:, CAUSE], kinds).any())

    def image(self, codes: np.ndarray) -> np.ndarray:
        """Return the mirror image of events and pieces."""
        image = codes.copy()
        is_placed = codes[:, HOME] > 0
        image[is_placed, HOME] = 3 - codes[is_placed, HOME]
        image[~is_placed, DIRECTION:] *= -1
        return image

    def like(self, m: int, mirrored: int, codes: np.ndarray) -> Law:
        """Return another law."""
        return Law(codes, 0.5 * m if mirrored else float(m), mirrored)

    @property
    def beside_chatters(self) -> list[int]:
        """The events but the impacts, and turns, on a support that lead to a rest on it."""
        rests, n = np.flatnonzero(self.codes[:, CAUSE] == REST_BEGINS), len(self.codes)
        # From the last rest backwards, once round; a mirrored law goes on with its image.
        last = int(rests[-1]) + 1 if rests.size and not self.mirrored else n
        kept, rest = list[int](), None
        for i in range(last - 1, last - 1 - n, -1):
            cause, home = self.codes[i, CAUSE], self.codes[i, HOME]
            if cause not in (IMPACT, TURN) or home != rest:
                kept.append(i % n)
                rest = home if cause == REST_BEGINS else None
        return kept[::-1]

    @property
    def without_chatters(self) -> Law:
        """The law of these events."""
        return self._replace(codes=self.codes[self.beside_chatters])

    @property
    def key(self) -> tuple[float, int, bytes]:
        """What tells laws apart: no matter which event is listed first."""
        n = len(self.codes)
        turned = [np.roll(self.codes, -i, axis=0).tobytes() for i in range(n)]
        if self.mirrored:
            image = self.image(self.codes)
            both = np.concatenate([self.codes, image])
            turned = [np.roll(both, -i, axis=0)[:n].tobytes() for i in range(2 * n)]
        return self.span, self.mirrored, min(turned)


def law_of_impacts(m: int, mirrored: int, supports: Iterable[int]) -> Law:
    """Return the law of an orbit that strikes rigid supports in turn, over its period or, if mirrored, half of it."""
    codes = np.array([[IMPACT, FREE, support, 1] for support in supports], np.int8)
    return Law(codes.reshape(-1, 4), 0.5 * m if mirrored else float(m), int(mirrored))


def without_events(span: float, mirrored: int, columns: int = 4) -> Law:
    """Return the law of an orbit on which nothing happens, known by its state at the phase 0."""
    codes = np.array([[SECTION, FREE, 0, 1, 0][:columns]], np.int8)
    return Law(codes, span * (1 + mirrored), 0)


@jit_inline
def width_of(housing):
    """Return the number of unknowns of an event, and of its equations; housing : int or None, the effect."""
    if housing is None:
        return 2
    return 3


@jit
def set_unknowns(values, along, u, events, k, moved) -> None:
    """Set events (n, w) and parameters, in `values` (1, parameters) at `along`, from unknowns of which one has moved.

    u : (w n + parameters,) float, in the order of a curve: each part of all events in turn
    k, moved : number of the one that moves, and by how much
    """
    n, width = events.shape
    for i in range(n):
        for j in range(width):
            events[i, j] = u[j * n + i]
    for j in range(along.size):
        values[0, along[j]] = u[width * n + j]
    if k < width * n:
        events[k % n, k // n] += moved
    else:
        values[0, along[k - width * n]] += moved


@jit
def is_contact(kind) -> bool:
    """Return whether an event is that the mass arrives at a support, or leaves a soft one."""
    return kind in (ENTER, LEAVE, IMPACT, REST_BEGINS)


@jit
def ends_force(kind) -> bool:
    """Return whether an event is that the force of a support that only pushes falls to zero, or rises from it."""
    return kind in (UNLOAD, RELOAD)


@jit
def frame_before(law, i) -> int:
    """Return the frame of the piece that event i ends; of a mirrored law, before event 0, that of its image."""
    if i > 0:
        return law.codes[i - 1, HOME]
    home = law.codes[law.codes.shape[0] - 1, HOME]
    return 3 - home if law.mirrored == 1 and home > 0 else home


@jit
def way_before(law, i):
    """Return in which direction the housing slides before event i, in the frame of `frame_before`; 0 if it is held."""
    if i > 0:
        return law.codes[i - 1, WAY]
    last = law.codes.shape[0] - 1
    way = law.codes[last, WAY]
    return -way if law.mirrored == 1 and law.codes[last, HOME] == 0 else way


@jit
def acts_in(law, i) -> bool:
    """Return whether a soft support acts during piece i; a held mass stays where it was."""
    n = law.codes.shape[0]
    for back in range(n):
        form = law.codes[(i - back) % n, FORM]
        if form != HELD:
            return form == CONTACT
    return False


@jit
def trivial_order(e, p, law, i) -> int:
    """Return the order of the root at span 0 of the condition that ends the piece before event i; 0 if there is none.

    A piece that begins where the condition of its end holds, too, may vanish: its equation is divided by a power of its
    span, so that it stays regular there, and a branch passes the end of a law as any other point.
    """
    before = (i - 1) % law.codes.shape[0]
    kind, began = law.codes[i, CAUSE], law.codes[before, CAUSE]
    if is_contact(kind):
        if law.codes[i, HOME] != frame_before(law, i):
            return 0
        if began == RELEASE:
            return 2 if jumps_at_slip(e, p) else 3
        return 1 if is_contact(began) else 0
    if kind in (TURN, STICK):
        if began in (SLIP, RELEASE):
            return 1 if jumps_at_slip(e, p) else 2
        return 1 if began == TURN else 0
    return stop_order(law, before) if kind == HOUSING_STOP else 0


@jit
def stop_order(law, before) -> int:
    """Return `trivial_order` of the stop of a housing whose piece begins with an event.

    An impact gives it a velocity; any other event at which it begins to slide leaves it without one.
    """
    began = law.codes[before, CAUSE]
    if began == HOUSING_SLIP:
        return 2
    if began in (IMPACT, REST_BEGINS):
        return 0
    return 1 if began == HOUSING_STOP or way_before(law, before) == 0 else 0
