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

        Raises ParameterError if they cannot be read, or a name has no value, or two.
        """
        ties = _read(tuple({**self._shared_ties, **self.ties}.items()))
        # What the study states and a scene ties is tied there, as it is swept where a scene sweeps it.
        stated = (self._shared.keys() - self.ties.keys()) | self.exciter.explicit().keys()
        ties.check(stated, self.first_values(), self.varied_key)
        return ties

    @property
    def varied_key(self) -> str:
        """The key that gives names several values."""
        return "vary" if "vary" in type(self).model_fields else "over"

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
        tied = ties.values({**DEFAULTS, **self.given_exciter(), **values}, ties.parameters)
        return {name: value for name, value in tied.items() if np.isfinite(value).all()}

    def resolved_exciter(self) -> dict[str, float]:  # noqa: D102 - as BaseScene
        first = self.first_values()
        varied = {name: value for name, value in first.items() if name in PARAMETERS}
        return {**super().resolved_exciter(), **varied, **self.tied_at(first)}

    def untied_exciter(self) -> dict[str, float]:
        """Return the parameters without those that are tied, but for l, which an exciter must have."""
        tied = {*self.tied().parameters} - {"l"}
        return {name: v for name, v in self.resolved_exciter().items() if name not in tied}

    def data_keys(self) -> dict[str, Any]:  # noqa: D102 - as BaseScene
        keys = super().data_keys()
        texts = self.tied().texts
        return {
            **{key: value for key, value in keys.items() if key != "ties"},
            **({"ties": texts} if texts else {}),
        }


@functools.lru_cache(maxsize=64)
def _read(ties: tuple[tuple[str, str], ...]) -> Ties:
    return Ties(dict(ties))


def check_ties(scene: TiedScene) -> Iterator[Problem]:
    """Check that ties can be read and computed, and that each name that varies is a parameter or stands in a tie."""
    key = scene.varied_key
    try:
        ties = scene.all_ties()
        ties.checked({**DEFAULTS, **scene.resolved_exciter(), **scene.first_values()})
        if key == "over":
            scene.row_grid()
    except ParameterError as error:
        path = argument_path(error)
        yield refused(path if len(path) > 1 or path == ("ties",) else ("exciter", *path), error)
        return
    for name in scene.first_values():
        if name not in (*PARAMETERS, *STARTS, *ties.own):
            yield unknown((key, name), [*PARAMETERS, *(STARTS if key == "over" else ()), *ties.own])


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
