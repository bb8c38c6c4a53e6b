"""A bifurcation of an orbit, enclosed: the zero of the equations of its impacts with one condition more.

The unknowns are times and velocities of the impacts, one parameter and, at a grazing, the time of the touch. At a
regular zero the bifurcation is the usual one: the orbits turn back at a fold, a multiplier passes -1 at a flip, and the
touch becomes an impact or a gap with non-zero speed at a grazing [1]_.

References
----------
.. [1] Yu. A. Kuznetsov, Elements of Applied Bifurcation Theory, Springer 2004, sections 4.2 to 4.5.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from vibropipe.proof.balls import ONE, Number, arb, arb_mat, magnitude, seed
from vibropipe.proof.flights import Flights
from vibropipe.proof.motion import FlightMotion
from vibropipe.proof.orbit import (
    MAX_INFLATIONS,
    MAX_NEWTON,
    RADIUS,
    STEP,
    Law,
    flights_of,
    residual,
)
from vibropipe.proof.values import trace_and_determinant
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.proofs import Why

# Points of a flight among which the touch is sought, and the shortest stretch that is looked at.
SAMPLES, SHORTEST = 64, 2.0**-30
KINDS = {
    each.name.lower(): each for each in (Bifurcation.FOLD, Bifurcation.FLIP, Bifurcation.GRAZING)
}


@dataclass
class Critical:
    """The orbit at a bifurcation, and what is proved of it.

    Attributes
    ----------
    tube : list of ball
        Times and velocities of the impacts; empty unless it exists.
    parameter : ball
    touched : int
        The support that is touched at a grazing, else 0.
    why : Why
        What is not proved.
    """

    tube: list[Any]
    parameter: Any
    touched: int
    why: Why


def bifurcation_near(
    nominal: Mapping[str, Any], law: Law, guess: Sequence[Any], kind: Bifurcation, along: str
) -> Critical:
    """Return the bifurcation of a kind that Newton's method finds from an orbit nearby.

    Parameters
    ----------
    nominal : mapping of str to ball
        The exciter of the orbit, exact numbers.
    law : Law
    guess : sequence of ball
        Times and velocities of the impacts of the orbit.
    kind : Bifurcation
        FOLD, FLIP or GRAZING.
    along : str
        The parameter that varies.
    """
    n = len(law.supports)
    z, touch = [*map(arb, guess), nominal[along]], (0, 0)
    if kind is Bifurcation.GRAZING:
        found = _nearest_touch(nominal, law, z[: 2 * n])
        if found is None:
            return Critical([], arb.nan(), 0, Why.EXISTENCE)
        touch = found[:2]
        z.append(found[2])

    def equations(at: Sequence[Number]) -> list[Number]:
        p, u = {**nominal, along: at[2 * n]}, at[: 2 * n]
        model, rows = Flights(p), residual(p, law, u)
        if kind is Bifurcation.GRAZING:
            x, v = _at_touch(model, law, u, touch[0], at[-1])
            return [*rows, x - model.position[touch[1]], v]
        trace, determinant = trace_and_determinant(model, law, u)
        side = -1 if kind is Bifurcation.FOLD else 1
        return [*rows, 1 + side * trace + determinant]

    speed = max((abs(v) for v in z[n : 2 * n]), key=float)
    own = abs(nominal[along])
    scale = [ONE] * n + [speed] * n + [own if own > 0 else ONE] + [ONE] * (len(z) - 2 * n - 1)
    tube = enclosed(equations, z, scale)
    if tube is None:
        return Critical([], arb.nan(), touch[1], Why.EXISTENCE)
    model = Flights({**nominal, along: tube[2 * n]})
    is_motion = _is_motion(model, law, tube, touch[0] if touch[1] else None)
    return Critical(tube[: 2 * n], tube[2 * n], touch[1], Why.NONE if is_motion else Why.MOTION)


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
    leaving = -(model.restitution[flight.support] * flight.velocity)
    return model.fly(flight.start, turns, model.position[flight.support], leaving)


def _nearest_touch(
    nominal: Mapping[str, Any], law: Law, u: Sequence[Any]
) -> tuple[int, int, Any] | None:
    """Return flight, support and time since its departure of the turn that comes nearest to a support; None without."""
    model, found = Flights(nominal), []
    for i, _j, flight in flights_of(law, u):
        length = (flight.end - flight.start).mid()
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


def _is_motion(model: Flights, law: Law, tube: Sequence[Any], of: int | None) -> bool:
    """Return whether no flight certainly leaves the supports, but for the touch of flight `of`."""
    n = len(law.supports)
    for support, v in zip(law.supports, tube[n : 2 * n], strict=True):
        if not (v > 0 if support == 1 else v < 0):
            return False
    return all(
        FlightMotion(model, flight).leaves(SHORTEST, tube[-1] if i == of else None) is False
        for i, _j, flight in flights_of(law, tube[: 2 * n])
    )
