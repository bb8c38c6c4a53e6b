"""The load: phases, release of a sticking mass, bounds, and harmonics against samples."""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from vibropipe.physics.exciter import Parameters
from vibropipe.physics.load import (
    NEVER,
    constant_load,
    first_terms,
    force_at,
    force_bounds,
    force_rate,
    next_term,
    release_turn,
)
from vibropipe.physics.load_harmonics import (
    force_amplitude,
    force_values,
    reaction_integral,
    with_force,
    work_of_force,
)
from vibropipe.physics.turns import sincos_turns

P = Parameters(1.3, -0.8, 0.2, 0.5, 0.01, 0.7, 0.6)


@given(u=st.floats(-1000, 1000))
def test_sine_and_cosine_of_turns(u: float) -> None:
    s, c = sincos_turns(u)
    with mp.workdps(40):
        assert s == pytest.approx(float(mp.sin(2 * mp.pi * mp.mpf(u))), abs=2.3e-16)
        assert c == pytest.approx(float(mp.cos(2 * mp.pi * mp.mpf(u))), abs=2.3e-16)


def test_quarters_of_a_turn_are_exact() -> None:
    values = [sincos_turns(k / 4 + 1000) for k in range(4)]
    assert values == [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)]


@given(f=st.floats(-5, 5), load=st.floats(-5, 5))
def test_release_is_where_the_force_turns_positive(f: float, load: float) -> None:
    assume(abs(abs(load) - abs(f)) > 1e-6)
    turn = release_turn(P._replace(f=f), 1.0, load)
    turns = np.linspace(0, 1, 2001)
    force = f * np.sin(2 * np.pi * turns) + load
    if turn == NEVER:
        assert (force <= 1e-12).all()
    elif turn < 0:
        assert (force > 0).all()
    else:
        eps = 1e-7
        assert f * math.sin(2 * math.pi * (turn - eps)) + load < 0
        assert f * math.sin(2 * math.pi * (turn + eps)) + load > 0


def test_the_taylor_terms_add_up_to_the_force() -> None:
    turn, angle = 0.31, 0.4
    terms = list(first_terms(force_at(P, -1.0, turn), angle))
    for n in range(1, 14):
        terms.append(next_term(terms[-2], angle, 1.0 / (n * (n + 1))))
    for theta in (0.0, 0.3, 1.0):
        later = force_at(P, -1.0, turn + theta * angle / (2 * math.pi))
        assert np.polyval(terms[::-1], theta) == pytest.approx(later.sine, abs=1e-15)


def test_bounds_are_sharp() -> None:
    forces = [force_at(P, 1.0, turn) for turn in np.linspace(0, 1, 1001)]
    amplitude, rate, second = force_bounds(P)
    assert max(abs(force.sine) for force in forces) == pytest.approx(amplitude, rel=1e-6)
    assert max(abs(force_rate(P, force)) for force in forces) == pytest.approx(rate, rel=1e-6)
    assert second == pytest.approx(P.nu**2 * 0.8)


@pytest.mark.parametrize(("k", "m"), [(0, 1), (1, 1), (2, 1), (1, 2), (2, 2)])
def test_harmonics_of_the_force_are_those_of_its_samples(k: int, m: int) -> None:
    turns = (np.arange(4096) + 0.5) / 4096
    waves = np.exp(-2j * math.pi * k * turns)
    force = force_values(P.f, m * turns)
    assert with_force(P, k, m, 0j) == pytest.approx(np.mean(force * waves), abs=1e-14)
    rest_turns = 0.2 + 0.3 * turns
    expected = -0.3 * np.mean(
        force_values(P.f, rest_turns) * np.exp(-2j * math.pi * k / m * rest_turns)
    )
    assert reaction_integral(P, k, m, 0.2, 0.5) == pytest.approx(expected, abs=1e-7)


@given(x=st.complex_numbers(max_magnitude=2.0))
def test_work_is_force_times_velocity_over_a_period(x: complex) -> None:
    turns = np.arange(64) / 64
    velocity = 2 * np.real(1j * P.nu * x * np.exp(2j * math.pi * turns))
    power = np.mean(force_values(P.f, turns) * velocity)
    assert work_of_force(P, x) == pytest.approx(power * 2 * math.pi / P.nu, abs=1e-13)
    assert force_amplitude(P) == 0.5j * 0.8


@given(sigma=st.sampled_from([-1.0, 1.0]), reference=st.floats(-1, 1))
@example(1.0, 0.0)
@example(-1.0, -0.0)
def test_the_spring_pulls_back_to_the_equilibrium(sigma: float, reference: float) -> None:
    load = constant_load(sigma, reference)
    assert load == -sigma * reference
    assert load != 0.0 or math.copysign(1.0, load) == 1.0
