"""All orbits with one or two impacts of one exciter, by branch and bound in the length of one flight.

Each interval of lengths has no zero of g (`linear.py`), or exactly one, or is cut in two; no velocity needs a bound.
Each zero is then an orbit that is proved, or has a velocity away from its support, or leaves the supports.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from vibropipe.proof.balls import BITS, ONE, Box, Jet, arb, hull
from vibropipe.proof.certificate import MAX_MOVED_BY_ROUNDING, Claim, Part, examine
from vibropipe.proof.law import Law
from vibropipe.proof.linear import Equations, UndecidedError
from vibropipe.words.proofs import Why

# The search begins with so many intervals, and gives up those that are shorter than this, in forcing periods.
FIRST_INTERVALS, SHORTEST = 64, 2.0**-40
# A cut in the middle would meet zeros that symmetry puts there.
CUT = 0.4921875


@dataclass
class Found:
    """The orbits of a law: those that are proved, what is left undecided, and the intervals looked at.

    parts : orbits that are motions; their stability may be undecided
    why : `NONE` if there are certainly no others
    """

    parts: list[Part]
    why: Why
    looked: int

    def take(self, find: Callable[[], Part | None]) -> None:
        """Add the orbit that a call finds, if there is one, or why that is not decided."""
        try:
            part = find()
        except UndecidedError as error:
            self.why = error.why
        else:
            self.parts += [part] if part is not None else []


def all_orbits(
    p: Mapping[str, Any], law: tuple[int, int, int], harmonics: int, limit: int
) -> Found:
    """Return all orbits of a law (m, 1, 0), (m, 0, 1) or (m, 1, 1) of one exciter.

    p : balls by parameter, exact numbers
    limit : intervals that are looked at most
    """
    m, p1, p2 = law
    equations = Equations(p, m)
    if p1 + p2 == 1:
        support = 1 if p1 else 2
        found = Found([], Why.NONE, 0)
        _add_one_flight(found, equations, arb(m), Law.of_impacts(m, (support,)), harmonics)
        return found
    is_mirrored = equations.has_mirrored()
    intervals, left, looked = _zeros(equations, is_mirrored, limit)
    found = Found([], Why.PARTS if left else Why.NONE, looked)
    if is_mirrored:
        _add_one_flight(found, equations, arb(m) / 2, Law.of_impacts(m, (1, 2)), harmonics)
    for low, high in intervals:
        found.take(partial(_orbit_at, equations, low, high, harmonics))
    return found


def _zeros(
    equations: Equations, is_mirrored: bool, limit: int
) -> tuple[list[tuple[float, float]], list[tuple[float, float]], int]:
    """Return intervals with exactly one zero of g each, those left undecided, and the number looked at.

    The zero at m/2 of mirrored supports, which is double, is not among them.
    """
    m, half = equations.m, equations.m / 2
    found, left, looked = [], [], 0
    stack = [
        (m * k / FIRST_INTERVALS, m * (k + 1) / FIRST_INTERVALS) for k in range(FIRST_INTERVALS)
    ]
    while stack and looked < limit:
        low, high = stack.pop()
        looked += 1
        s, c = hull(low, high), arb((low + high) / 2)
        if is_mirrored and low <= half <= high:
            if not equations.g_halved(s).contains(0):
                continue
        else:
            jet = equations.g(Jet(s, [ONE]))
            if not jet.value.contains(0):
                continue
            if not (equations.g(c) + jet.slopes[0] * (s - c)).contains(0):
                continue
            if not jet.slopes[0].contains(
                0
            ):  # at most one zero, and one if the signs at the ends differ
                product = equations.g(arb(low)) * equations.g(arb(high))
                if product > 0:
                    continue
                if product < 0:
                    found.append((low, high))
                    continue
        if high - low < SHORTEST:
            left.append((low, high))
        else:
            cut = low + (high - low) * CUT
            stack += [(low, cut), (cut, high)]
    return sorted(found), left + stack, looked


def _orbit_at(equations: Equations, low: float, high: float, harmonics: int) -> Part | None:
    """Return the orbit at a zero of g, None where it is certainly no motion.

    Raises UndecidedError if it may be one.
    """
    s = _narrowed(equations, arb(low), arb(high))
    D, n1, n2, alpha, beta = equations.cramer(s)
    if D.contains(0):
        raise UndecidedError
    v = [n1 / D, n2 / D]
    if strikes(v, (1, 2)) is False:
        return None
    start = equations.time_of(alpha / D, beta / D)
    part = proved_orbit(
        equations, Law.of_impacts(equations.m, (1, 2)), [start, start + s, *v], harmonics
    )
    if part is not None:
        first = part.orbit.law.supports.index(1)
        length = part.orbit.tube[1 - first] - part.orbit.tube[first] + (equations.m if first else 0)
        if not hull(low, high).contains_interior(length):
            raise UndecidedError
    return part


def _narrowed(equations: Equations, low: Any, high: Any) -> Any:
    """Return a narrow ball of the zero of g between two exact numbers at which its signs differ."""
    rises = bool(equations.g(low) < 0)
    for _ in range(BITS):
        middle = ((low + high) / 2).mid()
        value = equations.g(middle)
        if value.contains(0):
            break
        low, high = (middle, high) if bool(value < 0) == rises else (low, middle)
    return hull(low, high)


def _add_one_flight(
    found: Found, equations: Equations, turns: Any, law: Law, harmonics: int
) -> None:
    """Add the orbits that repeat, mirrored or not, after one flight of known length."""
    of, to = law.supports[0], law.supports[-1]
    try:
        if of != to and not equations.is_mirrored_alone():
            raise UndecidedError
        solutions = equations.one_flight(turns, of, to)
    except UndecidedError as error:
        found.why = error.why
        return
    for v, time in solutions:
        guess = [time, v] if of == to else [time, time + turns, v, -v]
        if strikes(guess[len(law.supports) :], law.supports) is False:
            continue
        found.take(partial(proved_orbit, equations, law, guess, harmonics))


def strikes(velocities: Sequence[Any], supports: Sequence[int]) -> bool | None:
    """Return whether all velocities are towards their supports; None: undecided."""
    towards = [v if support == 1 else -v for v, support in zip(velocities, supports, strict=True)]
    if any(v < 0 for v in towards):
        return False
    return True if all(v > 0 for v in towards) else None


def proved_orbit(
    equations: Equations, law: Law, guess: Sequence[Any], harmonics: int
) -> Part | None:
    """Return the orbit near a solution, proved but perhaps for its stability; None where it is certainly no motion."""
    ordered, guess = _in_order(law, guess)
    claim = Claim(ordered, None, harmonics)
    part = examine(Box(equations.p), claim, guess, MAX_MOVED_BY_ROUNDING)
    if part.why in (Why.NONE, Why.STABILITY):
        return part
    if part.why is Why.MOTION and part.refuted:
        return None
    raise UndecidedError(part.why)


def _in_order(law: Law, u: Sequence[Any]) -> tuple[Law, list[Any]]:
    """Return law and unknowns in the order of time, the first impact of the law in the first forcing period."""
    n, first = len(law.supports), math.floor(float(u[0].mid()))
    times = [t - first for t in u[:n]]
    late = [law.m if float(t.mid()) >= law.m else 0 for t in times]
    times = [t - turns for t, turns in zip(times, late, strict=True)]
    order = sorted(range(n), key=lambda i: float(times[i].mid()))
    guess = [times[i] for i in order] + [u[n + i] for i in order]
    return Law.of_impacts(law.m, [law.supports[i] for i in order]), guess
