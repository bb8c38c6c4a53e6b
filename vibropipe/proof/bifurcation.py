"""A bifurcation of an orbit, enclosed: the zero of the equations of its impacts with one condition more.

The unknowns are times and velocities of the impacts, one parameter and, at a grazing, the time of the touch. At a
regular zero the bifurcation is the usual one: the orbits turn back at a fold, a multiplier passes -1 at a flip, and the
touch becomes an impact or a gap with non-zero speed at a grazing [1]_.

An orbit that is its own mirror image half an orbit later is known by the impacts of its first half. Its pitchfork is a
flip of the half map, which is half of the orbit and then the mirror; there the equations of the whole orbit are
singular. At its grazing both supports are touched.

References
----------
.. [1] Yu. A. Kuznetsov, Elements of Applied Bifurcation Theory, Springer 2004, sections 4.2 to 4.5.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from vibropipe.proof.balls import ONE, Number, arb, arb_mat, magnitude, seed
from vibropipe.proof.equations import flights_of, residual, scale_of, start_of
from vibropipe.proof.flights import Flights
from vibropipe.proof.law import Law
from vibropipe.proof.motion import leaves_law
from vibropipe.proof.orbit import MAX_INFLATIONS, MAX_NEWTON, RADIUS, STEP
from vibropipe.proof.values import trace_and_determinant
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.proofs import Why

# Points of a flight among which the touch is sought, and the shortest stretch that is looked at.
SAMPLES, SHORTEST = 64, 2.0**-30
KINDS = {each.name.lower(): each for each in Bifurcation if each <= Bifurcation.GRAZING}
# Those that are sought between rigid supports without friction alone.
OF_IMPACTS = (Bifurcation.PITCHFORK, Bifurcation.GRAZING)
# Parameters along which an exciter stays its own mirror image.
SYMMETRIC = ("nu", "f", "h", "l", "shaker")
BOTH = 3  # supports touched
# An orbit so near its mirror image (forcing periods, share of the largest velocity) is taken for it.
MIRRORED = 1e-6


@dataclass
class Critical:
    """The orbit at a bifurcation, and what is proved of it.

    tube : balls, times and velocities of the impacts; empty unless it exists
    touched : the support that is touched at a grazing, or BOTH; else 0
    why : what is not proved
    """

    tube: list[Any]
    parameter: Any
    touched: int
    why: Why


def bifurcation_near(
    nominal: Mapping[str, Any], law: Law, guess: Sequence[Any], kind: Bifurcation, along: str
) -> Critical:
    """Return the bifurcation of a kind that Newton's method finds from an orbit nearby.

    nominal : the exciter of the orbit, exact numbers
    guess : balls, times and velocities of the impacts of the orbit
    kind : FOLD, FLIP, PITCHFORK or GRAZING
    """
    u0 = [*map(arb, guess)]
    is_half = _may_be_mirrored(nominal, law, along)
    if kind is Bifurcation.PITCHFORK and not is_half:
        return Critical([], arb.nan(), 0, Why.SYMMETRY)
    if kind is not Bifurcation.PITCHFORK:
        is_half = is_half and kind is Bifurcation.GRAZING and _is_near_mirrored(law, u0)
    k = len(law.events)
    n = k // 2 if is_half else k
    z, touch = [*u0[:n], *u0[k : k + n], nominal[along]], (0, 0)
    if kind is Bifurcation.GRAZING:
        found = _nearest_touch(nominal, law, u0)
        if found is None:
            return Critical([], arb.nan(), 0, Why.EXISTENCE)
        i, support, time = found
        touch = (i, support) if i < n else (i - n, 3 - support)
        z.append(time)

    def orbit_of(at: Sequence[Number]) -> list[Number]:
        return mirrored(law, at[: 2 * n]) if is_half else [*at[: 2 * n]]

    def equations(at: Sequence[Number]) -> list[Number]:
        p, u = {**nominal, along: at[2 * n]}, orbit_of(at)
        model, rows = Flights(p), residual(p, law, u)[: 2 * n]
        if kind is Bifurcation.GRAZING:
            x, v = _at_touch(model, law, u, touch[0], at[-1])
            return [*rows, x - model.position[touch[1]], v]
        trace, determinant = trace_and_determinant(model, law, u, is_half)
        side = 1 if kind is Bifurcation.FLIP else -1
        return [*rows, 1 + side * trace + determinant]

    own, scale = abs(nominal[along]), scale_of(law, u0, nominal["l"])
    scale = scale[:n] + scale[k : k + n] + [own if own > 0 else ONE] + [ONE] * (len(z) - 2 * n - 1)
    tube = enclosed(equations, z, scale)
    touched = BOTH if is_half and touch[1] else touch[1]
    if tube is None:
        return Critical([], arb.nan(), touched, Why.EXISTENCE)
    model, u = Flights({**nominal, along: tube[2 * n]}), orbit_of(tube)
    touches = dict.fromkeys(range(touch[0], k, n), tube[-1]) if touched else {}
    is_motion = leaves_law(model, law, u, None, SHORTEST, touches) is False
    return Critical(u, tube[2 * n], touched, Why.NONE if is_motion else Why.MOTION)


def is_sought(kind: Bifurcation, law: Law) -> bool:
    """Return whether a bifurcation of a kind is sought of orbits of a law."""
    return law.is_of_impacts or kind not in OF_IMPACTS


def mirrored(law: Law, half: Sequence[Number]) -> list[Number]:
    """Return times and velocities of the orbit whose first half is this one and whose other half mirrors it."""
    n = len(half) // 2
    times, velocities = half[:n], half[n:]
    return [*times, *(t + law.m / 2 for t in times), *velocities, *(-v for v in velocities)]


def _may_be_mirrored(nominal: Mapping[str, Any], law: Law, along: str) -> bool:
    """Return whether exciters along a parameter are their own mirror images, and orbits of a law may be."""
    if not law.is_of_impacts:
        return False
    n, odd = divmod(len(law.supports), 2)
    image = tuple(3 - support for support in law.supports[:n])
    return (
        along in SYMMETRIC
        and bool(nominal["R1"] == nominal["R2"])
        and bool(nominal["delta"] == nominal["load"])
        and bool(nominal["f2"] == 0)
        and law.m % 2 == 1  # the force changes its sign in half of the orbit
        and not odd
        and law.supports[n:] == image
    )


def _is_near_mirrored(law: Law, u: Sequence[Any]) -> bool:
    """Return whether the other half of an orbit nearly mirrors the first one."""
    n = len(law.supports) // 2
    speed = max((abs(v) for v in u[2 * n :]), key=float)
    image = mirrored(law, [*u[:n], *u[2 * n : 3 * n]])
    scale = [ONE] * (2 * n) + [speed] * (2 * n)
    return all(abs(a - b) < s * MIRRORED for a, b, s in zip(u, image, scale, strict=True))


def enclosed(
    equations: Callable[[Sequence[Number]], list[Number]],
    guess: Sequence[Any],
    scale: Sequence[Any],
) -> list[Any] | None:
    """Return a tube with exactly one zero of as many equations as unknowns, by Krawczyk's test; None if it fails."""
    size = len(guess)

    def with_jacobian(z: Sequence[Any]) -> tuple[list[Any], Any]:
        rows = equations([seed(a, i, size) for i, a in enumerate(z)])
        return [row.value for row in rows], arb_mat([row.slopes for row in rows])

    z = [arb(value).mid() for value in guess]
    try:
        for _ in range(MAX_NEWTON):
            values, jacobian = with_jacobian(z)
            inverse = jacobian.mid().inv().mid()
            step = inverse * arb_mat([[value.mid()] for value in values])
            z = [(a - step[i, 0]).mid() for i, a in enumerate(z)]
            if all(abs(step[i, 0]) < s * STEP for i, s in enumerate(scale)):
                break
    except (ZeroDivisionError, ValueError):
        return None
    if not all(a.is_finite() for a in z):
        return None
    at_centre = arb_mat([[value] for value in equations(z)])
    identity = arb_mat([[int(i == j) for j in range(size)] for i in range(size)])
    radius = [(s * RADIUS).upper() for s in scale]
    for _ in range(MAX_INFLATIONS):
        w = [arb(0, r) for r in radius]
        _values, jacobian = with_jacobian([a + b for a, b in zip(z, w, strict=True)])
        image = (identity - inverse * jacobian) * arb_mat([[a] for a in w]) - inverse * at_centre
        k = [image[i, 0] for i in range(size)]
        if not all(a.is_finite() and magnitude(a) < s for a, s in zip(k, scale, strict=True)):
            return None
        if all(b.contains_interior(a) for a, b in zip(k, w, strict=True)):
            return [a + b for a, b in zip(z, k, strict=True)]
        grown = zip(k, scale, strict=True)
        radius = [(magnitude(a) * 1.25 + s * RADIUS).upper() for a, s in grown]
    return None


def _at_touch(
    model: Flights, law: Law, u: Sequence[Number], of: int, turns: Number
) -> tuple[Number, Number]:
    """Return displacement and velocity some time after the impact with which a flight begins."""
    flight = next(flight for i, _j, flight in flights_of(law, u) if i == of)
    return model.on(flight.event.after).fly(flight.start, turns, *start_of(model, flight))


def _nearest_touch(
    nominal: Mapping[str, Any], law: Law, u: Sequence[Any]
) -> tuple[int, int, Any] | None:
    """Return flight, support and time since its departure of the turn that comes nearest to a support; None without."""
    model, found = Flights(nominal), []
    for i, _j, flight in flights_of(law, u):
        length = flight.turns.mid()
        turns = [length * n / SAMPLES for n in range(1, SAMPLES)]
        states = [_at_touch(model, law, u, i, s) for s in turns]
        x, v = ([float(state[k].mid()) for state in states] for k in (0, 1))
        for n in range(len(turns) - 1):
            support = 1 if v[n] > 0 else 2
            towards = 1 if support == 1 else -1
            if v[n] * v[n + 1] < 0:
                gap = towards * (float(model.position[support].mid()) - max(x[n : n + 2], key=abs))
                share = v[n] / (v[n] - v[n + 1])
                found.append((abs(gap), i, support, turns[n] + (turns[n + 1] - turns[n]) * share))
    return min(found, key=lambda each: each[0])[1:] if found else None
