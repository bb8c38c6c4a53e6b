"""The study of hard cases: all pass, and a solver that is wrong does not."""

from __future__ import annotations

import itertools
import math
from typing import Any

import mpmath
import numpy as np
import pytest
from oracles import Flight, Parameters, Twin, digits

import vibropipe as vp
from vibropipe.batch.hard_cases import CASES, solve_hard_cases
from vibropipe.batch.hard_cases.case import Bound, Case, Solver, judge, solvers
from vibropipe.batch.hard_cases.chatter import FALL, PRESSED, chatter_series
from vibropipe.batch.hard_cases.known import first_peak, flight_error, linear, transfer
from vibropipe.batch.hard_cases.patience import WINDOW, multiple_of

BY_NAME = {case.name: case for case in CASES}
LONG = {"ideal_free", "ideal_marched", "million_periods"}
SHORT = [case for case in CASES if case.name not in LONG]


@pytest.fixture(scope="module")
def found() -> Any:
    return solve_hard_cases(SHORT)


@pytest.mark.parametrize("name", [case.name for case in SHORT])
def test_each_case_is_passed_by_every_solver(found: Any, name: str) -> None:
    case = found.sel(case=name)
    failed = {
        str(solver): (float(case.measured[n]), float(case.bound[n]))
        for n, solver in enumerate(case.solver.values)
        if int(case.passed[n]) == 0
    }
    assert not failed
    assert int(case.passed.sel(solver="exact")) == 1


@pytest.mark.parametrize("name", sorted(LONG))
def test_the_long_cases_are_passed_by_the_exact_method(name: str) -> None:
    assert judge(BY_NAME[name], Solver("exact")).passed is True


def test_the_dataset_says_what_was_done(found: Any) -> None:
    assert found.sizes == {"case": len(SHORT), "solver": 4}
    assert list(found.solver.values) == ["exact", "newmark 8", "newmark 60", "newmark 2000"]
    assert len({case.name for case in CASES}) == len(CASES)
    assert (found.motions.where(found.passed != 2, 1) + (found.case == "refused") > 0).all()
    assert found.impacts.sel(case="chatter_complete", solver="exact") > 500
    # a flight shorter than a step is counted and named, not hidden
    coarse = found.sel(case="supports_together", solver="newmark 8")
    assert int(coarse.short_flight_motions) == 4
    assert (
        int(coarse.worst_status)
        == vp.simulate(
            vp.Exciter(l=1e-6, f=1e-300), tau_end=1e-3, v0=1.0, method="newmark", steps_per_period=8
        ).status
    )
    closed = found.sel(case="energy_of_orbits")
    assert closed.passed.values.tolist() == [1, 2, 2, 2]


# -- a solver that is wrong --------------------------------------------------------------------


def late(ds: Any) -> Any:
    """Impacts a little late."""
    return ds.assign(impact_tau=ds.impact_tau * (1 + 1e-9))


def lossless(ds: Any) -> Any:
    """A reset that keeps the velocity."""
    return ds.assign(impact_velocity_after=-ds.impact_velocity)


def deaf(ds: Any) -> Any:
    """No impact is ever seen."""
    return ds.isel(impact=slice(0))


def restless(ds: Any) -> Any:
    """No rest is ever seen."""
    return ds.isel(rest=slice(0))


def adrift(ds: Any) -> Any:
    """The end is a little off."""
    return ds.assign(displacement_end=ds.displacement_end * (1 + 1e-9) + 1e-9)


def lopsided(ds: Any) -> Any:
    """The first support is a little softer than the second."""
    after = ds.impact_velocity_after
    return ds.assign(impact_velocity_after=after.where(ds.impact_support == 1, after * (1 + 1e-15)))


def later(spoil: Any) -> Any:
    """Spoils each motion more than the one before."""
    number = itertools.count(1)
    return lambda ds: spoil(1 + 1e-4 * next(number), ds)


def broken(spoil: Any, steps: int | None = None) -> Solver:
    def simulate(*given: Any, **named: Any) -> Any:
        return spoil(vp.simulate(*given, **named))

    def steady_state(*given: Any, **named: Any) -> Any:
        return spoil(vp.steady_state(*given, **named))

    return Solver("broken", steps, simulate=simulate, steady_state=steady_state)


@pytest.mark.parametrize(
    ("name", "spoil"),
    [
        ("grazing_free", deaf),
        ("grazing_forced", deaf),
        ("chatter_complete", restless),
        ("chatter_cut", late),
        ("chatter_released", restless),
        ("chatter_interrupted", late),
        ("chatter_interrupted", lossless),
        ("chatter_interrupted", deaf),
        ("plastic", lossless),
        ("plastic_for_ever", restless),
        ("start_on_support", restless),
        ("start_on_support", deaf),
        ("end_on_impact", deaf),
        ("supports_together", late),
        ("impact_at_release", deaf),
        ("growth_resonance", adrift),
        ("growth_impacts", deaf),
        ("near_resonance", adrift),
        ("near_critical", adrift),
        ("damping", late),
        ("extremes", adrift),
        ("slow_force", lossless),
        ("offset", lossless),
        ("scale_of_length", adrift),
        ("energy_of_motions", late),
        ("energy_of_motions", lossless),
        ("energy_of_orbits", lambda ds: ds.assign(energy_residual=ds.energy_residual + 1e-9)),
        ("unbounded", lambda ds: ds.assign(regime=ds.regime * 0 + 5)),
        ("period_multiples", lambda ds: ds.assign(period_multiple=ds.period_multiple * 2)),
        ("weakly_stable", lambda ds: ds.assign(floquet_multiplier=ds.floquet_multiplier * 0.9999)),
        ("slow_drift", lambda ds: ds.assign(impact_velocity=ds.impact_velocity * 0.9)),
        ("slow_drift", lambda ds: ds.assign(period_multiple=1 + 0 * ds.period_multiple)),
        ("coexisting", lambda ds: ds.assign(regime=ds.regime * 0)),
        ("mirrored", lopsided),
        ("split", adrift),
    ],
)
def test_a_wrong_result_is_not_passed(name: str, spoil: Any) -> None:
    assert judge(BY_NAME[name], Solver("exact")).passed is True
    assert judge(BY_NAME[name], broken(spoil)).passed is False


@pytest.mark.parametrize("name", ["damping", "extremes", "offset", "slow_force"])
def test_newmark_is_held_to_what_no_method_may_break(name: str) -> None:
    for spoil in (lossless, lambda ds: ds.assign(displacement=ds.displacement * 1.5)):
        found = judge(BY_NAME[name], broken(spoil, 60))
        assert found.measured >= 1
        assert found.passed is False


@pytest.mark.parametrize(
    ("name", "spoil"),
    [
        ("unbounded", lambda ds: ds.assign(displacement_end=0.1 * ds.displacement_end)),
        ("period_multiples", deaf),
        ("period_multiples", lambda ds: ds.assign(displacement_end=0 * ds.displacement_end)),
        ("weakly_stable", lambda ds: ds.map(lambda values: values * (1 + 1e-4))),
        ("slow_drift", deaf),
        ("slow_drift", later(lambda n, ds: ds.assign(impact_velocity=n * ds.impact_velocity))),
        ("coexisting", deaf),
    ],
)
def test_newmarks_labels_see_a_wrong_motion(name: str, spoil: Any) -> None:
    assert judge(BY_NAME[name], Solver("newmark", 60)).passed is True
    assert judge(BY_NAME[name], broken(spoil, 60)).passed is False


@pytest.mark.parametrize("steps", [8, 60])
def test_newmarks_own_balance_of_energy_sees_a_wrong_number(steps: int) -> None:
    def nudged(ds: Any) -> Any:
        x = ds.displacement.values.copy()
        x[20] *= 1 + 1e-6
        return ds.assign(displacement=("tau", x))

    for spoil in (lossless, nudged):
        assert judge(BY_NAME["energy_of_motions"], broken(spoil, steps)).passed is False


@pytest.mark.parametrize("steps", [None, 60])
def test_a_solver_that_takes_anything_is_not_passed(steps: int | None) -> None:
    def simulate(exciter: Any, **named: Any) -> Any:
        return vp.simulate(vp.Exciter(l=10.0), tau_end=1.0)

    taken = judge(BY_NAME["refused"], Solver("broken", steps, simulate=simulate))
    assert taken.passed is False
    assert taken.measured == 5


def test_no_number_does_not_pass_and_no_error_escapes() -> None:
    def refused(solver: Solver) -> float:
        solver.motion(vp.Exciter(l=1.0), -1.0)
        return 0.0

    for measure in (lambda solver: math.nan, lambda solver: math.inf, refused):
        case = Case("made", "asked", "known", measure, Bound(1.0, 1.0))
        dataset = solve_hard_cases([case], solvers()[:2])
        assert dataset.passed.values.tolist() == [[0, 0]]


# -- what is known, against arbitrary precision ------------------------------------------------


@pytest.mark.parametrize("h", [0.0, 1e-12, 0.2, 2.0, 50.0])
@pytest.mark.parametrize("nu", [0.7, 1.0, 1.0 + 1e-9])
def test_the_matrix_exponential_is_the_closed_form(nu: float, h: float) -> None:
    p = Parameters(nu=nu, f=0.8, h=h, l=1e9)
    c = digits(p, 110)
    zero = c.mpf(0)
    at = c.mpf(2 * math.pi * 3 / nu)
    known = Flight(c, c.mpf(nu), c.mpf(p.f), c.mpf(h), (zero, zero, zero))(at)
    got = linear(vp.Exciter(**p._asdict()), 3, None)
    size = max(abs(float(part)) for part in known)
    np.testing.assert_allclose(got, [float(part) for part in known], rtol=0, atol=2e-14 * size)


def test_the_series_of_a_chatter_is_the_twins() -> None:
    p = Parameters(**PRESSED, R1=0.8)
    impacts = Twin(p, digits(p)).run(9.0, FALL, 0.0).impacts
    assert len(impacts) > 8
    for n, impact in enumerate(impacts[:9]):
        tau, speed = chatter_series(0.8, n)
        assert tau == pytest.approx(float(impact.tau), rel=1e-14)
        assert speed == pytest.approx(abs(float(impact.after)), rel=1e-14)


def test_a_peak_is_where_the_velocity_turns() -> None:
    tau, height = first_peak(vp.Exciter(l=1.0), None, v0=1.3)
    assert tau == pytest.approx(math.pi / 2, abs=1e-14)
    assert height == pytest.approx(1.3, abs=1e-14)
    # one step of constant average acceleration: a = -(dt v/2)/(1 + dt^2/4), x = v^2/(-2a)
    dt = 2 * math.pi / 3
    pull = -(dt / 2) / (1 + dt * dt / 4)
    assert first_peak(vp.Exciter(l=1.0), 3, v0=1.0)[1] == pytest.approx(-0.5 / pull, abs=1e-14)


def test_newmarks_own_steady_motion_answers_the_force_as_its_powers_do() -> None:
    p = vp.Exciter(l=9.0, nu=1.3, f=0.7, h=0.4)
    x, _v = linear(p, 40, 12)
    assert x == pytest.approx(transfer(p, 12).imag, abs=1e-13)
    exact = mpmath.mpc(1 - mpmath.mpf(1.3) ** 2, mpmath.mpf(1.3) * mpmath.mpf(0.4))
    assert transfer(p, None) == pytest.approx(complex(0.7 / exact), abs=1e-15)


def test_a_flight_through_a_support_is_seen() -> None:
    p = vp.Exciter(l=0.5, R1=0.5, R2=0.5)
    ds = vp.simulate(p, tau_end=2.0, v0=1.0, samples_per_period=0)
    assert flight_error(p, ds, 2.0, 0.0, 1.0) < 1e-14
    unseen = ds.isel(impact=slice(0)).assign(
        displacement_end=math.sin(2.0), velocity_end=math.cos(2.0)
    )
    assert flight_error(p, unseen, 2.0, 0.0, 1.0) > 0.3


def test_an_impact_on_the_end_of_a_step_keeps_its_rebound() -> None:
    """nu = 2 and a support at the equilibrium: every impact falls on the end of a forcing period."""
    p = vp.Exciter(l=50.0, delta=50.0, nu=2.0, f=1.0)
    for v0 in (0.1, 0.2, 0.3, 1.0):
        ds = vp.simulate(p, tau_end=20.0, v0=v0, samples_per_period=0)
        known = -(v0 + 4 / 3 * np.arange(1, 7))
        np.testing.assert_allclose(ds.impact_velocity.values, known, rtol=1e-12)


# -- what repeats -------------------------------------------------------------------------------


def sections(of: Any) -> np.ndarray:
    """Sections (x, v) at the periods of a window from a complex number for each."""
    at = np.array([of(n) for n in range(WINDOW + 1)], complex)
    return np.column_stack([at.real, at.imag])


@pytest.mark.parametrize("m", [1, 2, 3, 8, 32])
def test_what_has_arrived_repeats_after_its_least_multiple(m: int) -> None:
    turn = np.exp(2j * math.pi / m)
    assert multiple_of(sections(lambda n: 2 + turn**n), 3.0) == m
    # still on its way, by 1e-8 in all
    assert multiple_of(sections(lambda n: 2 + turn**n + 1e-8 * 0.99**n), 3.0) == m
    # in a spiral of three periods a turn, nearly
    assert (
        multiple_of(sections(lambda n: 2 + turn**n + 1e-7 * (0.99 * np.exp(2.1j)) ** n), 3.0) == m
    )


def test_what_has_far_to_go_does_not_repeat() -> None:
    for rate in (0.9, 0.999, 0.999999):
        start = 1e-3 / rate**WINDOW
        assert multiple_of(sections(lambda n, r=rate, s=start: 1 + s * r**n), 1.0) == 0
    # a change of 1e-8 a period, for ever
    assert multiple_of(sections(lambda n: 1 + 1e-8 * n), 1.0) == 0
    assert multiple_of(sections(lambda n: np.exp(1j * n)), 1.0) == 0
    assert multiple_of(sections(lambda n: np.exp(2j * math.pi / 33 * n)), 1.0) == 0
