"""Keys of scenes that search parameters within ranges."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vibropipe.physics.effects import all_effect_names
from vibropipe.scenes.keys.base import BaseScene, plain

if TYPE_CHECKING:
    from vibropipe.scenes.keys.parts import Start


class VariedScene(BaseScene):
    """A search of parameters within ranges."""

    if TYPE_CHECKING:  # each kind describes these keys itself
        vary: dict[Any, list[float]]
        start: Start

    def ranges(self) -> dict[str, tuple[float, float]]:
        """Return the ends of each varied parameter."""
        return {str(name): (ends[0], ends[1]) for name, ends in self.vary.items()}

    def resolved_exciter(self) -> dict[str, float]:  # noqa: D102 - as BaseScene
        lowest = {name: ends[0] for name, ends in self.ranges().items()}
        return {**super().resolved_exciter(), **lowest}

    def extent(self) -> dict[str, Any]:  # noqa: D102 - as BaseScene
        return {**super().extent(), **self.ranges()}

    def data_exciter(self) -> dict[str, float]:  # noqa: D102 - as BaseScene
        return {n: v for n, v in self.resolved_exciter().items() if n not in self.vary}

    def data_keys(self) -> dict[str, Any]:  # noqa: D102 - as BaseScene
        # The equilibrium may lie beyond a support for some of the varied parameters: x0 stays as it is.
        return {**super().data_keys(), "start": plain(self.start)}

    def called_effects(self) -> tuple[str, ...]:
        """Return all effects of the ranges: which of them occur depends on the parameters found."""
        return all_effect_names(
            {**self.resolved_exciter(), **self.ranges()}, pieces=self.COMPUTES_PIECES
        )
