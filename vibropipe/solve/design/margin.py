"""How far a design is from the nearest change of its law of motion."""

from __future__ import annotations

import numpy as np

from vibropipe.solve.design.problem import Problem, directions
from vibropipe.solve.rows.points import within_ranges

# Distances tried along each direction, in shares of the ranges, then bisections of the first change.
DISTANCES = np.geomspace(1e-4, 1.0, 17)
BISECTIONS = 8


def law_margin(problem: Problem, share: np.ndarray) -> float:
    """Return the distance, in shares of the ranges, to the nearest point found whose motion has another law.

    Motions begin at the given start, so that a change of the attractor counts as well. Points beyond the ranges count,
    those where a parameter has no meaning do not. 1 if no change is found.
    """
    rays = directions(share.size)
    # Far motions, which may be chaotic and slow, are marched only where nothing changes nearer.
    for first in range(DISTANCES.size):
        changed = ~_is_same(problem, share, rays * DISTANCES[first])
        if changed.any():
            break
    else:
        return 1.0
    rays = rays[changed]
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
    points = problem.laws_from_start(parameters[inside])
    same = np.ones(len(parameters), bool)
    same[inside] = points.has_law(points.laws[0])
    return same[1:]
