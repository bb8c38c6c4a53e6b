"""How the search for a design or for parameters ended."""

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


class ToleranceResult(IntEnum):
    """Whether the parameters of a design have tolerances, or why they have none; `reason` says it in words."""

    FOUND = 0
    ON_BOUND = 1
    LAW_CHANGES = 2
    NOT_MET = 3
    GOAL_MISSED = 4

    @property
    def reason(self) -> str:
        """Why there is no tolerance, as a clause."""
        return _NO_TOLERANCE[self]


_NO_TOLERANCE = {
    ToleranceResult.FOUND: "",
    ToleranceResult.ON_BOUND: "on the bound",
    ToleranceResult.LAW_CHANGES: "at a change of law",
    ToleranceResult.NOT_MET: "not all that is wanted holds",
    ToleranceResult.GOAL_MISSED: "a tenth of the deviations misses a goal",
}


class FitResult(IntEnum):
    """Whether the misfit of a fit to measurements is no larger than their noise."""

    EXPLAINED = 0
    BEYOND_NOISE = 1
    CONSTANT = 2
    ABSENT = 3
    NOT_JUDGED = 4


class FoundResult(IntEnum):
    """Whether measurements determine a parameter, or what its value stands for."""

    DETERMINED = 0
    AT_RANGE = 1
    UNDETERMINED = 2
