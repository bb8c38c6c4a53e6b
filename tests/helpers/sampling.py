"""Cases of a test of which few always run and the others on request (`-m slow`)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def sampled(cases: Iterable[Any], *always: Any) -> list[Any]:
    """Return cases as parameters, of which those in `always`, or else the first, are not marked slow.

    A case that is a plain tuple is one of several parameters.
    """
    known = list(cases)
    kept = always or known[:1]
    return [case if case in kept else _slow(case) for case in known]


def _slow(case: Any) -> Any:
    values = case if type(case) is tuple else (case,)
    return pytest.param(*values, marks=pytest.mark.slow)
