"""One linear piece of a motion, y'' + H y' + K y = L + F: its end and all derivatives of it, in closed form."""

from __future__ import annotations

from typing import NamedTuple

from vibropipe.compiler import jit, jit_inline
from vibropipe.physics.impulse import (
    Impulse,
    harmonic_motion,
    impulse_response,
    motion_by_rate,
    square_motion,
    square_response,
)
from vibropipe.physics.load import Force
from vibropipe.physics.turns import TWO_PI, sincos_turns


class Flight(NamedTuple):
    """A piece over a time: its coefficients, and its responses.

    force : at its start
    nu, turns, t : frequency of the force, and the time in forcing periods and in tau
    first, second : responses from rest to exp(i nu tau) and exp(2 i nu tau); the latter is 0 without a second harmonic
    second_harmonic : the effect. What tests `second` itself for None can raise where it is a number
    """

    stiffness: float
    damping: float
    load: float
    force: Force
    nu: float
    turns: float
    t: float
    free: Impulse
    first: complex
    second: complex
    second_harmonic: int | None


@jit
def flight_over(stiffness, damping, load, force: Force, nu, turns, second=None) -> Flight:
    """Return the `Flight` over some turns, counted in forcing periods; second : the effect `second_harmonic`."""
    t = turns * TWO_PI / nu
    free = impulse_response(stiffness, damping, t)
    first = harmonic_motion(stiffness, damping, nu, turns, t, free.s)
    other = _second_motion(stiffness, damping, nu, turns, t, free.s, second)
    return Flight(stiffness, damping, load, force, nu, turns, t, free, first, other, second)


@jit_inline
def _second_motion(stiffness, damping, nu, turns, t, s, second):
    """Return the response to exp(2 i nu tau); 0 without a second harmonic."""
    if second is None:
        return complex(0.0, 0.0)
    return harmonic_motion(stiffness, damping, 2.0 * nu, 2.0 * turns, t, s)


@jit_inline
def _mixed(sine, cosine, response):
    """Return the response to sine cos(w tau) + cosine sin(w tau) from that to exp(i w tau)."""
    return sine * response.real + cosine * response.imag


@jit
def harmonic_response(flight, response, w, sine, cosine, harmonic=1):
    """Return displacement and velocity by one harmonic of the frequency w that begins with its sine and cosine.

    response : `Flight.first` or `second`
    harmonic : 1, or `Flight.second_harmonic`, of which None gives zeros
    """
    if harmonic is None:
        return 0.0, 0.0
    rate = flight.free.s + complex(0.0, w) * response
    return _mixed(sine, cosine, response), _mixed(sine, cosine, rate)


@jit
def forced_response(flight, force: Force):
    """Return displacement and velocity from rest at the end of a flight by a force that begins so."""
    nu = flight.nu
    y, w = harmonic_response(flight, flight.first, nu, force.sine, force.cosine)
    more, more_rate = harmonic_response(
        flight, flight.second, 2.0 * nu, force.sine_2, force.cosine_2, flight.second_harmonic
    )
    return y + more, w + more_rate


@jit
def flown(flight, y, w):
    """Return (y, w) at the end of a flight from (y, w)."""
    free = flight.free
    ahead, faster = forced_response(flight, flight.force)
    end = free.c * y + free.s * w + (flight.load * free.g + ahead)
    rate = free.ds * w - flight.stiffness * free.s * y + (flight.load * free.s + faster)
    return end, rate


@jit
def force_at_end(flight):
    """Return the force at the end of a flight."""
    sine, cosine = sincos_turns(flight.turns)
    force = flight.force
    return (
        force.sine * cosine + force.cosine * sine + _second_at_end(flight, flight.second_harmonic)
    )


@jit_inline
def _second_at_end(flight, second):
    """Return the second harmonic of the force at the end of a flight; 0 without one."""
    if second is None:
        return 0.0
    sine, cosine = sincos_turns(2.0 * flight.turns)
    return flight.force.sine_2 * cosine + flight.force.cosine_2 * sine


@jit_inline
def acceleration_of(flight, force, y, w):
    """Return y'' of a piece in a state, under a force."""
    return (flight.load + force) - flight.damping * w - flight.stiffness * y


@jit_inline
def _square_of(flight):
    """Return the `Square` at the end of a flight."""
    return square_response(flight.stiffness, flight.damping, flight.t, flight.free)


@jit
def by_stiffness(flight, y, w):
    """Return the derivative of the end (y, w) by the stiffness, from the start (y, w)."""
    h, k, square = flight.damping, flight.stiffness, _square_of(flight)
    dds = flight.free.s - h * square.ds - k * square.s
    end = -(square.ds + h * square.s) * y - square.s * w - flight.load * square.g
    rate = -(dds + h * square.ds) * y - square.ds * w - flight.load * square.s
    a, b, _c = _square_response(flight, square)
    return end - a, rate - b


@jit
def by_damping(flight, y, w):
    """Return the derivative of the end (y, w) by the damping, from the start (y, w)."""
    h, k, square = flight.damping, flight.stiffness, _square_of(flight)
    dds = flight.free.s - h * square.ds - k * square.s
    end = k * square.s * y - square.ds * w - flight.load * square.s
    rate = k * square.ds * y - dds * w - flight.load * square.ds
    _a, b, c = _square_response(flight, square)
    return end - b, rate - c


@jit
def _square_response(flight, square):
    """Return motion, rate and acceleration of 1/q^2 under the force."""
    force, nu = flight.force, flight.nu
    a, b, c = _harmonic_square(flight, square, flight.first, nu, force.sine, force.cosine)
    more, more_b, more_c = _harmonic_square(
        flight,
        square,
        flight.second,
        2.0 * nu,
        force.sine_2,
        force.cosine_2,
        flight.second_harmonic,
    )
    return a + more, b + more_b, c + more_c


@jit
def _harmonic_square(flight, square, response, w, sine, cosine, harmonic=1):
    """Return motion, rate and acceleration of 1/q^2 under one harmonic; zeros without it."""
    if harmonic is None:
        return 0.0, 0.0, 0.0
    iw = complex(0.0, w)
    motion = square_motion(
        flight.stiffness, flight.damping, w, flight.t, response, flight.free.s, square
    )
    rate = square.s + iw * motion
    return (
        _mixed(sine, cosine, motion),
        _mixed(sine, cosine, rate),
        _mixed(sine, cosine, square.ds + iw * rate),
    )


@jit
def by_frequency(flight):
    """Return the derivative of the end (y, w) by nu, the phase of the force at the start and the time held."""
    force, nu = flight.force, flight.nu
    by, rate_by = _frequency_response(flight, flight.first, nu, force.sine, force.cosine)
    more, more_rate = _frequency_response(
        flight, flight.second, 2.0 * nu, force.sine_2, force.cosine_2, flight.second_harmonic
    )
    return by + 2.0 * more, rate_by + 2.0 * more_rate


@jit
def by_phase(flight):
    """Return the derivative of the end (y, w) by the phase of the force at the start, in radians."""
    force, nu = flight.force, flight.nu
    y, w = harmonic_response(flight, flight.first, nu, force.cosine, -force.sine)
    more, more_rate = harmonic_response(
        flight,
        flight.second,
        2.0 * nu,
        2.0 * force.cosine_2,
        -2.0 * force.sine_2,
        flight.second_harmonic,
    )
    return y + more, w + more_rate


@jit
def _frequency_response(flight, response, w, sine, cosine, harmonic=1):
    """Return the derivative of the motion and of its rate under one harmonic by its frequency; zeros without it."""
    if harmonic is None:
        return 0.0, 0.0
    i = complex(0.0, 1.0)
    by_rate = motion_by_rate(flight.stiffness, flight.damping, w, flight.t, response)
    return _mixed(sine, cosine, i * by_rate), _mixed(sine, cosine, i * response - w * by_rate)
