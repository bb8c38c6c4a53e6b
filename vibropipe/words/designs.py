"""How the search for a design or for parameters ended."""

from __future__ import annotations

from enum import IntEnum
from typing import Self

# Limits (least, largest) of the samples of a round, and of the designs of a search.
DESIGN_SAMPLES, DESIGNS = (8, 10**6), (1, 100)


class Reasoned(IntEnum):
    """A result; `reason` says it in words, as a clause."""

    reason: str

    def __new__(cls, code: int, reason: str = "") -> Self:  # noqa: D102
        member = int.__new__(cls, code)
        member._value_ = code
        member.reason = reason
        return member


class DesignResult(Reasoned):
    """Whether all that is wanted of a design holds, or what keeps it from holding."""

    MET = 0, "all that is wanted holds"
    AT_RANGE = 1, "it lies at an end of a range of vary: widen the range"
    LAW_CHANGES = 2, "the law of motion changes there"
    CONFLICTING = (
        3,
        "no small change that was tried brings all of it nearer: what is wanted may conflict",
    )
    NOT_REACHED = 4, "the motion from the start settles elsewhere: give another start"


class ToleranceResult(Reasoned):
    """Whether the parameters of a design have tolerances, or why they have none."""

    FOUND = 0
    ON_BOUND = 1, "on the bound"
    LAW_CHANGES = 2, "at a change of law"
    NOT_MET = 3, "not all that is wanted holds"
    GOAL_MISSED = 4, "a tenth of the deviations misses a goal"


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


class Twin(IntEnum):
    """What another set of parameters is that fits measurements as well as the one found."""

    OTHER = 0
    MIRROR_IMAGE = 1
    REVERSED = 2
