"""A constant load is an offset of the equilibrium: x = y + load, delta -> delta - load, for every face."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
import xarray as xr
from comparisons import reference
from hypothesis import given, settings
from strategies import Case, cases

import vibropipe as vp
from vibropipe.lab.reference_solver import ReferenceSolver
from vibropipe.words.regimes import Regime
from vibropipe.words.units import DIMENSIONS

FORCED: dict[str, Any] = {"l": 0.5, "nu": 1.0, "f": -1.0, "h": 0.2, "R1": 0.7, "R2": 0.7}
LOAD = 0.3
LOADED = vp.Exciter(**FORCED, delta=0.1, load=LOAD)
OFFSET = vp.Exciter(**FORCED, delta=0.1 - LOAD)
# Variables that count displacements.
DISPLACED = (
    "displacement", "displacement_end", "displacement_strobe", "displacement_mean", "poincare_displacement",
)  # fmt: skip


def assert_same(loaded: xr.Dataset, offset: xr.Dataset, tolerance: float = 1e-12) -> None:
    """Both datasets are one motion, counted from x = 0 and from the equilibrium."""
    assert set(loaded.data_vars) == set(offset.data_vars)
    for name, array in offset.data_vars.items():
        expected = array.values + LOAD if name in DISPLACED else array.values
        np.testing.assert_allclose(loaded[name].values, expected, 1e-10, tolerance, err_msg=name)


def test_the_reference_is_met() -> None:
    entry = reference("effects")["load"]
    e = vp.Exciter(**FORCED, load=float(entry["q"]))
    ds = vp.simulate(e, float(entry["tau_end"]), x0=0.0)
    assert abs(float(ds.displacement_end) - float(entry["x_end"])) < 1e-13
    assert abs(float(ds.velocity_end) - float(entry["v_end"])) < 1e-13
    times = np.array([float(event["tau"]) for event in entry["events"]])
    assert np.abs(ds.impact_tau.values - times).max() < 1e-13
    (x, v), *_ = ReferenceSolver(e).run(0.0, 0.0, [40]).states  # type: ignore[list-item]
    assert abs(float(x) - float(entry["x_end"])) < 1e-15
    assert abs(float(v) - float(entry["v_end"])) < 1e-15


@pytest.mark.parametrize("solver", [{}, {"method": "newmark", "steps_per_period": 200}])
def test_a_motion_is_that_of_the_offset(solver: dict[str, Any]) -> None:
    loaded = vp.simulate(LOADED, 20.0, x0=0.2, v0=0.4, energy=True, **solver)
    offset = vp.simulate(OFFSET, 20.0, x0=0.2 - LOAD, v0=0.4, energy=True, **solver)
    assert_same(loaded, offset)
    assert "load" in loaded.attrs["effects"]
    assert float(loaded["load"]) == LOAD
    assert abs(float(loaded.energy_residual)) < 1e-13


def test_a_start_left_out_is_the_equilibrium_or_the_nearest_support() -> None:
    assert vp.Exciter(l=1.0, load=0.4).check_start(None, 0.0) == (0.4, 0.0)
    assert vp.Exciter(l=1.0, load=-3.0).check_start(None, 0.0) == (-1.0, 0.0)
    still = vp.simulate(vp.Exciter(l=1.0, load=0.4, h=0.1), 5.0)
    assert np.all(still.displacement == 0.4)
    swept = vp.sweep(vp.Exciter(l=1.0, h=0.1), {"load": [0.0, 0.4, 3.0]}, outputs=("harmonics",))
    np.testing.assert_array_equal(swept.displacement_mean, [0.0, 0.4, 1.0])
    assert swept.regime.values.tolist()[:2] == [Regime.NO_IMPACT] * 2


def test_a_load_presses_the_mass_on_a_support_until_the_force_lifts_it() -> None:
    """The mass rests where load - b > |f|, and is released where the force exceeds the difference."""
    e = vp.Exciter(l=0.5, nu=0.3, f=1.0, h=0.2, R1=0.0, R2=0.0, load=1.2)
    ds = vp.simulate(e, 60.0)
    ends = ds.rest_end.values[:-1] if np.isinf(ds.rest_end.values[-1]) else ds.rest_end.values
    assert ends.size > 1
    pull = 1.2 + np.sin(0.3 * ends) - e.upper
    np.testing.assert_allclose(pull, 0.0, atol=1e-13)
    pressed = vp.steady_state(dataclasses.replace(e, load=1.6))
    assert (pressed.rests_per_orbit.values == [1, 0]).all()
    assert float(pressed.displacement_mean) == e.upper


@pytest.mark.parametrize("delta", [0.1, 0.3])
def test_steady_states_are_those_of_the_offset(delta: float) -> None:
    outputs = (
        "harmonics",
        "impacts",
        "motion",
        "stability",
        "energy",
        "subharmonics",
        "poincare",
        "lyapunov",
    )
    loaded = vp.Exciter(**FORCED, delta=delta, load=LOAD)
    offset = vp.Exciter(**FORCED, delta=delta - LOAD)
    over = {"nu": [0.8, 1.0, 2.9]}
    assert_same(
        vp.sweep(loaded, over, outputs=outputs, x0=0.2),
        vp.sweep(offset, over, outputs=outputs, x0=0.2 - LOAD),
    )
    assert_same(
        vp.steady_state(loaded, 0.2, accuracy=1e-8)[["displacement_strobe", "displacement_mean"]],
        vp.steady_state(offset, 0.2 - LOAD)[["displacement_strobe", "displacement_mean"]],
    )


def test_a_load_is_swept_and_followed() -> None:
    loads = np.linspace(0.0, 0.4, 5)
    e = vp.Exciter(**FORCED)
    swept = vp.sweep(e, {"load": loads}, x0=0.0)
    assert swept["load"].dims == ("load",)
    for load in loads:
        row = vp.steady_state(dataclasses.replace(e, load=load), x0=0.0, harmonics=3)
        assert float(swept.displacement_mean.sel(load=load)) == float(row.displacement_mean)
    up, down = vp.sweep(e, {"load": loads}, follow=("load", "both")).displacement_mean.values
    assert np.abs(up - down).max() < 1e-9
    # A row starts from the state of its neighbour, not from the same distance to the equilibrium.
    free = vp.Exciter(l=5.0)
    chain = vp.sweep(
        free, {"load": [0.0, 1.0]}, x0=None, follow=("load", "up"), outputs=("impacts",)
    )
    assert chain.displacement_strobe.values.tolist() == [0.0, 0.0]


def test_branches_and_boundaries_know_the_load() -> None:
    loaded = vp.branch(LOADED, "nu", 1.1, x0=0.2)
    offset = vp.branch(OFFSET, "nu", 1.1, x0=0.2 - LOAD)
    assert loaded.sizes["point"] == offset.sizes["point"]
    np.testing.assert_allclose(
        loaded.displacement_strobe, offset.displacement_strobe + LOAD, atol=1e-10
    )
    # The load takes the exciter from one side to the other as an offset does.
    along = vp.branch(vp.Exciter(**FORCED), "load", 0.2, at=[0.02], harmonics=1)
    beside = vp.branch(vp.Exciter(**FORCED), "delta", -0.2, at=[-0.02], harmonics=1)
    by_load = along.isel(point=int(np.flatnonzero(along["load"].values == 0.02)[0]))
    by_delta = beside.isel(point=int(np.flatnonzero(beside.delta.values == -0.02)[0]))
    assert float(by_load.displacement_mean) == pytest.approx(
        float(by_delta.displacement_mean) + 0.02, abs=1e-12
    )
    assert "load" in along.attrs["effects"]


def test_closed_forms_know_the_load() -> None:
    symmetric = vp.Exciter(**FORCED, delta=LOAD, load=LOAD)
    centred = vp.Exciter(**FORCED)
    assert_same(vp.symmetric_orbit(symmetric), vp.symmetric_orbit(centred))
    with pytest.raises(vp.ParameterError, match="delta: must be the load for a symmetric orbit"):
        vp.symmetric_orbit(LOADED)
    for support in (1, 2):
        assert_same(vp.one_sided_orbit(LOADED, support, 1), vp.one_sided_orbit(OFFSET, support, 1))
    assert_same(
        vp.amplitude_frequency(LOADED, [0.4, 0.7, 1.5]),
        vp.amplitude_frequency(OFFSET, [0.4, 0.7, 1.5]),
    )


def test_basins_know_the_load() -> None:
    e = {"l": 0.5, "nu": 2.1, "f": 1.0, "h": 0.1, "R1": 0.7, "R2": 0.7}
    x0, v0 = np.linspace(-0.35, 0.35, 5), np.linspace(-1, 1, 4)
    loaded = vp.basins(vp.Exciter(**e, delta=LOAD, load=LOAD), x0 + LOAD, v0, starts=64)
    centred = vp.basins(vp.Exciter(**e), x0, v0, starts=64)
    np.testing.assert_array_equal(loaded.attractor, centred.attractor)
    np.testing.assert_allclose(
        loaded.displacement_mean, centred.displacement_mean + LOAD, atol=1e-10
    )


def test_a_dataset_in_si_has_the_load_in_newtons() -> None:
    e = vp.Exciter.from_physical(
        m=2, C=8000, H=40, F=120, omega=55, l=0.008, slope="-90 deg", load="-3 N"
    )
    ds = vp.to_physical(vp.simulate(e, 10.0), 2, 8000)
    assert float(ds["load"]) == pytest.approx(2 * 9.80665 - 3, rel=1e-14)
    assert ds["load"].attrs["units"] == DIMENSIONS["force"].units


def check_a_load_is_an_offset(case: Case) -> None:
    e, load = case.exciter, case.exciter.l * 0.25
    loaded = dataclasses.replace(e, load=load, delta=e.delta + load)
    lower, upper = loaded.lower, loaded.upper
    x0 = min(max(case.x0 + load, lower), upper)
    for x, on in ((e.upper, upper), (e.lower, lower)):
        x0 = on if case.x0 == x else x0
    options: dict[str, Any] = {"samples_per_period": 0, "max_impacts": 40}
    end = min(case.tau_end, 2.0)
    with_load = vp.simulate(loaded, end, x0, case.v0, **options)
    without = vp.simulate(e, end, case.x0, case.v0, **options)
    if with_load.sizes["impact"] != without.sizes["impact"]:
        return  # a grazing or a chatter within rounding
    size = e.l + abs(e.delta) + abs(case.x0) + abs(case.v0) + abs(e.f)
    first = slice(0, 1)
    for name in ("impact_tau", "impact_velocity"):
        np.testing.assert_allclose(with_load[name][first], without[name][first], 1e-6, 1e-6 * size)


test_a_load_is_an_offset = settings(max_examples=60)(given(cases())(check_a_load_is_an_offset))
test_a_load_is_an_offset_patiently = pytest.mark.slow(
    settings(max_examples=20_000)(given(cases())(check_a_load_is_an_offset))
)
