"""How the search for a design ended."""

from __future__ import annotations

from enum import IntEnum

# Limits (least, largest) of the samples of a round, and of the designs of a search.
DESIGN_SAMPLES, DESIGNS = (8, 10**6), (1, 100)


class DesignResult(IntEnum):
    """Whether all that is wanted of a design holds, or what keeps it from holding; `reason` says it in words."""

    MET = 0
    AT_RANGE = 1
    LAW_CHANGES = 2
    CONFLICTING = 3
    NOT_REACHED = 4

    @property
    def reason(self) -> str:
        """The reason as a clause."""
        return _REASONS[self]


_REASONS = {
    DesignResult.MET: "all that is wanted holds",
    DesignResult.AT_RANGE: "it lies at an end of a range of vary: widen the range",
    DesignResult.LAW_CHANGES: "the law of motion changes there",
    DesignResult.CONFLICTING: "what is wanted conflicts: no small change brings all of it nearer",
    DesignResult.NOT_REACHED: "the motion from the start settles elsewhere: give another start",
}
