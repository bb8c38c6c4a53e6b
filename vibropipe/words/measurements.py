"""Methods that are compared with each other, and outcomes of runs and checks.

`crude` is Newmark's method with impacts at the ends of steps; RK45, DOP853 and Radau are scipy's integrators; heyoka
and solve_nivp are packages of their own.
"""

from __future__ import annotations

from enum import IntEnum
from functools import cache
from importlib.util import find_spec
from typing import Literal, get_args

ComparedMethod = Literal[
    "crude", "newmark", "exact", "RK45", "DOP853", "Radau", "heyoka", "solve_nivp"
]
COMPARED_METHODS: tuple[ComparedMethod, ...] = get_args(ComparedMethod)
OWN_METHODS, SCIPY, PEER_METHODS = (
    COMPARED_METHODS[:3],
    COMPARED_METHODS[3:6],
    COMPARED_METHODS[3:],
)


@cache
def is_installed(method: str) -> bool:
    """Return whether a method can be run: it is of this package, or the one that it is from is installed."""
    return method in OWN_METHODS or find_spec("scipy" if method in SCIPY else method) is not None


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
