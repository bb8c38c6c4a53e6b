"""What an exciter remembers of how it was stated."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


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
