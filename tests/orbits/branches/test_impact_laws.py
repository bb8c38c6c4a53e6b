"""Orbits of impacts on rigid supports by laws and by sequences: equations, derivatives, multipliers, margins."""

from __future__ import annotations

import numpy as np
import pytest
from orbit_motions import motion_of

import vibropipe as vp
from vibropipe.march.log import new_log
from vibropipe.march.state import FLIGHT, State
from vibropipe.orbits.branches.curve import ImpactCurve, is_no_motion
from vibropipe.orbits.branches.rows import closing_residual, log_impacts, orbit_multipliers
from vibropipe.orbits.branches.symmetry import doubled, halved, halves_agree
from vibropipe.orbits.law import least as of
from vibropipe.orbits.law.law import law_of_impacts
from vibropipe.orbits.law.problem import Problem
from vibropipe.orbits.law.steps import (
    DETERMINANT,
    GAP,
    GAP_FLIGHT,
    GAP_SIDE,
    GAP_TIME,
    MARGIN,
    N_TESTS,
    TRACE,
    fill_at,
    fill_tests,
)
from vibropipe.physics.effects import all_effects
from vibropipe.physics.exciter import Parameters
from vibropipe.solve.boundary.closed_orbits import one_sided_orbit
from vibropipe.solve.branch.problem import problem_of

NAMES = ("nu", "f", "h", "l", "delta", "R1", "R2", "load")
EXCITERS = [
    vp.Exciter(l=0.5, nu=1.3, f=1.0, h=0.1, delta=0.1, R1=0.8, R2=0.6),
    vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.0, R1=0.7, R2=0.7),
    vp.Exciter(l=0.5, nu=0.6, f=1.0, h=0.2, R1=0.5, R2=0.5),
    vp.Exciter(l=0.5, nu=1.5, f=2.0, h=2.0, delta=-0.1, R1=0.9, R2=0.5),
    vp.Exciter(l=0.5, nu=2.5, f=1.0, h=0.1, delta=0.3, R1=0.8, R2=0.7),
    vp.Exciter(l=0.5, nu=1.3, f=1.0, h=0.1, delta=0.1, load=0.05, R1=0.8, R2=0.6, f2=0.2, phi2=0.7),
]


def curve_of(exciter, along="nu"):
    """The branch of a steady state, its unknowns, and the steady state."""
    state, p = vp.steady_state(exciter), exciter.parameters()
    own, effects = getattr(exciter, along), all_effects(p._asdict())
    index = Parameters._fields.index(along)
    problem = Problem(np.array(p), index, own - 1.0, own + 1.0, (), False, 0.02, effects)
    times = state.impact_phase.values + state.impact_period.values
    law = law_of_impacts(int(state.period_multiple), 0, state.impact_support.values)
    speed = float(np.abs(state.impact_velocity.values).max())
    u = np.concatenate([times, state.impact_velocity.values, [own]])
    return ImpactCurve(problem, law, speed), u, state


@pytest.mark.parametrize("exciter", EXCITERS)
def test_steady_states_are_orbits_with_the_same_multipliers(exciter) -> None:
    curve, u, state = curve_of(exciter)
    point = curve.settle(u)
    assert point is not None
    assert point.u == pytest.approx(u, abs=1e-12)
    expected = state.floquet_multiplier.values
    assert point.tests[TRACE] == pytest.approx(expected.sum().real, abs=1e-11)
    assert point.tests[DETERMINANT] == pytest.approx(expected.prod().real, abs=1e-11)
    strobe = [float(state.displacement_strobe) - exciter.load, float(state.velocity_strobe)]
    assert curve.state_at(point) == pytest.approx(strobe, abs=1e-12)


@pytest.mark.parametrize("along", NAMES)
@pytest.mark.parametrize("exciter", EXCITERS[::5])
def test_derivatives_are_those_of_differences(exciter, along: str) -> None:
    curve, u, _state = curve_of(exciter, along)
    blocks, n, step = curve.system.blocks, len(curve.sequence.codes), 1e-6

    def rest(k, sign):
        moved = u.copy()
        moved[k] += sign * step
        assert fill_at(curve.system, moved)
        return blocks.rest.copy()

    assert fill_at(curve.system, u)
    exact = np.zeros((n, 2, 2 * n + 1))
    for i in range(n):
        exact[i][:, [i, n + i]] += blocks.at[i]
        exact[i][:, [(i - 1) % n, n + (i - 1) % n]] += blocks.before[i]
        exact[i][:, 2 * n] = blocks.by[i, :, 0]
    for k in range(2 * n + 1):
        difference = (rest(k, 1.0) - rest(k, -1.0)) / (2.0 * step)
        np.testing.assert_allclose(exact[:, :, k], difference, atol=2e-8)


@pytest.mark.parametrize("exciter", EXCITERS[:5])
def test_the_least_gap_is_that_of_the_sampled_motion(exciter) -> None:
    curve, u, state = curve_of(exciter)
    point, m = curve.settle(u), int(state.period_multiple)
    assert point is not None
    gap, _flight, side, time = curve.system.margins[of.GAP]
    motion = motion_of(exciter, state, samples_per_period=20_000)
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
        if point.tests[MARGIN] == of.GAP:
            assert point.tests[GAP] * exciter.l == pytest.approx(gaps.min(), abs=1e-6)
            assert (point.tests[GAP_SIDE], point.tests[GAP_TIME]) == (side, time)


def test_a_flight_beyond_a_support_has_a_negative_gap() -> None:
    # An orbit without its impacts on support 2 is no motion.
    exciter = vp.Exciter(l=0.5, nu=0.5, f=1.0, h=0.1, R1=0.5)
    problem = Problem(np.array(exciter.parameters()), 0, 0.2, 1.0, (), False, 0.02)
    system, tests = ImpactCurve(problem, law_of_impacts(1, 0, [1]), 0.3).system, np.zeros(N_TESTS)
    assert fill_at(system, np.array([0.25, 0.3, 0.5]))
    fill_tests(system, system.blocks.polynomial, tests)
    assert tests[GAP] < 0
    assert (tests[MARGIN], tests[GAP_SIDE], tests[GAP_FLIGHT]) == (of.GAP, 2, 0)


@pytest.mark.parametrize("exciter", EXCITERS)
def test_impacts_alone_tell_how_an_orbit_closes_and_its_multipliers(exciter) -> None:
    _curve, u, state = curve_of(exciter)
    p, m, n = exciter.parameters(), int(state.period_multiple), state.impact_support.size
    e, log = all_effects(p._asdict()), new_log(n, 1)
    start = State(0, 0, 0.0, 0, 0.0, 0.0, FLIGHT, 0.0, None)

    def written(unknowns):
        log_impacts(p, m, state.impact_support.values.astype(np.int8), unknowns, log)
        return closing_residual(e, p, m, log), np.array(orbit_multipliers(e, p, m, log, start))

    closing, found = written(u)
    assert closing < 1e-12
    expected = state.floquet_multiplier.values
    # Trace and determinant: of a double multiplier each half of the digits only.
    assert found.sum() == pytest.approx(expected.sum(), abs=1e-12)
    assert found.prod() == pytest.approx(expected.prod(), abs=1e-12)
    for k in range(2 * n):
        moved = u.copy()
        moved[k] += 1e-6
        assert written(moved)[0] > 1e-8


def test_a_flight_beyond_a_support_has_a_negative_margin() -> None:
    # Closed forms without impacts on support 2 that would pass through it.
    exciter = vp.Exciter(l=0.5, nu=0.5, f=1.0, h=0.1, R1=0.5)
    orbits = one_sided_orbit(exciter, 1, 1)
    orbit = orbits.isel(solution=int(np.flatnonzero(orbits.admissible == 0)[0]))
    problem, _signs = problem_of(exciter, "nu", 2.0 * exciter.nu, (), 0.02)
    curve = ImpactCurve(problem, law_of_impacts(1, 0, [1]), 1.0)
    times = orbit.impact_phase.values + orbit.impact_period.values
    point = curve.settle(np.concatenate([times, orbit.impact_velocity.values, [exciter.nu]]))
    assert is_no_motion(point)
    gap, flight, side, _time = curve.system.margins[of.GAP]
    assert gap < 0
    assert (side, flight) == (2, 0)


def test_doubled_and_halved_are_inverse() -> None:
    for sequence in (law_of_impacts(1, 0, [1, 2]), law_of_impacts(3, 1, [1, 1, 2])):
        n = len(sequence.supports)
        u = np.concatenate([0.1 + 0.2 * np.arange(n), 0.5 + np.arange(n), [2.0]])
        whole, twice, change = doubled(sequence, u, np.ones(2 * n + 1))
        kind = halves_agree(whole, twice, np.ones(twice.size), symmetric=True)
        assert kind == ("pitchfork" if sequence.mirrored else "flip")
        back, mean = halved(whole, twice, kind)
        assert (back.m, back.mirrored) == (sequence.m, sequence.mirrored)
        assert np.array_equal(back.supports, sequence.supports)
        assert mean == pytest.approx(u, abs=1e-15)
        assert not halves_agree(whole, twice + 0.01 * change, np.ones(twice.size), symmetric=True)
