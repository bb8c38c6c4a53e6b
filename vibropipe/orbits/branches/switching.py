"""Branches that begin at the bifurcations of another."""

from __future__ import annotations

from vibropipe.continuation.curve import Point
from vibropipe.continuation.path import Event
from vibropipe.orbits.branches.following import Branch, Seed
from vibropipe.orbits.branches.grazing import MAX_SEQUENCE, MIN_CHATTER_SPEED, seeds_at_grazing
from vibropipe.orbits.branches.parents import child_point, parent_point
from vibropipe.orbits.law.curve import HIDDEN_LENGTH, LawCurve
from vibropipe.orbits.law.steps import DOUBLING, SPEED
from vibropipe.orbits.recurrence import MAX_MULTIPLE

# Kinds of bifurcation at which branches begin.
SWITCHES = ("flip", "pitchfork", "grazing")
# First step away from a parent: both branches solve the equations of the doubled sequence, which are singular there.
DOUBLED_LENGTH = 1e-2


def _doubled_seeds(curve: LawCurve, point: Point, kind: str) -> list[Seed]:
    """Return the branches of doubled (or asymmetric) orbits that begin at a flip (or pitchfork)."""
    n = len(curve.sequence.supports)
    child, start = child_point(curve, point, curve.doubling_vector(point))
    # The other side of a flip is the same orbit a period later; that of a pitchfork is its mirror image. The one that
    # strikes support 1 harder comes first, wherever the sequence begins.
    sides = [start]
    if kind == "pitchfork":
        harder = start.tangent[2 * n : 4 * n][child.sequence.on_first].sum() >= 0.0
        sides = [start, start.reversed()] if harder else [start.reversed(), start]
    return [Seed(child, side, point.value, (1.0,), DOUBLED_LENGTH) for side in sides]


def limit_at(branch: Branch, event: Event) -> str:
    """Return why the orbits that begin at a bifurcation of a branch are not followed, "" if they are.

    Returns "multiple" or "impacts" if they have too many periods or impacts, "rounding" if that hides them.
    """
    if branch.curve is None or event.reason in ("speed", "doubled"):
        return ""
    point = branch.points[event.point]
    sequence = point.curve.sequence
    n, is_doubled = len(sequence.supports), event.kind != "grazing"
    # A mirrored sequence is half of its orbit, and loses its symmetry within the same periods.
    if is_doubled and not sequence.mirrored and 2 * sequence.m > MAX_MULTIPLE:
        return "multiple"
    if (2 * n if is_doubled else n + 1) > MAX_SEQUENCE:
        return "impacts"
    if point.tests[SPEED] < MIN_CHATTER_SPEED:
        return "rounding"
    return "rounding" if is_doubled and point.curve.is_steep(point, 0.0, HIDDEN_LENGTH) else ""


def seeds_at(branch: Branch, event: Event) -> list[Seed]:
    """Return the branches that begin at a bifurcation of a branch."""
    if event.kind == "grazing" or branch.curve is None:
        return seeds_at_grazing(branch, event)
    point = branch.points[event.point]
    if event.reason == "doubled":
        at_parent = parent_point(point.curve, point, event.kind)
        if at_parent is None:
            return []
        parent, start = at_parent
        tests = start.tests.copy()
        tests[DOUBLING] = 0.0
        return [Seed(parent, start._replace(tests=tests), point.value, (1.0, -1.0))]
    return _doubled_seeds(point.curve, point, event.kind)
