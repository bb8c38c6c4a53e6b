"""Following orbits from law to law."""

from __future__ import annotations

import numpy as np

from vibropipe.continuation.curve import Point
from vibropipe.continuation.follower import FIRST_LENGTH
from vibropipe.continuation.path import LIMIT, Event, Path
from vibropipe.march.piece_log import CAUSE, REST_BEGINS
from vibropipe.orbits.branches.curve import ImpactCurve
from vibropipe.orbits.branches.following import follow
from vibropipe.orbits.law import least as of
from vibropipe.orbits.law.beyond import (
    BESIDES,
    beyond,
    comes_back_early,
    halves_beyond,
    key_of,
    marched_beyond,
    settled_ahead,
)
from vibropipe.orbits.law.curve import LawCurve
from vibropipe.orbits.law.steps import GAP_FLIGHT, GAP_SIDE, MARGIN

# Weighted difference of orbits at which a branch begins a law, a small length from its end, that are one.
SAME_ORBIT = 1e-6
# Laws after which a branch is left: where contacts chatter, others follow ever again.
MAX_LAWS = 100
# Why a branch ends that may go on by another law; at a grazing of impacts alone others begin, too.
ENDS = ("gap", "speed", "lost")


def follow_laws(
    curve: LawCurve, start: Point, closes: bool = True, first_length: float = FIRST_LENGTH
) -> Path:
    """Follow a branch from a point along its tangent, through the ends of its laws.

    Arguments and result are those of `following.follow`. Where the events change there is an event of kind "change";
    the path ends there where no orbit continues it, and at a grazing of orbits that strike rigid supports alone.
    """
    path = follow(curve, start, closes, first_length)
    begun: list[Point] = []
    shortest = BESIDES[0] * (curve.problem.high - curve.problem.low)
    for _law in range(MAX_LAWS):
        if path.end not in ENDS or isinstance(path.points[-1].curve, ImpactCurve):
            return path
        end, last = path.points[-1], len(path.points) - 1
        # many branches begin at an orbit of fewer periods as it touches a support: none continues this one
        is_early = path.end != "lost" and comes_back_early(end)
        after = None
        if path.end == "lost":
            # next to a cusp Newton's method may fail where a march finds the next law
            after = marched_beyond(end, path.points)
            path.events += [Event("lost", "", last)] if after else []
        elif not is_early:
            # laws that follow each other ever faster are passed together; what rests forgets, and is marched
            is_short = begun and abs(end.value - begun[-1].value) < shortest
            after = settled_ahead(end, path.points) if is_short or _ends_chatter(end) else None
            after = beyond(end, path.points) if after is None else after
        if after is None:
            if is_early or (path.end != "lost" and halves_beyond(end)):
                path.events[-1], path.end = path.events[-1]._replace(reason="halved"), "halved"
            return path
        if is_same_chatter(end, after):
            path.events.pop()
        else:
            path.events[-1] = Event("change", "", last)
        if not curve.problem.low < after.value < curve.problem.high:
            path.end = LIMIT
            return path
        if any(_is_again(after, each) for each in begun):
            path.end = "closed"
            return path
        begun.append(after)
        more = follow(after.curve, after, False, FIRST_LENGTH)
        path.points += more.points
        path.lengths += more.lengths
        path.events += [each._replace(point=each.point + last + 1) for each in more.events]
        path.end = more.end
    if path.end in ("gap", "speed"):
        path.events[-1], path.end = path.events[-1]._replace(reason=""), "points"
    return path


def _ends_chatter(point: Point) -> bool:
    """Return whether a law ends where a chatter lasts up to the release, or its uncounted flights get long."""
    return int(point.tests[MARGIN]) == of.SPAN and int(point.tests[GAP_SIDE]) == of.CHATTER


def is_same_chatter(point: Point, after: Point) -> bool:
    """Return whether the law after a point counts more or fewer impacts of a chatter as events, and nothing else.

    A chatter has impacts without end; how many are counted is a matter of digits, and the motion is as before.
    """
    law = point.curve.sequence
    is_chatter = law.codes[int(point.tests[GAP_FLIGHT]), CAUSE] == REST_BEGINS
    if not is_chatter or int(point.tests[MARGIN]) not in (of.SPAN, of.HOUSING_SLIDE):
        return False
    return key_of(point.curve) == key_of(after.curve)


def _is_again(point: Point, before: Point) -> bool:
    """Return whether a branch begins a law in the same orbit and direction as before: it is closed."""
    curve, other = point.curve, before.curve
    if not np.array_equal(curve.sequence.codes, other.sequence.codes):
        return False
    is_same = curve.distance(point, before) < SAME_ORBIT
    return bool(is_same and curve.cosine(point, before) > 0.0)
