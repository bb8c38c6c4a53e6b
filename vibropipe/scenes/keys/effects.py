"""Physical effects of a scene: derived from its parameters and their ranges, or stated by `effects`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import AfterValidator

from vibropipe.physics.effects import (
    absent_supports,
    all_effect_names,
    effect_names,
    effects_of,
    missing_effect,
)
from vibropipe.physics.start import largest_start, largest_velocity
from vibropipe.scenes.keys.base import BaseScene, each_once, plain
from vibropipe.scenes.keys.parts import Solver, Start
from vibropipe.scenes.keys.problems import Problem
from vibropipe.scenes.keys.ties import TiedScene
from vibropipe.scenes.keys.values import NotNull
from vibropipe.words.parameters import DEFAULTS, PARAMETERS, Effect
from vibropipe.words.wording import method_text

if TYPE_CHECKING:
    from vibropipe.scenes.keys.parts import Start


_NAME = re.compile(r"[A-Za-z_]\w*")
StatedEffects = Annotated[list[Effect] | None, AfterValidator(each_once), NotNull]
EFFECTS_TEXT = "Physical effects to compute (default: those that the parameters require)."


class ForcedScene(BaseScene):
    """A scene whose motions begin at its `start` and may state their `effects`."""

    if TYPE_CHECKING:  # each kind describes these keys itself
        start: Start
        solver: Solver
        effects: StatedEffects

    def method_text(self) -> str:  # noqa: D102 - as BaseScene
        solver = self.solver.arguments()
        return method_text(solver.get("method", "exact"), solver.get("steps_per_period"))

    def accuracy_asked(self) -> float | None:  # noqa: D102 - as BaseScene
        return self.solver.arguments().get("accuracy")

    def effect_bounds(self) -> tuple[float, dict[str, Any]]:
        """Return the tau until which effects may occur, and further keywords of `effects_of`."""
        raise NotImplementedError

    def effect_arguments(self) -> tuple[tuple[Any, ...], dict[str, Any]]:
        """Return arguments and keywords of `physics.effects.effects_of` for this scene."""
        values = self.extent()
        span, keywords = self.effect_bounds()
        x, v = largest_start(values, self.start.x0), largest_velocity(values, self.start.v0)
        return (values, x, v, span), keywords

    def called_effects(self) -> tuple[str, ...]:  # noqa: D102 - as BaseScene
        if self.effects is not None:
            return tuple(self.effects)
        arguments, keywords = self.effect_arguments()
        return effect_names(effects_of(*arguments, **keywords), arguments[0])


def check_effects(scene: ForcedScene) -> Iterator[Problem]:
    """Check that stated effects include those that the parameters require."""
    if scene.effects is None or not scene.has_l():
        return
    arguments, keywords = scene.effect_arguments()
    missing = missing_effect(scene.effects, *arguments, **keywords)
    if missing is not None:
        must, found = missing
        if scene.mass_and_stiffness is not None:
            effect, unless, where = must.partition(" unless ")
            written = _NAME.sub(lambda match: scene.as_written(match[0]), where)
            # Numbers would be without units.
            must, found = effect + unless + written, found.partition(" with ")[0]
        yield Problem(("effects",), found, must=must)
    for support in absent_supports(scene.effects):
        name = f"R{support[-1]}"
        if name in scene.exciter.explicit() or name in scene.grids():
            key = "over" if name in scene.grids() else "exciter"
            found = repr(scene.resolved_exciter()[name])
            must = f"must be left out unless effects include {support}"
            yield Problem((key, name), found, must=must)


class VariedScene(TiedScene):
    """A search of parameters within ranges."""

    FOLLOWS_TIES = True
    if TYPE_CHECKING:  # each kind describes these keys itself
        vary: dict[Any, list[float]]
        start: Start

    def ranges(self) -> dict[str, tuple[float, float]]:
        """Return the ends of each varied parameter."""
        return {str(name): (ends[0], ends[1]) for name, ends in self.vary.items()}

    def first_values(self) -> dict[str, float]:  # noqa: D102 - as TiedScene
        return {name: ends[0] for name, ends in self.ranges().items()}

    def ends(self) -> dict[str, tuple[float, float]]:
        """Return the ends of each parameter that is varied, or tied to what is."""
        ranges = self.ranges()
        spans = self.tied().spans({**DEFAULTS, **self.given_exciter()}, ranges)
        return {name: ends for name, ends in ranges.items() if name in PARAMETERS} | spans

    def extent(self) -> dict[str, Any]:  # noqa: D102 - as BaseScene
        return {**super().extent(), **self.ends()}

    def data_keys(self) -> dict[str, Any]:  # noqa: D102 - as BaseScene
        # The equilibrium may lie beyond a support for some of the varied parameters: x0 stays as it is.
        return {**super().data_keys(), "start": plain(self.start)}

    def called_effects(self) -> tuple[str, ...]:
        """Return all effects of the ranges: which of them occur depends on the parameters found."""
        return all_effect_names({**self.resolved_exciter(), **self.ends()}, **self.computed())
