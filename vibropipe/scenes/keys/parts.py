"""The mappings that scenes are made of: exciter, start, follow, solver, figure.

The JSON schema and the table of keys are generated from these classes and their descriptions.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from vibropipe.physics.limits import ACCURACY, STEPS_PER_PERIOD
from vibropipe.scenes.keys.grids import StudyModel
from vibropipe.scenes.keys.values import (
    DisplayUnitRule,
    Measured,
    NameRule,
    NumberOrUnit,
    NumberRange,
    UnitRule,
    parameter_range,
)
from vibropipe.words import parameters as words
from vibropipe.words.methods import Method
from vibropipe.words.spelling import latin

# Lines of a panel: as many as there are styles of lines.
MAX_LINES = 7
ParameterName = Annotated[words.ParameterName, BeforeValidator(latin)]
SweptName = Annotated[Literal[words.ParameterName, "x0", "v0"], BeforeValidator(latin)]


class ExciterKeys(StudyModel):
    """Parameters of the exciter; default: the study's value, else the effect is absent."""

    nu: Annotated[float | None, parameter_range("nu")] = Field(
        default=None, description="Excitation frequency divided by the eigenfrequency (1)."
    )
    f: Annotated[float | None, parameter_range("f")] = Field(
        default=None, description="Amplitude of the excitation (0)."
    )
    h: Annotated[float | None, parameter_range("h")] = Field(
        default=None, description="Viscous damping (0)."
    )
    l: Annotated[float | None, parameter_range("l")] = Field(  # noqa: E741 - the paper's symbol
        default=None, description="Half the distance between the supports; required."
    )
    delta: Annotated[float | None, parameter_range("delta")] = Field(
        default=None,
        description="Offset of the equilibrium: support 1 at l + delta, support 2 at -(l - delta) (0).",
    )
    R1: Annotated[float | None, parameter_range("R1")] = Field(
        default=None, description="Coefficient of restitution of support 1 (1)."
    )
    R2: Annotated[float | None, parameter_range("R2")] = Field(
        default=None, description="Coefficient of restitution of support 2 (1)."
    )
    k1: Annotated[float | None, parameter_range("k1")] = Field(
        default=None, description="Stiffness of support 1; a support without it is rigid (0)."
    )
    k2: Annotated[float | None, parameter_range("k2")] = Field(
        default=None, description="Stiffness of support 2 (0)."
    )
    h1: Annotated[float | None, parameter_range("h1")] = Field(
        default=None, description="Damping of support 1, for k1 > 0 (0)."
    )
    h2: Annotated[float | None, parameter_range("h2")] = Field(
        default=None, description="Damping of support 2, for k2 > 0 (0)."
    )
    load: Annotated[float | None, parameter_range("load")] = Field(
        default=None, description="Constant force (0)."
    )
    friction: Annotated[float | None, parameter_range("friction")] = Field(
        default=None, description="Dry friction (0)."
    )
    f2: Annotated[float | None, parameter_range("f2")] = Field(
        default=None, description="Amplitude of the second harmonic of the excitation (0)."
    )
    phi2: Annotated[float | None, parameter_range("phi2")] = Field(
        default=None,
        description="Phase of the second harmonic, f2 sin(2 nu tau + phi2), in radians (0).",
    )

    def explicit(self) -> dict[str, float]:
        """Return the parameters that the study states here."""
        return {
            name: getattr(self, name) for name in words.PARAMETERS if name in self.model_fields_set
        }


class PhysicalKeys(StudyModel):
    """Parameters of the exciter with units, in place of those without; held in SI."""

    omega: Annotated[float | None, UnitRule("omega")] = Field(
        default=None,
        description="Angular frequency of the excitation; in Hz it counts cycles: 9 Hz is 2 pi 9 rad/s.",
    )
    F: Annotated[float | None, UnitRule("F")] = Field(
        default=None, description="Amplitude of the excitation (0)."
    )
    H: Annotated[float | None, UnitRule("H")] = Field(
        default=None, description="Viscous damping (0)."
    )
    l: Annotated[float | None, UnitRule("l")] = Field(  # noqa: E741 - the paper's symbol
        default=None, description="Half the distance between the supports; required."
    )
    delta: Annotated[float | None, UnitRule("delta")] = Field(
        default=None, description="Offset of the equilibrium (0)."
    )
    C1: Annotated[float | None, UnitRule("C1")] = Field(
        default=None, description="Stiffness of support 1; a support without it is rigid (0)."
    )
    C2: Annotated[float | None, UnitRule("C2")] = Field(
        default=None, description="Stiffness of support 2 (0)."
    )
    H1: Annotated[float | None, UnitRule("H1")] = Field(
        default=None, description="Damping of support 1, for C1 > 0 (0)."
    )
    H2: Annotated[float | None, UnitRule("H2")] = Field(
        default=None, description="Damping of support 2, for C2 > 0 (0)."
    )
    load: Annotated[float | None, UnitRule("load")] = Field(
        default=None, description="Constant force (0)."
    )
    slope: Annotated[float | None, UnitRule("slope")] = Field(
        default=None,
        description="Angle at which x rises: gravity adds -m gravity sin(slope) to the load (0).",
    )
    gravity: Annotated[float | None, UnitRule("gravity")] = Field(
        default=None, description="Acceleration of gravity, beside slope (9.80665 m/s^2)."
    )
    friction: Annotated[float | None, UnitRule("friction")] = Field(
        default=None, description="Dry friction (0)."
    )
    F2: Annotated[float | None, UnitRule("F2")] = Field(
        default=None, description="Amplitude of the second harmonic of the excitation (0)."
    )
    phi2: Annotated[float | None, UnitRule("phi2")] = Field(
        default=None, description="Phase of the second harmonic, F2 sin(2 omega t + phi2) (0)."
    )


class StudyPhysical(PhysicalKeys):
    """Parameters with units, shared by all scenes; the mass and the stiffness are those of the whole study."""

    m: Annotated[float, UnitRule("m")] = Field(description="Mass.")
    C: Annotated[float, UnitRule("C")] = Field(description="Stiffness of the spring.")


class DisplayUnits(StudyModel):
    """Units in which a study with `physical` shows what it finds; datasets stay in SI."""

    frequency: Annotated[str | None, DisplayUnitRule("frequency")] = Field(
        default=None, description="Unit of frequencies; Hz and rpm count cycles."
    )
    length: Annotated[str | None, DisplayUnitRule("length")] = Field(
        default=None, description="Unit of lengths."
    )
    time: Annotated[str | None, DisplayUnitRule("time")] = Field(
        default=None, description="Unit of times."
    )
    velocity: Annotated[str | None, DisplayUnitRule("velocity")] = Field(
        default=None, description="Unit of velocities."
    )
    force: Annotated[str | None, DisplayUnitRule("force")] = Field(
        default=None, description="Unit of forces."
    )
    energy: Annotated[str | None, DisplayUnitRule("energy")] = Field(
        default=None, description="Unit of energies."
    )
    mass: Annotated[str | None, DisplayUnitRule("mass")] = Field(
        default=None, description="Unit of the mass."
    )
    stiffness: Annotated[str | None, DisplayUnitRule("stiffness")] = Field(
        default=None, description="Unit of stiffnesses."
    )
    damping: Annotated[str | None, DisplayUnitRule("damping")] = Field(
        default=None, description="Unit of dampings."
    )
    angle: Annotated[str | None, DisplayUnitRule("angle")] = Field(
        default=None, description="Unit of angles and phases."
    )


class Start(StudyModel):
    """State at tau = 0."""

    x0: Annotated[float | None, NumberOrUnit()] = Field(
        default=None,
        description="Initial displacement, not beyond a rigid support (default: the equilibrium or, if that lies "
        "beyond a support, the support).",
    )
    v0: Measured = Field(default=0.0, description="Initial velocity.")


class Follow(StudyModel):
    """Start each row from the steady state of its neighbour."""

    along: ParameterName = Field(description="Swept parameter to follow.")
    direction: Literal["up", "down", "both"] = Field(
        description="Upwards from its smallest value, downwards from its largest, or both: the dataset then has the "
        "dimension `direction`."
    )


class Solver(StudyModel):
    """A method with its step size, or an accuracy."""

    method: Method = Field(
        default="exact",
        description="Closed-form flow, or Newmark's method (constant average acceleration).",
    )
    steps_per_period: Annotated[int | None, NumberRange(*STEPS_PER_PERIOD, whole=True)] = Field(
        default=None,
        description="Steps per forcing period; required by newmark, not applicable to exact.",
    )
    accuracy: Annotated[float | None, NumberRange(*ACCURACY)] = Field(
        default=None, description="Maximum error; selects method and step, excludes both keys."
    )

    def arguments(self) -> dict[str, Any]:
        """Return the solver as keyword arguments of `vibropipe.simulate`."""
        if "accuracy" in self.model_fields_set:
            return {"accuracy": self.accuracy}
        if self.method == "exact":
            return {"method": "exact"}
        return {"method": "newmark", "steps_per_period": self.steps_per_period}


class FigureOptions(StudyModel):
    """Options of the pictures of a scene; a kind of scene may have its own."""

    def chosen(self) -> tuple[str, ...]:
        """Return the names of the chosen pictures; empty for the first one that fits the data."""
        return tuple(getattr(self, "pictures", ()))

    def shown_scenes(self) -> tuple[str, ...]:
        """Return the names of other scenes whose data the pictures show: the options that are names."""
        names = [
            getattr(self, name)
            for name, field in type(self).model_fields.items()
            if any(isinstance(rule, NameRule) for rule in field.metadata)
        ]
        return tuple(name for name in (*names, *self.drawn_together()) if name is not None)

    def drawn_together(self) -> tuple[str, ...]:
        """Return the names of the scenes that are drawn in the first picture of this one."""
        return tuple(getattr(self, "together", ()))


def figure_key(options: type[FigureOptions], pictures: str = "pictures") -> Any:
    """Return the key `figure` of a kind of scenes, of which one or several pictures are drawn."""
    text = f"Options of the {pictures}; data do not depend on them."
    return Field(default_factory=options, description=text)
