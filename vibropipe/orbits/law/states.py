"""States just before and just after the events of a law, and the flights between them, with their derivatives."""

from __future__ import annotations

from typing import NamedTuple

from vibropipe.compiler import jit
from vibropipe.march.piece_log import (
    CAUSE,
    CONTACT,
    DIRECTION,
    FORM,
    HELD,
    HOME,
    IMPACT,
    RELEASE,
    REST_BEGINS,
    SLIP,
)
from vibropipe.orbits.law.law import SECTION, acts_in, frame_before, is_contact
from vibropipe.physics.contact import support_position
from vibropipe.physics.derivatives import (
    F2,
    FRICTION,
    H1,
    H2,
    K1,
    K2,
    NU,
    F,
    H,
    distance_derivative,
    force_derivative,
    is_of_second,
    load_derivative,
    restitution_derivative,
    support_derivative,
)
from vibropipe.physics.load import (
    constant_load,
    force_at,
    force_by_phase,
    force_slope,
    force_value,
    unit_force,
)
from vibropipe.physics.piece import (
    Flight,
    by_damping,
    by_frequency,
    by_stiffness,
    flight_over,
    flown,
    harmonic_response,
)
from vibropipe.physics.stiffness import damping_of, stiffness_of
from vibropipe.physics.turns import TWO_PI, sincos_turns


class State(NamedTuple):
    """A state at an event in a frame, with its derivatives by both unknowns of the event.

    Attributes
    ----------
    t : float
        Time in forcing periods.
    y, w : float
    timed : float
        Derivative of `t` by the first unknown: 1, or 0 at a section.
    y_0, y_1, w_1 : float
        Derivatives of y by both unknowns, and of w by the second one.
    """

    t: float
    y: float
    w: float
    timed: float
    y_0: float
    y_1: float
    w_1: float


@jit
def sign_of(home) -> float:
    """Return the sign of a frame: -1 from support 1."""
    return -1.0 if home == 1 else 1.0


@jit
def reference_of(p, home):
    """Return the displacement from which a frame counts."""
    return support_position(p, home) if home > 0 else 0.0


@jit
def hold_force(e, p, law, i, t):
    """Return the force on the held mass of piece i where its gap is 0, stiffness, and the rate of the force by t."""
    home = law.codes[i, HOME]
    sigma = sign_of(home)
    second = e.second_harmonic
    force = force_at(p, sigma, t, second)
    stiffness = 1.0
    if e.soft is not None and acts_in(law, i):
        stiffness += stiffness_of(p, home)
    value = constant_load(sigma, reference_of(p, home)) + force_value(force, second)
    return value, stiffness, TWO_PI * force_slope(force, second)


@jit
def arrival(e, p, law, i, u) -> State:
    """Return the state just before event i, in the frame of `frame_before`."""
    kind, home = law.codes[i, CAUSE], law.codes[i, HOME]
    frame = frame_before(law, i)
    sigma = sign_of(frame)
    t, own = u[i, 0], sigma * u[i, 1]
    if kind == SECTION:
        return State(0.0, sigma * t, own, 0.0, sigma, 0.0, sigma)
    if is_contact(kind):
        y = 0.0
        if frame == 0:
            y = support_position(p, home)
        elif frame != home:
            y = 2.0 * p.l
        return State(t, y, own, 1.0, 0.0, 0.0, sigma)
    if e.friction is not None and kind == SLIP:
        value, stiffness, rate = hold_force(e, p, law, i - 1, t)
        y = (value - law.codes[i, DIRECTION] * p.friction) / stiffness
        return State(t, y, 0.0, 1.0, rate / stiffness, 0.0, 0.0)
    return State(t, own, 0.0, 1.0, 0.0, sigma, 0.0)


@jit
def press_by(e, p, law, i, t, k):
    """Return the derivative by parameter k of the force on a mass at a gap of 0, less the friction against a slip."""
    home = law.codes[i, HOME]
    change = sign_of(home) * force_derivative(p, t, k, e.second_harmonic)
    if home > 0:
        change += load_derivative(home, k)
    if e.friction is not None and k == FRICTION:
        change -= law.codes[i, DIRECTION]
    return change


@jit
def arrival_by(e, p, law, i, u, k):
    """Return the derivative of the displacement of `arrival` by parameter k."""
    kind, home, frame = law.codes[i, CAUSE], law.codes[i, HOME], frame_before(law, i)
    if is_contact(kind):
        if frame == 0:
            return support_derivative(home, k)
        return distance_derivative(k) if frame != home else 0.0
    if e.friction is None or kind != SLIP:
        return 0.0
    value, stiffness, _rate = hold_force(e, p, law, i - 1, u[i, 0])
    friction = law.codes[i, DIRECTION] * p.friction
    change = press_by(e, p, law, i, u[i, 0], k)
    if e.soft is not None and acts_in(law, i - 1) and k == (K1 if home == 1 else K2):
        change -= (value - friction) / stiffness
    return change / stiffness


@jit
def departure(e, p, law, i, u) -> State:
    """Return the state just after event i, in the frame of its piece."""
    before = arrival(e, p, law, i, u)
    kind, home = law.codes[i, CAUSE], law.codes[i, HOME]
    if kind == RELEASE:
        return State(before.t, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    if not is_contact(kind):
        return before
    turned = sign_of(home) * sign_of(frame_before(law, i))
    if kind in (IMPACT, REST_BEGINS):
        turned *= -(p.R1 if home == 1 else p.R2)
    return State(before.t, 0.0, turned * before.w, 1.0, 0.0, 0.0, turned * before.w_1)


@jit
def departure_by(e, p, law, i, u, k):
    """Return the derivatives of displacement and velocity of `departure` by parameter k."""
    kind, home = law.codes[i, CAUSE], law.codes[i, HOME]
    if kind == RELEASE:
        return 0.0, 0.0
    if not is_contact(kind):
        return arrival_by(e, p, law, i, u, k), 0.0
    if kind not in (IMPACT, REST_BEGINS):
        return 0.0, 0.0
    arrives = sign_of(home) * u[i, 1]
    return 0.0, -restitution_derivative(home, k) * arrives


@jit
def flight_of(e, p, law, i, t, turns) -> Flight:
    """Return the `Flight` of piece i, which is not held, over some turns from t."""
    form, home = law.codes[i, FORM], law.codes[i, HOME]
    stiffness, damping = 1.0, p.h
    if e.soft is not None and form == CONTACT:
        stiffness, damping = stiffness + stiffness_of(p, home), damping + damping_of(p, home)
    sigma = sign_of(home)
    load = constant_load(sigma, reference_of(p, home))
    if e.friction is not None:
        load -= p.friction * law.codes[i, DIRECTION]
    force = force_at(p, sigma, t, e.second_harmonic)
    return flight_over(stiffness, damping, load, force, p.nu, turns, e.second_harmonic)


@jit
def flown_by(e, p, law, i, flight, start, t, k):
    """Return the derivatives of the end of piece i by parameter k, at a fixed start (y, w), phase and time."""
    form, home = law.codes[i, FORM], law.codes[i, HOME]
    if k == NU:
        return by_frequency(flight)
    in_contact = e.soft is not None and form == CONTACT
    if k == H or (in_contact and k == (H1 if home == 1 else H2)):
        return by_damping(flight, *start)
    if in_contact and k == (K1 if home == 1 else K2):
        return by_stiffness(flight, *start)
    if k == F or is_of_second(k):
        unit = unit_force(p, sign_of(home), *sincos_turns(t), e.second_harmonic)
        if k == F:
            return harmonic_response(flight, flight.first, p.nu, unit.sine, unit.cosine)
        sine, cosine = unit.sine_2, unit.cosine_2
        if k != F2:
            sine, cosine = force_by_phase(p, unit), -p.f2 * unit.sine_2
        return harmonic_response(flight, flight.second, 2.0 * p.nu, sine, cosine)
    change = 0.0
    if home > 0:
        change = load_derivative(home, k)
    if e.friction is not None and k == FRICTION:
        change -= law.codes[i, DIRECTION]
    return flight.free.g * change, flight.free.s * change


@jit
def state_within(e, p, law, i, u, time):
    """Return (y, w) on piece i at a time, in its frame."""
    start = departure(e, p, law, i, u)
    if e.friction is not None and law.codes[i, FORM] == HELD:
        return start.y, 0.0
    return flown(flight_of(e, p, law, i, start.t, time - start.t), start.y, start.w)
