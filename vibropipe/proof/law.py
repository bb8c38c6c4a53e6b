"""The law of an orbit: its events in turn, and the linear piece of the motion that begins with each."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple


class Kind(IntEnum):
    """What an event is: at a support, or at velocity 0 with friction."""

    IMPACT = 0
    ENTERS = 1
    LEAVES = 2
    TURNS = 3
    STICKS = 4
    SLIPS = 5
    SECTION = 6  # of motions that begin or end there: nothing happens

    @property
    def is_at_support(self) -> bool:
        """Whether the mass is at a support, with a velocity; else it has none, at a displacement."""
        return self <= Kind.LEAVES

    @property
    def is_strike(self) -> bool:
        """Whether a contact begins."""
        return self <= Kind.ENTERS

    @property
    def words(self) -> str:
        """What happens, with a place for the support."""
        return {
            Kind.IMPACT: "impact on support {}",
            Kind.ENTERS: "contact with support {}",
            Kind.LEAVES: "off support {}",
            Kind.TURNS: "turn",
            Kind.STICKS: "stuck",
            Kind.SLIPS: "slip",
            Kind.SECTION: "section",
        }[self]


class Piece(NamedTuple):
    """A linear piece: the soft support that acts, the sign of the velocity that friction opposes; 0 for none.

    Held by friction, the mass stays where it is.
    """

    contact: int = 0
    way: int = 0
    is_held: bool = False


FREE = Piece()


class Event(NamedTuple):
    """An event, its support (0 of those at velocity 0), and the piece after it."""

    kind: Kind
    support: int
    after: Piece


class Law(NamedTuple):
    """The law of an orbit: its forcing periods and its events in turn."""

    m: int
    events: tuple[Event, ...]

    @staticmethod
    def of_impacts(m: int, supports: Sequence[int]) -> Law:
        """Return the law of an orbit between rigid supports, without friction."""
        return Law(m, tuple(Event(Kind.IMPACT, support, FREE) for support in supports))

    @property
    def is_of_impacts(self) -> bool:
        """Whether it is one of rigid supports, without friction."""
        return all(e.kind is Kind.IMPACT and e.after == FREE for e in self.events)

    @property
    def text(self) -> str:
        """The events in words."""
        return ", ".join(event.kind.words.format(event.support) for event in self.events)

    @property
    def strikes(self) -> list[int]:
        """The places of the events with which a contact begins."""
        return [i for i, event in enumerate(self.events) if event.kind.is_strike]

    @property
    def supports(self) -> tuple[int, ...]:
        """The supports struck in turn."""
        return tuple(self.events[i].support for i in self.strikes)
