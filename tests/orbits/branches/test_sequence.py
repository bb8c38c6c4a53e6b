"""The equations of an impact sequence, their derivative, and the multipliers of its return map."""

from __future__ import annotations

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.orbits.branches.curve import ImpactCurve, is_no_motion
from vibropipe.orbits.branches.sequence import (
    eigenvalues,
    fill_equations,
    return_derivative,
)
from vibropipe.orbits.branches.symmetry import doubled, halved, halves_agree
from vibropipe.orbits.law import least as of
from vibropipe.orbits.law.law import law_of_impacts
from vibropipe.solve.boundary.closed_orbits import one_sided_orbit
from vibropipe.solve.branch.problem import problem_of

NONE = np.zeros((0, 0))
TWO_SIDED = vp.Exciter(l=0.5, nu=1.3, f=1.0, h=0.1, delta=0.1, R1=0.8, R2=0.6)
PERIOD_2 = vp.Exciter(l=0.5, nu=2.5, f=1.0, h=0.1, delta=0.3, R1=0.8, R2=0.7)
EXCITERS = [
    TWO_SIDED,
    vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.0, R1=0.7, R2=0.7),
    vp.Exciter(l=0.5, nu=0.6, f=1.0, h=0.2, R1=0.5, R2=0.5),
    vp.Exciter(l=0.5, nu=1.5, f=2.0, h=2.0, delta=-0.1, R1=0.9, R2=0.5),
    PERIOD_2,
]


def orbit_of(exciter):
    state = vp.steady_state(exciter)
    times = state.impact_phase.values + state.impact_period.values
    supports = state.impact_support.values.astype(np.int8)
    u = np.concatenate([times, state.impact_velocity.values, [exciter.nu]])
    return state, int(state.period_multiple), supports, u


def residual_of(p, m, supports, u):
    residual = np.zeros(u.size)
    fill_equations(p, float(m), 0, supports, u, residual, NONE)
    return residual[:-1]


@pytest.mark.parametrize("exciter", EXCITERS)
def test_steady_states_are_zeros_with_the_same_multipliers(exciter) -> None:
    state, m, supports, u = orbit_of(exciter)
    p = exciter.parameters()
    assert np.abs(residual_of(p, m, supports, u)).max() < 1e-12
    found = np.array(eigenvalues(*return_derivative(p, float(m), 0, supports, u)))
    expected = state.floquet_multiplier.values
    # Trace and determinant: of a double multiplier each half of the digits only.
    assert found.sum() == pytest.approx(expected.sum(), abs=1e-12)
    assert found.prod() == pytest.approx(expected.prod(), abs=1e-12)


@pytest.mark.parametrize("exciter", EXCITERS)
def test_derivative_is_that_of_differences(exciter) -> None:
    _state, m, supports, u = orbit_of(exciter)
    p, size, step = exciter.parameters(), u.size, 1e-6
    exact = np.zeros((size, size))
    fill_equations(p, float(m), 0, supports, u, np.zeros(size), exact)
    for k in range(size - 1):
        ahead, back = u.copy(), u.copy()
        ahead[k] += step
        back[k] -= step
        column = residual_of(p, m, supports, ahead) - residual_of(p, m, supports, back)
        assert column / 2 / step == pytest.approx(exact[:-1, k], abs=1e-7)


@pytest.mark.parametrize("exciter", EXCITERS)
def test_the_margin_is_the_least_gap_of_the_sampled_motion(exciter) -> None:
    state, m, supports, u = orbit_of(exciter)
    curve = curve_of(exciter, m, supports)
    assert curve.settle(u) is not None
    gap, _flight, side, time = curve.system.margins[of.GAP]
    motion = vp.simulate(
        exciter, tau_end=m * exciter.period, samples_per_period=20_000,
        x0=float(state.displacement_strobe), v0=float(state.velocity_strobe),
    )  # fmt: skip
    x, v = motion.displacement.values, motion.velocity.values
    # Turning points: the velocity changes its sign without an impact between two samples.
    struck = np.isin(np.arange(x.size - 1), np.searchsorted(motion.tau, motion.impact_tau) - 1)
    turns = np.flatnonzero((v[1:] * v[:-1] < 0) & ~struck)
    gaps = np.where(v[turns] > 0, exciter.upper - x[turns], x[turns] - exciter.lower)
    assert gap == pytest.approx(gaps.min(initial=np.inf), abs=1e-6)
    if turns.size and exciter.delta != 0.0:  # a symmetric orbit has its least gap at both supports
        at = turns[gaps.argmin()]
        assert side == (1 if v[at] > 0 else 2)
        difference = time - motion.tau.values[at] / exciter.period
        assert (difference + m / 2) % m - m / 2 == pytest.approx(0.0, abs=2e-4)


def test_a_flight_beyond_a_support_has_a_negative_margin() -> None:
    # Closed forms without impacts on support 2 that would pass through it.
    exciter = vp.Exciter(l=0.5, nu=0.5, f=1.0, h=0.1, R1=0.5)
    orbits = one_sided_orbit(exciter, 1, 1)
    orbit = orbits.isel(solution=int(np.flatnonzero(orbits.admissible == 0)[0]))
    curve = curve_of(exciter, 1, np.array([1], np.int8))
    times = orbit.impact_phase.values + orbit.impact_period.values
    point = curve.settle(np.concatenate([times, orbit.impact_velocity.values, [exciter.nu]]))
    assert is_no_motion(point)
    gap, flight, side, _time = curve.system.margins[of.GAP]
    assert gap < 0
    assert (side, flight) == (2, 0)


def curve_of(exciter, m, supports):
    """Return the branch over nu of orbits that strike supports in turn."""
    problem, _signs = problem_of(exciter, "nu", 2.0 * exciter.nu, (), 0.02)
    return ImpactCurve(problem, law_of_impacts(m, 0, supports), 1.0)


def test_doubled_and_halved_are_inverse() -> None:
    for sequence in (
        law_of_impacts(1, 0, [1, 2]),
        law_of_impacts(3, 1, [1, 1, 2]),
    ):
        n = len(sequence.supports)
        u = np.concatenate([0.1 + 0.2 * np.arange(n), 0.5 + np.arange(n), [2.0]])
        whole, twice, change = doubled(sequence, u, np.ones(2 * n + 1))
        kind = halves_agree(whole, twice, np.ones(twice.size))
        assert kind == ("pitchfork" if sequence.mirrored else "flip")
        back, mean = halved(whole, twice, kind)
        assert (back.m, back.mirrored) == (sequence.m, sequence.mirrored)
        assert np.array_equal(back.supports, sequence.supports)
        assert mean == pytest.approx(u, abs=1e-15)
        assert not halves_agree(whole, twice + 0.01 * change, np.ones(twice.size))
