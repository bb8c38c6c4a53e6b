"""What a record of a parameter and of an effect of the exciter has; the records stand in `words.exciter`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Range:
    """Finite numbers from `low` to `high`: without `low` itself if `above`, without fractions if `whole`.

    words : where each number stands for a word, the words from that of 0 on
    """

    low: float = -math.inf
    high: float = math.inf
    above: bool = False
    whole: bool = False
    words: tuple[str, ...] = ()

    def contains(self, value: float) -> bool:
        """Return whether a number lies in the range; nan and infinities lie in none."""
        reaches = value > self.low if self.above else value >= self.low
        fits = math.isfinite(value) and reaches and value <= self.high
        return fits and not (self.whole and value != math.floor(value))

    def number_of(self, value: Any) -> Any:
        """Return the number that a word stands for; of anything else itself."""
        is_word = isinstance(value, str) and value in self.words
        return self.words.index(value) if is_word else value

    def shown(self, number: float) -> float | str:
        """Return the word that a number stands for, or the number."""
        return self.words[int(number)] if self.words else number

    @property
    def text(self) -> str:
        """The range as a noun phrase: "a finite number > 0", "a whole number from 1 to 1e8", "pull or no_pull"."""
        if self.words:
            return " or ".join(self.words)
        low, high = (
            f"{end:g}".replace("e+0", "e").replace("e-0", "e-") for end in (self.low, self.high)
        )
        if math.isfinite(self.high):
            kind = "a whole number" if self.whole else "a number"
            return (
                f"{kind} above {low} up to {high}" if self.above else f"{kind} from {low} to {high}"
            )
        kind = "a whole number" if self.whole else "a finite number"
        return f"{kind} {'>' if self.above else '>='} {low}" if math.isfinite(self.low) else kind


FINITE, NOT_NEGATIVE, POSITIVE = Range(), Range(0), Range(0, above=True)
FRACTION = Range(0, 1)


def one_of(*words: str) -> Range:
    """Return the range of a parameter whose values are words, the first of which is its default."""
    return Range(0, len(words) - 1, whole=True, words=words)


@dataclass(frozen=True)
class Effect:
    """A physical effect that an exciter can have or lack.

    unless : where it is absent: "h = 0"
    shown : the parameters whose values a message shows beside `unless`
    is_common : whether kernels have it unless effects are stated, as all of eqs. (5), (6); others only if parameters
        call for it
    calls : the parameters that call for it by being other than 0; without any, whether it occurs is a question of which
        supports are reached (`physics.effects`)
    is_marched : whether kernels have code for it; a load is an offset of the supports, and has none
    refusal : why calls that do not compute it refuse its parameters: "dry friction is"; "" where all compute it
    sentence : what a report says of it in the line on the model; "" if the equation says it
    occurs : of one with quantities of its own, where these are: "a support is soft"
    name : as in studies and files, the name that the record is assigned to
    """

    unless: str = ""
    shown: tuple[str, ...] = ()
    is_common: bool = False
    calls: tuple[str, ...] = ()
    is_marched: bool = True
    refusal: str = ""
    sentence: str = ""
    occurs: str = ""
    name: str = ""

    def __set_name__(self, owner: type, name: str) -> None:
        object.__setattr__(self, "name", name)


@dataclass(frozen=True)
class Physical:
    """The counterpart of a parameter with units; what is left out is as of the parameter.

    dimension, range : only of a mass M that a pure number m/M stands for.
    """

    name: str
    symbol: str = ""
    plain: str = ""
    long_name: str = ""
    key: str = ""
    dimension: str = ""
    range: Range | None = None


@dataclass(frozen=True)
class Parameter:
    """A parameter of the exciter.

    range, default : its values; the default means "effect absent". None: it is required
    symbol, plain : as matplotlib mathtext and as plain text
    long_name : as in datasets, on axes, and in the help of commands
    words : as beside the drawing of the exciter: two or three words
    key : what a study's key of this name means, a sentence without its full stop
    dimension : one of `words.units.DIMENSIONS`; "" for a pure number
    physical : its counterpart with units, by eqs. (2)-(4)
    effect : the effect that it belongs to; "" for the place of the supports, which are always there
    sign, twin : mirroring x -> -x multiplies it by the sign and exchanges it with the twin, one of the other support
    follows : whether an exciter knows that it was left out: it then only counts periods, or follows from others
    units : of its values without units of length: "rad" of an angle
    acts : how it acts, if through others and on no code of kernels: of each other parameter that it changes, an
        arithmetic expression of parameters, which kernels compile
    name : as in Python, studies and files, the name that the record is assigned to
    """

    range: Range
    default: float | None
    symbol: str
    plain: str
    long_name: str
    words: str
    key: str
    dimension: str = ""
    physical: Physical | None = None
    effect: str = ""
    sign: int = 1
    twin: str = ""
    follows: bool = False
    units: str = "1"
    acts: Mapping[str, str] | None = None
    name: str = ""

    def __set_name__(self, owner: type, name: str) -> None:
        object.__setattr__(self, "name", name)

    @property
    def description(self) -> str:
        """What the key means, with the default, as a sentence."""
        words = self.range.words
        return f"{self.key} ({words[0]})." if words else described(self.key, self.default)


def described(key: str, default: float | None) -> str:
    """Return what a key means with its default as a sentence."""
    return f"{key}; required." if default is None else f"{key} ({default:g})."


def effect_record(*of: Any, **named: Any) -> Any:
    """Return the record of an effect, which a type checker takes for what kernels have under its name."""
    return Effect(*of, **named)


def parameter_record(*of: Any, **named: Any) -> Any:
    """Return the record of a parameter, which a type checker takes for its value."""
    return Parameter(*of, **named)
