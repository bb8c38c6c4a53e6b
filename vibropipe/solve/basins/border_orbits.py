"""Unstable orbits between basins: the stable set of one, the starts whose motions approach it, is their border."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vibropipe.physics.limits import MAX_CALL_WORK, START_WORK
from vibropipe.physics.start import within_room
from vibropipe.solve.basins.attractor_set import SAME_ORBIT, AttractorSet
from vibropipe.solve.basins.section_map import SectionMap

if TYPE_CHECKING:
    import xarray as xr


# Borders between two attractors that are followed, spread over the grid, and pairs of attractors: those with the
# longest borders. Of interleaved basins most borders lead to the same orbits.
PAIRS, PLACES = 8, 4
# States on the line between two starts that are assigned at a time, and the distance of those on either side of the
# border, in the units of the section map, down to which the line is cut.
CUTS, CLOSE = 33, 1e-13
# Periods that both sides are marched, their distance beyond which they no longer tell where the border is, and how
# often they are then cut down and marched again.
MARCH, APART, ROUNDS = 128, 1e-4, 8
# Largest period multiple of an orbit that is sought, the distance after m periods from which it is, up to SHORT periods
# and beyond, and that at which it is closed.
MAX_MULTIPLE, SHORT, NEAR, NEAR_LONG, CLOSED, STEPS = 32, 8, 0.1, 1e-3, 1e-11, 30
# Largest velocity of the states of stable sets, as a multiple of the largest of the starts and of the orbits.
REACH = 1.5


class BorderOrbit(NamedTuple):
    """An unstable orbit between basins.

    sections : (m, 2), its states at the section, the one with the least displacement first
    multipliers : (2,), the larger modulus first
    sides : indices of the attractors on either side of the border
    """

    sections: np.ndarray
    multipliers: np.ndarray
    sides: tuple[int, int]


def border_orbits(
    attractors: AttractorSet, starts: np.ndarray, owner: np.ndarray, phase: float = 0.0
) -> list[BorderOrbit]:
    """Find unstable orbits on the borders between the basins of a grid.

    The line between two neighbouring starts of different basins is cut until its ends lie within rounding of the
    border. Both are marched: they stay beside the border, whose motions approach an orbit, until they part, and are
    cut down again [1]_. Newton's method closes the orbit.

    starts : (nx, nv, 2)
    owner : (nx, nv), index of the attractor of each start, or negative
    phase : phase of the force at the start, in turns
    Returns them in the order of their displacements. Those with more than MAX_MULTIPLE periods, of a chaotic border
    all but a few, and those beyond the work that the number of starts allows are not found.

    References
    ----------
    .. [1] J. D. Skufca, J. A. Yorke, B. Eckhardt, Edge of chaos in a parallel shear flow, Physical Review Letters 96
       (2006) 174101.
    """
    orbits: list[BorderOrbit] = []
    attractors.section.allow(MAX_CALL_WORK + 2 * START_WORK * owner.size)
    for sides, places in _places(owner).items():
        for first, second in places:
            pair = np.array([starts[first], starts[second]])
            if phase:
                ends = [attractors.section.sections(each, 1, phase) for each in pair]
                if min(map(len, ends)) == 0:
                    continue
                pair = np.concatenate(ends)
            orbit = _orbit_at(attractors, pair, sides)
            if orbit is not None and not any(_is_same(attractors, orbit, each) for each in orbits):
                orbits.append(orbit)
    return sorted(orbits, key=lambda orbit: (len(orbit.sections), *orbit.sections[0]))


def _places(owner: np.ndarray) -> dict[tuple[int, int], list[tuple[tuple[int, int], ...]]]:
    """Return some neighbouring starts on either side of the border of each pair of attractors."""
    places: dict[tuple[int, int], list[tuple[tuple[int, int], ...]]] = {}
    for dx, dv in ((1, 0), (0, 1)):
        here, ahead = owner[: owner.shape[0] - dx, : owner.shape[1] - dv], owner[dx:, dv:]
        for i, j in np.argwhere((here != ahead) & (here >= 0) & (ahead >= 0)).tolist():
            a, b = int(here[i, j]), int(ahead[i, j])
            pair = ((i, j), (i + dx, j + dv))
            places.setdefault((min(a, b), max(a, b)), []).append(pair if a < b else pair[::-1])
    longest = sorted(places, key=lambda sides: (-len(places[sides]), sides))[:PAIRS]
    spread = {n: (np.arange(PLACES) * n + n // 2) // PLACES for n in map(len, places.values())}
    return {
        sides: [places[sides][k] for k in np.unique(spread[len(places[sides])]).tolist()]
        for sides in longest
    }


def _orbit_at(
    attractors: AttractorSet, pair: np.ndarray, sides: tuple[int, int]
) -> BorderOrbit | None:
    """Return the orbit that the border between two states leads to; None if it is not found."""
    for _ in range(ROUNDS):
        cut = _cut_down(attractors, pair, sides[0])
        if cut is None:
            return None
        tracks = [attractors.section.sections(each, MARCH) for each in cut]
        n = min(map(len, tracks))
        away = np.abs((tracks[0][:n] - tracks[1][:n]) / attractors.section.scale).max(axis=1)
        n = int(np.argmax(away > APART)) if (away > APART).any() else n
        if n == 0:
            return None
        orbit = _closed_near(attractors, 0.5 * (tracks[0][:n] + tracks[1][:n]), sides)
        if orbit is not None:
            return orbit
        pair = np.array([tracks[0][n - 1], tracks[1][n - 1]])
    return None


def _cut_down(attractors: AttractorSet, pair: np.ndarray, side: int) -> np.ndarray | None:
    """Return two states on the line between a pair, of which the first alone settles on `side`, within CLOSE."""
    share = np.linspace(0.0, 1.0, CUTS)[:, None]
    while True:
        size = np.abs((pair[1] - pair[0]) / attractors.section.scale).max()
        states = pair[0] + share * (pair[1] - pair[0])
        others = np.flatnonzero(attractors.owners(states) != side)
        if others.size == 0 or others[0] == 0:
            return None
        pair = states[[others[0] - 1, others[0]]]
        is_close = np.abs((pair[1] - pair[0]) / attractors.section.scale).max()
        if is_close <= CLOSE or is_close >= 0.5 * size:
            return pair


def _closed_near(
    attractors: AttractorSet, track: np.ndarray, sides: tuple[int, int]
) -> BorderOrbit | None:
    """Return an unstable orbit near consecutive states (n, 2) at the section, of the fewest periods."""
    for m in range(1, min(MAX_MULTIPLE, len(track) - 1) + 1):
        back = np.abs((track[m:] - track[:-m]) / attractors.section.scale).max(axis=1)
        best = int(np.argmin(back))
        near = NEAR if m <= SHORT else NEAR_LONG
        point = _newton(attractors, track[best], m) if back[best] <= near else None
        if point is None or np.abs((point - track[best]) / attractors.section.scale).max() > NEAR:
            continue
        multipliers = np.linalg.eigvals(attractors.section.jacobian(point, m)).astype(complex)
        multipliers = multipliers[np.argsort(-np.abs(multipliers))]
        if np.abs(multipliers[0]) > 1.0:
            sections = np.roll(attractors.section.sections(point, m), 1, axis=0)
            sections[0] = point
            least = int(np.argmin(sections[:, 0]))
            return BorderOrbit(np.roll(sections, -least, axis=0), multipliers, sides)
    return None


def _newton(attractors: AttractorSet, point: np.ndarray, m: int) -> np.ndarray | None:
    """Return the fixed point of the m-period return map that Newton's method finds from a state; None if it fails."""
    exciter, scale = attractors.section.exciter, attractors.section.scale
    for _ in range(STEPS):
        image = attractors.section.images(point[None], m)[0][0]
        change = image - point
        if not np.isfinite(change).all():
            return None
        if np.abs(change / scale).max() <= CLOSED:
            return point
        matrix = attractors.section.jacobian(point, m) - np.eye(2)
        if not np.isfinite(matrix).all() or np.linalg.det(matrix) == 0.0:
            return None
        point = point - np.linalg.solve(matrix, change)
        point[0] = within_room(exciter, point[0])
    return None


def _is_same(attractors: AttractorSet, orbit: BorderOrbit, other: BorderOrbit) -> bool:
    """Return whether two orbits are one."""
    away = np.abs((other.sections - orbit.sections[0]) / attractors.section.scale).max(axis=1)
    return len(orbit.sections) == len(other.sections) and bool(away.min() <= SAME_ORBIT)


def with_border_orbits(
    dataset: xr.Dataset, attractors: AttractorSet, orbits: list[BorderOrbit], ids: np.ndarray
) -> xr.Dataset:
    """Return a dataset with unstable orbits and their stable sets; `ids` has the `attractor_id` of each attractor."""
    sizes = [len(orbit.sections) for orbit in orbits]
    states = np.concatenate([np.empty((0, 2)), *(orbit.sections for orbit in orbits)])
    multipliers = np.array([orbit.multipliers for orbit in orbits], complex).reshape(-1, 2)
    sides = ids[np.array([orbit.sides for orbit in orbits], int).reshape(-1, 2)]
    starts = dataset["v0"].size * dataset["x0"].size
    attractors.section.allow(MAX_CALL_WORK + 2 * START_WORK * starts)
    velocity = REACH * max(np.abs(v).max(initial=0.0) for v in (dataset["v0"].values, states[:, 1]))
    curves = [
        stable_set(attractors.section, orbit.sections[0], len(orbit.sections), velocity)
        for orbit in orbits
    ]
    numbers = np.arange(len(orbits), dtype=np.int32)
    vertices = np.concatenate([np.empty((0, 2)), *curves])
    return dataset.assign(
        {
            "border_orbit_multiple": ("border_orbit", np.array(sizes, np.int32)),
            "border_orbit_multiplier": (("border_orbit", "multiplier"), multipliers),
            "border_orbit_attractor": (("border_orbit", "border_side"), np.sort(sides, axis=1)),
            "border_point_orbit": ("border_point", np.repeat(numbers, sizes)),
            "border_point_displacement": ("border_point", states[:, 0]),
            "border_point_velocity": ("border_point", states[:, 1]),
            "stable_set_orbit": ("stable_set_point", np.repeat(numbers, [*map(len, curves)])),
            "stable_set_displacement": ("stable_set_point", vertices[:, 0]),
            "stable_set_velocity": ("stable_set_point", vertices[:, 1]),
        }
    )  # fmt: skip


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
        places = np.insert(places, cuts, places[cuts])
        states = np.insert(states, cuts, np.nan, axis=0)
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
