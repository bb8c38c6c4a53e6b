"""Following a branch: what bifurcations it meets, and the reason why it ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from vibropipe.continuation.curve import FOLD, Point, Zero
from vibropipe.continuation.follower import FIRST_LENGTH, Follower
from vibropipe.continuation.path import LIMIT, Event, Path, Step, Wanted
from vibropipe.march.piece_log import CAUSE, HOUSING_STOP
from vibropipe.orbits.branches.parents import parent_ahead, reached_parent
from vibropipe.orbits.branches.symmetry import halves_agree
from vibropipe.orbits.law.curve import UNRESOLVED_LENGTH, LawCurve
from vibropipe.orbits.law.law import WAY
from vibropipe.orbits.law.problem import Problem
from vibropipe.orbits.law.steps import DETERMINANT, DOUBLING, GAP, PAIR, SPEED, TRACE

# Step towards the parent at which what lies before it is found.
PARENT_LENGTH = 1e-6
# Component of the tangent along the parameter at both ends of a longer step where orbits are a continuum: rounding.
FLAT, FLAT_LENGTH = 1e-10, 1e-5
# The least impact speed may fall to this share in a step, unless it is below a bound: tests vary with its inverse.
SPEED_SHARE, SLOW = 0.4, 1e-5
# Shortest step of which is asked whether it leads onto another branch; components of the tangent along the parameter,
# and det(I - M), below which their signs may be rounding.
LEAST_GAP, STEEP, AT_FOLD = 1e-7, 1e-4, 1e-8


class Seed(NamedTuple):
    """The start of a branch: a point with its tangent, or the parameter of a motion without impacts; and where to go.

    curve : None without impacts
    value : the parameter
    signs : 1 along the tangent (without impacts: upwards), -1 against it
    first_length : of the first step
    """

    curve: LawCurve | None
    point: Point | None
    value: float
    signs: tuple[float, ...]
    first_length: float = FIRST_LENGTH


@dataclass
class Branch:
    """A branch: its points or, without impacts, its values of the parameter, in order; its events; why it ended."""

    problem: Problem
    curve: LawCurve | None
    points: list[Point]
    values: list[float]
    events: list[Event]


def follow(
    curve: LawCurve, start: Point, closes: bool = True, first_length: float = FIRST_LENGTH
) -> Path:
    """Follow a branch from a point along its tangent until it ends or leaves the range of the parameter.

    Its end is also `doubled` where it reaches its parent, and `continuum`; else arguments and result are those of
    `Follower`.
    """
    return BranchFollower(curve, start, closes, first_length).follow()


def is_pair(point: Point) -> bool:
    """Return whether multipliers of a point at which PAIR is zero are complex: a and 1/a have the same zero."""
    # The third is the determinant, where the product of the two is 1.
    return abs(point.tests[TRACE] - point.tests[DETERMINANT]) < 2.0


class BranchFollower(Follower):
    """Follows a branch of one impact sequence."""

    curve: LawCurve
    ends = (SPEED, GAP)
    turns: tuple[int, ...] = (FOLD, DOUBLING)
    jumps = True

    def __init__(self, curve: LawCurve, start: Point, closes: bool, first_length: float) -> None:
        super().__init__(curve, start, closes, first_length)
        low, high = curve.problem.low, curve.problem.high
        inner = [Wanted(-1, value) for value in curve.problem.at if value not in (low, high)]
        if curve.effects.housing is not None:
            # A housing that never stops keeps any momentum: a multiplier is 1 along the branch.
            keeps = (
                curve.sequence.codes[:, WAY].all()
                and HOUSING_STOP not in curve.sequence.codes[:, CAUSE]
            )
            self.turns = (FOLD,) if keeps else (FOLD, DOUBLING, PAIR)
        self.wanted = [*inner, Wanted(-1, low, LIMIT, -1.0), Wanted(-1, high, LIMIT, 1.0)]

    def name_of(self, test: int, step: Step, zero: Zero) -> tuple[str, str]:  # noqa: D102 - as Follower
        curve, (length, point) = self.curve, zero
        if test in self.turns and curve.is_born(point):
            return "", ""
        if test == PAIR:
            return ("neimark_sacker" if is_pair(point) else ""), ""
        if test in self.turns and curve.is_steep(step.point, length, UNRESOLVED_LENGTH):
            return "end", "rounding"
        if test == DOUBLING:
            return ("pitchfork" if curve.sequence.mirrored else "flip"), ""
        if test == FOLD:
            kind = halves_agree(curve.sequence, point.u, curve.weights, curve.problem.symmetric)
            return (
                (kind, "doubled") if kind else ("fold", "fold" if curve.problem.until_fold else "")
            )
        return curve.end_of(test, point)

    def looks_ahead(self) -> bool:  # noqa: D102 - as Follower
        path, point = self.path, self.path.points[-1]
        kind = parent_ahead(self.curve, self.curve.problem.symmetric, point, self.length)
        if not kind:
            return True
        parent = reached_parent(self.curve, point, kind)
        if parent is not None and self._is_clear(point, parent):
            path.points.append(parent)
            path.events.append(Event(kind, "doubled", len(path.points) - 1))
            path.end = "doubled"
            return False
        # Past a parent that is not found yet, a step may hide the last flip before it, and end at a wrong place.
        if self.length > PARENT_LENGTH:
            self.length *= 0.5
            return False
        return True

    def _is_clear(self, point: Point, parent: Point) -> bool:
        """Return whether no flip, and no wanted value or limit, lies between a point and its parent."""
        # Next to the parent a doubled orbit has a multiplier close to 1.
        if point.tests[DOUBLING] < 0.0:
            return False
        return not any(
            (point.value - each.value) * (parent.value - each.value) < 0.0 for each in self.wanted
        )

    def ends_at(self, new: Point) -> str:  # noqa: D102 - as Follower
        # The parameter does not change over a step, as for undamped orbits at a natural period.
        tests = abs(self.path.points[-1].tests[FOLD]), abs(new.tests[FOLD])
        return "continuum" if self.length > FLAT_LENGTH and max(tests) < FLAT else ""

    def is_too_far(self, point: Point, new: Point) -> bool:  # noqa: D102 - as Follower
        speed = point.tests[SPEED]
        is_slower = speed > SLOW and new.tests[SPEED] < SPEED_SHARE * speed
        return super().is_too_far(point, new) or bool(is_slower) or self._leaves(point, new)

    def _leaves(self, point: Point, new: Point) -> bool:
        """Return whether a step seems to lead onto another branch, as next to a pitchfork that is not quite one.

        Along a branch det(I - M) changes its sign with the direction of the parameter: at folds.
        """
        if self.curve.effects.housing is not None or self.length < LEAST_GAP:
            return False
        # At an end of its law the derivative is infinite, or the tangent lies across the parameter.
        if not (self.is_inside(point) and self.is_inside(new)):
            return False
        before, after = (1.0 - each.tests[TRACE] + each.tests[DETERMINANT] for each in (point, new))
        way, way_after = point.tests[FOLD], new.tests[FOLD]
        if min(abs(way), abs(way_after)) < STEEP or min(abs(before), abs(after)) < AT_FOLD:
            return False
        return bool(before * way * after * way_after < 0.0)
