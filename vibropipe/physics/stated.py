"""How an exciter is stated: what it says of wrong keywords, and what it remembers."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from vibropipe.physics.parameter_error import ParameterError, check_keywords, required
from vibropipe.words.parameters import PARAMETERS

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

    def __setstate__(self, state: Any) -> None:
        fields, slots = state if isinstance(state, tuple) else (state, None)
        for name, value in {**fields, **(slots or {})}.items():
            object.__setattr__(self, name, value)


def telling_keywords(cls: type[Exciter]) -> type[Exciter]:
    """Return the class, whose call says of an unknown keyword what could be meant, and what is missing."""
    init = cls.__init__

    @functools.wraps(init)
    def checked(self: Exciter, *args: Any, **given: Any) -> None:
        check_keywords(given, tuple(PARAMETERS))
        if not args and "l" not in given:
            allowed = PARAMETERS["l"].range.text
            raise ParameterError("l", None, allowed, required(allowed), got="")
        init(self, *args, **given)

    cls.__init__ = checked  # type: ignore[method-assign]
    return cls
