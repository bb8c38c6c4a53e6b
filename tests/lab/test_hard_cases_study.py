"""The study of hard cases: all pass, and a solver that is wrong does not."""

from __future__ import annotations

import itertools
import math
from typing import Any

import pytest

import vibropipe as vp
from vibropipe.lab.hard_cases import CASES, solve_hard_cases
from vibropipe.lab.hard_cases.case import Bound, Case, Solver, evaluate_case, solvers
from vibropipe.words.measurements import Passed
from vibropipe.words.regimes import Regime

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
        if int(case.passed[n]) == Passed.NOT_PASSED
    }
    assert not failed
    assert int(case.passed.sel(solver="exact")) == Passed.PASSED


@pytest.mark.parametrize("name", sorted(LONG))
def test_the_long_cases_are_passed_by_the_exact_method(name: str) -> None:
    assert evaluate_case(BY_NAME[name], Solver("exact")).passed is True


def test_the_dataset_says_what_was_done(found: Any) -> None:
    assert found.sizes == {"case": len(SHORT), "solver": 4}
    assert list(found.solver.values) == ["exact", "newmark 8", "newmark 60", "newmark 2000"]
    assert len({case.name for case in CASES}) == len(CASES)
    assert (
        found.motions.where(found.passed != Passed.NOT_ASKED, 1) + (found.case == "refused") > 0
    ).all()
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
    assert closed.passed.values.tolist() == [Passed.PASSED, *[Passed.NOT_ASKED] * 3]


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
        ("unbounded", lambda ds: ds.assign(regime=ds.regime * 0 + Regime.APERIODIC)),
        ("period_multiples", lambda ds: ds.assign(period_multiple=ds.period_multiple * 2)),
        ("weakly_stable", lambda ds: ds.assign(floquet_multiplier=ds.floquet_multiplier * 0.9999)),
        ("slow_drift", lambda ds: ds.assign(impact_velocity=ds.impact_velocity * 0.9)),
        ("slow_drift", lambda ds: ds.assign(period_multiple=1 + 0 * ds.period_multiple)),
        ("coexisting", lambda ds: ds.assign(regime=ds.regime * 0 + Regime.NO_IMPACT)),
        ("mirrored", lopsided),
        ("split", adrift),
    ],
)
def test_a_wrong_result_is_not_passed(name: str, spoil: Any) -> None:
    assert evaluate_case(BY_NAME[name], Solver("exact")).passed is True
    assert evaluate_case(BY_NAME[name], broken(spoil)).passed is False


@pytest.mark.parametrize("name", ["damping", "extremes", "offset", "slow_force"])
def test_newmark_is_held_to_what_no_method_may_break(name: str) -> None:
    for spoil in (lossless, lambda ds: ds.assign(displacement=ds.displacement * 1.5)):
        found = evaluate_case(BY_NAME[name], broken(spoil, 60))
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
    assert evaluate_case(BY_NAME[name], Solver("newmark", 60)).passed is True
    assert evaluate_case(BY_NAME[name], broken(spoil, 60)).passed is False


@pytest.mark.parametrize("steps", [8, 60])
def test_newmarks_own_balance_of_energy_sees_a_wrong_number(steps: int) -> None:
    def nudged(ds: Any) -> Any:
        x = ds.displacement.values.copy()
        x[20] *= 1 + 1e-6
        return ds.assign(displacement=("tau", x))

    for spoil in (lossless, nudged):
        assert evaluate_case(BY_NAME["energy_of_motions"], broken(spoil, steps)).passed is False


@pytest.mark.parametrize("steps", [None, 60])
def test_a_solver_that_takes_anything_is_not_passed(steps: int | None) -> None:
    def simulate(exciter: Any, **named: Any) -> Any:
        return vp.simulate(vp.Exciter(l=10.0), tau_end=1.0)

    taken = evaluate_case(BY_NAME["refused"], Solver("broken", steps, simulate=simulate))
    assert taken.passed is False
    assert taken.measured == 5


def test_no_number_does_not_pass_and_no_error_escapes() -> None:
    def refused(solver: Solver) -> float:
        solver.motion(vp.Exciter(l=1.0), -1.0)
        return 0.0

    for measure in (lambda solver: math.nan, lambda solver: math.inf, refused):
        case = Case("made", "asked", "known", measure, Bound(1.0, 1.0))
        dataset = solve_hard_cases([case], solvers()[:2])
        assert dataset.passed.values.tolist() == [[Passed.NOT_PASSED] * 2]
