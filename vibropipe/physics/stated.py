"""How an exciter is stated: what it says of wrong keywords, and what it remembers."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Collection, Iterable, Mapping
from copy import copy
from typing import TYPE_CHECKING, Any

from vibropipe.physics.parameter_error import (
    ParameterError,
    check_keywords,
    number_within,
    required,
)
from vibropipe.physics.ties import TIED, Ties
from vibropipe.words.parameters import (
    DEFAULTS,
    FOLLOWING,
    PARAMETERS,
    Acted,
    TiedValue,
    stated_value,
)

if TYPE_CHECKING:
    from vibropipe.physics.exciter import Exciter


class Unstated(float):
    """A parameter that was left out: copies of its exciter with other parameters leave it out, too."""


class Written:
    """What an exciter was made from, beside its fields."""

    __slots__ = ("_written",)

    @property
    def written(self) -> Mapping[str, Any]:
        """The arguments of `from_physical`, as they were given; empty for any other exciter."""
        return getattr(self, "_written", {})

    @property
    def ties(self) -> Mapping[str, str]:
        """The expression of each tied parameter, and of names of one's own; empty for an exciter without ties."""
        return next((value.ties for value in _tied(self).values() if value.ties), {})

    def without_ties(self) -> Exciter:
        """Return the exciter with the values that tied parameters have, each stated."""
        plain: Any = copy(self)
        for name, value in _tied(self).items():
            own, number = getattr(self, name), float(value)
            plain._set(name, Acted(own, number) if isinstance(own, Acted) else number)
        return plain

    def _set(self, name: str, value: Any) -> None:
        object.__setattr__(self, name, value)

    def __setstate__(self, state: Any) -> None:
        fields, slots = state if isinstance(state, tuple) else (state, None)
        for name, value in {**fields, **(slots or {})}.items():
            object.__setattr__(self, name, value)


def telling_keywords(cls: type[Exciter]) -> type[Exciter]:
    """Return the class, whose call takes ties, says of an unknown keyword what could be meant, and what is missing."""
    init, names = cls.__init__, tuple(cls.__dataclass_fields__)

    @functools.wraps(init)
    def checked(
        self: Exciter, *args: Any, ties: Mapping[str, Any] | None = None, **given: Any
    ) -> None:
        check_keywords(given, (*PARAMETERS, "ties"))
        positional = dict(zip(names, args, strict=False))
        kept = [value for value in map(stated_value, given.values()) if _follows(value)]
        if ties is not None or kept:
            args, given = (), _with_tied(positional | given, ties, kept)
        if not args and "l" not in given:
            allowed = PARAMETERS["l"].range.text
            raise ParameterError("l", None, allowed, required(allowed), got="")
        init(self, *args, **given)

    signature = inspect.signature(init)
    last = inspect.Parameter("ties", inspect.Parameter.KEYWORD_ONLY, default=None)
    checked.__signature__ = signature.replace(  # type: ignore[attr-defined]
        parameters=[*signature.parameters.values(), last]
    )
    cls.__init__ = checked  # type: ignore[method-assign]
    return cls


def _follows(value: Any) -> bool:
    return isinstance(value, TiedValue) and bool(value.ties)


def _tied(exciter: Any) -> dict[str, TiedValue]:
    """Return the tied parameters of an exciter."""
    values = ((name, stated_value(value)) for name, value in vars(exciter).items())
    return {name: value for name, value in values if isinstance(value, TiedValue)}


def _with_tied(
    given: Mapping[str, Any], ties: Mapping[str, Any] | None, kept: list[TiedValue]
) -> dict[str, Any]:
    """Return parameters with those that are tied; ParameterError if one cannot be computed, or is stated, too.

    given : as they are stated, or copied from an exciter
    kept : those that were tied in it; where `ties` are not given, what is stated in its place is tied no more, and
        where they are, what they do not tie has the value that it had
    """
    values = {name: stated_value(value) for name, value in given.items()}
    stated = {
        name: value
        for name, value in values.items()
        if not (_follows(value) or value is None or isinstance(value, Unstated))
    }
    if ties is None:
        ties = {name: text for name, text in kept[0].ties.items() if name not in stated}
    tied = Ties(ties)
    stated |= {
        name: float(value)
        for name, value in values.items()
        if _follows(value) and name not in tied.expressions
    }
    differ = {name for name in stated if name in FOLLOWING or stated[name] != DEFAULTS.get(name)}
    # A call may vary the frequency, and asks for it where it does not.
    tied.check(differ if "nu" in tied.expressions else {*differ, "nu"})
    numbers = {
        name: number_within(name, value, PARAMETERS[name].range) for name, value in stated.items()
    }
    found = tied.checked({**DEFAULTS, **numbers})
    left_out = {name: None for name in values if name in FOLLOWING}
    return {**left_out, **stated} | {name: TiedValue(found[name], tied.texts) for name in found}


def ties_of_call(
    exciter: Exciter, ties: Mapping[str, Any] | None, varied: Collection[str] = ()
) -> tuple[Exciter, Ties]:
    """Return an exciter that states nothing that is tied, and its ties with those of a call, which take precedence.

    varied : what the call gives values; a name of one's own that has a number by the exciter's ties varies from it
    """
    called = Ties(ties)
    if not exciter.ties:
        return exciter, called
    own = Ties(exciter.ties)
    given = varied if isinstance(varied, Collection) else ()  # the call says what is wrong with it
    kept = {
        name: text
        for name, text in own.texts.items()
        if name in PARAMETERS or own.expressions[name].names or name not in given
    }
    return own.untied(exciter), Ties({**kept, **called.texts})


def check_untied(exciter: Exciter, argument: str, varied: Iterable[str]) -> None:
    """Raise a ParameterError where a call varies what an exciter ties, or ties others to, and does not follow it."""
    tied = Ties(exciter.ties)
    for name in varied:
        if name in tied.expressions:
            raise ParameterError(argument, name, must=TIED, got="")
        for each in tied.following([name]):
            must = f"must leave {name} as it is: {each} is tied to it, which is not followed here"
            raise ParameterError(argument, name, must=must, got="")


def stated_names(exciter: Exciter) -> set[str]:
    """Return the parameters that an exciter states: those that differ from their default, without l, which all have."""
    own = {name: stated_value(value) for name, value in vars(exciter).items()}
    stated = {name for name, value in own.items() if not isinstance(value, TiedValue)}
    differ = {name for name, default in DEFAULTS.items() if own[name] != default}
    follow = {name for name in FOLLOWING if exciter.states(name)}
    return stated & ((differ - {*FOLLOWING}) | follow)
