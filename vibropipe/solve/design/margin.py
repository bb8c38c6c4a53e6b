"""How far a design lies from the nearest change of its law of motion."""

from __future__ import annotations

import numpy as np

from vibropipe.solve.design.problem import Problem
from vibropipe.solve.rows.points import within_ranges

# Distances tried along each direction, in shares of the ranges, then bisections of the first change.
DISTANCES = np.geomspace(1e-4, 1.0, 17)
BISECTIONS = 8
# Directions beside those of the axes, for each varied parameter.
DIRECTIONS = 6


def directions(k: int) -> np.ndarray:
    """Return unit vectors (n, k): along each axis both ways, then of low discrepancy."""
    from scipy.special import ndtri
    from scipy.stats import qmc

    axes = np.vstack([np.eye(k), -np.eye(k)])
    if k == 1:
        return axes
    points = qmc.Halton(k, scramble=False).random(DIRECTIONS * k + 1)[1:]
    scattered = ndtri(points)
    return np.vstack([axes, scattered / np.linalg.norm(scattered, axis=1, keepdims=True)])


def law_margin(problem: Problem, share: np.ndarray) -> float:
    """Return the distance, in shares of the ranges, to the nearest point found whose motion has another law.

    Motions begin at the given start, so that a change of the attractor counts as well. Points beyond the ranges count,
    those where a parameter has no meaning do not. 1 if no change is found.
    """
    rays = directions(share.size)
    same = _is_same(problem, share, (rays[:, None] * DISTANCES[:, None]).reshape(-1, share.size))
    changed = ~same.reshape(len(rays), DISTANCES.size)
    if not changed.any():
        return 1.0
    first = int(changed.any(axis=0).argmax())
    rays = rays[changed[:, first]]
    low = np.full(len(rays), DISTANCES[first - 1] if first else 0.0)
    high = np.full(len(rays), DISTANCES[first])
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        same = _is_same(problem, share, rays * middle[:, None])
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return float(high.min())


def _is_same(problem: Problem, share: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """Return whether the motions at moved points (n, k) have the law of the point itself."""
    parameters = problem.parameters(np.vstack([share, share + moves]))
    inside = within_ranges(parameters)
    points = problem.from_start(parameters[inside])
    same = np.ones(len(parameters), bool)
    same[inside] = (points.laws == points.laws[0]).all(axis=1) & points.is_stable
    return same[1:]
