"""What scenes of every kind have, and the kinds of values they share."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, PrivateAttr

from vibropipe.physics.limits import HARMONICS
from vibropipe.study.grids import Keys, RangeGrid, ValueGrid
from vibropipe.study.parts import ExciterKeys, FigureOptions
from vibropipe.study.values import Within, Words, refuse

Output = Literal["harmonics", "impacts", "motion", "stability", "energy"]
Title = Annotated[str, Words(200)]
Prose = Annotated[str, Words(4000, one_line=False)]
Harmonics = Annotated[int, Within(*HARMONICS, whole=True)]

DEFAULTS = {"nu": 1.0, "f": 0.0, "h": 0.0, "delta": 0.0, "R1": 1.0, "R2": 1.0}


def each_once(names: list[Any]) -> list[Any]:
    """Refuse a list that names something twice."""
    if len(set(names)) < len(names):
        refuse("each name once", ", ".join(names))
    return names


Outputs = Annotated[list[Output], Field(min_length=1), AfterValidator(each_once)]


class BaseScene(Keys):
    """What scenes of every kind have; `name` is the scene's key in the study."""

    title: Title = Field(default="", description="Title of the scene.")
    caption: Prose = Field(default="", description="What to see in the figure.")
    exciter: ExciterKeys = Field(
        default_factory=ExciterKeys, description="Parameters that differ from the study's."
    )
    figure: FigureOptions = Field(
        default_factory=FigureOptions,
        description="Options of the picture; no data depends on them.",
    )
    _name: str = PrivateAttr("")
    _shared: dict[str, float] = PrivateAttr(default_factory=dict)

    @property
    def name(self) -> str:
        """The scene's name in its study."""
        return self._name

    @property
    def row_count(self) -> int:
        """Number of rows that are solved."""
        return math.prod(grid.size for grid in self.grids().values())

    def grids(self) -> dict[str, ValueGrid | RangeGrid]:
        """Return the grids the scene runs over, in the order of its dimensions."""
        return {}

    def over_arrays(self) -> dict[str, NDArray[np.float64]]:
        """Return the same grids as arrays, each of shape (size of its dimension,)."""
        return {name: grid.array() for name, grid in self.grids().items()}

    def resolved_exciter(self) -> dict[str, float]:
        """Return all seven parameters: the scene's own, else the study's, else "effect absent".

        A swept parameter stands with the first value of its grid.
        """
        return {**DEFAULTS, **self._shared, **self.exciter.given()}
