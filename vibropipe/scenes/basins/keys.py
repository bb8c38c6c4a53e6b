"""Keys of basins scenes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from vibropipe.physics.exciter import Exciter, ParameterError
from vibropipe.physics.start import start_room
from vibropipe.scenes.keys.base import BaseScene, Harmonics, each_once
from vibropipe.scenes.keys.checks import EXCITER_CHECK, SUPPORTS, Check, check_rows
from vibropipe.scenes.keys.grids import Grid, RangeGrid, StudyModel, ValueGrid
from vibropipe.scenes.keys.parts import FigureOptions
from vibropipe.scenes.keys.problems import Problem
from vibropipe.scenes.keys.values import NumberRange
from vibropipe.words.effects import EFFECT_NAMES


class StartGrids(StudyModel):
    """Grid of starts."""

    x0: Grid = Field(description="Initial displacements, between the supports.")
    v0: Grid = Field(description="Initial velocities.")


class BasinsFigure(FigureOptions):
    """Options of the picture of basins."""

    show: Annotated[
        list[Literal["attractor", "periods_to_attractor"]], AfterValidator(each_once)
    ] = Field(
        default=[],
        description="Maps: the attractor of each start, and the forcing periods until it settles (default: both).",
    )


class BasinsScene(BaseScene):
    """Coexisting motions of one exciter, and which of them each start of a grid settles on."""

    kind: Literal["basins"] = Field(
        description="Coexisting motions, and the starts that settle on them."
    )
    figure: BasinsFigure = Field(
        default_factory=BasinsFigure,
        description="Options of the picture; data do not depend on them.",
    )
    over: StartGrids = Field(description="Grid of the starts.")
    phase: Annotated[float, NumberRange(0, 1)] = Field(
        default=0.0,
        description="Phase of the force at the start, as a fraction of a forcing period.",
    )
    harmonics: Harmonics = Field(default=6, description="Number of harmonics of each motion.")
    starts: Annotated[int, NumberRange(1, 10**7, whole=True)] = Field(
        default=4096,
        description="Scattered starts that look for motions beside the grid.",
    )

    def grids(self) -> dict[str, ValueGrid | RangeGrid]:  # noqa: D102 - as BaseScene
        return {"x0": self.over.x0, "v0": self.over.v0}

    def called_effects(self) -> tuple[str, ...]:
        """Return all effects: which of them occur depends on the start."""
        return EFFECT_NAMES


def _starts(scene: BasinsScene) -> Iterator[Problem]:
    """Check that the displacements lie between the supports."""
    if not scene.has_l():
        return
    try:
        exciter = Exciter(**scene.resolved_exciter())
    except ParameterError:
        return  # reported by `EXCITER_CHECK`
    least, most = start_room(exciter.l, exciter.delta)
    for value in dict.fromkeys((scene.over.x0.low, scene.over.x0.high)):
        if not least <= value <= most:
            allowed = f"numbers from {exciter.lower!r} to {exciter.upper!r} (between the supports)"
            yield Problem(("over", "x0"), repr(value), allowed)
            return


CHECKS = (
    EXCITER_CHECK,
    Check((*SUPPORTS, ("over", "x0")), _starts),
    Check((("over",),), lambda scene: check_rows(scene, ("over",))),
)
