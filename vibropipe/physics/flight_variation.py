"""The variations of a whole flight between rigid supports: in one step, step by step, or in closed form."""

from __future__ import annotations

import math

from vibropipe.compiler import jit
from vibropipe.physics.contact import support_position
from vibropipe.physics.flow import DEGREE, REACH, fastest_rate, free_flow, motion, taylor
from vibropipe.physics.impulse import free_flow_by_h
from vibropipe.physics.load import (
    constant_load,
    fastest_forcing,
    first_terms,
    first_terms_of_phase,
    first_terms_of_second,
    force_of_angle,
    forcing_period,
    next_term,
    unit_force,
)
from vibropipe.physics.quotient import divide
from vibropipe.physics.turns import sincos_turns
from vibropipe.physics.variation import (
    BY_F,
    BY_F2,
    BY_H,
    BY_LOAD,
    BY_NU,
    BY_W,
    BY_Y,
    FACTORS,
    SHARES,
    WITH_SECOND,
    begin_variations,
    vary_step,
)

# Product of the fastest rate and the length of a flight above which, and modulus of the dynamic stiffness of the force
# above which, the closed form of the variations loses at most three digits; it takes a tenth of the time of the steps.
SHORT_REACH, NEAR_RESONANCE = 1.0, 0.1
# Degrees that suffice for flights whose product with the fastest rate is below these limits: the hops of a chatter. The
# first neglected term is then below 1e-16 of the response to a load.
SHORT_DEGREES = ((0.15, 11), (0.025, 8), (0.003, 6), (4e-4, 5), (1.5e-5, 4))


@jit
def steps_of_flight(p, start, end, second):
    """Return the steps of a flight from `start` to `end`, in turns, for which a polynomial is exact to rounding."""
    fastest = fastest_rate(fastest_forcing(p, second), p.h)
    return max(1, math.ceil((end - start) * forcing_period(p) * fastest / REACH))


@jit
def vary_by_steps(p, support, start, end, w, work, second) -> None:
    """Fill work.ends with the variations at the end of a flight step by step; arguments as for `vary_flight`."""
    ends = work.ends
    begin_variations(p, w, ends)
    sigma = -1.0 if support == 1 else 1.0
    load, y = constant_load(sigma, support_position(p, support)), 0.0
    steps = steps_of_flight(p, start, end, second)
    dt = (end - start) * forcing_period(p) / steps
    if dt > 0.0:
        for step in range(steps):
            turn = start + (end - start) * step / steps
            sine, cosine = sincos_turns(turn)
            force = force_of_angle(p, sigma, sine, cosine, second)
            taylor(work.c, y, w, force, load, p.h, p.nu, dt, second)
            unit = unit_force(p, sigma, sine, cosine, second)
            vary_step(p, work.c, unit, dt, ends, work.z, second)
            y, w = motion(work.c, 1.0, dt)
    ends[1, BY_NU] += w / p.nu


@jit
def vary_in_one_step(p, support, sine, cosine, dt, w, reach, ends, second) -> None:
    """Fill the variations at the end of a flight of at most one step, of the length dt; arguments as for `vary_flight`.

    The recurrences of `taylor` and `vary_step` in registers, since a chatter has many short flights; `reach` is the
    product of the fastest rate and the length. The response g to a unit load gives the free flow: e11 = 1 - g,
    e12 = g', e22 = 1 - h g' - g.
    """
    sigma, by_nu = -1.0 if support == 1 else 1.0, 1.0 / p.nu
    degree = DEGREE
    for limit, enough in SHORT_DEGREES:
        if reach < limit:
            degree = enough
    unit = unit_force(p, sigma, sine, cosine, second)
    term, term_next = first_terms(unit, p.nu * dt)
    other, other_next = 0.0, 0.0
    if second is not None:
        force = force_of_angle(p, sigma, sine, cosine, second)
        other, other_next = first_terms_of_second(force, 2.0 * p.nu * dt)
    square, damped, push = dt * dt, p.h * dt, 0.5 * dt * dt
    load = constant_load(sigma, support_position(p, support))
    # Coefficients n and n + 1 of the motion and of the responses to load, nu, h and f; then their sums at the end.
    c0, c1, g0, g1, n0, n1 = 0.0, w * dt, 0.0, 0.0, 0.0, -w * by_nu * dt
    h0, h1, f0, f1 = 0.0, 0.0, 0.0, 0.0
    g, n_end, h_end, f_end = 0.0, n1, 0.0, 0.0
    rate, g_rate, n_rate, h_rate, f_rate = c1, 0.0, n1, 0.0, 0.0
    for n in range(degree - 1):
        to_next, share, order = square * FACTORS[n], damped * SHARES[n], float(n + 2)
        c2 = to_next * (p.f * term - c0) - share * c1 + load * push
        if second is not None:
            c2 += to_next * other
            other, other_next = other_next, next_term(other, 2.0 * p.nu * dt, FACTORS[n])
        g2 = push - to_next * g0 - share * g1
        n2 = -to_next * n0 - share * n1 - (2.0 * c2 + share * c1) * by_nu
        h2 = -to_next * h0 - share * h1 - dt * SHARES[n] * c1
        f2 = to_next * (term - f0) - share * f1
        g, n_end, h_end, f_end = g + g2, n_end + n2, h_end + h2, f_end + f2
        g_rate, n_rate = g_rate + order * g2, n_rate + order * n2
        h_rate, f_rate, rate = h_rate + order * h2, f_rate + order * f2, rate + order * c2
        c0, c1, g0, g1, n0, n1, h0, h1, f0, f1 = c1, c2, g1, g2, n1, n2, h1, h2, f1, f2
        term, term_next, push = term_next, next_term(term, p.nu * dt, FACTORS[n]), 0.0
    per = 1.0 / dt if dt > 0.0 else 0.0
    e12 = g_rate * per
    ends[0, BY_Y], ends[0, BY_W], ends[1, BY_Y], ends[1, BY_W] = (
        1.0 - g,
        e12,
        -e12,
        1.0 - p.h * e12 - g,
    )
    ends[0, BY_LOAD], ends[0, BY_NU], ends[0, BY_H], ends[0, BY_F] = g, n_end, h_end, f_end
    ends[1, BY_LOAD], ends[1, BY_NU] = e12, (n_rate + rate * by_nu) * per
    ends[1, BY_H], ends[1, BY_F] = h_rate * per, f_rate * per
    if second is not None:
        vary_by_second(p, unit, dt, degree, ends)


@jit
def vary_by_second(p, unit, dt, degree, ends) -> None:
    """Fill the variations by f2 and phi2 at the end of a step, by polynomials of a degree; unit : `unit_force`."""
    square, damped, twice = dt * dt, p.h * dt, 2.0 * p.nu * dt
    per = 1.0 / dt if dt > 0.0 else 0.0
    for v in range(BY_F2, WITH_SECOND):
        if v == BY_F2:
            term, term_next = first_terms_of_second(unit, twice)
        else:
            term, term_next = first_terms_of_phase(p, unit, twice)
        c0, c1, end, rate = 0.0, 0.0, 0.0, 0.0
        for n in range(degree - 1):
            c2 = square * FACTORS[n] * (term - c0) - damped * SHARES[n] * c1
            end, rate = end + c2, rate + (n + 2) * c2
            c0, c1 = c1, c2
            term, term_next = term_next, next_term(term, twice, FACTORS[n])
        ends[0, v], ends[1, v] = end, rate * per


@jit
def vary_in_closed_form(p, support, at_sine, at_cosine, turns, w, ends) -> None:
    """Fill the variations at the end of a flight of some turns from the derivatives of the flow, as `vary_flight`.

    A unit force exp(i nu t) moves the mass from rest to X (exp(i nu t) - e11 - i nu e12), X = 1/(1 - nu^2 + i h nu),
    which cancels in a short flight or near resonance.
    """
    t = turns * forcing_period(p)
    sigma = -1.0 if support == 1 else 1.0
    load = constant_load(sigma, support_position(p, support))
    e11, e12, e21, e22 = free_flow(p.h, t)
    d11, d12, d21, d22 = free_flow_by_h(p.h, t)
    x = divide(complex(1.0, 0.0), complex((1.0 - p.nu) * (1.0 + p.nu), p.h * p.nu))
    x_nu, x_h = -complex(-2.0 * p.nu, p.h) * x * x, -complex(0.0, p.nu) * x * x
    sine, cosine = sincos_turns(turns)
    forced, rate = complex(cosine, sine), complex(0.0, p.nu)
    shape, speed = forced - e11 - rate * e12, rate * forced - e21 - rate * e22
    at_start = sigma * complex(at_cosine, at_sine)
    ends[0, BY_Y], ends[0, BY_W], ends[1, BY_Y], ends[1, BY_W] = e11, e12, e21, e22
    ends[0, BY_LOAD], ends[1, BY_LOAD] = 1.0 - e11, e12
    ends[0, BY_F], ends[1, BY_F] = (at_start * x * shape).imag, (at_start * x * speed).imag
    by_h = x_h * shape - x * (d11 + rate * d12), x_h * speed - x * (d21 + rate * d22)
    ends[0, BY_H] = d12 * w - d11 * load + p.f * (at_start * by_h[0]).imag
    ends[1, BY_H] = d22 * w + d12 * load + p.f * (at_start * by_h[1]).imag
    turned = complex(0.0, 1.0) * forced
    by_nu = x_nu * shape + x * (t * turned - complex(0.0, e12))
    rate_by_nu = x_nu * speed + x * (turned + t * rate * turned - complex(0.0, e22))
    y1 = e12 * w + load * (1.0 - e11) + p.f * ends[0, BY_F]
    w1 = e22 * w + load * e12 + p.f * ends[1, BY_F]
    a1 = p.f * (at_start * forced).imag + load - p.h * w1 - y1
    ends[0, BY_NU] = p.f * (at_start * by_nu).imag - t / p.nu * w1
    ends[1, BY_NU] = p.f * (at_start * rate_by_nu).imag - t / p.nu * a1


@jit
def vary_flight(p, support, start, sine, cosine, end, w, work, second=None) -> None:
    """Fill the variations at the end of a flight.

    support : the support that the flight leaves, 1 or 2
    start, end : phases, in turns
    sine, cosine : of the phase of the start
    w : rate of the distance from the support at the start
    work : `ends` is filled with the derivatives of distance and rate at the end: by those at the start, by a constant
        load, and by nu, h, f, f2 and phi2 at fixed phases
    second : the effect `second_harmonic`; with it there is no closed form
    """
    dt = (end - start) * forcing_period(p)
    reach = dt * fastest_rate(fastest_forcing(p, second), p.h)
    stiffness = abs((1.0 - p.nu) * (1.0 + p.nu)) + p.h * p.nu
    if reach <= REACH:
        vary_in_one_step(p, support, sine, cosine, dt, w, reach, work.ends, second)
    elif second is None and reach > SHORT_REACH and stiffness > NEAR_RESONANCE:
        vary_in_closed_form(p, support, sine, cosine, end - start, w, work.ends)
    else:
        vary_by_steps(p, support, start, end, w, work, second)
