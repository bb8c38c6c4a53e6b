"""The keys of a scene of hard cases."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from vibropipe.scenes.keys.base import BaseScene, each_once
from vibropipe.scenes.keys.checks import Check, no_exciter
from vibropipe.scenes.keys.problems import Problem, did_you_mean, one_of
from vibropipe.scenes.keys.values import Name
from vibropipe.words.effects import EFFECT_NAMES


class HardCasesScene(BaseScene):
    """Motions with known answers on which numerical methods fail, each by every method."""

    kind: Literal["hard_cases"] = Field(
        description="Known motions on which numerical methods fail, by every method."
    )
    cases: Annotated[list[Name], AfterValidator(each_once)] = Field(
        default=[], description="Names of the cases; all of them if left out."
    )

    def resolved_exciter(self) -> dict[str, float]:
        """Return nothing: each case has its own exciter."""
        return {}

    def called_effects(self) -> tuple[str, ...]:
        """Return all effects: among the cases each occurs."""
        return EFFECT_NAMES


def _cases(scene: HardCasesScene) -> Iterator[Problem]:
    """See that the cases exist, and that the scene is given no exciter: each case has its own."""
    yield from no_exciter(scene, "each case has its own exciter")
    if scene.cases:
        from vibropipe.lab.hard_cases import CASES

        known = [case.name for case in CASES]
        for place, name in enumerate(scene.cases):
            if name not in known:
                hint = did_you_mean(name, known)
                yield Problem(("cases", place), repr(name), one_of(known), hint)


CHECKS = (Check((("cases",),), _cases),)
