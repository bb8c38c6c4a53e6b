"""Regimes and statuses in words, in figures and reports."""

from __future__ import annotations

import numpy as np

from vibropipe.words.quantities import REGIMES
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status
from vibropipe.words.wording import series

REGIME_TEXT = {name: name.replace("_", " ") for name in REGIMES} | {
    "one_sided_1": "one-sided, support 1",
    "one_sided_2": "one-sided, support 2",
    "two_sided": "two-sided",
}

# Reason why a row is unresolved, by status.
UNRESOLVED_TEXT = {
    Status.MAX_IMPACTS: "too many impacts in a forcing period",
    Status.MAX_PERIODS: "still changing at the end of the march",
    Status.ROOT_BOUND: "impact not located",
    Status.NOT_FINITE: "floating-point overflow",
    Status.LOG_FULL: "more contacts than the log holds",
    Status.SUPPORT_REACHED: "a support left out of the effects is reached",
    Status.MAX_STEPS: "too many steps",
}


def regime_clause(text: str, plural: bool = False) -> str:
    """Write a regime, given as in REGIME_TEXT, as what motions do: `is two-sided`, `has no impact`.

    >>> regime_clause("two-sided"), regime_clause("no impact"), regime_clause("with rest", plural=True)
    ('is two-sided', 'has no impact', 'come to rest on a support')
    """
    if text == REGIME_TEXT["no_impact"]:
        return f"{'have' if plural else 'has'} {text}"
    if text == REGIME_TEXT["with_rest"]:
        return f"{'come' if plural else 'comes'} to rest on a support"
    return f"{'are' if plural else 'is'} {text}"


def regime_name(code: int) -> str:
    """Return the name of a regime's integer value; raises ValueError for an unknown value."""
    return Regime(code).name.lower()


def regime_text(code: int) -> str:
    """Write a regime: `no impact`, `one-sided, support 1`."""
    return REGIME_TEXT[regime_name(code)]


def reasons_text(status: np.ndarray) -> str:
    """Write why rows are unresolved, with the number of rows of each reason if there are several."""
    codes, amounts = np.unique(status, return_counts=True)
    words = [UNRESOLVED_TEXT.get(Status(code), status_words(code)) for code in codes.tolist()]
    if len(words) == 1:
        return words[0]
    return series(f"{text} ({n:,})" for text, n in zip(words, amounts.tolist(), strict=True))


def status_words(code: int) -> str:
    """Write a status in words."""
    if code == Status.MAX_PERIODS:
        return "no orbit found"
    return Status(code).name.lower().replace("_", " ").replace("max ", "too many ")
