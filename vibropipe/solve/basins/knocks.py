"""How hard a motion may be hit: the least disturbances, of those tried, from which it does not come back."""

from __future__ import annotations

import numpy as np

from vibropipe.physics.limits import START_WORK
from vibropipe.solve.basins.attractor_set import Attractor, AttractorSet

# Sizes that are tried in each direction, the least one as a share of the largest, and the halvings that follow.
SIZES, LEAST, HALVINGS = 96, 1e-5, 16
# Directions of disturbances in displacement and velocity, and the most section points of an orbit that are disturbed.
DIRECTIONS, MAX_POINTS = 24, 32


def knocks_of(
    attractors: AttractorSet, orbit: Attractor, index: int, velocity: float
) -> tuple[float, float]:
    """Return the least distance and the least change of velocity, at the section, after which a motion is another.

    Rounded down: after all smaller ones that were tried it comes back. Disturbances grow by a ninth from one to the
    next, so that a narrower tongue of another basin may be missed.

    Parameters
    ----------
    attractors : AttractorSet
    orbit : Attractor
    index : int
        Its index among the known ones.
    velocity : float
        Largest change of velocity that is tried.

    Returns
    -------
    (float, float)
        NaN where every disturbance that was tried leads back, and without an orbit.
    """
    if orbit.period_multiple == 0 or len(orbit.sections) > MAX_POINTS:
        return np.nan, np.nan
    up = np.array([[0.0, 1.0], [0.0, -1.0]])
    impulse = _least(attractors, orbit, index, up, velocity)
    turns = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    around = np.column_stack([np.cos(turns), np.sin(turns)])
    distance = _least(attractors, orbit, index, around, velocity)
    # a change of velocity is a distance, too
    return float(np.fmin(distance, impulse)), impulse


def _least(
    attractors: AttractorSet, orbit: Attractor, index: int, directions: np.ndarray, largest: float
) -> float:
    """Return the least size of a disturbance along some directions after which a motion is another, or NaN."""
    sizes = largest * np.geomspace(LEAST, 1.0, SIZES)
    points = np.repeat(orbit.sections, len(directions), axis=0)
    ways = np.tile(directions, (len(orbit.sections), 1))
    low = 0.0
    for size in sizes:
        on = ~_comes_back(attractors, points + size * ways, index)
        if on.any():
            break
        low = float(size)
    else:
        return np.nan
    # Only what leaves at this size leaves at a smaller one.
    high = float(size)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if _comes_back(attractors, points[on] + middle * ways[on], index).all():
            low = middle
        else:
            high = middle
    return low


def _comes_back(attractors: AttractorSet, states: np.ndarray, index: int) -> np.ndarray:
    """Return whether motions from states at the section settle on an attractor; beyond a rigid support none begins."""
    exciter = attractors.section.exciter
    inside = np.ones(len(states), bool)
    if exciter.k1 == 0.0:
        inside &= states[:, 0] <= exciter.upper
    if exciter.k2 == 0.0:
        inside &= states[:, 0] >= exciter.lower
    back = ~inside
    if inside.any():
        attractors.section.allow(START_WORK * int(inside.sum()))
        back[inside] = attractors.owners(states[inside]) == index
    return back
