"""What is tied to the parameters that vary along a curve: its values, and its derivatives by them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vibropipe.physics.exciter import Parameters
from vibropipe.physics.ties import Ties


class Tied:
    """The parameters that follow others, by their places among the values of an exciter.

    by : the names that vary
    held : names of one's own that have a value and do not vary
    names : of the values: the parameters, and after them the names of one's own among both, in the order of the ties
    """

    def __init__(self, ties: Ties, by: Sequence[str], held: Sequence[str] = ()) -> None:
        self.ties, self.by = ties, tuple(by)
        self.names = (*Parameters._fields, *(name for name in ties.own if name in (*by, *held)))
        self.following = ties.following(by)
        self.places = np.array([self.names.index(name) for name in self.following], np.int64)

    def fill(self, values: np.ndarray) -> None:
        """Set what follows, in values of which the others are set; nan where an expression has none."""
        tied = self.ties.values(self._given(values), self.following)
        values[self.places] = [tied[name] for name in self.following]

    def slopes(self, values: np.ndarray) -> np.ndarray:
        """Return the derivatives of what follows, by each name that varies."""
        slopes = self.ties.slopes(self._given(values), self.by)
        rows = [[slopes[name].get(by, 0.0) for by in self.by] for name in self.following]
        return np.array(rows).reshape(-1, len(self.by))

    def _given(self, values: np.ndarray) -> dict[str, float]:
        return dict(zip(self.names, values.tolist(), strict=True))
