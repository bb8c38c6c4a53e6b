"""Keys of effects scenes: motions and rows, each timed by several kernels."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from vibropipe.physics.effects import effect_names, effects_of
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.start import largest_start
from vibropipe.scenes.keys.base import each_once
from vibropipe.scenes.keys.checks import EXCITER, Check
from vibropipe.scenes.keys.motions import MotionKeys, SetOfMotions, check_motions
from vibropipe.scenes.keys.parts import FigureOptions, figure_key
from vibropipe.scenes.keys.problems import KeyPath, Problem, did_you_mean, one_of
from vibropipe.scenes.keys.values import Name, NotNull, NumberRange
from vibropipe.words.effects import COMMON_EFFECTS
from vibropipe.words.outputs import OF_MOTION, OF_STEADY_STATE, Output


class TimedMotion(MotionKeys):
    """One motion, or the row of its steady state, timed by several kernels."""

    of: Literal["motion", "row"] = Field(
        default="motion", description="A march over `periods`, or the steady state."
    )
    outputs: Annotated[list[Output], AfterValidator(each_once)] = Field(
        default=["impacts"],
        description="Outputs: of a motion `impacts`, `motion`; of a row `harmonics`, `impacts`, `stability`, `energy`.",
    )
    against: Annotated[Name | None, NotNull] = Field(
        default=None,
        description="Reference motion of `at_most` (default: the all-effects kernel on the same motion).",
    )
    at_most: Annotated[float | None, NumberRange(0, 1e6, above=True), NotNull] = Field(
        default=None, description="Target: upper limit of the ratio of run times."
    )


class EffectsFigure(FigureOptions):
    """Options of the picture of an effects scene."""

    show: Annotated[list[Literal["time_ratio", "bytes_per_row"]], AfterValidator(each_once)] = (
        Field(
            default=[],
            description="Panels: ratios of run times with their targets, and stored bytes (default: both).",
        )
    )


class EffectsScene(SetOfMotions):
    """Run time and stored bytes by physical effect and by output."""

    COMPUTES_PIECES = True
    kind: Literal["effects"] = Field(description="Cost of each physical effect and each output.")
    figure: EffectsFigure = figure_key(EffectsFigure, "picture")
    motions: Annotated[dict[Name, TimedMotion], Field(min_length=1, max_length=40)] = Field(
        description="Motions and rows to time, by name; one of them is `full`."
    )
    full: Name = Field(
        default="full", description="Motion that contains all effects; reference of every ratio."
    )
    repeats: Annotated[int, NumberRange(1, 1000, whole=True)] = Field(
        default=15, description="Number of timing rounds."
    )

    @property
    def row_count(self) -> int:
        """Number of motions and rows to time."""
        return len(self.motions)

    def effects_of(self, motion: str) -> tuple[str, ...]:
        """Return the effects that the parameters of one motion require."""
        timed, values = self.motions[motion], self.exciter_of(motion)
        span = math.inf if timed.of == "row" else timed.periods * Exciter(**values).period
        start = largest_start(values, timed.start.x0), timed.start.v0
        return effect_names(effects_of(values, *start, span), values)


def _timed(scene: EffectsScene) -> Iterator[Problem]:
    """Check the motions, that `full` has all effects, and that `against` is of the same sort."""
    faults = list(check_motions(scene))
    yield from faults
    if scene.full not in scene.motions:
        allowed = f"a motion of this scene ({', '.join(scene.motions)})"
        yield Problem(("full",), repr(scene.full), allowed, did_you_mean(scene.full, scene.motions))
    elif not faults:
        missing = [name for name in COMMON_EFFECTS if name not in scene.effects_of(scene.full)]
        if missing:
            found = f"a motion without {', '.join(missing)}"
            full: KeyPath = ("motions", scene.full, "exciter")
            yield Problem(full, found, must="must call for all effects")
    for name, timed in scene.motions.items():
        path = ("motions", name)
        fits = OF_STEADY_STATE if timed.of == "row" else OF_MOTION
        for place, output in enumerate(timed.outputs):
            if output not in fits:
                yield Problem((*path, "outputs", place), repr(output), one_of(fits))
        if timed.against is None:
            continue
        same = [other for other, entry in scene.motions.items() if entry.of == timed.of]
        if timed.against not in same:
            words = f"a {timed.of} of this scene ({', '.join(same)})"
            hint = did_you_mean(timed.against, same)
            yield Problem((*path, "against"), repr(timed.against), words, hint)


CHECKS = (Check((*EXCITER, ("motions",)), _timed),)
