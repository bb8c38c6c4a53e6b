"""Ties of scenes: parameters by expressions of others, or of names of one's own that a scene gives values."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping
from contextlib import suppress
from typing import Any

import numpy as np
from pydantic import Field

from vibropipe.physics.exciter import ParameterError
from vibropipe.physics.ties import Ties
from vibropipe.scenes.keys import parts
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.keys.problems import Problem, argument_path, refused, unknown
from vibropipe.words.expressions import Expression, ExpressionError
from vibropipe.words.parameters import DEFAULTS, PARAMETERS, PHYSICAL, STARTS


class TiedScene(BaseScene):
    """A scene whose parameters may be tied to each other."""

    ties: parts.Ties = Field(
        default={},
        description="Parameters by expressions of others or of names of one's own: `{R2: R1, f: 0.02 * nu**2}`.",
    )

    def all_ties(self) -> Ties:
        """Return the ties of the study and of the scene, which take precedence.

        Raises ParameterError if they cannot be read, a name has no value, or two, or varies where no tie follows it.
        """
        ties = _read(tuple({**self._shared_ties, **self.ties}.items()))
        # What the study states and a scene ties is tied there, as it is swept where a scene sweeps it.
        stated = (self._shared.keys() - self.ties.keys()) | self.exciter.explicit().keys()
        varied = self.first_values()
        named = next((name for name in varied if name in ties.expressions), next(iter(varied), ""))
        ties.check(stated, varied, self.key_of(named))
        for name in ties.parameters if not self.FOLLOWS_TIES else ():
            for root in varied.keys() & ties.roots[name]:
                must = f"must be left out, since {name} is tied to it, which scenes of this kind do not follow"
                raise ParameterError(f"{self.key_of(root)}.{root}", root, must=must, got="")
        return ties

    def key_of(self, name: str) -> str:
        """Return the key under which a name varies."""
        keys = [key for key in ("along", "vary", "measured") if key in type(self).model_fields]
        return next((key for key in keys if name in getattr(self, key)), "over")

    def first_values(self) -> dict[str, float]:
        """Return the first value of each name that the scene varies, names of one's own included."""
        return {str(name): grid.low for name, grid in self.grids().items()}

    def tied(self) -> Ties:  # noqa: D102 - as BaseScene
        try:
            return self.all_ties()
        except ParameterError:  # reported by `check_ties`
            return Ties()

    def tied_at(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the tied parameters at values of others, those that are left out as they are stated."""
        ties = self.tied()
        tied = ties.values({**DEFAULTS, **super().given_exciter(), **values}, ties.parameters)
        return {name: value for name, value in tied.items() if np.isfinite(value).all()}

    def given_exciter(self) -> dict[str, float]:  # noqa: D102 - as BaseScene
        given = super().given_exciter()
        return given if self.FOLLOWS_TIES else {**given, **self.tied_at({})}

    def varied_names(self) -> set[str]:
        """Return the names that have several values, tied ones included."""
        tied = self.tied().parameters if self.FOLLOWS_TIES else ()
        return super().varied_names() | {*tied}

    def resolved_exciter(self) -> dict[str, float]:  # noqa: D102 - as BaseScene
        values = super().resolved_exciter()
        if not self.FOLLOWS_TIES:
            return values
        first = self.first_values()
        varied = {name: value for name, value in first.items() if name in PARAMETERS}
        return {**values, **varied, **self.tied_at(first)}

    def untied_exciter(self) -> dict[str, float]:
        """Return the parameters without those that are tied, but for l, which an exciter must have."""
        tied = {*self.tied().parameters} - {"l"}
        return {name: v for name, v in self.resolved_exciter().items() if name not in tied}

    def data_keys(self) -> dict[str, Any]:  # noqa: D102 - as BaseScene
        keys = super().data_keys()
        del keys["ties"]
        texts = self.tied().texts if self.FOLLOWS_TIES else {}
        return {**keys, **({"ties": texts} if texts else {})}


@functools.lru_cache(maxsize=64)
def _read(ties: tuple[tuple[str, str], ...]) -> Ties:
    return Ties(dict(ties))


def check_ties(scene: TiedScene) -> Iterator[Problem]:
    """Check that ties can be read and computed, and that each name that varies is a parameter or stands in a tie."""
    first = scene.first_values()
    try:
        ties = scene.all_ties()
        ties.checked({**DEFAULTS, **scene.resolved_exciter(), **first})
        scene.row_grid()
    except ParameterError as error:
        path = argument_path(error)
        yield refused(path if len(path) > 1 or path == ("ties",) else ("exciter", *path), error)
        return
    for name in first if scene.FOLLOWS_TIES else ():
        if name not in (*PARAMETERS, *STARTS, *ties.own):
            key = scene.key_of(name)
            known = [*PARAMETERS, *(STARTS if key == "over" else ()), *ties.own]
            yield unknown((key, name), known)


def own_names(tree: dict[str, Any]) -> set[str]:
    """Return the names of one's own that the ties of a study and of its scenes use, as far as they can be read."""
    scenes = tree.get("scenes")
    owners = [tree, *(scenes.values() if isinstance(scenes, dict) else ())]
    texts = [
        text
        for owner in owners
        if isinstance(owner, dict) and isinstance(owner.get("ties"), dict)
        for text in owner["ties"].values()
        if isinstance(text, str)
    ]
    names: set[str] = set()
    for text in texts:
        with suppress(ExpressionError):
            names |= {*Expression(text).names}
    return names - PARAMETERS.keys() - PHYSICAL.keys() - {*STARTS}
