"""What measurements of the program name: methods set side by side, and what became of a run or a check.

`crude` is Newmark's method with impacts at the ends of steps; RK45, DOP853 and Radau are those of scipy.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Literal, get_args

ComparedMethod = Literal["crude", "newmark", "exact", "RK45", "DOP853", "Radau", "heyoka"]
COMPARED_METHODS: tuple[ComparedMethod, ...] = get_args(ComparedMethod)
OWN_METHODS, SCIPY, PEER_METHODS = (
    COMPARED_METHODS[:3],
    COMPARED_METHODS[3:6],
    COMPARED_METHODS[3:],
)


class Outcome(IntEnum):
    """How a method got through a motion it was timed on."""

    OK = 0
    MISSED_IMPACT = 1
    FELL_THROUGH = 2
    DID_NOT_END = 3
    NOT_TRIED = 4
    NOT_INSTALLED = 5


class Passed(IntEnum):
    """Whether a check is passed, or a target met."""

    NOT_PASSED = 0
    PASSED = 1
    NOT_ASKED = 2
