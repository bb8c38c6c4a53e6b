"""Keys of effects scenes: motions and rows, each timed beside the one it is compared with."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from vibropipe.scenes.costs import HEAD_BYTES, Work
from vibropipe.scenes.keys.base import EachOnce, Title
from vibropipe.scenes.keys.checks import EXCITER, Check
from vibropipe.scenes.keys.motions import MotionKeys, SetOfMotions, check_motions
from vibropipe.scenes.keys.problems import Problem, one_of
from vibropipe.scenes.keys.values import Name, NotNull, NumberRange
from vibropipe.words.outputs import OF_MOTION, OUTPUTS, Output
from vibropipe.words.spelling import did_you_mean
from vibropipe.words.wording import count

SECONDS_PER_TRIAL, SECONDS_PER_ROUND = 0.1, 0.012
TRIAL_BYTES = 400


class TimedMotion(MotionKeys):
    """One motion, or the row of its steady state, to time."""

    of: Literal["motion", "row"] = Field(
        default="motion", description="A march over `periods`, or the steady state."
    )
    outputs: EachOnce[Output] = Field(
        default=["impacts"],
        description="Outputs: of a motion `impacts`, `motion`; of a row any of a sweep.",
    )
    kernel: Literal["own", "all"] = Field(
        default="own",
        description="Kernel: of the motion's effects, or of all effects, as if none were left out.",
    )
    against: Annotated[Name | None, NotNull] = Field(
        default=None,
        description="Whose time is the 1 of its ratio (default: the first motion, or row, of the scene).",
    )
    title: Title = Field(default="", description="What is timed, in words (default: its name).")
    group: Title = Field(
        default="", description="Group of the price list (default: that of the one before)."
    )


class EffectsScene(SetOfMotions):
    """Run time and stored bytes by physical effect and by output."""

    COMPUTES_PIECES = True
    COMPUTES_HOUSING = True
    kind: Literal["effects"] = Field(description="Cost of each physical effect and each output.")
    motions: Annotated[dict[Name, TimedMotion], Field(min_length=1, max_length=40)] = Field(
        description="Motions and rows to time, by name."
    )
    repeats: Annotated[int, NumberRange(1, 1000, whole=True)] = Field(
        default=15, description="Number of timing rounds."
    )

    @property
    def row_count(self) -> int:
        """Number of motions and rows to time."""
        return len(self.motions)

    def reference_of(self, motion: str) -> str:
        """Return the name of the motion whose time is the 1 of another's ratio."""
        timed = self.motions[motion]
        first = next(name for name, entry in self.motions.items() if entry.of == timed.of)
        return timed.against or first


def _timed(scene: EffectsScene) -> Iterator[Problem]:
    """Check the motions, their outputs, that `against` is of the same sort, and that some are compared."""
    yield from check_motions(scene)
    if all(
        timed.against is None and scene.reference_of(name) == name
        for name, timed in scene.motions.items()
    ):
        must = "must have a motion, or a row, to compare with the first one"
        yield Problem(("motions",), ", ".join(scene.motions), must=must)
    for name, timed in scene.motions.items():
        path = ("motions", name)
        fits = OUTPUTS if timed.of == "row" else OF_MOTION
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


def plan(scene: EffectsScene) -> Work:
    """Return the work of an effects scene, from its motions and timing rounds."""
    return Work(
        size=count(scene.row_count, "motion"),
        rows=scene.row_count,
        seconds=scene.row_count * (SECONDS_PER_TRIAL + scene.repeats * SECONDS_PER_ROUND),
        bytes=HEAD_BYTES + scene.row_count * TRIAL_BYTES,
    )
