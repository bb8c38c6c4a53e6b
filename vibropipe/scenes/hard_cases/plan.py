"""Cost of hard cases."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from vibropipe.scenes.costs import Work
from vibropipe.words.wording import count

if TYPE_CHECKING:
    from vibropipe.scenes.hard_cases.keys import HardCasesScene

# Seconds of cases with very many motions or impacts, and of any other case.
SECONDS_OF_CASES = {
    "grazing_free": 1.0,
    "ideal_free": 2.2,
    "ideal_marched": 2.6,
    "million_periods": 2.0,
}
# Seconds of the questions that are put to common methods as well.
SECONDS_OF_QUESTIONS = {"energy": 3.0, "grazing": 2.0, "chatter": 0.6, "step": 0.7}
SECONDS_PER_CASE, USUAL_CASES = 0.03, 30
HARD_CASES_BYTES = 40e3


def plan(scene: HardCasesScene) -> Work:
    """Return the work of hard cases, from the seconds that each took once."""
    cases = len(scene.cases)
    return Work(
        size=count(cases, "case") if cases else "all cases",
        rows=max(1, cases),
        method="exact, newmark",
        outputs=(),
        seconds=case_seconds(scene.cases)
        + sum(SECONDS_OF_QUESTIONS[question] for question in scene.compare),
        bytes=HARD_CASES_BYTES,
    )


def case_seconds(names: Sequence[str]) -> float:
    """Return the rough seconds of hard cases by name; of all cases if none is named."""
    if not names:
        return sum(SECONDS_OF_CASES.values()) + USUAL_CASES * SECONDS_PER_CASE
    return sum(SECONDS_OF_CASES.get(name, SECONDS_PER_CASE) for name in names)
