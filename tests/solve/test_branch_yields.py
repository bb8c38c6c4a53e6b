"""Yields along branches, against `tolerance` at the same orbits, closed forms and parts marched one by one."""

from __future__ import annotations

from dataclasses import replace
from statistics import NormalDist

import numpy as np
import pytest

import vibropipe as vp

STRUCK = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, delta=-0.05, R1=0.7, R2=0.7)
SIGMA = {"delta": 0.02, "R1": 0.03}
BOUND = {"impact_velocity_max_1": "< 0.95"}
SHARES = ("yield", "yield_low", "yield_high", "law_yield")


def start_of(row) -> tuple[float, float]:
    return float(row.displacement_strobe), float(row.velocity_strobe)


@pytest.fixture(scope="module")
def branch():
    return vp.branch(
        STRUCK, "nu", (0.95, 1.3), at=(1.0, 1.1, 1.2), tolerance=SIGMA, subject_to=BOUND
    )


@pytest.mark.slow
def test_the_yield_of_a_point_is_that_of_tolerance(branch):
    known = np.isfinite(branch["yield"].values)
    assert (known == ((branch.stable == 1) & branch.nu.isin([1.0, 1.1, 1.2])).values).all()
    assert known.any()
    for point in np.flatnonzero(known):
        row = branch.isel(point=point)
        own = replace(STRUCK, nu=float(row.nu))
        same = vp.tolerance(own, SIGMA, *start_of(row), samples=1024, harmonics=6, subject_to=BOUND)
        for name in SHARES:
            assert float(row[name]) == float(same[name])
        assert float(row.impact_velocity_max_yield[0]) == float(same.impact_velocity_max_yield[0])
        assert str(row.foretold_by.values) == same.attrs["foretold_by"]
        whole = vp.tolerance(own, SIGMA, *start_of(row), samples=4096, subject_to=BOUND)
        assert row.yield_low <= whole["yield"] <= row.yield_high
        assert whole.yield_low <= row["yield"] <= whole.yield_high
        if "R1_sort_threshold" in same:
            for name in ("R1_sort_threshold", "displacement_amplitude_sort_wrong"):
                np.testing.assert_array_equal(row[name], same[name])
    assert branch.attrs["subject_to"] == "impact_velocity_max_1 < 0.95"


def test_the_yield_is_that_of_parts_marched_one_by_one(branch):
    row = branch.isel(point=int(np.flatnonzero(np.isfinite(branch["yield"].values))[0]))
    generator, n, kept = np.random.default_rng(4), 300, 0
    for _ in range(n):
        off = {
            name: getattr(STRUCK, name) + s * generator.standard_normal()
            for name, s in SIGMA.items()
        }
        own = replace(STRUCK, nu=float(row.nu), **off)
        x, v = start_of(row)
        part = vp.steady_state(own, min(max(x, own.lower), own.upper), v)
        kept += bool(
            part.stable == 1
            and part.regime == row.regime
            and part.period_multiple == row.period_multiple
            and (part.impacts_per_orbit == row.impacts_per_orbit).all()
            and part.impact_velocity_max.sel(support=1) <= 0.95
        )
    share = float(row["yield"])
    assert 0.02 < share < 0.98
    assert kept / n == pytest.approx(share, abs=4 * np.sqrt(share * (1 - share) / n))


def test_the_yield_of_a_linear_motion_has_its_closed_form():
    # A_1 = f gain(nu): the share below a bound is that of f below it.
    exciter = vp.Exciter(l=5.0, nu=0.6, f=0.2, h=0.1)
    found = vp.branch(
        exciter, "nu", 0.8, tolerance={"f": 0.01}, subject_to={"displacement_amplitude_1": "< 0.4"}
    )
    known = np.flatnonzero(np.isfinite(found["yield"].values))
    assert 2 < len(known) <= 32
    assert {known[0], known[-1]} == {0, found.sizes["point"] - 1}
    nu = found.nu.values[known]
    below = np.array([NormalDist(0.2, 0.01).cdf(0.4 * np.hypot(1 - v**2, 0.1 * v)) for v in nu])
    assert below.max() > 0.9 > 0.1 > below.min()
    np.testing.assert_allclose(found["yield"].values[known], below, atol=2e-3)
    np.testing.assert_array_equal(found.law_yield.values[known], 1.0)
    rule = found.f_sort_threshold.values[known]
    sorts = np.isfinite(rule)
    assert sorts.any()
    expected = 0.4 * np.hypot(1 - nu**2, 0.1 * nu)
    np.testing.assert_allclose(rule[sorts], expected[sorts], atol=3e-4)


def test_without_bounds_it_is_the_yield_of_the_law():
    found = vp.branch(STRUCK, "nu", 1.05, at=(1.0,), tolerance=SIGMA, subject_to={})
    (point,) = np.flatnonzero(np.isfinite(found["yield"].values))
    row = found.isel(point=point)
    same = vp.tolerance(STRUCK, SIGMA, *start_of(row), samples=1024)
    assert float(row["yield"]) == float(row.law_yield)
    assert float(row["yield"]) == pytest.approx(1 - float(same.law_change_share), abs=1e-12)
    bare = vp.branch(STRUCK, "nu", 1.05, at=(1.0,), tolerance=SIGMA)
    assert "yield" not in bare
    assert "subject_to" not in found.attrs


def test_unstable_points_have_no_yield():
    exciter = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.2, R1=0.7, R2=0.7)
    found = vp.branch(exciter, "nu", (0.9, 3.0), tolerance={"f": 0.01}, subject_to={})
    unstable = found.stable.values == 0
    assert unstable.any()
    assert np.isnan(found["yield"].values[unstable]).all()
    assert set(found.foretold_by.values[unstable].tolist()) == {""}
    assert np.isfinite(found["yield"].values).sum() <= 32


def test_what_is_tied_follows_in_parts_and_laws_have_yields():
    # It strikes both supports once in a period.
    free = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.2, delta=0.02, R1=0.7)
    ties, bounds = {"R2": "R1"}, {"displacement_mean": "> -0.2", "impact_velocity_max_2": "< 0.9"}
    found = vp.branch(
        free, "nu", (0.9, 1.6), law=(1, 1, 1), at=(1.5,), tolerance={"R1": 0.05}, ties=ties,
        subject_to=bounds,
    )  # fmt: skip
    known = np.flatnonzero(np.isfinite(found["yield"].values))
    assert len(known) >= 1
    row, at = found.isel(point=known[0]), replace(free, nu=1.5)
    same = vp.tolerance(
        at, {"R1": 0.05}, *start_of(row), samples=1024, ties=ties, subject_to=bounds
    )
    assert float(row["yield"]) == float(same["yield"])
    alone = vp.tolerance(
        replace(at, R2=0.7), {"R1": 0.05}, *start_of(row), samples=1024, subject_to=bounds
    )
    assert float(row["yield"]) != float(alone["yield"])


def test_soft_supports_and_sliding_housings_have_yields():
    soft = vp.Exciter(l=0.5, nu=1.0, f=0.8, h=0.1, delta=0.1, k1=60.0, h1=1.0, R2=0.75)
    sigma, bounds = {"k1": 1.0, "f": 0.02}, {"support_force_max_1": "< 6"}
    found = vp.branch(soft, "nu", 1.1, at=(1.08,), tolerance=sigma, subject_to=bounds)
    row = found.isel(point=int(np.flatnonzero(np.isfinite(found["yield"].values))[0]))
    own = replace(soft, nu=1.08)
    same = vp.tolerance(
        own, {"f": 0.02, "k1": 1.0}, *start_of(row), samples=1024, subject_to=bounds
    )
    assert float(row["yield"]) == float(same["yield"]) < 1.0
    housed = vp.Exciter(
        l=0.3, nu=1.1, f=1.0, h=0.1, R1=0.6, R2=0.75, mass_ratio=0.4, housing_friction_1=0.3,
        housing_friction_2=0.5,
    )  # fmt: skip
    bounds = {"housing_velocity_mean": "> 0.02"}
    found = vp.branch(housed, "nu", 1.15, at=(1.12,), tolerance={"f": 0.02}, subject_to=bounds)
    row = found.isel(point=int(np.flatnonzero(np.isfinite(found["yield"].values))[0]))
    forces = 1.0 + 0.02 * np.random.default_rng(9).standard_normal(200)
    parts = [vp.steady_state(replace(housed, nu=1.12, f=float(f))) for f in forces]
    kept = sum(
        bool(
            part.stable == 1
            and part.period_multiple == row.period_multiple
            and (part.impacts_per_orbit == row.impacts_per_orbit).all()
            and part.housing_velocity_mean >= 0.02
        )
        for part in parts
    )
    share = float(row["yield"])
    assert 0.05 < share < 0.95
    assert kept / 200 == pytest.approx(share, abs=4 * np.sqrt(share * (1 - share) / 200))


def test_with_units_it_is_the_same():
    exciter = vp.Exciter.from_physical(
        m="2 kg", C="8 N/mm", H="25 N s/m", F="-8 kN", omega="10 Hz", l="500 mm", R2=0.7
    )
    p = np.sqrt(8000 / 2)
    bound = float(vp.steady_state(exciter).impact_velocity_max[0])
    given = {"along": "omega", "to": "10.2 Hz", "at": ["10.1 Hz"], "tolerance": {"F": "16 N"}}
    found = vp.branch(exciter, **given, subject_to={"impact_velocity_max_1": f"< {bound * p} m/s"})
    nu = 10.1 * 2 * np.pi / p
    plain = vp.branch(
        exciter, "nu", 10.2 * 2 * np.pi / p, at=[nu], tolerance={"f": 0.002},
        subject_to={"impact_velocity_max_1": f"< {bound}"},
    )  # fmt: skip
    assert np.nanmax(found["yield"]) == np.nanmax(plain["yield"])
    assert {*found.foretold_by.values.tolist()} == {
        name.replace("nu", "omega") if name == "nu" else {"f": "F"}.get(name, name)
        for name in plain.foretold_by.values.tolist()
    }


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"subject_to": BOUND}, "tolerance: is required beside subject_to"),
        ({"subject_to": {"fold_nu_up": "> 1"}, "tolerance": SIGMA},
         "subject_to.fold_nu_up: must be a quantity of the motion"),
        ({"subject_to": {"f": "> 1"}, "tolerance": SIGMA}, "subject_to.f: must be a quantity of the motion"),
        ({"subject_to": {"lyapunov_exponent": "< 0"}, "tolerance": SIGMA},
         "subject_to.lyapunov_exponent: must be a quantity that the points of a branch have"),
        ({"subject_to": {"support_force_max_1": "< 3"}, "tolerance": SIGMA}, "k1: must be above 0"),
        ({"subject_to": {"impact_velocity_max_1": "0.8"}, "tolerance": SIGMA}, "must be a bound such as"),
    ],
)  # fmt: skip
def test_what_cannot_be_a_bound_is_refused(arguments, message):
    with pytest.raises(vp.ParameterError, match=message):
        vp.branch(STRUCK, "nu", 1.1, **arguments)
