"""What is followed of an exciter, and the scales of its orbits."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from vibropipe.orbits.law.tied import Tied
from vibropipe.orbits.row import row_parameters
from vibropipe.physics.effects import ALL_EFFECTS, Effects
from vibropipe.physics.exciter import Parameters


class Scales(NamedTuple):
    """Scales of displacement and velocity of orbits, > 0."""

    size: float
    speed: float


class Problem(NamedTuple):
    """What is followed.

    values : (parameters,), parameters of the exciter, and the name of one's own that varies, if one does
    along : index of the parameter that varies
    low, high : its range
    at : its values at which points are wanted
    symmetric : whether the exciter is its own mirror image over the whole range
    max_length : largest weighted length of a step
    effects : of all exciters of the range
    until_fold : whether a branch is left where it turns back
    tied : what follows the parameter that varies
    """

    values: np.ndarray
    along: int
    low: float
    high: float
    at: tuple[float, ...]
    symmetric: bool
    max_length: float
    effects: Effects = ALL_EFFECTS
    until_fold: bool = False
    tied: Tied | None = None

    @property
    def name(self) -> str:
        """Name of what varies."""
        return (Parameters._fields if self.tied is None else self.tied.names)[self.along]

    @property
    def varied(self) -> tuple[str, ...]:
        """Names of what varies, and of what follows it."""
        return (self.name, *(() if self.tied is None else self.tied.following))

    def values_at(self, value: float) -> np.ndarray:
        """Return `values` at a value of the parameter that varies."""
        values = self.values.copy()
        values[self.along] = value
        if self.tied is not None:
            self.tied.fill(values)
        return values

    def parameters_at(self, value: float) -> Any:
        """Return the `Parameters` at a value of the one that varies."""
        return row_parameters(self.values_at(value).reshape(1, -1), 0)
