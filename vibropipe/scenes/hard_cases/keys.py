"""Keys of hard_cases scenes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from pydantic import Field

from vibropipe.scenes.costs import Work
from vibropipe.scenes.keys.base import BaseScene, EachOnce
from vibropipe.scenes.keys.checks import Check, no_exciter
from vibropipe.scenes.keys.parts import FigureOptions, figure_key
from vibropipe.scenes.keys.problems import Problem, one_of
from vibropipe.scenes.keys.values import Name
from vibropipe.words.parameters import EFFECT_NAMES
from vibropipe.words.spelling import did_you_mean
from vibropipe.words.wording import count

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
HARD_CASES_BYTES = 130e3


class HardCasesFigure(FigureOptions):
    """Options of the pictures of hard cases."""

    pictures: EachOnce[Literal["failures", "margins"]] = Field(
        default=[],
        description="Pictures: where common methods fail (needs `compare`), and the share of each bound that is taken.",
    )
    show: EachOnce[Literal["exact", "newmark 8", "newmark 60", "newmark 2000"]] = Field(
        default=[], description="Solvers of the shares (default: exact and newmark 60)."
    )


class HardCasesScene(BaseScene):
    """Motions with known properties on which numerical methods fail, solved by every method."""

    kind: Literal["hard_cases"] = Field(
        description="Motions with known properties on which numerical methods fail, by every method."
    )
    figure: HardCasesFigure = figure_key(HardCasesFigure)
    cases: EachOnce[Name] = Field(default=[], description="Names of the cases (default: all).")
    compare: EachOnce[Literal["energy", "grazing", "chatter", "step"]] = Field(
        default=[], description="Questions that are put to common methods as well: where they fail."
    )

    def resolved_exciter(self) -> dict[str, float]:
        """Return no parameters, since each case has its own exciter."""
        return {}

    def called_effects(self) -> tuple[str, ...]:
        """Return all effects, since each occurs in some case."""
        return EFFECT_NAMES


def _cases(scene: HardCasesScene) -> Iterator[Problem]:
    """Check that the cases exist and that no exciter is stated, since each case has its own."""
    yield from no_exciter(scene, "each case has its own exciter")
    if scene.cases:
        from vibropipe.lab.hard_cases import CASES

        known = [case.name for case in CASES]
        for place, name in enumerate(scene.cases):
            if name not in known:
                hint = did_you_mean(name, known)
                yield Problem(("cases", place), repr(name), one_of(known), hint)


CHECKS = (Check((("cases",),), _cases),)


def plan(scene: HardCasesScene) -> Work:
    """Return the work of hard cases, from the seconds that each took once."""
    cases = len(scene.cases)
    seconds = sum(SECONDS_OF_CASES.get(name, SECONDS_PER_CASE) for name in scene.cases)
    if not cases:
        seconds = sum(SECONDS_OF_CASES.values()) + USUAL_CASES * SECONDS_PER_CASE
    return Work(
        size=count(cases, "case") if cases else "all cases",
        rows=max(1, cases),
        method="exact, newmark",
        seconds=seconds + sum(SECONDS_OF_QUESTIONS[question] for question in scene.compare),
        bytes=HARD_CASES_BYTES,
    )
