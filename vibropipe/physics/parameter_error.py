"""The error that a parameter or argument raises whose value is not allowed, and the numbers that are."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

from vibropipe.words.parameters import PHYSICAL
from vibropipe.words.records import Range
from vibropipe.words.spelling import hint_of_key
from vibropipe.words.units import UnitError, to_si


class ParameterError(ValueError):
    """A parameter or an argument has a value that is not allowed.

    Its text reads "nu: must be a finite number > 0, got -1.0".

    Parameters
    ----------
    name : str
        Name of the parameter or argument.
    value : Any
        Its value.
    allowed : str
        What it takes, a noun phrase ("a finite number > 0"); `must` if left out.
    must : str
        What must hold, a full predicate; "must be <allowed>" if left out.
    got : str or None
        The value as the text shows it, "" for not at all; `repr(value)` if left out.
    """

    def __init__(
        self, name: str, value: Any, allowed: str = "", must: str = "", got: str | None = None
    ) -> None:
        # All arguments go to the base class: a copy sent to another process is built from them.
        super().__init__(name, value, allowed, must, got)
        self.name, self.value, self.allowed = name, value, allowed or must
        self.must = must or f"must be {allowed}"
        self.got = repr(value) if got is None else got

    def __str__(self) -> str:
        return f"{self.name}: {self.must}" + (f", got {self.got}" if self.got else "")


def check_keywords(given: Iterable[str], known: Collection[str], noun: str = "parameter") -> None:
    """Raise a ParameterError if a keyword is none of the known ones; noun: what they are."""
    for name in given:
        if name not in known:
            must = f"is an unknown {noun}; must be one of {', '.join(known)}"
            raise ParameterError(name, None, must=must + _hint(name, known), got="")


def check_keys(argument: str, given: Iterable[Any], known: Collection[str]) -> None:
    """Raise a ParameterError if a key of a mapping is none of those that the argument takes."""
    for name in given:
        if name not in known:
            must = f"must have keys among {', '.join(known)}"
            raise ParameterError(argument, given, must=must, got=f"{name!r}{_hint(name, known)}")


def _hint(name: Any, known: Collection[str]) -> str:
    hint = hint_of_key(name, known)
    return f" ({hint})" if hint else ""


def required(allowed: str) -> str:
    """Return what must hold of a parameter that is missing, by what it takes."""
    return f"is required ({allowed})"


def as_float(name: str, value: Any, allowed: str) -> float:
    """Return `value` as a float, or raise a ParameterError naming it; text and booleans are not numbers."""
    try:
        if isinstance(value, (str, bytes, bool)):
            raise TypeError
        return float(value)
    except (TypeError, ValueError):
        raise ParameterError(name, value, allowed) from None


def number_within(name: str, value: Any, within: Range) -> float:
    """Return `value`, or the number of the word that it is, as a float in a range, or raise a ParameterError."""
    number = as_float(name, within.number_of(value), within.text)
    if not within.contains(number):
        raise ParameterError(name, number, within.text)
    return number


def si_value(name: str, value: Any) -> float:
    """Return a physical parameter as a number in SI, or raise a ParameterError naming it."""
    physical = PHYSICAL[name]
    try:
        number = to_si(value, physical.dimension, numbers=True)
    except UnitError as error:
        hint = f" ({error.hint})" if error.hint else ""
        must, got = ("", repr(value) + hint) if value is not None else (required(error.allowed), "")
        raise ParameterError(name, value, error.allowed, must, got) from None
    if not physical.range.contains(number):
        raise ParameterError(name, value, physical.range.text)
    return number
