"""One linear piece of a motion, y'' + H y' + K y = L + F: its end and all derivatives of it, in closed form."""

from __future__ import annotations

from typing import NamedTuple

from vibropipe.compiler import jit, jit_inline
from vibropipe.physics.impulse import Impulse, Response, force_responses, impulse_response
from vibropipe.physics.load import Force
from vibropipe.physics.turns import TWO_PI, sincos_turns


class Flight(NamedTuple):
    """A piece over a time: its coefficients, and its responses.

    Attributes
    ----------
    stiffness, damping, load : float
    force : Force
        At its start.
    nu, turns, t : float
        Frequency of the force, and the time in forcing periods and in tau.
    free : Impulse
    first, second : Response
        To the first and to the second harmonic.
    """

    stiffness: float
    damping: float
    load: float
    force: Force
    nu: float
    turns: float
    t: float
    free: Impulse
    first: Response
    second: Response


@jit
def flight_over(stiffness, damping, load, force: Force, nu, turns) -> Flight:
    """Return the `Flight` over some turns, counted in forcing periods."""
    t = turns * TWO_PI / nu
    free = impulse_response(stiffness, damping, t)
    first = force_responses(stiffness, damping, nu, turns, t, free)
    second = force_responses(stiffness, damping, 2.0 * nu, 2.0 * turns, t, free)
    return Flight(stiffness, damping, load, force, nu, turns, t, free, first, second)


@jit_inline
def _mixed(sine, cosine, response):
    """Return the response to sine cos(w tau) + cosine sin(w tau) from that to exp(i w tau)."""
    return sine * response.real + cosine * response.imag


@jit
def harmonic_response(flight, response, w, sine, cosine):
    """Return displacement and velocity by one harmonic of the frequency w that begins with its sine and cosine."""
    rate = flight.free.s + complex(0.0, w) * response.w
    return _mixed(sine, cosine, response.w), _mixed(sine, cosine, rate)


@jit
def flown(flight, y, w):
    """Return (y, w) at the end of a flight from (y, w)."""
    free, force, nu = flight.free, flight.force, flight.nu
    ahead, faster = harmonic_response(flight, flight.first, nu, force.sine, force.cosine)
    if force.sine_2 != 0.0 or force.cosine_2 != 0.0:
        more, more_rate = harmonic_response(
            flight, flight.second, 2.0 * nu, force.sine_2, force.cosine_2
        )
        ahead, faster = ahead + more, faster + more_rate
    end = free.c * y + free.s * w + (flight.load * free.g + ahead)
    rate = free.ds * w - flight.stiffness * free.s * y + (flight.load * free.s + faster)
    return end, rate


@jit
def force_at_end(flight):
    """Return the force at the end of a flight."""
    sine, cosine = sincos_turns(flight.turns)
    force = flight.force
    end = force.sine * cosine + force.cosine * sine
    if force.sine_2 != 0.0 or force.cosine_2 != 0.0:
        sine, cosine = sincos_turns(2.0 * flight.turns)
        end += force.sine_2 * cosine + force.cosine_2 * sine
    return end


@jit_inline
def acceleration_of(flight, force, y, w):
    """Return y'' of a piece in a state, under a force."""
    return (flight.load + force) - flight.damping * w - flight.stiffness * y


@jit
def by_stiffness(flight, y, w):
    """Return the derivative of the end (y, w) by the stiffness, from the start (y, w)."""
    free, force, nu, h, k = flight.free, flight.force, flight.nu, flight.damping, flight.stiffness
    dds2 = free.s - h * free.ds2 - k * free.s2
    end = -(free.ds2 + h * free.s2) * y - free.s2 * w - flight.load * free.g2
    rate = -(dds2 + h * free.ds2) * y - free.ds2 * w - flight.load * free.s2
    a, b, _c = _square_response(flight, flight.first, nu, force.sine, force.cosine)
    end, rate = end - a, rate - b
    if force.sine_2 != 0.0 or force.cosine_2 != 0.0:
        a, b, _c = _square_response(flight, flight.second, 2.0 * nu, force.sine_2, force.cosine_2)
        end, rate = end - a, rate - b
    return end, rate


@jit
def by_damping(flight, y, w):
    """Return the derivative of the end (y, w) by the damping, from the start (y, w)."""
    free, force, nu, h, k = flight.free, flight.force, flight.nu, flight.damping, flight.stiffness
    dds2 = free.s - h * free.ds2 - k * free.s2
    end = k * free.s2 * y - free.ds2 * w - flight.load * free.s2
    rate = k * free.ds2 * y - dds2 * w - flight.load * free.ds2
    _a, b, c = _square_response(flight, flight.first, nu, force.sine, force.cosine)
    end, rate = end - b, rate - c
    if force.sine_2 != 0.0 or force.cosine_2 != 0.0:
        _a, b, c = _square_response(flight, flight.second, 2.0 * nu, force.sine_2, force.cosine_2)
        end, rate = end - b, rate - c
    return end, rate


@jit
def _square_response(flight, response, w, sine, cosine):
    """Return motion, rate and acceleration of 1/q^2 under one harmonic."""
    iw, free = complex(0.0, w), flight.free
    rate = free.s2 + iw * response.w2
    return (
        _mixed(sine, cosine, response.w2),
        _mixed(sine, cosine, rate),
        _mixed(sine, cosine, free.ds2 + iw * rate),
    )


@jit
def by_frequency(flight):
    """Return the derivative of the end (y, w) by nu, the phase of the force at the start and the time held."""
    force, nu = flight.force, flight.nu
    by, rate_by = _frequency_response(flight.first, nu, force.sine, force.cosine)
    if force.sine_2 != 0.0 or force.cosine_2 != 0.0:
        more, more_rate = _frequency_response(flight.second, 2.0 * nu, force.sine_2, force.cosine_2)
        by, rate_by = by + 2.0 * more, rate_by + 2.0 * more_rate
    return by, rate_by


@jit
def by_phase(flight):
    """Return the derivative of the end (y, w) by the phase of the force at the start, in radians."""
    force, nu = flight.force, flight.nu
    y, w = harmonic_response(flight, flight.first, nu, force.cosine, -force.sine)
    if force.sine_2 != 0.0 or force.cosine_2 != 0.0:
        more, more_rate = harmonic_response(
            flight, flight.second, 2.0 * nu, 2.0 * force.cosine_2, -2.0 * force.sine_2
        )
        y, w = y + more, w + more_rate
    return y, w


@jit
def _frequency_response(response, w, sine, cosine):
    """Return the derivative of the motion and of its rate under one harmonic by its frequency."""
    i = complex(0.0, 1.0)
    return (
        _mixed(sine, cosine, i * response.w3),
        _mixed(sine, cosine, i * response.w - w * response.w3),
    )
