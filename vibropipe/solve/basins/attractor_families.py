"""Attractors carried along a parameter: which of one value goes on as which of the next, appears, or vanishes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vibropipe.physics.exciter import Exciter
from vibropipe.physics.start import within_room
from vibropipe.solve.basins.attractor_set import SAME_ORBIT, AttractorSet, loses
from vibropipe.solve.basins.neighbourhood import MAX_RADIUS, spectral_radius
from vibropipe.solve.basins.section_map import SectionMap
from vibropipe.solve.sweep.blocks import MAX_PERIODS
from vibropipe.words.regimes import Regime

# Largest mean distance of the states at the section, in the units of the section map, over a step of the parameter
# along which an attractor goes on. Steps are halved until it holds, down to a share of the step between two values:
# an attractor whose states still lie apart has jumped.
CONTINUOUS, MIN_STEP = 0.05, 2.0**-10
# Share of what is left up to the next value by which a step may fall short of it and still be the last.
ROUNDING = 1e-9
# States at the section by which an attractor without an orbit is compared.
STATES = 512


class Link(NamedTuple):
    """Where an attractor is at a neighbouring value of the parameter.

    target : index in the set there of the attractor that its motion settles on; negative: none
    jump : value of the parameter at which the motion jumps; None: it goes on
    """

    target: int
    jump: float | None


class Change(NamedTuple):
    """An attractor that appears or vanishes with increasing parameter.

    value : of the parameter
    family : the attractor
    other : the attractor that its motion settles on where it is not; -1: none
    """

    appears: bool
    value: float
    family: int
    other: int


class Families(NamedTuple):
    """Number of each attractor of each set, the same where it goes on, and the changes in the order of the values."""

    numbers: list[np.ndarray]
    changes: list[Change]


def follow_attractors(sets: Sequence[AttractorSet], name: str) -> Families:
    """Carry attractors along a parameter.

    Each attractor is carried to both neighbouring values: the motion from one of its states settles at a value ahead,
    where its states must lie near those before; else the step is halved. So an attractor may move far from one value
    to the next, and a jump to one close by is still a jump. Period doublings and windows of chaos are no jumps.

    sets : at increasing values of the parameter. What is found on the way from a neighbouring value is added
    """
    links: dict[tuple[int, int, int], Link] = {}
    n_known = -1
    while n_known != sum(len(each.known) for each in sets):
        n_known = sum(len(each.known) for each in sets)
        for way, order in ((1, range(len(sets) - 1)), (-1, range(len(sets) - 1, 0, -1))):
            for k in order:
                for index in range(len(sets[k].known)):
                    if (k, index, way) not in links:
                        links[k, index, way] = carry(sets[k], index, sets[k + way], name)
    return _number(sets, links, name)


def carry(source: AttractorSet, index: int, target: AttractorSet, name: str) -> Link:
    """Follow an attractor from the parameters of one set to those of another, which differ in `name`."""
    exciter, states = source.section.exciter, _states(source, index)
    begin, end = (getattr(each.numbers(), name) for each in (exciter, target.section.exciter))
    value, step = begin, end - begin
    while True:
        is_last = abs(step) >= (1.0 - ROUNDING) * abs(end - value)
        ahead = target.section.exciter if is_last else replace(exciter, **{name: value + step})
        owner = target.attractor_of(_within(ahead, states[0])) if is_last else -1
        settled = _settled(ahead, states[0]) if not is_last else None
        if owner >= 0:
            settled = _states(target, owner)
        if settled is not None and distance(states, settled, source.section) <= CONTINUOUS:
            if is_last:
                return Link(owner, None)
            value, states, step = getattr(ahead.numbers(), name), settled, 2 * step
            continue
        step *= 0.5
        if abs(step) < MIN_STEP * abs(end - begin):
            beyond = target.attractor_of(_within(target.section.exciter, states[0]))
            tried = end if is_last else value + 2 * step
            return Link(beyond, 0.5 * (value + tried))


def distance(states: np.ndarray, others: np.ndarray, section: SectionMap) -> float:
    """Return the mean distance of the states (n, 2) of one attractor from the nearest of another, or the other way.

    The less of both counts: where an orbit takes the place of chaos, its states lie among those of the chaos, but not
    all of these lie near the orbit. States before and after an impact are one: an impact that passes the phase of the
    section is no jump.
    """
    from scipy.spatial import KDTree

    ways = [
        KDTree(_with_impacts(one, section) / section.scale).query(other / section.scale)[0].mean()
        for one, other in ((states, others), (others, states))
    ]
    return float(min(ways))


def _with_impacts(states: np.ndarray, section: SectionMap) -> np.ndarray:
    """Return states (n, 2) and, of those next to a support, also the states on the other side of an impact there."""
    exciter = section.exciter
    parts = [states]
    supports = (
        (1, exciter.upper, exciter.R1, exciter.k1),
        (-1, exciter.lower, exciter.R2, exciter.k2),
    )
    for sign, place, R, k in supports:
        if k > 0.0:  # the velocity is continuous
            continue
        near = states[sign * (place - states[:, 0]) <= CONTINUOUS * section.scale[0]]
        before, after = near[sign * near[:, 1] > 0], near[sign * near[:, 1] < 0]
        parts.append(before * [1.0, -R])
        if R > 0:
            parts.append(after * [1.0, -1.0 / R])
    return np.concatenate(parts)


def _states(attractors: AttractorSet, index: int) -> np.ndarray:
    """Return the states of an attractor at the section, of one without an orbit some."""
    attractor = attractors.known[index]
    return attractor.sections if attractor.period_multiple else attractor.sections[-STATES:]


def _within(exciter: Exciter, state: np.ndarray) -> np.ndarray:
    """Return a state with its displacement between rigid supports, which may have moved."""
    return np.array([within_room(exciter, state[0]), state[1]])


def _settled(exciter: Exciter, state: np.ndarray) -> np.ndarray | None:
    """Return the states (n, 2) of the attractor that a motion settles on; None if it settles on none."""
    section = SectionMap(exciter)
    rows = section.steady_states(_within(exciter, state)[None], MAX_PERIODS)
    m = int(rows.period_multiple[0])
    if m == 0 and not (rows.regime[0] == Regime.APERIODIC and loses(exciter, rows.impacts[0])):
        return None
    states = section.sections(rows.section[0], m or STATES)
    if len(states) < (m or STATES):
        return None
    # A mass that friction holds stays wherever it is: such places attract nothing.
    attracts = m == 0 or spectral_radius(section.jacobian(states[0], m)) < MAX_RADIUS
    return states if attracts else None


def _number(
    sets: Sequence[AttractorSet], links: dict[tuple[int, int, int], Link], name: str
) -> Families:
    """Number the attractors: those of the first value in order, then those that appear."""
    numbers = [np.full(len(each.known), -1) for each in sets]
    changes: list[Change] = []
    n_families = 0
    for k, own in enumerate(sets):
        pairs = _matched(sets, links, k - 1, numbers[k - 1]) if k else {}
        for before, index in pairs.items():
            numbers[k][index] = numbers[k - 1][before]
        order = sorted(range(len(own.known)), key=lambda index: own.known[index].sort_key())
        for index in order:
            if numbers[k][index] < 0:
                numbers[k][index], n_families = n_families, n_families + 1
        if k:
            changes += _changes(sets, numbers, links, k, name)
    return Families(numbers, changes)


def _changes(
    sets: Sequence[AttractorSet],
    numbers: Sequence[np.ndarray],
    links: dict[tuple[int, int, int], Link],
    k: int,
    name: str,
) -> list[Change]:
    """Return what vanishes and appears between the values k - 1 and k."""
    changes = []
    for appears, at, way in ((False, k - 1, 1), (True, k, -1)):
        own, others = numbers[at], numbers[at + way]
        for index in np.flatnonzero(~np.isin(own, others)).tolist():
            link = links[at, index, way]
            other = int(others[link.target]) if link.target >= 0 else -1
            value = link.jump
            if value is None:  # it merges with the one that goes on
                rival = np.flatnonzero(own == other).tolist()
                value = _merges(sets[at], [index, *rival], sets[at + way].section.exciter, name)
            changes.append(Change(appears, value, int(own[index]), other))
    return sorted(changes, key=lambda change: change.value)


def _merges(attractors: AttractorSet, indices: list[int], end: Exciter, name: str) -> float:
    """Return where two attractors become one on the way to other parameters, by bisection."""
    exciter = attractors.section.exciter
    separate, merged = (getattr(each.numbers(), name) for each in (exciter, end))
    least = MIN_STEP * abs(merged - separate)
    states = [_states(attractors, index) for index in indices]
    while abs(merged - separate) > least and len(states) == 2:
        middle = 0.5 * (separate + merged)
        one, other = (_settled(replace(exciter, **{name: middle}), each[0]) for each in states)
        if one is None or other is None or _is_one(one, other, attractors.section):
            merged = middle
        else:
            separate, states = middle, [one, other]
    return float(0.5 * (separate + merged))


def _is_one(states: np.ndarray, others: np.ndarray, section: SectionMap) -> bool:
    """Return whether the states of two attractors are those of one."""
    limit = CONTINUOUS if max(len(states), len(others)) == STATES else SAME_ORBIT
    return distance(states, others, section) <= limit


def _matched(
    sets: Sequence[AttractorSet],
    links: dict[tuple[int, int, int], Link],
    k: int,
    numbers: np.ndarray,
) -> dict[int, int]:
    """Return which attractors of the value k go on as which of the next, each at most once.

    First come those that are carried upwards, where two merge the one with the lower number; then those that are
    carried downwards only, the nearest first.
    """
    up = {(i, link.target) for (at, i, way), link in links.items()
          if (at, way) == (k, 1) and link.jump is None}  # fmt: skip
    down = {(link.target, j) for (at, j, way), link in links.items()
            if (at, way) == (k + 1, -1) and link.jump is None}  # fmt: skip
    ranked = [(0, float(numbers[i]), i, j) for i, j in up]
    for i, j in down - up:
        away = distance(_states(sets[k], i), _states(sets[k + 1], j), sets[k].section)
        ranked.append((1, away, i, j))
    matched: dict[int, int] = {}
    for _way, _rank, i, j in sorted(ranked):
        if i not in matched and j not in matched.values():
            matched[i] = j
    return matched
