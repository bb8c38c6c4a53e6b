"""The values a study's keys take: numbers in a range, counts, text, names, exciter parameters.

Each is an annotation that checks a value, names what is allowed in messages and in the table of
keys, and gives its part of the JSON schema.
"""

from __future__ import annotations

import math
import re
import unicodedata
from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import PurePath
from typing import Annotated, Any, ClassVar, NoReturn

from pydantic import AfterValidator, BeforeValidator, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from vibropipe.words.parameters import PARAMETERS, PHYSICAL
from vibropipe.words.records import FINITE, Range
from vibropipe.words.units import (
    DIMENSIONS,
    MINUS,
    UnitError,
    allowed_text,
    allowed_unit,
    check_unit,
    to_si,
)

REFUSED = "refused"
NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?", re.ASCII)
WITH_UNIT = re.compile(rf"\s*(?:{NUMBER.pattern})\s+[^\W\d_].*", re.ASCII)
DECIMAL_COMMA = re.compile(r"\d,\d", re.ASCII)
NAME = re.compile(r"[a-z][a-z0-9_]{0,63}", re.ASCII)


# In the JSON schema: text with a unit. A bare 0 needs none.
UNIT_TEXT = {"type": "string", "pattern": rf"^\s*{NUMBER.pattern}\s*([^\s\d.,]|1\s*/)"}


class Quoted(str):
    """A number in quotes: valid as a text, not as a number."""


def refuse(allowed: str = "", found: str = "", hint: str = "", must: str = "") -> NoReturn:
    """Refuse a value from within a validator, as `Problem`; `found` is made from the value if empty."""
    context = {"allowed": allowed, "found": found, "hint": hint, "must": must}
    raise PydanticCustomError(REFUSED, "{must}{allowed}", context)


class Rule(ABC):
    """An annotation that replaces pydantic's own reading of a value."""

    @property
    @abstractmethod
    def allowed(self) -> str:
        """What is allowed, a noun phrase."""

    @property
    @abstractmethod
    def schema(self) -> dict[str, Any]:
        """The rule as a JSON schema."""

    @abstractmethod
    def convert(self, value: Any) -> Any:
        """Return the value as the study holds it, or refuse it."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.convert)

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return dict(self.schema)


def as_number(value: Any) -> float | None:
    """Return a number, or text that spells one (`1e-3`), as a float; None for anything else.

    Some YAML readers take `1e-3` for text; quoted text is text on purpose.
    """
    if isinstance(value, Quoted):
        return None
    if isinstance(value, str):
        plain = value.replace(MINUS, "-")
        return float(plain) + 0.0 if NUMBER.fullmatch(plain) else None
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    try:
        return float(value) + 0.0  # -0.0 becomes 0.0: equal numbers must have equal fingerprints
    except OverflowError:
        return math.inf


def number_hint(value: Any) -> str:
    """Return how to write the number that a text was meant to be; empty if there is none."""
    if isinstance(value, Quoted):
        return f"a number stands without quotes: write {value}"
    if isinstance(value, str) and NUMBER.fullmatch(pointed := value.replace(",", ".")):
        return f"write {pointed}, with a point"
    if isinstance(value, str) and WITH_UNIT.fullmatch(value):
        return "no unit belongs here: quantities with units go with `physical`"
    return ""


@dataclass(frozen=True)
class NumberRange(Range, Rule):
    """A number of a range, written as a number or as text that spells one."""

    @property
    def allowed(self) -> str:  # noqa: D102 - as Rule
        return self.text

    @property
    def schema(self) -> dict[str, Any]:  # noqa: D102
        if self.words:
            return {"enum": [*self.words]}
        schema: dict[str, Any] = {"type": "integer" if self.whole else "number"}
        if math.isfinite(self.low):
            schema["exclusiveMinimum" if self.above else "minimum"] = self.low
        if math.isfinite(self.high):
            schema["maximum"] = self.high
        return schema

    def convert(self, value: Any) -> float | int:  # noqa: D102
        number = as_number(self.number_of(value))
        if number is None:
            refuse(self.allowed, hint=number_hint(value))
        if not self.contains(number):
            refuse(self.allowed)
        return int(number) if self.whole else number


@dataclass(frozen=True)
class NumberOrUnit(NumberRange):
    """A number of a range; in a study with `physical`, which is read before, text with a unit stands in its place."""

    @property
    def schema(self) -> dict[str, Any]:  # noqa: D102
        return {"anyOf": [super().schema, UNIT_TEXT]}


@dataclass(frozen=True)
class UnitRule(Rule):
    """A quantity with its unit, held in SI.

    name : its key; of a parameter, dimension and range are those of `PHYSICAL`
    dimension : one of `words.units.DIMENSIONS`
    within : its range in SI
    numbers : whether bare numbers are taken, as numbers in SI
    """

    name: str
    dimension: str = ""
    within: Range = FINITE
    numbers: bool = False
    schema: ClassVar[dict[str, Any]] = {"anyOf": [{"const": 0}, UNIT_TEXT]}

    def __post_init__(self) -> None:
        if not self.dimension:
            dimension, within = PHYSICAL[self.name][:2]
            object.__setattr__(self, "dimension", dimension)
            object.__setattr__(self, "within", within)

    @property
    def allowed(self) -> str:  # noqa: D102
        noun = DIMENSIONS[self.dimension].noun
        bound = self.within.text.removeprefix(FINITE.text)
        return allowed_text(self.dimension, self.numbers).replace(noun, noun + bound, 1)

    def convert(self, value: Any) -> float:  # noqa: D102
        try:
            number = to_si(value, self.dimension, self.numbers)
        except UnitError as error:
            refuse(self.allowed, hint=error.hint)
        if not self.within.contains(number):
            refuse(self.allowed)
        return number


@dataclass(frozen=True)
class DisplayUnitRule(Rule):
    """A unit of a dimension (one of `words.units.DIMENSIONS`), as text."""

    dimension: str
    schema: ClassVar[dict[str, Any]] = {"type": "string", "minLength": 1, "maxLength": 60}

    @property
    def allowed(self) -> str:  # noqa: D102 - as Rule
        return allowed_unit(self.dimension)

    def convert(self, value: Any) -> str:  # noqa: D102
        try:
            return check_unit(value, self.dimension)
        except UnitError as error:
            refuse(self.allowed, hint=error.hint)


def is_allowed(name: str, value: float) -> bool:
    """Return whether a value lies in the range of a parameter, whatever the others are."""
    return PARAMETERS[name].range.contains(value)


@dataclass(frozen=True)
class TextRule(Rule):
    """Text without control characters, of at most `longest` characters."""

    longest: int
    one_line: bool = True

    @property
    def allowed(self) -> str:  # noqa: D102
        line = "one line of text" if self.one_line else "text"
        return f"{line}, at most {self.longest} characters"

    @property
    def schema(self) -> dict[str, Any]:  # noqa: D102
        return {"type": "string", "minLength": 1, "maxLength": self.longest}

    def convert(self, value: Any) -> str:  # noqa: D102
        if not isinstance(value, str):
            refuse(
                self.allowed, hint="put it in quotes if text is meant" if value is not None else ""
            )
        text = value.strip()
        if not text or len(text) > self.longest:
            refuse(self.allowed, f"{len(text)} characters")
        for letter in text:
            newline = letter == "\n" and not self.one_line
            if unicodedata.category(letter) in ("Cc", "Cs", "Cn", "Co", "Zl", "Zp") and not newline:
                refuse(self.allowed, f"the character U+{ord(letter):04X}", "it cannot be printed")
        return text


@dataclass(frozen=True)
class NameRule(Rule):
    """A name that becomes a part of file names."""

    allowed = "a name of a-z, 0-9 and _ that begins with a letter, at most 64 long"
    schema: ClassVar[dict[str, Any]] = {"type": "string", "pattern": f"^{NAME.pattern}$"}

    def convert(self, value: Any) -> str:  # noqa: D102
        if not isinstance(value, str) or not NAME.fullmatch(value):
            # The value may be a file name, or have capital letters.
            stem = PurePath(value).stem.lower() if isinstance(value, str) else ""
            refuse(self.allowed, hint=f"did you mean {stem!r}?" if NAME.fullmatch(stem) else "")
        return value


def _written(value: Any) -> Any:
    if value is None:
        refuse(must="must have a value or be left out")
    return value


# A key with an empty value is a mistake, not the default.
NotNull = BeforeValidator(_written)
Number = Annotated[float, NumberRange()]
Measured = Annotated[float, NumberOrUnit()]
Sigma = Annotated[float, NumberOrUnit(0, above=True)]  # a standard deviation
Name = Annotated[str, NameRule()]


AN_INTERVAL = "two increasing numbers, [low, high]"


def _pair(value: Any) -> Any:
    if not isinstance(value, (list, tuple)):
        refuse(AN_INTERVAL)
    return value


def _interval(ends: list[float]) -> list[float]:
    if len(ends) != 2 or not ends[0] < ends[1]:
        refuse(AN_INTERVAL, f"{ends!r}")
    return ends


Interval = Annotated[list[Measured], BeforeValidator(_pair), AfterValidator(_interval)]
