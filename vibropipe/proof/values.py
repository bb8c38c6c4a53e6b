"""Enclosures of what a proved orbit is worth: stability, harmonics, the state at the section.

The impulses of the impacts and the force give the harmonics without integrals: with w = k nu,

    c_k (1 - w^2 + i h w) = F_k / (2 i) - sum_i (1 + R_i) v_i exp(-i 2 pi k t_i) / (m T)

where F_k is the amplitude of the force's k-th harmonic, and A_k = 2 |c_k|.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import islice
from typing import Any, NamedTuple

from vibropipe.proof.balls import (
    ONE,
    ZERO,
    Jet,
    Number,
    acb,
    arb,
    ball_of,
    complex_of,
    exp,
    hull,
    imag_of,
    real_of,
    total,
)
from vibropipe.proof.flights import Flights
from vibropipe.proof.orbit import Law, Orbit, end_of, flights_of


class Values(NamedTuple):
    """Balls of an orbit; each by the mean value form over a box, so that no width is counted twice.

    Attributes
    ----------
    trace, determinant, discriminant : ball
        Of the derivative of the return map: tr, det and tr^2/4 - det.
    mean, displacement, velocity : ball
        Constant part of displacement, and the state at the section.
    squares : list of ball
        |c_k|^2; not finite for a harmonic at resonance without damping, which the impulses do not determine.
    """

    trace: Any
    determinant: Any
    discriminant: Any
    mean: Any
    displacement: Any
    velocity: Any
    squares: Sequence[Any]


def values_of(orbit: Orbit, harmonics: int) -> Values:
    """Return the values of a proved orbit over its box, each by the narrower of two forms, or what both contain.

    One takes the tube as it is; the other is the mean value form along the tube, from the centre.
    """
    plain = _values(orbit.box.balls, orbit.law, orbit.tube, harmonics)
    if not orbit.box.directions:
        return Values._make([*plain[:6], plain[6:]])
    k = len(orbit.box.directions)
    along = [Jet(a, slopes) for a, slopes in zip(orbit.tube, orbit.slopes, strict=True)]
    slopes = _values(orbit.box.jets(k), orbit.law, along, harmonics)
    middle = [a + arb(0, r) for a, r in zip(orbit.u, orbit.radius, strict=True)]
    centre = _values(orbit.box.centre, orbit.law, middle, harmonics)
    values = []
    for a, jet, c in zip(plain, slopes, centre, strict=True):
        moves = zip(jet.slopes, orbit.box.offsets, strict=True) if type(jet) is Jet else ()
        form = c + total(slope * offset for slope, offset in moves)
        values.append(a.intersection(form) if a.is_finite() and form.is_finite() else a)
    return Values._make([*values[:6], values[6:]])


def _values(p: Mapping[str, Number], law: Law, u: Sequence[Number], harmonics: int) -> list[Number]:
    """Return the numbers of `Values` in a row."""
    model, n = Flights(p), len(law.supports)
    trace, determinant = trace_and_determinant(model, law, u)
    jumps = [
        -((1 + model.restitution[support]) * v) / (model.period * law.m)
        for support, v in zip(law.supports, u[n:], strict=True)
    ]
    mean = sum(jumps, p["load"])
    # from the last impact to the section
    last = max(range(n), key=lambda i: float(ball_of(u[i]).mid()))
    flight = next(flight for i, _j, flight in flights_of(law, u) if i == last)
    x, v = end_of(model, flight._replace(end=flight.start * 0 + law.m))
    discriminant = trace * trace / 4 - determinant
    values = [trace, determinant, discriminant, mean, x + p["load"], v]
    return values + [_square(model, k, u[:n], jumps) for k in range(1, harmonics + 1)]


def trace_and_determinant(
    model: Flights, law: Law, u: Sequence[Number], is_half: bool = False
) -> tuple[Number, Number]:
    """Return trace and determinant of the return map's derivative: products of flow and saltation matrices.

    Over the first half of an orbit that is its own mirror image, without the mirror, if `is_half`.
    """
    share = 2 if is_half else 1
    rows = [[ONE, ZERO], [ZERO, ONE]]
    determinant = exp(-(model.h * model.period * law.m / share))
    for _i, _j, flight in islice(flights_of(law, u), len(law.supports) // share):
        b, R = model.position[flight.support], model.restitution[flight.support]
        flow = model.flow(flight.end - flight.start)
        shear = (1 + R) * (model.force(flight.start) - b) / flight.velocity
        factor = (
            (flow.e12 * shear - R * flow.e11, -(R * flow.e12)),
            (flow.e22 * shear - R * flow.e21, -(R * flow.e22)),
        )
        rows = [[a * rows[0][c] + b * rows[1][c] for c in (0, 1)] for a, b in factor]
        determinant = determinant * R * R
    return rows[0][0] + rows[1][1], determinant


def _square(model: Flights, k: int, times: Sequence[Number], jumps: Sequence[Number]) -> Number:
    """Return |c_k|^2."""
    w = model.nu * k
    stiffness = complex_of(1 - w * w, model.h * w)
    if acb(ball_of(stiffness)).contains(acb(0)):
        return arb.nan()
    pulse: Any = sum((model.turned(-t, k) * jump for t, jump in zip(times, jumps, strict=True)), 0)
    for multiple, amplitude in model.forces:
        if multiple == k:
            pulse = pulse + amplitude * acb(0, -0.5)
    real, imag = real_of(pulse), imag_of(pulse)
    re, im = real_of(stiffness), imag_of(stiffness)
    return (real * real + imag * imag) / (re * re + im * im)


def stability(values: Values) -> bool | None:
    """Return True: both multipliers certainly lie inside the unit circle; False: one outside; None: undecided."""
    trace, determinant = abs(values.trace), values.determinant
    if trace < 1 + determinant and determinant < 1:
        return True
    return False if trace > 1 + determinant or determinant > 1 else None


def spectral_radius(values: Values) -> Any:
    """Return a ball of the larger modulus of the multipliers."""
    half, determinant = abs(values.trace / 2), values.determinant.nonnegative_part()
    inside = values.discriminant
    if inside < 0:  # a conjugate pair
        return determinant.sqrt()
    if inside > 0:
        return half + inside.sqrt()
    real = half + inside.nonnegative_part().sqrt()
    return hull(half.lower(), real.max(determinant.sqrt()).upper())


def amplitudes(values: Values) -> list[Any]:
    """Return balls of the amplitudes 2 |c_k| of the harmonics."""
    return [2 * square.nonnegative_part().sqrt() for square in values.squares]
