"""Methods that are compared with each other, and outcomes of runs and checks.

`crude` is Newmark's method with impacts at the ends of steps; RK45, DOP853 and Radau are scipy's integrators.
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
    """Outcome of a run of a method on a motion."""

    OK = 0
    MISSED_IMPACT = 1
    FELL_THROUGH = 2
    DID_NOT_END = 3
    NOT_TRIED = 4
    NOT_INSTALLED = 5


class Passed(IntEnum):
    """Whether a check is passed or a target met; NOT_ASKED means "not applicable"."""

    NOT_PASSED = 0
    PASSED = 1
    NOT_ASKED = 2
