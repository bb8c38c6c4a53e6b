"""One family of orbits over a whole box of exciters: proved part by part, or disproved by a counterexample.

A part where a test fails is split along the parameter that widens its tube most. Two parts are joined by the orbit of
one exciter on their common face, which is proved to be the only one in the tubes of both: where two families agree is
then open and closed on the face, so that the orbits of all parts are one continuous family. A counterexample is an
exciter whose orbit is proved to leave the supports, or to have the other stability, and to belong to the family: the
straight line to it from the nominal exciter is such a box in one direction.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from vibropipe.proof.balls import ZERO, Box, arb, magnitude, total
from vibropipe.proof.law import Law
from vibropipe.proof.motion import is_minimal, is_no_motion
from vibropipe.proof.orbit import Orbit
from vibropipe.proof.values import Values, stability, values_of
from vibropipe.words.proofs import Why

# How far the guess of an orbit may be off, as a share of the scale: farther, Newton's method has found another one.
MAX_MOVED, MAX_MOVED_BY_ROUNDING = 0.3, 1e-4
# At most so many parameters have the corners of their box tried.
MAX_CORNERS = 6
# A proved part is split further, to narrow its bounds, while its tube is wider than what follows the parameters by this
# share, and it is more than this share of the whole box.
WIDER, NARROWED = 0.1, 2.0**-6
# Share of the whole box below which a part is not split.
SMALLEST = 2.0**-60
# Factors of a box that are tried, and how near the largest one is known.
MIN_FACTOR, MAX_FACTOR, FACTOR_STEP = 2.0**-20, 2.0**10, 1.05


@dataclass
class Claim:
    """What is claimed of all exciters: an orbit of this law, which is a motion of this stability."""

    law: Law
    is_stable: bool | None
    harmonics: int


@dataclass
class Part:
    """A part of a box with its orbit; `why` is `NONE` where all that is claimed is proved."""

    orbit: Orbit
    why: Why
    values: Values | None = None
    refuted: bool = False

    def leaf_at(self, _c: Sequence[float]) -> Part:
        """Return the part of an offset."""
        return self

    def leaves(self) -> list[Part]:
        """Return all parts."""
        return [self]


@dataclass
class Joined:
    """Two parts with a common face, or what they were split into."""

    axis: int
    cut: float
    halves: list[Any]

    def leaf_at(self, c: Sequence[float], side: int | None = None) -> Part:
        """Return the part of an offset; of one on the face, that on a side."""
        side = int(c[self.axis] > self.cut) if side is None else side
        found: Part = self.halves[side].leaf_at(c)
        return found

    def leaves(self) -> list[Part]:
        """Return all parts."""
        return [part for half in self.halves for part in half.leaves()]


def examine(box: Box, claim: Claim, guess: Sequence[Any], max_moved: float) -> Part:
    """Prove of a box all that is claimed, or return the first that is not proved."""
    orbit = Orbit(box, claim.law, guess)
    if not (orbit.moved < max_moved and orbit.prove()):
        return Part(orbit, Why.EXISTENCE)
    leaves = is_no_motion(orbit)
    if leaves is not False:
        return Part(orbit, Why.MOTION, refuted=leaves is True)
    values, has_period = values_of(orbit, claim.harmonics), is_minimal(orbit)
    if not has_period:
        return Part(orbit, Why.PERIOD, values, has_period is False)
    is_stable = stability(values)
    if is_stable is None or (claim.is_stable is not None and is_stable != claim.is_stable):
        return Part(orbit, Why.STABILITY, values, is_stable is not None)
    return Part(orbit, Why.NONE, values)


def exists(box: Box, claim: Claim, guess: Sequence[Any], max_moved: float) -> Part:
    """Prove of a box that there is the orbit, no matter whether it is a motion."""
    orbit = Orbit(box, claim.law, guess)
    is_proved = orbit.moved < max_moved and orbit.prove()
    return Part(orbit, Why.NONE if is_proved else Why.EXISTENCE)


@dataclass
class Certificate:
    """The proof over a box of exciters |c_j| <= 1 around one whose orbit is known.

    nominal, within : balls by parameter: the exciter, and how far each parameter may be off, either way
    start : the orbit of the nominal exciter, proved
    limit : parts and points that are examined at most
    narrows : whether proved parts are split further to narrow their bounds
    tree : all parts, once the claim is proved
    why : what is not proved
    counterexample : parameters at which the claim is disproved
    """

    nominal: Mapping[str, Any]
    within: Mapping[str, Any]
    claim: Claim
    start: Orbit
    limit: int
    narrows: bool = False
    tree: Part | Joined | None = None
    why: Why = Why.NONE
    counterexample: dict[str, float] | None = None
    examined: int = field(default=0)

    def prove(self) -> bool:
        """Prove the claim, or find a counterexample, or give up; return whether it is proved."""
        names = list(self.within)
        directions = [{name: self.within[name]} for name in names]
        whole = Box(self.nominal, directions, [-1.0] * len(names), [1.0] * len(names))
        first = self._examine(examine, whole, self.start.u)
        if first.why is Why.NONE:
            self.tree = first
        elif not self._is_refuted_at_corner(first, names):
            self.tree = self._split(examine, first)
        if self.tree is not None and not self._holds_start(self.tree, self.start):
            self.tree, self.why = None, Why.FAMILY
        elif self.tree is not None:
            self.tree = self._narrowed(self.tree) if self.narrows else self.tree
            self.why = Why.NONE
        return self.tree is not None

    def _examine(self, test: Callable[..., Part], box: Box, guess: Sequence[Any]) -> Part:
        self.examined += 1
        return test(box, self.claim, guess, MAX_MOVED)

    def _split(self, test: Callable[..., Part], part: Part) -> Part | Joined | None:
        """Return a part whose test failed, proved by halves; None if that fails, `why` then says at what."""
        orbit, box = part.orbit, part.orbit.box
        if not orbit.moved < MAX_MOVED:
            self.why = Why.EXISTENCE
            return None
        if self.examined >= self.limit:
            self.why = Why.PARTS
            return None
        if box.share < SMALLEST:  # at a bifurcation no part is small enough
            self.why = part.why
            return None
        centre = self._examine(test, Box(box.centre), orbit.u)
        if centre.refuted and self._is_counterexample(centre):
            return None
        if not centre.orbit.tube:
            self.why = Why.EXISTENCE
            return None
        axis = orbit.share.index(max(orbit.share))
        cut, halves = box.middle[axis], []
        for low, high in ((box.low[axis], cut), (cut, box.high[axis])):
            lows, highs = list(box.low), list(box.high)
            lows[axis], highs[axis] = low, high
            half = Box(box.nominal, box.directions, lows, highs)
            step = arb(half.middle[axis] - cut)
            guess = [
                a + slopes[axis] * step for a, slopes in zip(orbit.u, orbit.slopes, strict=True)
            ]
            found: Any = self._examine(test, half, guess)
            if found.why is not Why.NONE:
                found = self._split(test, found)
            if found is None:
                return None
            halves.append(found)
        joined = Joined(axis, cut, halves)
        for side in (0, 1):
            if not _is_only_orbit(joined.leaf_at(box.middle, side), box.middle, centre.orbit):
                self.why = Why.FAMILY
                return None
        return joined

    def _narrowed(self, tree: Part | Joined) -> Part | Joined:
        """Return proved parts, split on to narrow their bounds as long as that is worth while."""
        if isinstance(tree, Joined):
            return replace(tree, halves=[self._narrowed(half) for half in tree.halves])
        orbit = tree.orbit
        follows = [
            total(magnitude(slope * c) for slope, c in zip(slopes, orbit.box.offsets, strict=True))
            for slopes in orbit.slopes
        ]
        is_wide = any(r > f * WIDER for r, f in zip(orbit.radius, follows, strict=True))
        if not is_wide or orbit.box.share <= NARROWED or self.examined >= self.limit:
            return tree
        halves = self._split(examine, tree)
        return tree if halves is None else self._narrowed(halves)

    def _holds_start(self, tree: Part | Joined, start: Orbit) -> bool:
        """Return whether the orbit of the nominal exciter belongs to a proved family."""
        middle = [0.0] * len(self.within)
        return _is_only_orbit(tree.leaf_at(middle), middle, start)

    def _is_refuted_at_corner(self, part: Part, names: Sequence[str]) -> bool:
        """Return whether an end of an axis or a corner of the whole box is a counterexample."""
        orbit, n = part.orbit, len(names)
        if not orbit.moved < MAX_MOVED or n > MAX_CORNERS:
            return False
        ends = [[float(s * (i == j)) for i in range(n)] for j in range(n) for s in (-1, 1)]
        corners = [list(each) for each in itertools.product((-1.0, 1.0), repeat=n)] if n > 1 else []
        for c in ends + corners:
            if self.examined >= self.limit:
                return False
            guess = [
                u + sum((s * x for s, x in zip(slopes, c, strict=True)), ZERO)
                for u, slopes in zip(orbit.u, orbit.slopes, strict=True)
            ]
            point = self._examine(examine, Box(orbit.box.at(c)), guess)
            if point.refuted and self._is_counterexample(point):
                return True
        return False

    def _is_counterexample(self, point: Part) -> bool:
        """Return whether a refuted point is one of doubles within the box and belongs to the family of the start."""
        values = {name: self._inside(name, point.orbit.box.centre[name]) for name in self.within}
        off = {name: arb(value) - self.nominal[name] for name, value in values.items()}
        if any(not abs(d) <= self.within[name] for name, d in off.items()):
            return False
        exact = Box({**self.nominal, **{name: arb(value) for name, value in values.items()}})
        found = self._examine(examine, exact, point.orbit.u)
        if not found.refuted:
            return False
        line = Certificate(
            self.nominal, {}, self.claim, self.start, self.limit, examined=self.examined
        )
        is_family = line.reaches(found.orbit, off)
        self.examined = line.examined
        if is_family:
            self.counterexample, self.why = values, found.why
        return is_family

    def _inside(self, name: str, value: Any) -> float:
        """Return the double nearest to a value of a parameter; at an end of the box the next one inside."""
        near, nominal = float(value.mid()), self.nominal[name]
        is_inside = abs(arb(near) - nominal) <= self.within[name]
        return near if is_inside else math.nextafter(near, float(nominal))

    def reaches(self, other: Orbit, off: Mapping[str, Any]) -> bool:
        """Return whether the orbit of the nominal exciter, followed straight to another one, is the given one there."""
        whole = Box(self.nominal, [off], [0.0], [1.0])
        first: Any = self._examine(
            exists, whole, [(a + b) / 2 for a, b in zip(self.start.u, other.u, strict=True)]
        )
        tree = first if first.why is Why.NONE else self._split(exists, first)
        if tree is None:
            return False
        ends = ((0.0, self.start), (1.0, other))
        return all(_is_only_orbit(tree.leaf_at([c]), [c], orbit) for c, orbit in ends)


def _is_only_orbit(part: Part, c: Sequence[float], point: Orbit) -> bool:
    """Return whether the orbit of one exciter, at an offset, lies where a part has no other."""
    offsets = [arb(a) - b for a, b in zip(c, part.orbit.box.middle, strict=True)]
    tube = part.orbit.tube_of(part.orbit.unique, offsets)
    return all(a.contains(b) for a, b in zip(tube, point.tube, strict=True))


def largest_factor(proves: Callable[[float], bool], is_proved: bool) -> float:
    """Return the largest factor found at which a claim is proved, 0 if none is, to a share of 5 %.

    `proves` returns whether it is at a factor; it is known at 1.
    """
    good, bad = (1.0, math.inf) if is_proved else (0.0, 1.0)
    while bad > MIN_FACTOR and good < MAX_FACTOR and not (good > 0 and bad / good < FACTOR_STEP):
        between = math.sqrt(good * bad) if good > 0 else 0.5 * bad
        factor = 2.0 * good if bad == math.inf else between
        if proves(factor):
            good = factor
        else:
            bad = factor
    return good
