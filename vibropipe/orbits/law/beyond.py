"""The law and the orbit with which a branch goes on where its law ends: by the edit of its margin, or by a march."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, pairwise

import numpy as np

from vibropipe.continuation.curve import Point
from vibropipe.march.piece_log import (
    CAUSE,
    CONTACT,
    ENTER,
    FORM,
    FREE,
    HOME,
    IMPACT,
    LEAVE,
    REST_BEGINS,
    TURN,
)
from vibropipe.orbits.branches.symmetry import halves_agree
from vibropipe.orbits.law import least as of
from vibropipe.orbits.law.curve import LawCurve
from vibropipe.orbits.law.edits import edits
from vibropipe.orbits.law.flights import state_within
from vibropipe.orbits.law.happenings import law_from, reference_of
from vibropipe.orbits.law.law import SECTION, Law, without_events
from vibropipe.orbits.law.steps import GAP, MARGIN, SPEED

# Lengths from the end of a law at which the next one is tried, and the largest distance of its first orbit from it.
TRIED, NEAR = (1e-3, 1e-4, 1e-5, 1e-6), 1e-3
# Lengths at which a branch goes on, if it keeps its margins there.
CLOSE = (1e-6, 1e-5, 1e-4)
# Distances in the parameter, as shares of its range, at which a march seeks the next law, how many orbits it settles,
# and the largest distance, weighted, of the orbit that it finds.
BESIDES, SETTLING, CLOSEST = (1e-6, 1e-5, 1e-4), 32, 1e-2
# Weighted difference of orbits, or of halves of one, that are the same.
SAME = 1e-8
# Shares of the scale of speeds at which a branch with a cusp at its end goes on, and by how many periods each earlier.
SPEEDS, SPREAD = (1e-4, 1e-3), 0.2
# Time beside an event of zero speed, in forcing periods, after which the speed is the acceleration times this time.
ASIDE = 1e-6
# Least margin that counts as kept: rounding of a zero.
KEPT = 1e-13


def has_passed(points: Sequence[Point], point: Point) -> bool:
    """Return whether an orbit is one that a branch has passed the other way: it would go back along itself."""
    key, value, speeds = key_of(point.curve), point.value, _speeds(point)
    least = SAME * point.curve.speed
    for before, after in pairwise(points):
        is_between = (before.value - value) * (after.value - value) <= 0.0
        is_back = (after.value - before.value) * point.tangent[-1] < 0.0
        if not (is_between and is_back) or key_of(before.curve) != key:
            continue
        same = before.curve.settle(np.append(before.u[:-1], value))
        if same is not None and np.abs(_speeds(same) - speeds).max(initial=0.0) < least:
            return True
    return False


def key_of(curve: LawCurve) -> tuple[float, int, bytes]:
    """Return what tells laws apart, no matter how many impacts of a chatter they count."""
    return curve.sequence.without_chatters.key


def _speeds(point: Point) -> np.ndarray:
    """Return what an orbit has free at the events of `key_of`, without signs, no matter which is listed first."""
    law = point.curve.sequence
    listed = [i for i in law.beside_chatters if law.codes[i, CAUSE] != REST_BEGINS]
    return np.sort(np.abs(point.curve.events_of(point.u)[listed, 1]))


def beyond(point: Point, points: Sequence[Point]) -> Point | None:
    """Return the orbit at the end of a law as a point of the branch that goes on, along it; None if none is found.

    points : of the branch up to there
    """
    return _first_new(points, chain(_edited(point), _marched(point, _heading(points))))


def marched_beyond(point: Point, points: Sequence[Point]) -> Point | None:
    """Return what `beyond` does, by marches alone."""
    return _first_new(points, _marched(point, _heading(points)))


def settled_ahead(point: Point, points: Sequence[Point]) -> Point | None:
    """Return the orbit of another law that a march ahead of the end of one settles on; arguments as of `beyond`."""
    return _first_new(points, _settled(point, _heading(points)))


def _first_new(points: Sequence[Point], found: Iterable[Point]) -> Point | None:
    """Return the first of some orbits that no branch has passed."""
    return next((each for each in found if not has_passed(points, each)), None)


def _heading(points: Sequence[Point]) -> float:
    """Return whether the parameter has risen (1) or fallen (-1); at the end of a law the tangent may be across it."""
    last = points[-1].value
    far = (each.value for each in reversed(points) if abs(each.value - last) > SAME * abs(last))
    return math.copysign(1.0, last - next(far, last))


def halves_beyond(point: Point) -> bool:
    """Return whether the orbits beyond the end of a law repeat, or mirror, their half: those of another branch."""
    curve = point.curve
    for law, u in _laws_at(point):
        whole = curve.with_sequence(law)
        end = whole.nearest(np.concatenate([u.T.ravel(), point.u[-1:]]))
        for side in () if end is None else (end, end.reversed()):
            ahead = whole.advance(side, TRIED[0])
            if ahead is not None and is_kept(ahead) and _repeats(ahead):
                return True
    beside = (_settled_beside(point, share) for share in (BESIDES[0], -BESIDES[0]))
    return any(first is not None and _repeats(first) for first in beside)


def comes_back_early(point: Point) -> bool:
    """Return whether an orbit repeats after fewer periods than its law, or mirrors itself: one of another branch."""
    curve, m = point.curve, point.curve.sequence.m
    state = curve.state_at(point)
    others = [curve.state_at(point, visit) for visit in range(1, m)]
    if curve.problem.symmetric and m % 2 and not curve.sequence.mirrored:
        others.append(-curve.state_at(point, 0.5 * m))
    scales = np.array([*curve.scales, curve.speed][: state.size])
    return any(np.abs((other - state) / scales).max() < SAME for other in others)


def _edited(point: Point) -> Iterator[Point]:
    """Yield the orbits that begin the laws to which the edits of a margin lead."""
    curve = point.curve
    for law, u in _laws_at(point):
        if law.key == curve.sequence.key:
            continue
        begun = begin_at(curve.with_sequence(law), np.concatenate([u.T.ravel(), point.u[-1:]]))
        if begun is not None and _is_beside(begun, point):
            yield begun


def _marched(point: Point, way: float) -> Iterator[Point]:
    """Yield the orbits of other laws that marches next to the end of one lead to, first those on one side (1 or -1).

    Next to a chatter laws follow each other ever faster: one of those farther on, at last that with the rest.
    """
    yield from _settled(point, way)
    yield from _settled(point, -way)
    # From an unstable orbit a march settles on another one: what it meets at first has the law on either side.
    for share in (BESIDES[0], -BESIDES[0]):
        met = _law_beside(point, share, 1)
        begun = begin_at(*met) if met is not None else None
        if begun is not None and _is_beside(begun, point):
            yield begun


def _settled(point: Point, way: float) -> Iterator[Point]:
    """Yield the orbits of other laws that marches on one side settle on, each along the way that leads off."""
    for share in (way * beside for beside in BESIDES):
        first = _settled_beside(point, share)
        if first is not None and not _repeats(first):
            yield first if first.tangent[-1] * share > 0.0 else first.reversed()


def _settled_beside(point: Point, share: float) -> Point | None:
    """Return the orbit of another law that a march settles on at a share of the range from the end of one."""
    found = _law_beside(point, share, SETTLING)
    if found is None:
        return None
    curve, u = found
    first = curve.settle(u)
    return first if first is not None and is_kept(first) and _is_beside(first, point) else None


def _law_beside(point: Point, share: float, orbits: int) -> tuple[LawCurve, np.ndarray] | None:
    """Return another law that a motion has some orbits after the end of one, at a share of the range, and unknowns."""
    curve, problem = point.curve, point.curve.problem
    m, value = curve.sequence.m, point.value + share * (problem.high - problem.low)
    p = curve.parameters(value)
    state = curve.marcher.after(p, curve.state_at(point), float(orbits * m))
    read = None if state is None else curve.marcher.law_of(p, state, m, problem.symmetric)
    if read is None or read.law.key == curve.sequence.key:
        return None
    return curve.with_sequence(read.law), np.concatenate([read.u.T.ravel(), [value]])


def _is_beside(begun: Point, point: Point) -> bool:
    """Return whether an orbit that was found from the end of a law is one beside it."""
    curve, problem = point.curve, point.curve.problem
    if abs(begun.value - point.value) > CLOSEST * (problem.high - problem.low):
        return False
    state, other = begun.curve.state_at(begun), curve.state_at(point)
    change = (state - other) / np.array([*curve.scales, curve.speed][: other.size])
    return bool(np.abs(change).max() < CLOSEST)


def _laws_at(point: Point) -> Iterator[tuple[Law, np.ndarray]]:
    """Yield the laws that may follow a point at which a margin is zero, and their unknowns there."""
    curve, law = point.curve, point.curve.sequence
    p, u = curve.parameters(point.value), curve.events_of(point.u)
    kinds = [int(of.SPEED), int(point.tests[MARGIN])]
    if abs(point.tests[GAP]) < abs(point.tests[SPEED]):
        kinds.reverse()
    for kind in kinds:
        if abs(point.tests[SPEED if kind == of.SPEED else GAP]) > NEAR:
            continue
        for events in edits(curve.effects, law, p, u, point.tests, kind):
            if not events:
                yield from _eventless_at(point)
                continue
            forms = [(law.span, law.mirrored)]
            if law.codes[0, CAUSE] == SECTION and curve.problem.symmetric and law.m % 2:
                # What happens on an orbit that is its own mirror image happens on both sides.
                forms = [(0.5 * law.m, 1)]
            for span, mirrored in forms:
                made = law_from(events, p, span, mirrored)
                if made is not None:
                    yield made


def _eventless_at(point: Point) -> Iterator[tuple[Law, np.ndarray]]:
    """Yield the laws without events that may follow a point, in free flight or within a soft support, and the state."""
    curve, law = point.curve, point.curve.sequence
    p = curve.parameters(point.value)
    pressed = law.codes[law.codes[:, FORM] == CONTACT, HOME].tolist()
    for form, home in ((FREE, 0), *((CONTACT, home) for home in dict.fromkeys(pressed))):
        empty = without_events(law.span, law.mirrored, law.codes.shape[1])
        empty.codes[0, FORM], empty.codes[0, HOME] = form, home
        state = curve.state_at(point)[np.newaxis]
        state[0, 0] -= reference_of(p, home)
        yield empty, state


def begin_at(curve: LawCurve, u: np.ndarray) -> Point | None:
    """Return a point of a branch next to u, where a margin is zero, along the side where it grows, if there is one.

    At the end itself the determinants are zero, and signs of tests rounding.
    """
    end = curve.nearest(u)
    if end is None or float(np.abs((end.u - u) * curve.weights).max()) > NEAR:
        return _away_from(curve, u)
    for length in TRIED:
        for side in (end, end.reversed()):
            ahead = curve.advance(side, length)
            if ahead is not None and is_kept(ahead) and not _repeats(ahead):
                nearer = (curve.advance(side, each) for each in CLOSE if each < length)
                return next((each for each in nearer if each and is_kept(each)), ahead)
    return _away_from(curve, u)


def _away_from(curve: LawCurve, u: np.ndarray) -> Point | None:
    """Return a point next to u of a branch that has a cusp there, known by the speed of its slowest contact.

    As where a mass that is held at the surface of a soft support begins to enter it: what it does there has times that
    go with different powers of that speed.
    """
    codes = curve.sequence.codes
    n, begins = len(codes), np.flatnonzero(np.isin(codes[:, CAUSE], (ENTER, IMPACT)))
    if not begins.size:
        return None
    slowest = int(begins[np.abs(u[n + begins]).argmin()])
    way = 1.0 if codes[slowest, HOME] == 1 else -1.0
    turns_inside = codes[slowest : slowest + 3, CAUSE].tolist() == [ENTER, TURN, LEAVE]
    if turns_inside:
        before, after = (_speed_beside(curve, u, slowest, each) for each in (-1, 2))
    for share in SPEEDS:
        speed = share * curve.speed
        moved = u.copy()
        if turns_inside:
            # It takes speed and gives it back by friction's two ways: as square roots of the accelerations.
            moved[slowest] -= speed * ASIDE / before
            left = speed * float(np.sqrt(after / before))
            moved[slowest + 2] += left * ASIDE / after
            moved[n + slowest + 2] = -way * left
        else:
            moved[slowest] -= SPREAD * share
            together = np.flatnonzero(np.diff(u[:n]) == 0.0) + 1
            moved[together[together > slowest + 1]] += share ** (2.0 / 3.0)
        moved[n + slowest] = way * speed
        point = curve.settle(moved, n + slowest)
        if point is not None and is_kept(point) and not _repeats(point):
            return point if way * point.tangent[n + slowest] > 0.0 else point.reversed()
    return None


def _speed_beside(curve: LawCurve, u: np.ndarray, event: int, pieces: int) -> float:
    """Return |x'| a moment before (-1) or after an event of zero speed, on the piece that is so many after it."""
    law, p = curve.sequence, curve.parameters(float(u[-1]))
    i = (event + pieces) % len(law.codes)
    later = law.span if event + pieces < 0 else 0.0
    time = float(u[event]) + (later - ASIDE if pieces < 0 else ASIDE)
    _y, speed = state_within(curve.effects, p, law, i, curve.events_of(u), time)
    return abs(float(speed))


def _repeats(point: Point) -> bool:
    """Return whether an orbit repeats its half, or mirrors it: another law solves the same equations."""
    curve = point.curve
    symmetric = curve.problem.symmetric
    return bool(halves_agree(curve.sequence, point.u, curve.weights, symmetric, SAME))


def is_kept(point: Point) -> bool:
    """Return whether an orbit keeps all margins."""
    return min(point.tests[GAP], point.tests[SPEED]) > KEPT
