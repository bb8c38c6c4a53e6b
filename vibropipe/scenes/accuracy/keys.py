"""Keys of accuracy scenes: motions, each solved by several methods at several settings."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import AfterValidator, Field

from vibropipe.physics.limits import ACCURACY, STEPS_PER_PERIOD
from vibropipe.scenes.costs import HEAD_BYTES, Work
from vibropipe.scenes.keys.base import EachOnce, each_once
from vibropipe.scenes.keys.checks import EXCITER, Check
from vibropipe.scenes.keys.motions import MotionKeys, SetOfMotions, check_motions
from vibropipe.scenes.keys.parts import FigureOptions, figure_key
from vibropipe.scenes.keys.values import Name, NumberRange
from vibropipe.words.measurements import (
    COMPARED_METHODS,
    PEER_METHODS,
    ComparedMethod,
    is_installed,
)
from vibropipe.words.vocabulary import drawn_by
from vibropipe.words.wording import count

# Seconds per run of an own method, and of another package, whether or not it is installed.
SECONDS_PER_RUN, SECONDS_PER_PEER_RUN = 0.05, 0.25
BYTES_PER_RUN = 89
Methods = Annotated[list[ComparedMethod], Field(min_length=1), AfterValidator(each_once)]
Steps = Annotated[int, NumberRange(*STEPS_PER_PERIOD, whole=True)]
Tolerance = Annotated[float, NumberRange(1e-14, 0.1)]
Accuracy = Annotated[float, NumberRange(*ACCURACY)]
BY_STEPS = ("crude", "newmark", "solve_nivp")


if TYPE_CHECKING:
    Shown = str
else:
    Shown = Literal[drawn_by("accuracy")]


class AccuracyFigure(FigureOptions):
    """Options of the pictures of an accuracy scene."""

    pictures: EachOnce[Literal["work_precision", "asked"]] = Field(
        default=[],
        description="Pictures: time over error, and what is asked of the program and reached (default: what fits).",
    )

    show: EachOnce[Shown] = Field(
        default=[], description="Errors of which the largest is drawn (default: all)."
    )


class AccuracyScene(SetOfMotions):
    """Work-precision data: error and time of several methods on several motions."""

    COMPUTES_PIECES = True

    kind: Literal["accuracy"] = Field(
        description="Error and time of several methods (work-precision)."
    )
    figure: AccuracyFigure = figure_key(AccuracyFigure)
    motions: Annotated[dict[Name, MotionKeys], Field(min_length=1, max_length=24)] = Field(
        description="Motions by name, each with `exciter`, `start` and `periods`."
    )
    methods: Methods = Field(
        default=list(COMPARED_METHODS),
        description="Methods to compare; the last five are of other packages, left out where not installed.",
    )
    steps_per_period: Annotated[list[Steps], Field(min_length=1)] = Field(
        default=[16, 64, 256, 1024, 4096, 16384],
        description="Settings of crude, newmark and solve_nivp: steps per forcing period.",
    )
    tolerances: Annotated[list[Tolerance], Field(min_length=1)] = Field(
        default=[1e-4, 1e-7, 1e-10],
        description="Settings of the other packages: relative tolerances.",
    )
    accuracies: EachOnce[Accuracy] = Field(
        default=[], description="Accuracies to ask of the program, on each motion."
    )
    repeats: Annotated[int, NumberRange(1, 1000, whole=True)] = Field(
        default=7, description="Number of timing rounds."
    )

    @property
    def row_count(self) -> int:
        """Number of runs, each of a motion by a method at a setting."""
        return len(self.motions) * sum(len(self.settings(method)) for method in self.methods)

    def method_text(self) -> str:  # noqa: D102 - as BaseScene
        run = ", ".join(each for each in self.methods if is_installed(each))
        absent = ", ".join(each for each in self.methods if not is_installed(each))
        return f"{run or 'none'}; not installed: {absent}" if absent else run

    def settings(self, method: ComparedMethod) -> list[float]:
        """Return the settings of a method; the exact method has none, written as 0."""
        if method == "exact":
            return [0.0]
        return [*(self.steps_per_period if method in BY_STEPS else self.tolerances)]


CHECKS = (Check((*EXCITER, ("motions",)), check_motions),)


def plan(scene: AccuracyScene) -> Work:
    """Return the work of an accuracy scene; runs of other packages take longer."""
    peers = len(scene.motions) * sum(
        len(scene.settings(method)) for method in scene.methods if method in PEER_METHODS
    )
    return Work(
        size=count(len(scene.motions), "motion"),
        rows=scene.row_count,
        method=scene.method_text(),
        seconds=(scene.row_count - peers) * SECONDS_PER_RUN + peers * SECONDS_PER_PEER_RUN,
        bytes=HEAD_BYTES + scene.row_count * BYTES_PER_RUN,
    )
