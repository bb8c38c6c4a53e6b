"""Stable sets of unstable orbits: the starts whose motions approach one, as curves in the plane of the section."""

from __future__ import annotations

import numpy as np

from vibropipe.solve.basins.section_map import SectionMap

# Distance from the orbit within which its stable set is its tangent, in the units of the section map.
TANGENT = 1e-5
# States of the stretch of the tangent that is marched backward, at first.
FIRST = 33
# Largest distance of neighbouring vertices, as a share of the extent of the window, and the least distance of their
# places on the stretch: a curve is cut there, which goes on elsewhere after an impact at the section.
FINE, CUT = 1.0 / 200.0, 2.0**-24
# Vertices, and forcing periods marched backward, after which a curve is left.
MAX_VERTICES, MAX_PERIODS = 3_000, 1_000


def stable_set(section: SectionMap, point: np.ndarray, m: int, velocity: float) -> np.ndarray:
    """Return the stable set of an unstable orbit, as far as its motions backward in time stay slow.

    Near the orbit the set is the line along the eigenvector of the smaller multiplier. The stretch of it that the
    orbit's period maps onto its own beginning is marched backward: its preimages follow one another along the set
    [1]_. Backward other states approach the set, so rounding is no trouble. States are added where neighbours part.

    point : (2,), state of the orbit at the section
    m : its period multiple
    velocity : largest |x'| that is followed
    Returns states (n, 2) along the curve, which NaN parts into pieces.

    References
    ----------
    .. [1] T. S. Parker, L. O. Chua, Practical Numerical Algorithms for Chaotic Systems, Springer 1989, chapter 6.
    """
    jacobian = section.jacobian(point, m) * section.scale / section.scale[:, None]
    multipliers, vectors = np.linalg.eig(jacobian)
    least = int(np.argmin(np.abs(multipliers)))
    factor = abs(multipliers[least])
    pieces = [np.empty((0, 2))]
    if np.isreal(multipliers).all() and 0.0 < factor < 1.0 < np.abs(multipliers).max():
        tangent = TANGENT * vectors[:, least].real * section.scale
        for away in (tangent, -tangent):
            pieces += _preimages(section, point, away, factor, velocity)
    return np.concatenate(pieces)


def _preimages(
    section: SectionMap, point: np.ndarray, away: np.ndarray, factor: float, velocity: float
) -> list[np.ndarray]:
    """Return the preimages of a stretch from point + factor * away to point + away, one after the other."""
    extent = np.array([section.exciter.upper - section.exciter.lower, 2.0 * velocity])

    def stretch(places: np.ndarray) -> np.ndarray:
        on_line: np.ndarray = point + factor ** (1.0 - places[:, None]) * away
        return on_line

    def before(states: np.ndarray) -> np.ndarray:
        states = section.preimages(states)
        states[~(np.abs(states[:, 1]) <= velocity)] = np.nan
        return states

    places = np.linspace(0.0, 1.0, FIRST)
    states, pieces, vertices = stretch(places), [], 0
    for periods in range(1, MAX_PERIODS + 1):
        states = before(states)
        while True:
            steps = np.abs(np.diff(states, axis=0) / extent).max(axis=1)
            wide = np.flatnonzero((steps > FINE) & (np.diff(places) > CUT))
            if wide.size == 0 or places.size > MAX_VERTICES:
                break
            new = 0.5 * (places[wide] + places[wide + 1])
            added = stretch(new)
            for _ in range(periods):
                added = before(added)
            places = np.insert(places, wide + 1, new)
            states = np.insert(states, wide + 1, added, axis=0)
        cuts = np.flatnonzero(steps > FINE) + 1
        places, states = (
            np.insert(places, cuts, places[cuts]),
            np.insert(states, cuts, np.nan, axis=0),
        )
        parts = np.isnan(states[:, 0])
        if parts.all():
            break
        kept = ~(parts & np.roll(parts, 1))
        places, states = places[kept], states[kept]
        pieces += [_thinned(states, extent), np.full((1, 2), np.nan)]
        vertices += len(pieces[-2])
        if vertices > MAX_VERTICES:
            break
    return pieces


def _thinned(states: np.ndarray, extent: np.ndarray) -> np.ndarray:
    """Return the states (n, 2) along pieces of curves without those closer to each other than needed."""
    steps = np.abs(np.diff(states, axis=0) / extent).max(axis=1)
    is_end = np.isnan(np.concatenate([[np.nan], steps, [np.nan]]))
    along = np.floor(np.nancumsum(np.concatenate([[0.0], steps])) / (0.5 * FINE))
    is_next = np.diff(along, prepend=-1.0) > 0.0
    kept: np.ndarray = states[is_end[:-1] | is_end[1:] | is_next]
    return kept
