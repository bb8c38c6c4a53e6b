"""Rows of parameters around those of a design: scattered parts, and the ends and corners of the worst case."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np

from vibropipe.physics.exciter import Parameters

# Corners of the worst case are tried as long as there are at most so many parameters.
MAX_CORNERS = 10


def moved_rows(base: np.ndarray, sigma: Mapping[str, float], n: int, reach: float) -> np.ndarray:
    """Return rows of parameters around one (p,): n scattered ones, then the ends and corners of the worst case."""
    columns = [Parameters._fields.index(name) for name in sigma]
    deviations = np.array(list(sigma.values()))
    moves = np.vstack([scattered(len(sigma), n), box(len(sigma), reach)]) * deviations
    rows = np.tile(base, (len(moves), 1))
    rows[:, columns] += moves
    return rows


def scattered(k: int, n: int) -> np.ndarray:
    """Return n normal deviates (n, k) of low discrepancy."""
    from scipy.special import ndtri
    from scipy.stats import qmc

    sequence = qmc.Sobol(k, scramble=False)
    # The first point of the sequence is a corner, at minus infinity.
    sequence.fast_forward(1)
    deviates: np.ndarray = ndtri(sequence.random(n))
    return deviates


def box(k: int, reach: float) -> np.ndarray:
    """Return the ends of each axis (below and above in turn) and the corners of a box, (n, k)."""
    axes = np.repeat(np.eye(k), 2, axis=0) * np.tile([-1.0, 1.0], k)[:, None]
    if 1 < k <= MAX_CORNERS:
        axes = np.vstack([axes, np.array(list(itertools.product((-1.0, 1.0), repeat=k)))])
    return reach * axes
