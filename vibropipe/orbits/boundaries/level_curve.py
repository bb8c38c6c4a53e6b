"""Level curves: orbits of one law of which a quantity has a given value, over two parameters."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np

from vibropipe.continuation.curve import Point, Zero
from vibropipe.continuation.path import Event, Mark, Step
from vibropipe.march.piece_log import CAUSE
from vibropipe.orbits.boundaries.curve import LEVELS, BoundaryFollower, Box
from vibropipe.orbits.boundaries.law_curve import DIFFERENCE, LawBoundary
from vibropipe.orbits.boundaries.seeds import settled
from vibropipe.orbits.branches.curve import is_no_motion
from vibropipe.orbits.branches.following import PARENT_LENGTH, Branch
from vibropipe.orbits.branches.linear import linear_state
from vibropipe.orbits.branches.parents import AT_PARENT, NEAR_PARENT, PROBES, parent_ahead
from vibropipe.orbits.branches.symmetry import doubled, halved, primitive
from vibropipe.orbits.law.curve import NO_TOUCH, LawZeros
from vibropipe.orbits.law.law import SECTION, Law, without_events
from vibropipe.orbits.law.marching import Marcher
from vibropipe.orbits.law.problem import Scales
from vibropipe.orbits.law.steps import DOUBLING, UNIT

# Change of a quantity between two points, over its scale, that is rounding: a quantity may have its value in a region.
NO_CHANGE = 1e-10
# Difference of a quantity, over its scale, of an orbit and its mirror image that have the same.
SAME_VALUE = 1e-9
# By how much a quantity misses its value, over its scale: from the curve that orbits (k, size) lie on, these orbits,
# and whether their mirror images are meant.
Misses = Callable[[LawZeros, np.ndarray, bool], np.ndarray]


class Level(NamedTuple):
    """A value of a quantity: its number among those that are sought, and by how much orbits miss it (k,)."""

    number: int
    misses: Misses


class LevelCurve(LawBoundary):
    """The orbits of one law of which a quantity has a value.

    scales, marcher : as for `LawZeros`
    is_image : whether the quantity is that of the mirror images of the orbits, which a symmetric exciter has too
    """

    def __init__(
        self, box: Box, level: Level, law: Law, scales: Scales, marcher: Marcher, is_image: bool
    ) -> None:
        super().__init__(box, LEVELS, law, NO_TOUCH, scales, marcher)
        self.level, self.is_image = level, is_image

    def with_sequence(self, sequence: Any) -> LevelCurve:  # noqa: D102 - as Curve
        return LevelCurve(self.box, self.level, sequence, self.scales, self.marcher, self.is_image)

    def key(self, is_image: bool) -> tuple[int, tuple[float, int, bytes]]:
        """Return what tells level curves of different motions apart, of the orbits or their mirror images."""
        law = self.sequence
        seen = law._replace(codes=law.image(law.codes)) if is_image else law
        return self.level.number, seen.key

    def conditions(self, u: np.ndarray) -> list[tuple[float, np.ndarray]]:  # noqa: D102 - as LawZeros
        if self._slope is not None:
            return [(float(self._missed(u[np.newaxis])[0]), self._slope)]
        # The error of the differences affects the speed of convergence alone.
        steps = np.diag(DIFFERENCE / self.weights)
        missed = self._missed(np.concatenate([u[np.newaxis], u + steps, u - steps]))
        above, below = np.split(missed[1:], 2)
        self._slope = (above - below) / (2.0 * np.diag(steps))
        return [(float(missed[0]), self._slope)]

    def _missed(self, orbits: np.ndarray) -> np.ndarray:
        return self.level.misses(self, orbits, self.is_image)

    def step(self, u: np.ndarray, target: float) -> np.ndarray | None:  # noqa: D102 - as Curve
        step = super().step(u, target)
        return step if step is not None and np.isfinite(step).all() else None

    def parent_met(self, point: Point, length: float) -> tuple[str, Point | None] | None:
        """Return the flip or pitchfork that creates the orbits of the curve, if a step along the tangent leads past it.

        Returns its kind, and the orbit there; None in its place if it is not found, or lies beyond the box.
        """
        kind = parent_ahead(self, self.box.symmetric, point, length)
        if not kind:
            return None
        # A number in place of the parameter that ends the unknowns of a branch.
        law, mean = halved(self.sequence, np.append(point.u[:-2], 0.0), kind)
        parent = self.with_sequence(law)
        begun = settled(parent, np.concatenate([mean[:-1], point.u[-2:]]), NEAR_PARENT)
        if begun is None:
            return kind, None
        for probe in PROBES:
            ends_of_probe = -probe, probe
            zero = parent.locate(begun[1], ends_of_probe, lambda each: float(each.tests[DOUBLING]))
            if zero is None or not abs(zero[1].tests[DOUBLING]) < AT_PARENT:
                continue
            at, ends = np.append(zero[1].u[:-2], 0.0), zero[1].u[-2:]
            _law, u, _change = doubled(law, at, np.zeros(at.size))
            reached = point._replace(u=np.concatenate([u[:-1], ends]))
            is_inside = (self.box.low <= ends).all() and (ends <= self.box.high).all()
            if is_inside and self.distance(reached, point) < NEAR_PARENT:
                return kind, reached
        return kind, None

    def near_end(self, point: Point) -> str:  # noqa: D102 - as LawBoundary
        return super().near_end(point).removeprefix("degenerate_")

    def is_again(self, point: Point, others: Iterable[Any]) -> bool:
        """Return whether a point lies on one of some boundaries (`search.Boundary`), or its mirror image does."""
        keys = {self.key(self.is_image)}
        if self.box.symmetric:
            other = self.level.misses(self, point.u[np.newaxis], not self.is_image)
            if abs(float(other[0])) < SAME_VALUE:
                keys.add(self.key(not self.is_image))
        return any(
            isinstance(each.curve, LevelCurve)
            and each.curve.key(each.curve.is_image) in keys
            and each.curve.passes(each.points, point)
            for each in others
        )


class LevelFollower(BoundaryFollower):
    """Follows a level curve, through folds, flips and pitchforks of its orbit."""

    curve: Any

    def __init__(self, curve: Any, start: Point) -> None:
        super().__init__(curve, start)
        self.turns = (UNIT, DOUBLING)

    def looks_ahead(self) -> bool:  # noqa: D102 - as Follower
        path, point = self.path, self.path.points[-1]
        met = self.curve.parent_met(point, self.length)
        if met is None:
            return True
        kind, parent = met
        if parent is None:
            # Past a parent that is not found yet a step may end at a wrong place.
            self.length *= 0.5
            return self.length < PARENT_LENGTH
        path.points.append(parent)
        path.lengths.append(self.length)
        path.events.append(Event(kind, kind, len(path.points) - 1))
        path.end = kind
        return False

    def name_of(self, test: int, step: Step, zero: Zero) -> tuple[str, str]:  # noqa: D102 - as Follower
        if test == UNIT:
            return "fold", ""
        if test == DOUBLING:
            return "pitchfork" if self.curve.sequence.mirrored else "flip", ""
        return super().name_of(test, step, zero)

    def marks_of_its_own(self, step: Step) -> list[Mark]:  # noqa: D102 - as Follower
        return []


def level_curves(
    box: Box, branch: Branch, levels: Sequence[Level], marcher: Marcher
) -> Iterator[tuple[LevelCurve, Point]]:
    """Yield the level curves that a branch crosses, and their points there.

    branch : along one of the parameters of the box; its problem holds the other
    """
    if not levels:
        return
    for law, scales, orbits in _orbits_of(box, branch):
        # The mirror image of an orbit has other quantities; an orbit that is its own has no other.
        is_own = law.mirrored or law.codes[0, CAUSE] == SECTION or not box.symmetric
        for level in levels:
            for is_image in (False,) if is_own else (False, True):
                curve = LevelCurve(box, level, law, scales, marcher, is_image)
                missed = level.misses(curve, orbits, is_image)
                for i in np.flatnonzero(_crosses(missed[:-1], missed[1:])):
                    share = missed[i] / (missed[i] - missed[i + 1])
                    near = orbits[i] + share * (orbits[i + 1] - orbits[i])
                    begun = _in_least_periods(settled(curve, near, box.max_length))
                    if begun is not None and not is_no_motion(begun[1]):
                        yield begun


def _crosses(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Return where a quantity has its value between two points, from by how much it misses it there."""
    is_crossed = (before > 0.0) != (after > 0.0)
    return np.asarray(is_crossed & (np.abs(after - before) > NO_CHANGE))


def _in_least_periods(begun: tuple[LevelCurve, Point] | None) -> tuple[LevelCurve, Point] | None:
    """Return a level curve and its point by the law that the orbit has in its least number of periods."""
    if begun is None:
        return None
    curve, point = begun
    # A number in place of the parameter that ends the unknowns of a branch.
    u, weights = np.append(point.u[:-2], 0.0), np.append(curve.weights[:-2], 0.0)
    law, events = primitive(curve.sequence, u, weights, curve.box.symmetric)
    if law is curve.sequence:
        return begun
    return settled(curve.with_sequence(law), np.concatenate([events[:-1], point.u[-2:]]))


def _orbits_of(box: Box, branch: Branch) -> Iterator[tuple[Law, Scales, np.ndarray]]:
    """Yield the laws of a branch in turn, their scales, and their orbits (k, size) with both parameters."""

    def ends(value: float) -> np.ndarray:
        return np.array(branch.problem.values_at(value)[box.along])

    if branch.curve is None:
        p = branch.problem.parameters_at(branch.values[0])
        orbits = [
            np.concatenate([linear_state(branch.problem.parameters_at(value)), ends(value)])
            for value in branch.values
        ]
        yield without_events(1.0, 0), Scales(p.l, p.l * p.nu), np.array(orbits)
        return
    for _id, group in groupby(branch.points, lambda each: id(each.curve)):
        points = [*group]
        curve = points[0].curve
        orbits = [np.concatenate([each.u[:-1], ends(each.value)]) for each in points]
        yield curve.sequence, curve.scales, np.array(orbits)
