"""What a reference solution finds, and what moves beside its mass: nothing, unless a subclass says otherwise."""

from __future__ import annotations

from dataclasses import dataclass, field
from decimal import Decimal

from vibropipe.lab.power_series import Series


@dataclass
class ReferenceMotion:
    """A motion to 20 digits or more.

    events : (tau, kind, support, velocity); kind is one of in, out, impact, turn, stick, slip, rest, release, graze,
        unload, reload.
    states : (x, v) at the requested times.
    """

    events: list[tuple[Decimal, str, int, Decimal]] = field(default_factory=list)
    states: list[tuple[Decimal, Decimal]] = field(default_factory=list)

    @property
    def impacts(self) -> list[tuple[Decimal, int, Decimal]]:
        """Impacts on rigid supports, and beginnings of soft contacts: (tau, support, velocity before)."""
        return [(tau, side, v) for tau, kind, side, v in self.events if kind in ("in", "impact")]


class MassAlone:
    """A mass in a fixed housing."""

    def begin(self) -> None:
        """Prepare what else moves."""

    def struck(self, before: Decimal) -> None:
        """Tell what else moves of an impact on a rigid support, with the velocity before it."""

    def goes_on(self, duration: Decimal) -> bool:
        """Return whether what else moves goes on its way for so long."""
        return True

    def still_until(self) -> Decimal | None:
        """Return the time until what else moves does otherwise while the mass lies still; None for ever."""
        return None

    def changes(self, rests: bool) -> None:
        """Go on from that time: of a mass that rests on a support or is held."""

    def other_event(self, x: Series, span: Decimal) -> Decimal | None:
        """Return when what else moves does otherwise, along a series of x; None if not up to `span`."""
        return None

    def otherwise(self) -> None:
        """Go on from that event."""
