"""Designs and tolerances with soft supports, friction, two harmonics or a housing, and what settles from rest."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.solve.branch.from_rest import reached_from_rest
from vibropipe.solve.rows import points
from vibropipe.words.designs import DesignResult
from vibropipe.words.quantities import FLAGS

SOFT = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, delta=0.02, k2=200.0, h2=3.0, friction=0.1)
TWO = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, R2=0.7, f2=0.4, phi2=0.7)
QUANTITY = "displacement_mean"


def slope_of(exciter: vp.Exciter, name: str) -> float:
    """Return the derivative of the mean displacement by differences of fourth order."""
    step = 1e-3 * max(abs(getattr(exciter, name)), 0.05)
    values = [
        float(vp.steady_state(replace(exciter, **{name: getattr(exciter, name) + n * step})).displacement_mean)
        for n in (-2, -1, 1, 2)
    ]  # fmt: skip
    return (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * step)


@pytest.mark.parametrize(
    ("exciter", "names"), [(SOFT, ("f", "k2", "h2", "friction")), (TWO, ("nu", "f2", "phi2"))]
)
def test_slopes_are_those_of_neighbours(exciter: vp.Exciter, names: tuple[str, ...]) -> None:
    ds = vp.tolerance(
        exciter, {name: 1e-3 * abs(getattr(exciter, name)) for name in names}, samples=64
    )
    assert float(ds.law_change_share) == 0.0
    for name in names:
        slope = float(ds[f"{QUANTITY}_sensitivity"].sel(parameter=name))
        assert slope == pytest.approx(slope_of(exciter, name), rel=1e-4, abs=1e-7)


def test_friction_and_stiffness_are_designed() -> None:
    target = float(vp.steady_state(replace(SOFT, friction=0.13, k2=260.0)).displacement_mean)
    ds = vp.design(
        SOFT, {"k2": (100.0, 400.0), "friction": (0.05, 0.2)}, {QUANTITY: target},
        samples=64, designs=2,
    )  # fmt: skip
    assert float(ds.design_miss[0]) < 1e-3
    best = {name: float(ds[name][0]) for name in ("k2", "friction")}
    found = float(vp.steady_state(replace(SOFT, **best)).displacement_mean)
    assert found == pytest.approx(float(ds[QUANTITY][0]), abs=1e-12)
    assert found == pytest.approx(target, rel=0.02)


def test_the_loss_by_friction_is_a_target() -> None:
    exciter = replace(SOFT, friction=0.0)
    name = "energy_friction"
    ds = vp.design(exciter, {"friction": (0.0, 0.2)}, {name: 0.1}, samples=64, designs=1)
    found = replace(exciter, friction=float(ds.friction[0]))
    assert float(vp.steady_state(found)[name]) == pytest.approx(0.1, rel=1e-6)
    assert float(ds[f"{name}_target"]) == 0.1


def test_a_support_does_not_turn_rigid() -> None:
    with pytest.raises(vp.ParameterError, match=r"vary.k2: must be above 0 .*, got 0.0"):
        vp.design(SOFT, {"k2": (0.0, 400.0)}, {QUANTITY: 0.0})
    with pytest.raises(vp.ParameterError, match="k1: must be above 0 where k1 or h1 vary"):
        vp.tolerance(SOFT, {"h1": 0.1})


def test_a_search_among_motions_that_take_too_many_steps_ends_in_words(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(points, "LONG_MARCHES", 4)
    monkeypatch.setattr(points, "START_WORK", 10_000)
    exciter = vp.Exciter(l=0.5, nu=2.5, f=1.0, h=0.1, k1=5e4, h1=7e-8, k2=1e-6, h2=1e9)
    with pytest.raises(
        vp.ParameterError, match=r"vary: must leave motions that are settled sooner"
    ):
        vp.design(exciter, {"delta": (-0.3, 0.3), "f": (0.5, 2.0)}, {QUANTITY: 0.1}, samples=16)


STRUCK = vp.Exciter(
    nu=1.02, f=0.882, h=0.403, l=1.0, delta=-0.19, R1=0.3, R2=0.55, mass_ratio=0.585,
    housing_friction_1=0.292, housing_friction_2=0.438,
)  # fmt: skip


def test_a_wanted_progression_is_met_by_the_motion_from_the_start():
    ranges = {"housing_friction_2": (0.3, 0.6), "delta": (-0.25, -0.15)}
    found = vp.design(
        STRUCK, ranges, {"housing_velocity_mean": 0.08}, {"impact_velocity_max_1": "< 1"},
        samples=32, designs=3,
    )  # fmt: skip
    assert (found.design_result == DesignResult.MET).all()
    best = found.isel(design=0)
    exciter = replace(STRUCK, **{name: float(best[name]) for name in ranges})
    own = vp.steady_state(exciter, outputs=["impacts"])
    assert float(own.housing_velocity_mean) == pytest.approx(0.08, rel=1e-8)
    assert float(own.impact_velocity_max[0]) < 1.0
    assert "housing" in found.attrs["effects"]


def test_a_design_creeps_as_fast_as_the_best_of_a_grid():
    ranges = {"nu": (1.0, 1.2)}
    found = vp.design(STRUCK, ranges, minimise="-housing_velocity_mean", samples=16, designs=1)
    grid = vp.sweep(STRUCK, {"nu": np.linspace(1.0, 1.2, 81)})
    best = float(grid.housing_velocity_mean.where(grid.period_multiple > 0).max())
    assert best <= float(found.housing_velocity_mean[0]) + 1e-9
    assert float(found.housing_velocity_mean[0]) < best + 1e-3


def test_scattered_parts_creep_as_first_order_says():
    sigma = {"R1": 1e-3, "mass_ratio": 2e-3, "housing_friction_1": 1e-3}
    told = vp.tolerance(STRUCK, sigma, samples=256)
    first, sampled = told.housing_velocity_mean_std.values
    assert sampled == pytest.approx(first, rel=0.03)
    by = told.housing_velocity_mean_sensitivity.sel(parameter="mass_ratio")
    moved = replace(STRUCK, mass_ratio=STRUCK.mass_ratio + 1e-4)
    near = float(vp.steady_state(moved).housing_velocity_mean - told.housing_velocity_mean) / 1e-4
    assert float(by) == pytest.approx(near, rel=1e-2)
    assert float(told.law_change_share) == 0


def test_a_progression_is_not_wanted_of_a_housing_that_is_fixed():
    held = replace(STRUCK, mass_ratio=0.0, housing_friction_1=0.0, housing_friction_2=0.0)
    with pytest.raises(vp.ParameterError) as refused:
        vp.design(held, {"nu": (1.0, 1.2)}, {"housing_velocity_mean": 0.1})
    assert str(refused.value) == (
        "mass_ratio: must be above 0, since housing_velocity_mean is wanted: a housing with 0 is "
        "fixed, got 0.0"
    )


def test_a_measured_progression_identifies_the_friction_on_the_ground():
    measured = vp.sweep(STRUCK, {"nu": np.linspace(1.05, 1.2, 7)}, outputs=["impacts"])
    table = {
        "nu": measured.nu.values,
        "housing_velocity_mean": measured.housing_velocity_mean.values,
    }
    ranges = {"housing_friction_1": (0.2, 0.4), "mass_ratio": (0.4, 0.8)}
    start = replace(STRUCK, housing_friction_1=0.25, mass_ratio=0.7)
    found = vp.identify(start, table, ranges, samples=32)
    for name in ranges:
        assert float(found[name]) == pytest.approx(getattr(STRUCK, name), rel=1e-6)


CODES = FLAGS["settled_same"]
# From rest the weaker forces lead to a motion that strikes no support, from v0 = 1.5 to one that strikes both.
TWO_MOTIONS = vp.Exciter(l=0.5, nu=1.9, h=0.2, R1=0.7, R2=0.7)
RANGES = {"f": (0.45, 0.95), "R1": (0.5, 0.9)}


def from_rest_by_sections(exciter: vp.Exciter, designs: xr.Dataset) -> Iterator[int]:
    """Yield the code of each design: whether its section is one of those of the steady state from rest."""
    for n in range(designs.sizes["design"]):
        own = designs.isel(design=n)
        made = replace(
            exciter, **{name: float(own[name]) for name in str(own.attrs["vary"]).split()}
        )
        rest = vp.steady_state(made, outputs=("poincare",))
        if int(rest.period_multiple) == 0:
            yield CODES["unknown"]
            continue
        visits = np.stack([rest.poincare_displacement, rest.poincare_velocity], axis=-1)
        state = np.array([own.displacement_strobe, own.velocity_strobe])
        is_near = (np.abs(visits - state) < 1e-6 * np.abs(visits).max()).all(axis=-1).any()
        yield CODES["same" if is_near else "other"]


def test_from_another_start_some_designs_are_not_reached_from_rest() -> None:
    ds = vp.design(TWO_MOTIONS, RANGES, {"impact_velocity_max_1": 0.75}, v0=1.5, samples=64)
    codes = [*from_rest_by_sections(TWO_MOTIONS, ds)]
    assert {CODES["same"], CODES["other"]} == {*codes}
    assert ds.from_rest.values.tolist() == codes
    assert ds.from_rest.attrs["flag_meanings"] == "unknown other same"
    assert ds.from_rest.dims == ("design",)


@pytest.mark.parametrize(
    "more",
    [
        {"load": 0.05},
        {"k2": 200.0, "h2": 3.0, "friction": 0.1},
        {"mass_ratio": 0.5, "housing_friction_1": 0.3, "housing_friction_2": 0.45},
    ],
)
def test_designs_from_rest_are_reached_from_rest(more: dict[str, float]) -> None:
    exciter = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, delta=0.02, **more)
    bound = {"impact_velocity_max_1": "< 0.9"}
    ds = vp.design(exciter, {"f": (-1.2, -0.5)}, subject_to=bound, samples=16, designs=2)
    codes = [*from_rest_by_sections(exciter, ds)]
    assert {*codes} == {CODES["same"]}
    assert ds.from_rest.values.tolist() == codes
    assert ds.attrs["start"] == f"x0 = {more.get('load', 0):g}, v0 = 0"


def test_of_a_motion_without_an_orbit_it_is_not_known() -> None:
    one = vp.steady_state(replace(TWO_MOTIONS, f=0.5), v0=1.5).expand_dims("design")
    assert reached_from_rest(one).tolist() == [CODES["other"]]
    chaotic = one.assign(period_multiple=("design", [0]))
    assert reached_from_rest(chaotic).tolist() == [CODES["unknown"]]
