"""States just before and just after the events of a law, and the flights between them, with their derivatives."""

from __future__ import annotations

from typing import NamedTuple

from vibropipe.compiler import jit
from vibropipe.march.piece_log import (
    CAUSE,
    DIRECTION,
    FORM,
    HELD,
    HOME,
    HOUSING_SLIP,
    HOUSING_STOP,
    IMPACT,
    RELEASE,
    REST_BEGINS,
    RESTING,
    SLIP,
)
from vibropipe.orbits.law.law import (
    SECTION,
    acts_in,
    ends_force,
    frame_before,
    is_contact,
    way_before,
)
from vibropipe.orbits.law.sliding import carried, carried_by, pull_by, pull_of, way_of
from vibropipe.physics.contact import support_position
from vibropipe.physics.derivatives import (
    FRICTION,
    FRICTION_RATIO,
    H1,
    H2,
    K1,
    K2,
    H,
    distance_derivative,
    force_derivative,
    load_derivative,
    restitution_derivative,
    support_derivative,
)
from vibropipe.physics.friction import hold_of
from vibropipe.physics.load import constant_load, force_at, force_slope, force_value
from vibropipe.physics.stiffness import damping_of, stiffness_of
from vibropipe.physics.turns import TWO_PI


class State(NamedTuple):
    """A state at an event in a frame, with its derivatives by the unknowns of the event.

    t : time in forcing periods
    timed : derivative of `t` by the first unknown: 1, or 0 at a section
    y_0, y_1, w_1, w_2 : derivatives of y by the first two unknowns, and of w by the second and, with a housing, the
        third one
    """

    t: float
    y: float
    w: float
    timed: float
    y_0: float
    y_1: float
    w_1: float
    w_2: float


class Momentum(NamedTuple):
    """The momentum q of `sliding` at an event in a frame, with its derivatives by the last two unknowns."""

    q: float
    q_1: float
    q_2: float


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
    if e.housing is not None:
        value += carried(p, sigma, way_of(law, i))
    return value, stiffness, TWO_PI * force_slope(force, second)


@jit
def arrival(e, p, law, i, u) -> State:
    """Return the state just before event i, in the frame of `frame_before`."""
    kind, home = law.codes[i, CAUSE], law.codes[i, HOME]
    frame = frame_before(law, i)
    sigma = sign_of(frame)
    t, own = u[i, 0], sigma * u[i, 1]
    if kind == SECTION:
        return State(0.0, sigma * t, own, 0.0, sigma, 0.0, sigma, 0.0)
    if is_contact(kind):
        y = 0.0
        if frame == 0:
            y = support_position(p, home)
        elif frame != home:
            y = 2.0 * p.l
        return State(t, y, own, 1.0, 0.0, 0.0, sigma, 0.0)
    if e.no_pull is not None and ends_force(kind):
        ratio = damping_of(p, home) / stiffness_of(p, home)
        return State(t, -ratio * own, own, 1.0, 0.0, -ratio * sigma, sigma, 0.0)
    if e.friction is not None and kind == SLIP:
        value, stiffness, rate = hold_force(e, p, law, i - 1, t)
        y = (value - law.codes[i, DIRECTION] * hold_of(e, p)) / stiffness
        return State(t, y, 0.0, 1.0, rate / stiffness, 0.0, 0.0, 0.0)
    if e.housing is not None and kind == HOUSING_SLIP:
        value, stiffness, damping, rate = slip_force(e, p, law, i, t)
        y = (value - damping * own) / stiffness
        by_own = -damping * sigma / stiffness
        return State(t, y, own, 1.0, rate / stiffness, by_own, sigma, 0.0)
    if (
        e.housing is not None
        and kind == HOUSING_STOP
        and law.codes[i - 1, FORM] not in (HELD, RESTING)
    ):
        return State(t, own, sigma * u[i, 2], 1.0, 0.0, sigma, 0.0, sigma)
    return State(t, own, 0.0, 1.0, 0.0, sigma, 0.0, 0.0)


@jit
def slip_force(e, p, law, i, t):
    """Return the force on the mass at a gap of 0 and without velocity less that at which its held housing slips.

    That is at event i; with stiffness, damping, and the rate of the force by t.
    """
    home = law.codes[i, HOME]
    value, stiffness, rate = hold_force(e, p, law, i - 1, t)
    damping = p.h
    if e.soft is not None and acts_in(law, i):
        damping += damping_of(p, home)
    value -= p.friction * law.codes[i, DIRECTION] + sign_of(home) * pull_of(p, way_of(law, i))
    return value, stiffness, damping, rate


@jit
def momentum_before(e, p, law, i, u) -> Momentum:
    """Return the momentum just before event i, in the frame of `frame_before`."""
    if way_before(law, i) != 0 and law.codes[i, CAUSE] != HOUSING_STOP:
        sigma = sign_of(frame_before(law, i))
        return Momentum(sigma * u[i, 2], 0.0, sigma)
    state = arrival(e, p, law, i, u)
    return Momentum(state.w, state.w_1, state.w_2)


@jit
def momentum_after(e, p, law, i, u) -> Momentum:
    """Return the momentum just after event i, in the frame of its piece."""
    before = momentum_before(e, p, law, i, u)
    turned = sign_of(law.codes[i, HOME]) * sign_of(frame_before(law, i))
    return Momentum(turned * before.q, turned * before.q_1, turned * before.q_2)


@jit
def press_by(e, p, law, i, t, k):
    """Return the derivative by parameter k of the force on a mass at a gap of 0, less the friction against a slip."""
    home = law.codes[i, HOME]
    change = sign_of(home) * force_derivative(p, t, k, e.second_harmonic)
    if home > 0:
        change += load_derivative(home, k)
    if e.friction is not None:
        held = law.codes[i, CAUSE] != HOUSING_SLIP
        if k == FRICTION:
            change -= law.codes[i, DIRECTION] * (p.friction_ratio if held else 1.0)
        elif k == FRICTION_RATIO and held:
            change -= law.codes[i, DIRECTION] * p.friction
    if e.housing is not None and law.codes[i, CAUSE] != HOUSING_SLIP:
        change += carried_by(p, sign_of(home), way_of(law, i), k)
    return change


@jit
def slip_by(e, p, law, i, u, k):
    """Return the derivative by parameter k of the displacement at which a housing slips."""
    home, t = law.codes[i, HOME], u[i, 0]
    sigma = sign_of(home)
    value, stiffness, damping, _rate = slip_force(e, p, law, i, t)
    change = press_by(e, p, law, i, t, k) - sigma * pull_by(way_of(law, i), k)
    in_contact = e.soft is not None and acts_in(law, i)
    if k == H or (in_contact and k == (H1 if home == 1 else H2)):
        change -= sigma * u[i, 1]
    if in_contact and k == (K1 if home == 1 else K2):
        change -= (value - damping * sigma * u[i, 1]) / stiffness
    return change / stiffness


@jit
def arrival_by(e, p, law, i, u, k):
    """Return the derivative of the displacement of `arrival` by parameter k."""
    kind, home, frame = law.codes[i, CAUSE], law.codes[i, HOME], frame_before(law, i)
    if is_contact(kind):
        if frame == 0:
            return support_derivative(home, k)
        return distance_derivative(k) if frame != home else 0.0
    if e.no_pull is not None and ends_force(kind):
        own, stiffness = sign_of(frame) * u[i, 1], stiffness_of(p, home)
        if k == (H1 if home == 1 else H2):
            return -own / stiffness
        if k == (K1 if home == 1 else K2):
            return damping_of(p, home) * own / (stiffness * stiffness)
        return 0.0
    if e.housing is not None and kind == HOUSING_SLIP:
        return slip_by(e, p, law, i, u, k)
    if e.friction is None or kind != SLIP:
        return 0.0
    value, stiffness, _rate = hold_force(e, p, law, i - 1, u[i, 0])
    hold = law.codes[i, DIRECTION] * hold_of(e, p)
    change = press_by(e, p, law, i, u[i, 0], k)
    if e.soft is not None and acts_in(law, i - 1) and k == (K1 if home == 1 else K2):
        change -= (value - hold) / stiffness
    return change / stiffness


@jit
def departure(e, p, law, i, u) -> State:
    """Return the state just after event i, in the frame of its piece."""
    before = arrival(e, p, law, i, u)
    kind, home = law.codes[i, CAUSE], law.codes[i, HOME]
    if kind == RELEASE:
        return State(before.t, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
    if not is_contact(kind):
        return before
    turned = sign_of(home) * sign_of(frame_before(law, i))
    if kind in (IMPACT, REST_BEGINS):
        turned *= -(p.R1 if home == 1 else p.R2)
    return State(before.t, 0.0, turned * before.w, 1.0, 0.0, 0.0, turned * before.w_1, 0.0)


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
