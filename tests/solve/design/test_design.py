"""Designs: targets met, bounds kept, quantities least, each checked by a new march; misses with their reasons."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.lab.bench_items import limit_threads
from vibropipe.solve.design.goals import goals_of
from vibropipe.words.designs import DesignResult
from vibropipe.words.status import UnsolvedWarning

EXCITER = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, R2=0.7)
VARY = {"delta": (-0.3, 0.3), "R1": (0.4, 0.9)}
WANTED = {"displacement_mean": -0.1}


def exciters(designs):
    """The exciters of designs, one after the other."""
    names = [name for name in EXCITER.parameters()._fields if name in designs]
    for number in range(designs.sizes["design"]):
        row = designs.isel(design=number)
        yield vp.Exciter(**{name: float(row[name]) for name in names})


@pytest.fixture(scope="module")
def found():
    return vp.design(
        EXCITER,
        VARY,
        WANTED,
        {"impact_velocity_max_1": "< 0.8"},
        samples=128,
        tolerance={"R1": 0.002},
    )


def test_every_design_is_met_by_a_new_march(found):
    assert (found.design_result == DesignResult.MET).all()
    for exciter, law in zip(exciters(found), found.impacts_per_orbit.values, strict=True):
        orbit = vp.steady_state(exciter)
        assert abs(float(orbit.displacement_mean) + 0.1) < 1e-9
        assert float(orbit.impact_velocity_max.sel(support=1)) < 0.8
        assert bool(orbit.stable)
        assert np.array_equal(orbit.impacts_per_orbit, law)


def test_designs_are_distinct_and_ranked_by_their_yield(found):
    ranks = list(zip(found["yield"].values, found.reliability_index.values, strict=True))
    assert ranks == sorted(ranks, reverse=True)
    places = np.stack([found.delta / 0.6, found.R1 / 0.5], axis=1)
    laws = np.column_stack([found.period_multiple, found.impacts_per_orbit])
    for a in range(len(places)):
        for b in range(a):
            same = (laws[a] == laws[b]).all()
            assert not same or np.abs(places[a] - places[b]).max() >= 0.02


def test_the_law_changes_no_nearer_than_the_margin(found):
    best = found.isel(design=0)
    margin, generator = float(best.law_margin), np.random.default_rng(2)
    for _ in range(20):
        move = generator.standard_normal(2)
        move *= 0.9 * margin / np.linalg.norm(move) * np.array([0.6, 0.5])
        moved = vp.steady_state(
            vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R2=0.7, delta=float(best.delta) + move[0],
                       R1=float(best.R1) + move[1])
        )  # fmt: skip
        assert np.array_equal(moved.impacts_per_orbit, best.impacts_per_orbit)


def test_the_spread_is_that_of_the_design_alone(found):
    alone = vp.tolerance(next(exciters(found)), {"R1": 0.002}, samples=4096)
    best = found.isel(design=0)
    for name in ("displacement_mean_std", "impact_velocity_max_worst", "law_change_share"):
        assert np.allclose(best[name], alone[name], rtol=1e-9)


def test_what_is_wanted_stands_in_the_dataset(found):
    assert float(found.displacement_mean_target) == -0.1
    assert found.impact_velocity_max_upper.values.tolist()[0] == 0.8
    assert np.isnan(found.impact_velocity_max_upper.values[1])
    assert found.attrs["target"] == "displacement_mean = -0.1"
    assert found.attrs["subject_to"] == "impact_velocity_max_1 < 0.8"


def test_the_symmetric_orbit_is_found_in_its_closed_form():
    # The velocity of the orbit (1; 1, 1) is known in closed form.
    exciter = vp.Exciter(l=0.5, nu=1.3, f=1.0, h=0.1, R1=0.7, R2=0.7)
    law = {"impacts_per_period_1": 1, "impacts_per_period_2": 1, "period_multiple": 1}
    found = vp.design(exciter, {"f": (0.5, 1.2)}, {"impact_velocity_max_1": 0.7, **law}, samples=64)
    designed = vp.Exciter(l=0.5, nu=1.3, f=float(found.f[0]), h=0.1, R1=0.7, R2=0.7)
    assert np.abs(vp.symmetric_orbit(designed).impact_velocity - 0.7).min() < 1e-9


def test_a_quantity_is_made_least():
    # The least force with an impact velocity of 0.5 is where the bound is met exactly.
    exciter = vp.Exciter(l=0.5, nu=1.3, h=0.1, R1=0.7, R2=0.7)
    bounds = {"impact_velocity_max_1": "> 0.9", "impacts_per_period_1": (0.5, 1.5)}
    found = vp.design(exciter, {"f": (0.5, 2.0)}, {}, bounds, minimise="f", samples=64)
    best = found.isel(design=0)
    assert float(best.impact_velocity_max.sel(support=1)) == pytest.approx(0.9, rel=1e-7)
    over = vp.sweep(exciter, over={"f": np.linspace(0.5, 2.0, 200)})
    struck = (over.impact_velocity_max.sel(support=1) > 0.9) & (
        over.impacts_per_period.sel(support=1) == 1
    )
    assert float(best.f) <= float(over.f[struck & (over.stable == 1)].min())


@pytest.mark.slow
def test_a_front_is_not_dominated_by_the_samples():
    exciter = vp.Exciter(l=0.5, nu=1.3, f=1.0, h=0.1, R1=0.7, R2=0.7)
    vary = {"delta": (-0.1, 0.1), "f": (0.6, 1.2)}
    bounds = {"impacts_per_period_1": (0.5, 1.5), "impacts_per_period_2": (0.5, 1.5)}
    found = vp.design(
        exciter,
        vary,
        {},
        bounds,
        ("impact_velocity_max_1", "-displacement_amplitude_1"),
        samples=128,
    )
    costs = np.column_stack(
        [found.impact_velocity_max.sel(support=1), -found.displacement_amplitude.sel(harmonic=1)]
    )
    assert len(costs) > 4
    assert (np.diff(costs[:, 0]) > 0).all()
    assert (np.diff(costs[:, 1]) < 0).all()
    over = vp.sweep(exciter, over={name: np.linspace(*ends, 25) for name, ends in vary.items()})
    kept = (over.impacts_per_period == 1).all("support") & (over.stable == 1)
    swept = np.column_stack(
        [
            over.impact_velocity_max.sel(support=1).values[kept],
            -over.displacement_amplitude.sel(harmonic=1).values[kept],
        ]
    )
    # No point of a grid beats the front, drawn as steps, by more than the distance of its neighbours.
    gap = np.abs(np.diff(costs, axis=0)).max(axis=0)
    beaten = (swept[:, None] < costs[None] - gap).all(axis=2)
    assert not beaten.any()


@pytest.mark.slow
def test_no_row_of_a_dense_sweep_dominates_a_front():
    # Slow impacts come with chatter and a rest, large amplitudes with two impacts: between them the laws of motion are
    # narrow, and the front crosses some twenty of them.
    exciter = replace(EXCITER, R1=0.4)
    vary, bounds = {"delta": (-0.3, 0.3), "R2": (0.4, 0.9)}, {"impacts_per_period_1": "> 0.5"}
    least = ("impact_velocity_max_1", "-displacement_amplitude_1")
    found = vp.design(exciter, vary, {}, bounds, least, samples=64)
    over = {"delta": np.linspace(-0.3, 0.3, 121), "R2": np.linspace(0.4, 0.9, 26)}
    swept = vp.sweep(exciter, over=over, outputs=("harmonics", "impacts", "stability"))
    kept = (swept.stable == 1) & (swept.impacts_per_period.sel(support=1) > 0.5)
    speeds, amplitudes = (
        each.values[kept.values]
        for each in (swept.impact_velocity_max.sel(support=1), swept.displacement_amplitude.sel(harmonic=1))
    )  # fmt: skip
    assert found.sizes["design"] == 16
    for design in range(16):
        speed = float(found.impact_velocity_max[design, 0])
        amplitude = float(found.displacement_amplitude[design, 0])
        beats = (speeds <= speed) & (amplitudes >= amplitude)
        gains = np.maximum(1 - speeds / speed, amplitudes / amplitude - 1)[beats]
        assert gains.max(initial=0.0) < 1e-3


@pytest.mark.slow
def test_a_front_has_the_designs_of_narrow_laws():
    # A law with three periods beats by 5.3 % what the grid and what is around its points lead to.
    vary = {"delta": (-0.3, 0.3), "R1": (0.4, 0.9), "R2": (0.4, 0.9)}
    least = ("impact_velocity_max_1", "-impact_velocity_max_2")
    bounds = {"displacement_mean": "< -0.05"}
    found = vp.design(replace(EXCITER, R1=1.0, R2=1.0), vary, {}, bounds, least)
    narrow = vp.steady_state(replace(EXCITER, delta=-0.12, R1=0.9, R2=0.44))
    assert int(narrow.period_multiple) == 3
    assert float(narrow.displacement_mean) < -0.05
    speeds = found.impact_velocity_max.values
    slow, fast = narrow.impact_velocity_max.values
    assert not ((speeds[:, 0] > 1.001 * slow) & (speeds[:, 1] < fast)).any()


def test_the_nearest_miss_has_its_reason():
    with pytest.warns(UnsolvedWarning, match="lies at an end of a range of vary"):
        found = vp.design(
            EXCITER, {"delta": (-0.01, 0.01)}, {"displacement_mean": -0.3}, samples=32
        )
    assert int(found.design_result[0]) == DesignResult.AT_RANGE
    assert float(found.design_miss[0]) > 0.1


def test_conflicting_targets_are_met_in_least_squares():
    exciter = vp.Exciter(l=5.0, nu=0.7, f=0.2, h=0.1)
    gain = 1 / np.hypot(1 - 0.49, 0.07)
    wanted = {"displacement_amplitude_1": 0.5, "velocity_amplitude_1": 0.5}
    with pytest.warns(UnsolvedWarning, match="0.57.*, by 0.07.*what is wanted may conflict"):
        found = vp.design(exciter, {"f": (0.05, 1.0)}, wanted, samples=32)
    # Amplitudes a and 0.7 a that miss 0.5 and 0.5 least in squares.
    assert float(found.f[0]) * gain == pytest.approx(0.5 * 1.7 / 1.49, rel=1e-6)


def test_the_same_bits_on_one_thread():
    given = {"minimise": "f", "subject_to": {"f": "< 0"}, "samples": 32}
    with limit_threads(1):
        alone = vp.design(EXCITER, {"delta": (-0.3, 0.3)}, **given)
    assert alone.identical(vp.design(EXCITER, {"delta": (-0.3, 0.3)}, **given))


def test_the_spread_of_a_quantity_is_made_least():
    sigma = {"delta": 0.001, "R1": 0.001}
    arguments = {"vary": {"delta": (-0.02, 0.02)}, "tolerance": sigma, "samples": 16, "designs": 2}
    law = {"impacts_per_period_1": 1, "impacts_per_period_2": 1, "period_multiple": 1}
    found = vp.design(EXCITER, target=law, minimise="displacement_mean_std", **arguments)
    least = float(found.displacement_mean_std.sel(estimate="first_order")[0])
    for delta in np.linspace(-0.02, 0.02, 9):
        other = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, R2=0.7, delta=delta)
        if (vp.steady_state(other).impacts_per_orbit == 1).all():
            spread = vp.tolerance(other, sigma, samples=16)
            assert float(spread.displacement_mean_std.sel(estimate="first_order")) >= least * (
                1 - 1e-6
            )


def test_a_sensitivity_is_made_zero():
    name = "displacement_amplitude_sensitivity_1_nu"
    exciter = vp.Exciter(l=5.0, nu=1.0, f=0.2, h=0.1)
    found = vp.design(exciter, {"nu": (0.8, 1.2)}, {name: 0.0}, samples=16)
    # The linear motion has its largest amplitude where nu^2 = 1 - h^2 / 2.
    assert float(found.nu[0]) == pytest.approx(np.sqrt(1 - 0.005), rel=1e-8)


@pytest.mark.slow
def test_progress_reaches_its_total():
    heard = []
    vp.design(
        EXCITER, VARY, WANTED, samples=64, designs=1, progress=lambda *each: heard.append(each)
    )
    assert heard[-1][0] == heard[-1][1]
    assert [done for done, _ in heard] == sorted(done for done, _ in heard)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"target": {"displacment_mean": 0}}, "target: must be a quantity .*did you mean"),
        ({"target": {"displacement_mean": "-0.8 mm"}}, "target.displacement_mean: must be a finite number"),
        ({"target": {"impact_velocity_max_1": -1}}, "target.impact_velocity_max_1: must be >= 0"),
        ({"subject_to": {"impact_velocity_max_1": "0.8"}}, "must be a bound such as"),
        ({"subject_to": {"impact_velocity_max_1": "> 0.8, < 0.1"}}, "lower bound below the upper"),
        ({"target": WANTED, "subject_to": {"displacement_mean": "> 0"}},
         "must agree with target.displacement_mean"),
        ({"minimise": ("f", "h", "nu")}, "minimise: must be one quantity or two"),
        ({"target": {"displacement": [[0, 0.1]]}, "minimise": "f"}, "minimise: must be left out"),
        ({"target": {"displacement": [0, 0.1]}}, "target.displacement: must be a table"),
        ({"minimise": "impacts_per_period_1"}, "must depend continuously on the parameters"),
        ({"minimise": "displacement_mean_std"}, "tolerance: is required"),
        ({}, "must have a target, a bound or a quantity to minimise"),
    ],
)  # fmt: skip
def test_wrong_goals_are_refused(arguments, message):
    with pytest.raises(vp.ParameterError, match=message):
        vp.design(EXCITER, VARY, **arguments)


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        ({}, "vary: must have at least one parameter"),
        ({"mass": (0, 1)}, "vary: must have keys among nu, f, h"),
        ({"R1": (0.4, 1.2)}, "vary.R1: must be within its range, a number from 0 to 1"),
        ({"R1": (0.9, 0.4)}, "vary.R1: must be a pair of increasing numbers"),
        ({"R1": 0.5}, "vary.R1: must be a pair of increasing numbers"),
    ],
)
def test_wrong_ranges_are_refused(vary, message):
    with pytest.raises(vp.ParameterError, match=message):
        vp.design(EXCITER, vary, WANTED)


def test_no_motion_with_the_quantity_is_an_error():
    quiet = vp.Exciter(l=5.0, nu=0.7, f=0.2, h=0.1)
    with pytest.raises(vp.ParameterError, match="a stable orbit with impact_velocity_max_1"):
        vp.design(quiet, {"f": (0.1, 0.3)}, {"impact_velocity_max_1": 1.0}, samples=16)


def test_no_warning_where_designs_are_met():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        vp.design(EXCITER, VARY, {"impacts_per_period_1": 2}, samples=16, designs=1)


SOFT = vp.Exciter(l=0.5, nu=0.8, f=0.9, h=0.1, k1=200.0, k2=200.0, h1=3.0, h2=3.0)


def test_the_force_of_a_soft_support_is_a_target_and_a_bound():
    vary = {"f": (0.7, 1.1), "k1": (100.0, 300.0)}
    bounds = {"support_force_max_2": "< 11", "contact_duration_max_1": "> 0.1"}
    found = vp.design(SOFT, vary, {"support_force_max_1": 10.0}, bounds, samples=32, designs=2)
    assert (found.design_result == DesignResult.MET).all()
    assert found.support_force_max.sel(support=1).values == pytest.approx(10.0, rel=1e-9)
    assert (found.support_force_max.sel(support=2) < 11.0).all()
    assert found.support_force_max_target.values.tolist()[0] == 10.0
    best = found.isel(design=0)
    exciter = replace(SOFT, f=float(best.f), k1=float(best.k1))
    marched = vp.steady_state(exciter, outputs=("impacts",)).support_force_max
    assert best.support_force_max.values == pytest.approx(marched.values, rel=1e-9)


def test_the_least_force_lies_at_the_end_of_the_range():
    vary = {"k1": (100.0, 300.0)}
    found = vp.design(SOFT, vary, minimise="support_force_max_1", samples=16, designs=1)
    assert float(found.k1[0]) == pytest.approx(100.0)


def test_a_design_at_an_end_of_its_range_is_that_end():
    exciter = vp.Exciter(l=0.5, nu=1.3, f=0.5, h=0.1, R1=0.7, R2=0.7)
    with pytest.warns(UnsolvedWarning):
        found = vp.design(exciter, {"delta": (0, 0.1)}, {"impact_velocity_max_1": 0.75}, samples=32)
    assert found.design_result.values.tolist() == [DesignResult.AT_RANGE]
    assert found.delta.values.tolist() == [0.0]


def test_the_force_of_a_rigid_support_is_refused():
    with pytest.raises(vp.ParameterError, match="k2: must be above 0, since support_force_max_2"):
        vp.design(replace(SOFT, k2=0.0, h2=0.0), {"f": (0.7, 1.1)}, {"support_force_max_2": 10.0})


def test_a_bound_keeps_the_digits_that_a_unit_needs():
    velocity = 0.8 / math.sqrt(4000)
    goals = goals_of(None, {"impact_velocity_max_1": f"< {velocity!r}"}, None, None)
    name, sign, number = goals.texts["subject_to"].split()
    assert (name, sign) == ("impact_velocity_max_1", "<")
    assert f"{float(number) * math.sqrt(4000):g}" == "0.8"


def test_a_motion_that_never_strikes_keeps_a_bound_of_its_velocity() -> None:
    exciter = vp.Exciter(l=1.0, nu=0.5, f=0.3, h=0.1, R1=0.7, R2=0.7)
    found = vp.design(
        exciter, vary={"f": (0.1, 0.6)}, target={"displacement_amplitude_1": 0.5},
        subject_to={"impact_velocity_max_1": "< 0.8"}, samples=64,
    )  # fmt: skip
    # the linear motion: 0.5 sqrt((1 - nu^2)^2 + h^2 nu^2)
    assert float(found.f[0]) == pytest.approx(0.5 * np.hypot(0.75, 0.05), rel=1e-9)
    assert np.isnan(found.impact_velocity_max.values[0]).all()
    assert found.design_miss.values[0] <= 1e-9
