"""Enclosures of what a proved orbit is worth: stability, harmonics, the state at the section.

The impulses of the impacts and the force give the harmonics without integrals: with w = k nu,

    c_k (1 - w^2 + i h w) = F_k / (2 i) - sum_i (1 + R_i) v_i exp(-i 2 pi k t_i) / (m T) + sum_j G_j / (m T)

where F_k is the amplitude of the force's k-th harmonic, A_k = 2 |c_k|, and G_j the transform of support and friction
over a piece, integral (y'' + h y' + y - F) exp(-i w tau) d tau: that of y is in closed form, by parts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
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
from vibropipe.proof.equations import Flight, end_of, flights_of, start_of
from vibropipe.proof.flights import Flights
from vibropipe.proof.law import FREE, Kind, Law, Piece
from vibropipe.proof.orbit import Orbit


class Values(NamedTuple):
    """Balls of an orbit; each by the mean value form over a box, so that no width is counted twice.

    trace, determinant, discriminant : balls of the derivative of the return map: tr, det and tr^2/4 - det
    mean, displacement, velocity : constant part of displacement, and the state at the section
    squares : |c_k|^2; not finite for a harmonic at resonance without damping, which the impulses do not determine
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
    lengths = orbit.lengths
    plain = _values(orbit.box.balls, orbit.law, orbit.tube, harmonics, lengths)
    if not orbit.box.directions:
        return Values._make([*plain[:6], plain[6:]])
    k = len(orbit.box.directions)
    along = [Jet(a, slopes) for a, slopes in zip(orbit.tube, orbit.slopes, strict=True)]
    slopes = _values(orbit.box.jets(k), orbit.law, along, harmonics, lengths)
    middle = [a + arb(0, r) for a, r in zip(orbit.u, orbit.radius, strict=True)]
    centre = _values(orbit.box.centre, orbit.law, middle, harmonics)
    values = []
    for a, jet, c in zip(plain, slopes, centre, strict=True):
        moves = zip(jet.slopes, orbit.box.offsets, strict=True) if type(jet) is Jet else ()
        form = c + total(slope * offset for slope, offset in moves)
        values.append(a.intersection(form) if a.is_finite() and form.is_finite() else a)
    return Values._make([*values[:6], values[6:]])


def _values(
    p: Mapping[str, Number],
    law: Law,
    u: Sequence[Number],
    harmonics: int,
    lengths: Sequence[Any] | None = None,
) -> list[Number]:
    """Return the numbers of `Values` in a row; lengths : as of `flights_of`."""
    model, n = Flights(p), len(law.events)
    trace, determinant = trace_and_determinant(model, law, u, lengths=lengths)
    flights = [flight for _i, _j, flight in flights_of(law, u, lengths)]
    pulses = [pulse for flight in flights for pulse in _pulses(model, flight)]
    span = model.period * law.m
    mean = sum((real_of(pulse(0)) for pulse in pulses), ZERO) / span + p["load"]
    # from the last event to the section
    last = max(range(n), key=lambda i: float(ball_of(u[i]).mid()))
    flight, end = flights[last], flights[last].start * 0 + law.m
    z, v = end_of(model, flight._replace(end=end, turns=end - flight.start))
    x = z + model.on(flight.event.after).origin
    discriminant = trace * trace / 4 - determinant
    values = [trace, determinant, discriminant, mean, x + p["load"], v]
    return values + [_square(model, k, pulses, span) for k in range(1, harmonics + 1)]


def trace_and_determinant(
    model: Flights,
    law: Law,
    u: Sequence[Number],
    is_half: bool = False,
    lengths: Sequence[Any] | None = None,
) -> tuple[Number, Number]:
    """Return trace and determinant of the return map's derivative: products of flow and saltation matrices.

    Over the first half of an orbit that is its own mirror image, without the mirror, if `is_half`.
    """
    share = 2 if is_half else 1
    rows = [[ONE, ZERO], [ZERO, ONE]]
    determinant = exp(-(model.damping * model.period * law.m / share))
    flights = islice(flights_of(law, u, lengths), len(law.events) // share)
    for i, _j, flight in flights:
        piece, turns = model.on(flight.event.after), flight.turns
        kept_x, shear, kept_v = saltation(model, flight, law.events[i - 1].after)
        rows = [
            [a * kept_x for a in rows[0]],
            [a * shear + b * kept_v for a, b in zip(*rows, strict=True)],
        ]
        determinant = determinant * kept_x * kept_v
        if piece.piece.is_held:
            continue
        flow = piece.flow(turns)
        factor = (flow.e11, flow.e12), (flow.e21, flow.e22)
        rows = [[a * rows[0][c] + b * rows[1][c] for c in (0, 1)] for a, b in factor]
        if piece.piece.contact:
            own = piece.damping - model.damping
            determinant = determinant * exp(-(own * turns * model.period))
    return rows[0][0] + rows[1][1], determinant


def saltation(model: Flights, flight: Flight, before: Piece) -> tuple[Number, Number, Number]:
    """Return S_11, S_21 and S_22 of the saltation matrix of the event that a flight begins with; S_12 is 0.

    before : the piece that ends there.
    """
    (kind, support, after), free, start = flight.event, flight.free, flight.start
    if kind is Kind.IMPACT:
        b, R = model.position[support], model.restitution[support]
        # the damping of v before and of -R v after cancels
        push = (1 + R) * (model.force(start) - b)
        if after.way:
            push = push - model.p["friction"] * (after.way + R * before.way)
        return -R, push / free, -R
    if kind.is_at_support:
        own = model.p[f"h{support}"]
        return ONE, -own if kind is Kind.ENTERS else own, ONE
    if kind is Kind.TURNS:
        ends = model.on(before).acceleration(start, free), model.on(after).acceleration(start, free)
        return ONE, ZERO, ends[1] / ends[0]
    return ONE, ZERO, ZERO  # held before or after: no velocity is left


Pulse = Callable[[int], Number]


def _pulses(model: Flights, flight: Flight) -> Iterator[Pulse]:
    """Yield the transforms, by the multiple k of nu, of an impact and of the forces on the piece after it."""
    if flight.event.kind is Kind.IMPACT:
        support = flight.event.support
        jump = -((1 + model.restitution[support]) * flight.free)
        yield lambda k: model.turned(-flight.start, k) * jump
    piece = model.on(flight.event.after)
    if piece.piece == FREE:
        return
    ends = start_of(model, flight), end_of(model, flight)

    def of_piece(k: int) -> Number:
        of_one, contact = _integral(model, flight, -k), piece.piece.contact
        if not (contact or piece.piece.is_held):
            return of_one * piece.push
        of_force = _of_force(model, flight, k)
        if piece.piece.is_held:
            return of_one * (ends[0][0] + piece.origin) - of_force
        turned, w = [model.turned(-time, k) for time in (flight.start, flight.end)], model.nu * k

        def by_parts(first: Number, second: Number) -> Number:  # of first z + second z'
            at = [complex_of(first * z + second * v, w * second * z) for z, v in ends]
            return at[1] * turned[1] - at[0] * turned[0]

        of_z = of_force + of_one * piece.push - by_parts(piece.damping, ONE)
        of_z = of_z / piece.resistance(k)
        stiffness, damping = (model.p[f"{name}{contact}"] for name in "kh")
        pulled = of_z * complex_of(stiffness, w * damping) + by_parts(damping, ZERO)
        if piece.piece.way:
            pulled = pulled + of_one * model.p["friction"] * piece.piece.way
        return -pulled

    yield of_piece


def _integral(model: Flights, flight: Flight, multiple: int) -> Number:
    """Return the integral of exp(i multiple nu tau) by tau over a flight."""
    if multiple == 0:
        span = flight.turns * model.period
        return complex_of(span, span * 0)
    first, last = (model.turned(time, multiple) for time in (flight.start, flight.end))
    return (last - first) / complex_of(model.nu * 0, model.nu * multiple)


def _of_force(model: Flights, flight: Flight, k: int) -> Number:
    """Return the integral of the force times exp(-i k nu tau) by tau over a flight."""
    parts = [
        amplitude * _integral(model, flight, multiple - k)
        - complex_of(real_of(amplitude), -imag_of(amplitude))
        * _integral(model, flight, -multiple - k)
        for multiple, amplitude in model.forces
    ]
    return sum(parts[1:], parts[0]) * acb(0, -0.5)


def _square(model: Flights, k: int, pulses: Sequence[Pulse], span: Number) -> Number:
    """Return |c_k|^2."""
    stiffness = model.resistance(k)
    if acb(ball_of(stiffness)).contains(acb(0)):
        return arb.nan()
    pulse: Any = sum((each(k) for each in pulses), complex_of(span * 0, span * 0)) / span
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
