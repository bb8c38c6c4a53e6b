"""Grids of values that a scene runs over, written as a range or as a list."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    WithJsonSchema,
    model_validator,
)

from vibropipe.scenes.keys.values import UNIT_TEXT, Measured, NumberRange, as_number, refuse
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.records import FINITE

MAX_ROWS = 10**8
A_GRID = "a list of numbers, {values: [...]} or {start, stop, points}"


class StudyModel(BaseModel):
    """A mapping of a study; unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def _increasing(values: list[float]) -> list[float]:
    if not values:
        refuse(must="must have at least one number")
    for before, after in itertools.pairwise(values):
        if not before < after:
            refuse(
                "increasing numbers, each once", f"{after!r} after {before!r}", comma_hint(values)
            )
    return values


def comma_hint(values: list[float]) -> str:
    """Return a hint for a list such as [0,5, 1,5], which YAML reads as four numbers."""
    pairs = len(values) % 2 == 0 and all(value == abs(int(value)) for value in values)
    return f"if {values[0]:g}.{values[1]:g} is meant, write it with a point" if pairs else ""


class ValueGrid(StudyModel):
    """Increasing values, written as a list."""

    values: Annotated[list[Measured], AfterValidator(_increasing)] = Field(
        description="Values in increasing order, without duplicates."
    )

    @property
    def size(self) -> int:
        """Number of values."""
        return len(self.values)

    @property
    def low(self) -> float:
        """The first and smallest value."""
        return self.values[0]

    @property
    def high(self) -> float:
        """The last and largest value."""
        return self.values[-1]

    def array(self) -> NDArray[np.float64]:
        """Return the values, shape (size,)."""
        return np.array(self.values, dtype=np.float64)


@dataclass(frozen=True)
class CountRule(NumberRange):
    """A number of values."""

    def convert(self, value: Any) -> float | int:  # noqa: D102 - as Rule
        if as_number(value) == 1:
            refuse(self.allowed, hint="one value is written as a list, such as [0.5]")
        return super().convert(value)


class RangeGrid(StudyModel):
    """`points` values from `start` to `stop`, both included, equally spaced."""

    start: Measured = Field(description="First value.")
    stop: Measured = Field(description="Last value, included; above `start`.")
    points: Annotated[int, CountRule(2, MAX_ROWS, whole=True)] = Field(
        description="Number of values, both ends included."
    )
    spacing: Literal["linear", "log"] = Field(
        default="linear",
        description="Equal steps of the value or of its logarithm (`start` above 0).",
    )

    @model_validator(mode="after")
    def _check_spacing(self) -> Self:
        if not self.start < self.stop:
            found = f"start {self.start!r}, stop {self.stop!r}"
            refuse(found=found, must="must have start below stop")
        if self.spacing == "log" and self.start <= 0:
            refuse(found=f"start {self.start!r}", must="must have start above 0 for log spacing")
        largest = max(abs(self.start), abs(self.stop))
        width = self.stop - self.start
        if self.spacing == "log":
            width = float(np.log(self.stop) - np.log(self.start)) * self.start
            largest = self.start
        # A step below a few spacings of floating-point numbers would repeat values.
        if not np.isfinite(width) or width / (self.points - 1) < 8 * np.spacing(largest):
            found = f"{self.points} points from {self.start!r} to {self.stop!r}"
            refuse(found=found, must="must have points that are distinct floating-point numbers")
        return self

    @property
    def size(self) -> int:
        """Number of values."""
        return self.points

    @property
    def low(self) -> float:
        """The first and smallest value."""
        return self.start

    @property
    def high(self) -> float:
        """The last and largest value."""
        return self.stop

    def array(self) -> NDArray[np.float64]:
        """Return the values, shape (size,); both ends are exact."""
        spaced = np.linspace if self.spacing == "linear" else np.geomspace
        return np.asarray(spaced(self.start, self.stop, self.points), dtype=np.float64)


def _form(value: Any) -> str | None:
    if isinstance(value, ValueGrid) or (isinstance(value, dict) and "values" in value):
        return "<values>"
    if isinstance(value, (dict, RangeGrid)):
        return "<range>"
    return "<list>" if isinstance(value, list) else None


def words_as_numbers(over: Any) -> Any:
    """Return grids in which words that stand for numbers, as of `contact_1`, are these numbers."""
    if not isinstance(over, dict):
        return over
    numbered = dict(over)
    for name, grid in over.items():
        within = PARAMETERS[name].range if name in PARAMETERS else FINITE
        if not within.words or not isinstance(grid, list):
            continue
        if any(isinstance(each, str) and each not in within.words for each in grid):
            refuse(f"a list of {within.text}", hint=f"in {name}")
        numbered[name] = [within.number_of(each) for each in grid]
    return numbered


_WORDS = dict.fromkeys(word for each in PARAMETERS.values() for word in each.range.words)
_LIST_SCHEMA = {
    "type": "array",
    "items": {"anyOf": [{"type": "number"}, UNIT_TEXT, {"enum": [*_WORDS]}]},
    "minItems": 1,
    "title": "values",
}

Grid = Annotated[
    Annotated[ValueGrid, Tag("<values>")]
    | Annotated[RangeGrid, Tag("<range>")]
    | Annotated[
        ValueGrid,
        BeforeValidator(lambda values: {"values": values}),
        WithJsonSchema(_LIST_SCHEMA),
        Tag("<list>"),
    ],
    Discriminator(_form),
]
