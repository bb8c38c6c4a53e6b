"""What is found of a curve: its points in one direction, what lies on them, and why it ended."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from vibropipe.continuation.curve import Point

# Name of the limit of a parameter, which ends a curve and is no event.
LIMIT = "limit"


class Event(NamedTuple):
    """What a curve meets: its kind, why the curve ends there ("" if it goes on), and its point's number."""

    kind: str
    reason: str
    point: int


class Mark(NamedTuple):
    """A point within a step: its length from the start of the step, kind ("" for none) and reason to end there."""

    length: float
    point: Point
    kind: str
    reason: str


class Wanted(NamedTuple):
    """A value of an unknown at which a point is wanted; if it ends the curve, its name and which side is beyond."""

    column: int
    value: float
    name: str = ""
    side: float = 0.0


class Step(NamedTuple):
    """A step: from where, to where, and its weighted length."""

    point: Point
    new: Point
    length: float


@dataclass
class Path:
    """Points of a curve in one direction, its events, why it ended, and the lengths of the steps to its points."""

    points: list[Point]
    events: list[Event] = field(default_factory=list)
    end: str = ""
    lengths: list[float] = field(default_factory=lambda: [0.0])

    def append(self, marks: Iterable[Mark]) -> None:
        """Append the points of a step, up to the first that ends the curve."""
        before = 0.0
        for mark in marks:
            if mark.length > before or not mark.kind:
                self.points.append(mark.point)
                self.lengths.append(mark.length - before)
                before = mark.length
            if mark.kind not in ("", LIMIT):
                self.events.append(Event(mark.kind, mark.reason, len(self.points) - 1))
            if mark.reason:
                self.end = mark.reason
                break

    def length_towards(self, hint: float) -> float | None:
        """Return the length of the next step, to a hint; None if it lies before a last point that has an event.

        A last point behind the hint is removed otherwise, and the step begins at the one before. The hint is a weighted
        length from the last point, negative before it.
        """
        if hint > 0.0:
            return hint
        if self.events and self.events[-1].point >= len(self.points) - 1:
            return None
        self.points.pop()
        return self.lengths.pop() + hint


def both_ways(
    follow: Callable[[Point], Path], start: Point, signs: Sequence[float] = (1.0, -1.0)
) -> tuple[Path, Path]:
    """Follow a curve from a point along its tangent (sign 1), against it (-1), or both unless it closes.

    Returns the paths before and after the point; a curve followed to one side begins there.
    """
    paths: list[Path] = []
    for sign in signs:
        if not (paths and paths[0].end == "closed"):
            paths.append(follow(start if sign > 0.0 else start.reversed()))
    return (paths[1] if len(paths) > 1 else Path([start])), paths[0]


def joined(back: Path, ahead: Path) -> tuple[list[Point], list[Event]]:
    """Return points and events of a curve that was followed from one point to both sides, in order."""
    shift = len(back.points) - 1
    points = [*(each.reversed() for each in back.points[:0:-1]), *ahead.points]
    events = [each._replace(point=shift - each.point) for each in reversed(back.events)]
    return points, events + [each._replace(point=shift + each.point) for each in ahead.events]
