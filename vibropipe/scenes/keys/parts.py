"""The mappings that scenes are made of: exciter, start, follow, solver, figure.

Every key has a description: the JSON schema and the table of keys are made from these classes.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from vibropipe.physics.limits import ACCURACY, STEPS_PER_PERIOD
from vibropipe.scenes.keys.grids import StudyModel
from vibropipe.scenes.keys.spelling import latin
from vibropipe.scenes.keys.values import Number, NumberRange, Parameter
from vibropipe.words import parameters as words
from vibropipe.words.methods import Method

ParameterName = Annotated[words.ParameterName, BeforeValidator(latin)]


class ExciterKeys(StudyModel):
    """Parameters of the exciter; one left out takes the shared value, else the effect is absent."""

    nu: Annotated[float | None, Parameter("nu")] = Field(
        default=None, description="Frequency of excitation over the eigenfrequency (1)."
    )
    f: Annotated[float | None, Parameter("f")] = Field(
        default=None, description="Amplitude of excitation (0)."
    )
    h: Annotated[float | None, Parameter("h")] = Field(
        default=None, description="Viscous damping (0)."
    )
    l: Annotated[float | None, Parameter("l")] = Field(  # noqa: E741 - the paper's symbol
        default=None, description="Half the distance between the supports; always needed."
    )
    delta: Annotated[float | None, Parameter("delta")] = Field(
        default=None,
        description="Offset: support 1 is at l + delta, support 2 at -(l - delta) (0).",
    )
    R1: Annotated[float | None, Parameter("R1")] = Field(
        default=None, description="Restitution of support 1 (1)."
    )
    R2: Annotated[float | None, Parameter("R2")] = Field(
        default=None, description="Restitution of support 2 (1)."
    )

    def explicit(self) -> dict[str, float]:
        """Return the parameters that are written down here."""
        return {
            name: getattr(self, name) for name in words.PARAMETERS if name in self.model_fields_set
        }


class Start(StudyModel):
    """Where a motion begins."""

    x0: Annotated[float | None, NumberRange()] = Field(
        default=None,
        description="Displacement at the start, within the supports; left out, the equilibrium or, where that lies "
        "beyond, the support nearest to it.",
    )
    v0: Number = Field(default=0.0, description="Velocity at the start.")


class Follow(StudyModel):
    """Each row is started from the steady state of its neighbour."""

    along: ParameterName = Field(description="The swept parameter that is followed.")
    direction: Literal["up", "down"] = Field(description="From its smallest value up, or down.")


class Solver(StudyModel):
    """How a motion is computed: a method with its step, or the accuracy that is wanted."""

    method: Method = Field(
        default="exact", description="The closed-form flow, or constant average acceleration."
    )
    steps_per_period: Annotated[int | None, NumberRange(*STEPS_PER_PERIOD, whole=True)] = Field(
        default=None, description="Steps of newmark in a forcing period; needed by newmark only."
    )
    accuracy: Annotated[float | None, NumberRange(*ACCURACY)] = Field(
        default=None, description="Error allowed; method and step are then chosen. Stands alone."
    )

    def arguments(self) -> dict[str, Any]:
        """Return what was chosen as keyword arguments of `vibropipe.simulate`."""
        if "accuracy" in self.model_fields_set:
            return {"accuracy": self.accuracy}
        if self.method == "exact":
            return {"method": "exact"}
        return {"method": "newmark", "steps_per_period": self.steps_per_period}


class FigureOptions(StudyModel):
    """What the pictures of a scene show beyond its data; a kind of scene may have its own."""

    def chosen(self) -> tuple[str, ...]:
        """Return the names of the pictures that were chosen; none for the one that fits the data."""
        return ()
