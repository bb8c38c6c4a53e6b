"""The mappings that scenes are made of: exciter, start, follow, solver, figure.

The JSON schema and the table of keys are generated from these classes and their descriptions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import (
    BeforeValidator,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    create_model,
)
from pydantic_core import CoreSchema, core_schema

from vibropipe.physics.limits import ACCURACY, LAW_IMPACTS, LAW_PERIODS, LAW_TEXT, STEPS_PER_PERIOD
from vibropipe.scenes.keys.grids import StudyModel
from vibropipe.scenes.keys.values import (
    DisplayUnitRule,
    Measured,
    NameRule,
    NumberOrUnit,
    NumberRange,
    Rule,
    UnitRule,
    as_number,
    refuse,
)
from vibropipe.words import parameters as words
from vibropipe.words.expressions import ALLOWED, NAME
from vibropipe.words.methods import Method
from vibropipe.words.spelling import latin
from vibropipe.words.units import DIMENSIONS as UNITS

# The names of one's own in the ties of a study, in the context of its validation.
OWN = "own"
# Lines of a panel: as many as there are styles of lines.
MAX_LINES = 7
# Dimensions of the units that a study may choose, and their nouns where these are not those of `words.units`.
DISPLAYED = {
    "frequency": "frequencies; Hz and rpm count cycles", "length": "", "time": "",
    "velocity": "velocities", "force": "", "energy": "energies", "torque": "",
    "mass": "the mass", "stiffness": "stiffnesses", "damping": "", "angle": "angles and phases",
}  # fmt: skip
ParameterName = Annotated[words.ParameterName, BeforeValidator(latin)]
_PERIODS, _IMPACTS = (NumberRange(*of, whole=True) for of in (LAW_PERIODS, LAW_IMPACTS))


@dataclass(frozen=True)
class LawRule(Rule):
    """A law of motion: period multiple, and impacts on each support."""

    allowed = f"[m, p1, p2]: {LAW_TEXT}"
    schema: ClassVar[dict[str, Any]] = {
        "type": "array",
        "prefixItems": [_PERIODS.schema, _IMPACTS.schema, _IMPACTS.schema],
        "minItems": 3,
        "maxItems": 3,
    }

    def convert(self, value: Any) -> list[int]:  # noqa: D102 - as Rule
        numbers = [as_number(each) for each in value] if isinstance(value, list) else []
        rules = (_PERIODS, _IMPACTS, _IMPACTS)
        if len(numbers) != 3 or not all(
            number is not None and rule.contains(number)
            for number, rule in zip(numbers, rules, strict=True)
        ):
            refuse(self.allowed, str(value) if isinstance(value, list) else "")
        return [int(number) for number in numbers if number is not None]


Law = Annotated[list[int], LawRule()]


@dataclass(frozen=True)
class OrOwn:
    """A name of a list, or one of those that the ties of the study use, which validation gets as its context."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        def convert(value: Any, known: Any, info: Any) -> Any:
            return value if value in (info.context or {}).get(OWN, ()) else known(value)

        return core_schema.with_info_wrap_validator_function(convert, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {"anyOf": [handler(schema), {"type": "string", "pattern": f"^{NAME.pattern}$"}]}


if TYPE_CHECKING:
    SweptName = str
    OverName = str
    VariedName = str
else:
    SweptName = Annotated[Literal[(*words.PARAMETERS, *words.STARTS)], BeforeValidator(latin)]
    OverName = Annotated[SweptName, OrOwn()]
    VariedName = Annotated[ParameterName, OrOwn()]


@dataclass(frozen=True)
class TieRule(Rule):
    """A number, or an expression as text."""

    allowed = f"a number or {ALLOWED}"
    schema: ClassVar[dict[str, Any]] = {
        "anyOf": [{"type": "number"}, {"type": "string", "minLength": 1}]
    }

    def convert(self, value: Any) -> str:  # noqa: D102 - as Rule
        number = as_number(value)
        if not isinstance(value, str) and number is None:
            refuse(self.allowed)
        return value if isinstance(value, str) else repr(number)


Ties = dict[str, Annotated[str, TieRule()]]


def _parameter_key(name: str) -> Any:
    key = Field(default=None, description=words.PARAMETERS[name].description)
    return Annotated[float | None, NumberRange(**vars(words.PARAMETERS[name].range))], key


def _physical_key(name: str) -> Any:
    key = Field(default=None, description=words.PHYSICAL[name].key)
    return Annotated[float | None, UnitRule(name)], key


def _unit_key(dimension: str) -> Any:
    noun = UNITS[dimension].noun.split(" ", 1)[1]
    text = f"Unit of {DISPLAYED[dimension] or noun + 's'}."
    return Annotated[str | None, DisplayUnitRule(dimension)], Field(default=None, description=text)


def _keys(model: str, of: Callable[[str], Any], names: Iterable[str]) -> Any:
    """Return a model whose keys are made from records."""
    return create_model(model, __base__=StudyModel, **{name: of(name) for name in names})


_ParameterKeys: Any = _keys("_ParameterKeys", _parameter_key, words.PARAMETERS)
_WithUnits: Any = _keys(
    "_WithUnits", _physical_key, [n for n in words.PHYSICAL if n not in ("m", "C")]
)
_Units: Any = _keys("_Units", _unit_key, DISPLAYED)


class ExciterKeys(_ParameterKeys):  # type: ignore[misc]
    """Parameters of the exciter; default: the study's value, else the effect is absent."""

    def explicit(self) -> dict[str, float]:
        """Return the parameters that the study states here."""
        return {
            name: getattr(self, name) for name in words.PARAMETERS if name in self.model_fields_set
        }


class PhysicalKeys(_WithUnits):  # type: ignore[misc]
    """Parameters of the exciter with units, in place of those without; held in SI."""


class StudyPhysical(PhysicalKeys):
    """Parameters with units, shared by all scenes; the mass and the stiffness are those of the whole study."""

    m: Annotated[float, UnitRule("m")] = Field(description=words.PHYSICAL["m"].key)
    C: Annotated[float, UnitRule("C")] = Field(description=words.PHYSICAL["C"].key)


class DisplayUnits(_Units):  # type: ignore[misc]
    """Units in which a study with `physical` shows what it finds; datasets stay in SI."""


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

    along: VariedName = Field(
        description="Swept parameter, or name of one's own in `ties`, to follow."
    )
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
