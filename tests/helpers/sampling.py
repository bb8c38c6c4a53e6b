"""Cases of a test of which few always run and the others on request (`-m slow`)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def sampled(cases: Iterable[Any], *always: Any) -> list[Any]:
    """Return cases as parameters, of which those in `always`, or else the first, are not marked slow."""
    known = list(cases)
    kept = always or known[:1]
    return [case if case in kept else pytest.param(case, marks=pytest.mark.slow) for case in known]
