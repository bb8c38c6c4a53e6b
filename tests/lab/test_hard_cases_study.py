"""Study of hard cases: correct solvers pass every case, wrong ones do not."""

import itertools
import math
from typing import Any

import pytest

import vibropipe as vp
from vibropipe.lab.hard_cases import CASES, solve_hard_cases
from vibropipe.lab.hard_cases.case import Bound, Case, Solver, evaluate_case, solvers
from vibropipe.lab.hard_cases.cases import GROUPS, YES_OR_NO
from vibropipe.words.measurements import Passed
from vibropipe.words.regimes import Regime

BY_NAME = {case.name: case for case in CASES}
LONG = {"ideal_free", "ideal_marched", "million_periods"}
SHORT = [case for case in CASES if case.name not in LONG]


@pytest.fixture(scope="module")
def results() -> Any:
    return solve_hard_cases(SHORT)


@pytest.mark.parametrize("name", [case.name for case in SHORT])
def test_each_case_is_passed_by_every_solver(results: Any, name: str) -> None:
    case = results.sel(case=name)
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


def test_every_case_is_in_one_group_and_has_a_reason_for_its_bound() -> None:
    listed = [name for group in GROUPS for name in group.reasons]
    assert sorted(listed) == sorted(case.name for case in CASES)
    for group in GROUPS:
        assert group.known
        for name, reason in group.reasons.items():
            assert reason
            assert (reason == YES_OR_NO) == (BY_NAME[name].bound.exact == 0.0)


def test_a_motion_that_is_solved_twice_is_counted_once() -> None:
    def measure(solver: Solver) -> float:
        for tau_end in (1.0, 1.0, 2.0):
            solver.motion(vp.Exciter(l=1.0), tau_end)
        solver.solve_steady(vp.Exciter(l=1.0, nu=1.0, f=0.1, h=0.1))
        return 0.0

    twice = [Case(name, "", "", measure, Bound(0.0, 0.0)) for name in ("one", "two")]
    dataset = solve_hard_cases(twice, solvers()[:1])
    assert dataset.motions.values.tolist() == [[3], [3]]
    assert dataset.attrs["distinct_motions"] == 3


def test_the_dataset_reports_the_effort(results: Any) -> None:
    assert results.sizes == {"case": len(SHORT), "solver": 4, "group": len(GROUPS)}
    assert results.group.values.tolist() == [group.title for group in GROUPS]
    assert list(results.solver.values) == ["exact", "newmark 8", "newmark 60", "newmark 2000"]
    assert len({case.name for case in CASES}) == len(CASES)
    assert (
        results.motions.where(results.passed != Passed.NOT_ASKED, 1) + (results.case == "refused")
        > 0
    ).all()
    assert results.impacts.sel(case="chatter_complete", solver="exact") > 500
    # flights shorter than a step are counted and reported
    coarse = results.sel(case="supports_together", solver="newmark 8")
    assert int(coarse.short_flight_motions) == 4
    assert (
        int(coarse.worst_status)
        == vp.simulate(
            vp.Exciter(l=1e-6, nu=1.0, f=1e-300),
            tau_end=1e-3,
            v0=1.0,
            method="newmark",
            steps_per_period=8,
        ).status
    )
    closed = results.sel(case="energy_of_orbits")
    assert closed.passed.values.tolist() == [Passed.PASSED, *[Passed.NOT_ASKED] * 3]


# -- wrong solvers -----------------------------------------------------------------------------


def with_late_impacts(ds: Any) -> Any:
    """Delay impacts slightly."""
    return ds.assign(impact_tau=ds.impact_tau * (1 + 1e-9))


def with_lossless_resets(ds: Any) -> Any:
    """Reset the velocity without loss."""
    return ds.assign(impact_velocity_after=-ds.impact_velocity)


def without_impacts(ds: Any) -> Any:
    """Remove all impacts."""
    return ds.isel(impact=slice(0))


def without_rests(ds: Any) -> Any:
    """Remove all rests."""
    return ds.isel(rest=slice(0))


def with_shifted_end(ds: Any) -> Any:
    """Shift the end slightly."""
    return ds.assign(displacement_end=ds.displacement_end * (1 + 1e-9) + 1e-9)


def with_unequal_supports(ds: Any) -> Any:
    """Increase the restitution of support 1 slightly."""
    after = ds.impact_velocity_after
    return ds.assign(impact_velocity_after=after.where(ds.impact_support == 1, after * (1 + 1e-15)))


def increasingly(corrupt: Any) -> Any:
    """Change each motion more than the previous one."""
    number = itertools.count(1)
    return lambda ds: corrupt(1 + 1e-4 * next(number), ds)


def corrupt_solver(corrupt: Any, steps: int | None = None) -> Solver:
    def simulate(*arguments: Any, **options: Any) -> Any:
        return corrupt(vp.simulate(*arguments, **options))

    def steady_state(*arguments: Any, **options: Any) -> Any:
        return corrupt(vp.steady_state(*arguments, **options))

    return Solver("broken", steps, simulate=simulate, steady_state=steady_state)


@pytest.mark.parametrize(
    ("name", "corrupt"),
    [
        ("grazing_free", without_impacts),
        ("grazing_forced", without_impacts),
        ("chatter_complete", without_rests),
        ("chatter_cut", with_late_impacts),
        ("chatter_released", without_rests),
        ("chatter_interrupted", with_late_impacts),
        ("chatter_interrupted", with_lossless_resets),
        ("chatter_interrupted", without_impacts),
        ("plastic", with_lossless_resets),
        ("plastic_for_ever", without_rests),
        ("start_on_support", without_rests),
        ("start_on_support", without_impacts),
        ("end_on_impact", without_impacts),
        ("supports_together", with_late_impacts),
        ("impact_at_release", without_impacts),
        ("growth_resonance", with_shifted_end),
        ("growth_impacts", without_impacts),
        ("near_resonance", with_shifted_end),
        ("near_critical", with_shifted_end),
        ("damping", with_late_impacts),
        ("extremes", with_shifted_end),
        ("slow_force", with_lossless_resets),
        ("offset", with_lossless_resets),
        ("scale_of_length", with_shifted_end),
        ("energy_of_motions", with_late_impacts),
        ("energy_of_motions", with_lossless_resets),
        ("energy_of_orbits", lambda ds: ds.assign(energy_residual=ds.energy_residual + 1e-9)),
        ("unbounded", lambda ds: ds.assign(regime=ds.regime * 0 + Regime.APERIODIC)),
        ("period_multiples", lambda ds: ds.assign(period_multiple=ds.period_multiple * 2)),
        ("weakly_stable", lambda ds: ds.assign(floquet_multiplier=ds.floquet_multiplier * 0.9999)),
        ("slow_drift", lambda ds: ds.assign(impact_velocity=ds.impact_velocity * 0.9)),
        ("slow_drift", lambda ds: ds.assign(period_multiple=1 + 0 * ds.period_multiple)),
        ("coexisting", lambda ds: ds.assign(regime=ds.regime * 0 + Regime.NO_IMPACT)),
        ("mirrored", with_unequal_supports),
        ("split", with_shifted_end),
    ],
)
def test_a_wrong_result_is_not_passed(name: str, corrupt: Any) -> None:
    assert evaluate_case(BY_NAME[name], Solver("exact")).passed is True
    assert evaluate_case(BY_NAME[name], corrupt_solver(corrupt)).passed is False


@pytest.mark.parametrize("name", ["damping", "extremes", "offset", "slow_force"])
def test_newmark_must_keep_the_invariants_of_any_method(name: str) -> None:
    for corrupt in (with_lossless_resets, lambda ds: ds.assign(displacement=ds.displacement * 1.5)):
        result = evaluate_case(BY_NAME[name], corrupt_solver(corrupt, 60))
        assert result.measured >= 1
        assert result.passed is False


@pytest.mark.parametrize(
    ("name", "corrupt"),
    [
        ("unbounded", lambda ds: ds.assign(displacement_end=0.1 * ds.displacement_end)),
        ("period_multiples", without_impacts),
        ("period_multiples", lambda ds: ds.assign(displacement_end=0 * ds.displacement_end)),
        ("weakly_stable", lambda ds: ds.map(lambda values: values * (1 + 1e-4))),
        ("slow_drift", without_impacts),
        (
            "slow_drift",
            increasingly(lambda n, ds: ds.assign(impact_velocity=n * ds.impact_velocity)),
        ),
        ("coexisting", without_impacts),
    ],
)
def test_labels_of_newmark_detect_a_wrong_motion(name: str, corrupt: Any) -> None:
    assert evaluate_case(BY_NAME[name], Solver("newmark", 60)).passed is True
    assert evaluate_case(BY_NAME[name], corrupt_solver(corrupt, 60)).passed is False


@pytest.mark.parametrize("steps", [8, 60])
def test_the_energy_balance_of_newmark_detects_a_wrong_value(steps: int) -> None:
    def perturb(ds: Any) -> Any:
        x = ds.displacement.values.copy()
        x[20] *= 1 + 1e-6
        return ds.assign(displacement=("tau", x))

    for corrupt in (with_lossless_resets, perturb):
        assert (
            evaluate_case(BY_NAME["energy_of_motions"], corrupt_solver(corrupt, steps)).passed
            is False
        )


@pytest.mark.parametrize("steps", [None, 60])
def test_a_solver_that_accepts_any_input_does_not_pass(steps: int | None) -> None:
    def simulate(exciter: Any, **options: Any) -> Any:
        return vp.simulate(vp.Exciter(l=10.0), tau_end=1.0)

    result = evaluate_case(BY_NAME["refused"], Solver("broken", steps, simulate=simulate))
    assert result.passed is False
    assert result.measured == 5


def test_nan_and_errors_do_not_pass() -> None:
    def rejected(solver: Solver) -> float:
        solver.motion(vp.Exciter(l=1.0), -1.0)
        return 0.0

    for measure in (lambda solver: math.nan, lambda solver: math.inf, rejected):
        case = Case("made", "asked", "known", measure, Bound(1.0, 1.0))
        dataset = solve_hard_cases([case], solvers()[:2])
        assert dataset.passed.values.tolist() == [[Passed.NOT_PASSED] * 2]
