"""All branches that are reached from an orbit: the one through it, and those that begin at its bifurcations."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterator
from typing import NamedTuple

import numpy as np

from vibropipe.continuation.path import Event, both_ways, joined
from vibropipe.orbits.branches.curve import ImpactCurve
from vibropipe.orbits.branches.following import Branch, Seed
from vibropipe.orbits.branches.grazing import siblings_at_grazing
from vibropipe.orbits.branches.linear import follow_linear
from vibropipe.orbits.branches.switching import SWITCHES, limit_at, seeds_at
from vibropipe.orbits.branches.symmetry import halved, halves_agree
from vibropipe.orbits.law.curve import LawCurve
from vibropipe.orbits.law.following import follow_laws
from vibropipe.orbits.law.law import law_of_impacts
from vibropipe.orbits.law.problem import Problem as Problem

# Largest number of branches that are followed, and difference of the parameter, as a share of its range, and of the
# speed of impacts, relative, at which two bifurcations are one.
MAX_BRANCHES, SAME_BIFURCATION = 64, 1e-6
# Weighted difference of the halves of an orbit that settled, at which they are equal.
SETTLED_HALVES = 1e-6

# Bifurcations that the orbits of half the period, or symmetric, pass.
HALVED = ("flip", "pitchfork")

# Indices of nu and of l, the scale of lengths, among the parameters.
NU, L = 0, 3
# Least scale of impact velocities, as a share of nu l: on a branch from beside a grazing they grow beyond those there.
LEAST_SPEED = 0.1
# A bifurcation: its kind and parameter, and speeds and velocities of its impacts added up, per forcing period.
Key = tuple[str, float, float, float]
# What tells branches that begin at one grazing from each other: periods, whether the orbit is its own mirror image, and
# the supports struck in turn, from whichever impact on.
Law = tuple[float, int, bytes]


class Tree(NamedTuple):
    """Branches, that of the start first, and the number of those that begin at their bifurcations and are left."""

    branches: list[Branch]
    n_left: int


def seed_of_orbit(
    problem: Problem, m: int, supports: np.ndarray, u: np.ndarray, signs: tuple[float, ...]
) -> Seed | None:
    """Return the start of the branch through an orbit.

    supports : (n,) int8, impact sequence; without impacts the orbit is the motion in closed form
    u : (2n + 1,), times, velocities, and the parameter
    signs : directions of the parameter to follow: 1, -1 or both

    Returns None if the equations of the sequence have no solution there.
    """
    n = len(supports)
    if n == 0:
        return Seed(None, None, float(u[-1]), signs)
    least = LEAST_SPEED * float(problem.values[L]) * float(problem.values[NU])
    speed = max(least, float(np.abs(u[n : 2 * n]).max()))
    sequence = law_of_impacts(m, 0, supports)
    curve = ImpactCurve(problem, sequence, speed)
    kind = halves_agree(sequence, u, curve.weights, problem.symmetric, SETTLED_HALVES)
    if kind == "pitchfork":
        sequence, u = halved(sequence, u, kind)
        curve = ImpactCurve(problem, sequence, speed)
    point = curve.settle(u)
    return None if point is None else Seed(curve, point, point.value, signs)


def with_children(problem: Problem, seed: Seed) -> Iterator[Branch]:
    """Yield the branch of a seed, and those that begin at its bifurcations."""
    (parent,) = follow_tree(problem, seed, ()).branches
    yield parent
    for event in parent.events:
        if event.kind in SWITCHES and not limit_at(parent, event):
            for child in seeds_at(parent, event):
                yield from follow_tree(problem, child, ()).branches


def follow_tree(
    problem: Problem,
    seed: Seed,
    switch: Collection[str],
    is_wanted: Callable[[Seed], bool] = lambda _seed: True,
) -> Tree:
    """Follow the branch of a seed, and those that begin at its bifurcations of the kinds `switch`, and at theirs.

    switch : any of flip, pitchfork, grazing
    is_wanted : says of the start of a branch at a bifurcation whether that is followed

    Returns at most `MAX_BRANCHES` branches; none is followed from both of its ends.
    """
    branches: list[Branch] = []
    waiting: deque[tuple[Key | None, Seed]] = deque([(None, seed)])
    # Grazings, whose branches beside the one with an impact more or less are followed last.
    grazings: deque[tuple[Key, Branch, Event]] = deque()
    known = _Known(problem)
    while (waiting or grazings) and len(branches) < MAX_BRANCHES:
        if not waiting:
            waiting += _siblings(known, is_wanted, *grazings.popleft())
            continue
        origin, seed = waiting.popleft()
        if origin is not None and known.is_reached(origin, seed):
            continue
        branch = _follow_seed(problem, seed)
        if origin is not None and len(branch.points) + len(branch.values) < 2:
            continue
        branches.append(branch)
        for index, key in known.enter(branch, origin, switch):
            event = branch.events[index]
            limit = limit_at(branch, event)
            if limit:
                branch.events[index] = event._replace(reason=limit)
                continue
            waiting += [(key, each) for each in seeds_at(branch, event) if is_wanted(each)]
            if event.kind == "grazing":
                grazings.append((key, branch, event))
    for grazing in grazings:
        waiting += _siblings(known, is_wanted, *grazing)
    return Tree(branches, sum(at is None or not known.is_reached(at, each) for at, each in waiting))


def _siblings(
    known: _Known, is_wanted: Callable[[Seed], bool], key: Key, branch: Branch, event: Event
) -> list[tuple[Key, Seed]]:
    """Return the starts of the branches at a grazing that are not followed yet."""
    siblings = (each for each in siblings_at_grazing(branch, event) if is_wanted(each))
    return [(key, each) for each in siblings if not known.is_met(key, each)]


class _Known:
    """Bifurcations that branches have passed, and the branches that have begun or ended there."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._keys: list[Key] = []
        self._arrived: list[Key] = []
        self._passed: list[tuple[Key, Law]] = []
        self._met: list[tuple[Key, Law]] = []

    def enter(
        self, branch: Branch, origin: Key | None, switch: Collection[str]
    ) -> list[tuple[int, Key]]:
        """Add a branch that begins at a bifurcation; return index and key of its new events of kinds `switch`."""
        new = []
        if origin is not None:
            self._met.append((origin, _law(branch.curve)))
        for index, event in enumerate(branch.events):
            if event.kind not in switch:
                continue
            key, law = _key(branch, event), _law_at(branch, event)
            self._met.append((key, law))
            if not event.reason:
                self._passed.append((key, law))
            if not self._find(self._keys, key):
                self._keys.append(key)
                new.append((index, key))
            elif event.reason and origin is not None and not self._find([origin], key):
                self._arrived.append(key)
        return new

    def is_met(self, key: Key, seed: Seed) -> bool:
        """Return whether a branch of the law of a seed has begun or ended at its bifurcation."""
        law = _law(seed.curve)
        return self._find([other for other, met in self._met if met == law], key)

    def is_reached(self, key: Key, seed: Seed) -> bool:
        """Return whether the branch of a seed, followed from elsewhere, has ended at its bifurcation or passed it."""
        law = _law(seed.curve)
        passed = [other for other, own in self._passed if own == law]
        is_met = self._find(self._arrived, key) and self.is_met(key, seed)
        return is_met or (key[0] in HALVED and self._find(passed, key))

    def _find(self, keys: list[Key], key: Key) -> bool:
        """Return whether a bifurcation is among some."""
        reach = SAME_BIFURCATION * (self._problem.high - self._problem.low)
        floor = 1e-9 * self._problem.values[L]
        return any(
            kind == key[0]
            and abs(value - key[1]) <= reach
            and abs(speed - key[2]) + abs(total - key[3])
            <= 1e3 * SAME_BIFURCATION * (speed + key[2]) + floor
            for kind, value, speed, total in keys
        )


def _law(curve: LawCurve | None) -> Law:
    """Return what tells a branch from others that begin at the same grazing."""
    return (0.5, 1, b"") if curve is None else curve.sequence.key


def _law_at(branch: Branch, event: Event) -> Law:
    """Return the law of the orbits of a branch at an event; it may have begun with another."""
    return _law(branch.points[event.point].curve if branch.points else None)


def _key(branch: Branch, event: Event) -> Key:
    """Return what tells a bifurcation of a branch from others."""
    if branch.curve is None:
        return event.kind, branch.values[event.point], 0.0, 0.0
    point = branch.points[event.point]
    sequence, u = point.curve.sequence, point.u
    n = len(sequence.supports)
    velocities = u[n : 2 * n] / sequence.span
    total = 0.0 if sequence.mirrored else float(velocities.sum())
    return event.kind, float(u[-1]), float(np.abs(velocities).sum()), total


def _follow_seed(problem: Problem, seed: Seed) -> Branch:
    """Follow a branch from its seed, to one or both sides."""
    if seed.curve is None or seed.point is None:
        return _follow_linear_seed(problem, seed)
    curve, closes, length = seed.curve, len(seed.signs) > 1, seed.first_length
    back, ahead = both_ways(
        lambda start: follow_laws(curve, start, closes, length), seed.point, seed.signs
    )
    points, events = joined(back, ahead)
    for path, index in ((back, 0), (ahead, len(points) - 1)):
        if path.end in ("lost", "points", "closed", "continuum"):
            events.append(Event("end", path.end, index))
    return Branch(problem, curve, points, [], sorted(events, key=lambda each: each.point))


def _follow_linear_seed(problem: Problem, seed: Seed) -> Branch:
    """Follow the motion without impacts from a seed."""
    sides = {sign: follow_linear(problem, seed.value, sign) for sign in seed.signs}
    none: tuple[list[float], bool] = ([], False)
    back, ahead = sides.get(-1.0, none), sides.get(1.0, none)
    if 1.0 not in sides:
        back, ahead = none, back
    values = [*reversed(back[0]), seed.value, *ahead[0]]
    events = [Event("grazing", "gap", 0)] if back[1] else []
    events += [Event("grazing", "gap", len(values) - 1)] if ahead[1] else []
    return Branch(problem, None, [], values, events)
