"""How hard a motion may be hit: the least disturbances, of those tried, from which it does not come back."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vibropipe.physics.limits import START_WORK
from vibropipe.solve.basins.attractor_set import Attractor, AttractorSet

if TYPE_CHECKING:
    import xarray as xr

# Sizes that are tried in each direction, the least one as a share of the largest, and the halvings that follow.
SIZES, LEAST, HALVINGS = 96, 1e-5, 16
STEPS = 64  # equal ones below the least size that was found, in which tongues of other basins are sought
# Directions of disturbances in displacement and velocity, and the most section points of an orbit that are disturbed.
DIRECTIONS, MAX_POINTS = 24, 32
# How far beyond a stable set it is tried, as a share of the way, and at how many of its states.
BEYOND, CANDIDATES = 1e-3, 256


def knocks_of(
    attractors: AttractorSet, orbit: Attractor, index: int, velocity: float
) -> tuple[float, float]:
    """Return the least distance and the least change of velocity, at the section, after which a motion is another.

    Rounded down: after all smaller ones that were tried it comes back. A tongue of another basin may be missed that is
    narrower than a share 1/STEPS of the least size.

    index : its index among the known ones
    velocity : largest change of velocity that is tried
    Returns NaN where every disturbance that was tried leads back, and without an orbit.
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
    least = _halved(attractors, points[on], ways[on], index, low, float(size))
    while least > sizes[0] and (ends := _first_of(attractors, points, ways, index, least)):
        least = _halved(attractors, points, ways, index, *ends)
    return least


def _first_of(
    attractors: AttractorSet, points: np.ndarray, ways: np.ndarray, index: int, below: float
) -> tuple[float, float] | None:
    """Return the first of equal steps below a size, and that before it, after which a motion is another; or None."""
    step = below / STEPS
    for n in range(1, STEPS):
        if not _comes_back(attractors, points + n * step * ways, index).all():
            return (n - 1) * step, n * step
    return None


def _halved(
    attractors: AttractorSet,
    points: np.ndarray,
    ways: np.ndarray,
    index: int,
    low: float,
    high: float,
) -> float:
    """Return the least size, between two, of disturbances after which a motion is another, rounded down."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if _comes_back(attractors, points + middle * ways, index).all():
            low = middle
        else:
            high = middle
    return low


def sharpened(dataset: xr.Dataset, attractors: AttractorSet, indices: np.ndarray) -> xr.Dataset:
    """Return a dataset of basins whose knocks are not longer than the ways to the stable sets that it has.

    What lies just beyond the nearest states of the stable sets is tried, too: so no tongue of another basin is missed
    that they bound.

    indices : of each attractor among the known ones
    """
    curve = np.column_stack(
        [dataset[f"stable_set_{name}"].values for name in ("displacement", "velocity")]
    )
    knocks, impulses = (dataset[name].values.copy() for name in ("knock", "knock_impulse"))
    for n, index in enumerate(indices.tolist()):
        orbit = attractors.known[index]
        if orbit.period_multiple == 0 or len(orbit.sections) > MAX_POINTS or not len(curve):
            continue
        for point in orbit.sections:
            up = np.column_stack([np.zeros(len(curve)), _crossings(curve, point[0]) - point[1]])
            impulses[n] = _nearer(attractors, index, point, up, impulses[n])
            knocks[n] = _nearer(attractors, index, point, curve - point, knocks[n])
    # a change of velocity is a distance, too
    knocks = np.fmin(knocks, impulses)
    return dataset.assign(
        knock=dataset["knock"].copy(data=knocks),
        knock_impulse=dataset["knock_impulse"].copy(data=impulses),
    )


def _crossings(curve: np.ndarray, x: float) -> np.ndarray:
    """Return the velocity at which each stretch of a curve passes a displacement; NaN of those that do not."""
    (x0, v0), (x1, v1) = curve[:-1].T, curve[1:].T
    passes = (x0 - x) * (x1 - x) < 0.0
    velocities = np.full(len(curve), np.nan)
    share = (x - x0[passes]) / (x1[passes] - x0[passes])
    velocities[:-1][passes] = v0[passes] + share * (v1[passes] - v0[passes])
    return velocities


def _nearer(
    attractors: AttractorSet, index: int, point: np.ndarray, ways: np.ndarray, known: float
) -> float:
    """Return the least size of disturbances to just beyond some states after which a motion is another, or `known`."""
    sizes = np.hypot(*ways.T) * (1.0 + BEYOND)
    tried = np.flatnonzero((sizes > 0.0) & (sizes < np.fmin(known, np.inf)))
    tried = tried[np.argsort(sizes[tried])][:CANDIDATES]
    sizes, ways = sizes[tried, None], ways[tried] / (sizes[tried, None] / (1.0 + BEYOND))
    leaves = ~_comes_back(attractors, point + sizes * ways, index)
    if not leaves.any():
        return known
    first = int(np.argmax(leaves))
    ends = point[None], ways[first][None]
    return _halved(attractors, *ends, index, 0.0, float(sizes[first, 0]))


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
