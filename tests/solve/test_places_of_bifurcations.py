"""How bifurcations move with each parameter: against differences of branches, closed forms and scattered parts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.parameters import PARAMETERS

STRUCK = vp.Exciter(l=0.5, nu=1.0, f=0.8, h=0.1, delta=0.1, R1=0.6, R2=0.75)
SYMMETRIC = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.2, R1=0.7, R2=0.7)
SOFT = vp.Exciter(l=0.5, nu=1.0, f=0.8, h=0.1, delta=0.1, k1=60.0, h1=1.0, R2=0.75)
RUBBED = vp.Exciter(l=0.5, nu=1.0, f=0.8, h=0.1, delta=0.1, R1=0.6, R2=0.75, friction=0.05)
HOUSED = vp.Exciter(
    l=0.3, nu=1.1, f=1.0, h=0.1, R1=0.6, R2=0.75, mass_ratio=0.4, housing_friction_1=0.3,
    housing_friction_2=0.5,
)  # fmt: skip
STEP = 2e-4
KINDS = (Bifurcation.FOLD, Bifurcation.FLIP, Bifurcation.PITCHFORK, Bifurcation.GRAZING)


def places(exciter: vp.Exciter, to: tuple[float, float], **options: object) -> xr.Dataset:
    return vp.branch(exciter, "nu", to, harmonics=1, **options)


def nearest(branch: xr.Dataset, kind: int, value: float) -> float:
    """Return the place of a bifurcation of a kind next to a value."""
    there = branch.bifurcation_nu.values[branch.bifurcation_kind.values == kind]
    return float(there[np.abs(there - value).argmin()])


CASES = [
    (STRUCK, (0.7, 3.0), ("f", "h", "l", "delta", "load", "R1", "R2"), ()),
    (STRUCK, (0.75, 1.2), ("f", "R2"), ("flip",)),
    (SYMMETRIC, (0.5, 3.0), ("f", "h", "l"), ("pitchfork",)),
    (SOFT, (0.7, 2.0), ("f", "h", "delta", "k1", "h1", "R2"), ()),
    (RUBBED, (0.7, 2.0), ("f", "l", "friction", "R1"), ()),
    (HOUSED, (1.0, 1.2), ("f", "mass_ratio", "housing_friction_1", "housing_load"), ()),
    (
        replace(STRUCK, nu=1.6, f2=0.1, phi2=0.3, shaker=0.05),
        (0.7, 3.0),
        ("f", "f2", "phi2", "shaker"),
        (),
    ),
]


@pytest.mark.parametrize(("exciter", "to", "names", "switch"), CASES)
def test_derivatives_are_differences_of_places(exciter, to, names, switch):
    branch = places(exciter, to, switch=switch, tolerance=dict.fromkeys(names, 0.01))
    slopes = branch.bifurcation_nu_sensitivity
    assert [*branch.parameter.values] == sorted(names, key=[*PARAMETERS].index)
    compared = 0
    for name in names:
        own = exciter.numbers()._asdict()[name]
        near = {
            n: places(
                vp.Exciter(**{**exciter.numbers()._asdict(), name: own + n * STEP}),
                to,
                switch=switch,
            )
            for n in (-2, -1, 1, 2)
        }
        for i, kind in enumerate(branch.bifurcation_kind.values):
            value = float(branch.bifurcation_nu[i])
            others = branch.bifurcation_nu.values[branch.bifurcation_kind.values == kind]
            is_alone = np.sum(np.abs(others - value) < 0.02) == np.sum(
                np.abs(others - value) < 1e-9
            )
            if kind not in KINDS or not is_alone:
                continue
            at = {n: nearest(each, kind, value) for n, each in near.items()}
            expected = (8 * (at[1] - at[-1]) - (at[2] - at[-2])) / (12 * STEP)
            got = float(slopes.sel(parameter=name)[i])
            assert got == pytest.approx(expected, rel=1e-6, abs=1e-7), (name, kind, value)
            compared += 1
    assert compared >= len(names)


def test_the_first_touch_moves_as_its_closed_form():
    """|f| / sqrt((1 - nu^2)^2 + h^2 nu^2) = l - |delta|."""
    exciter = vp.Exciter(l=0.5, nu=3.0, f=0.4, h=0.2, delta=0.05)
    branch = places(
        exciter, (1.2, 4.0), tolerance={"f": 0.01, "h": 0.02, "l": 0.005, "delta": 0.003}
    )
    i = int(np.flatnonzero(branch.bifurcation_kind == Bifurcation.GRAZING)[0])
    nu = float(branch.bifurcation_nu[i])
    size = (1 - nu**2) ** 2 + (0.2 * nu) ** 2
    by_nu = 4 * nu * (nu**2 - 1) + 2 * nu * 0.04
    gap = 0.45
    expected = {
        "f": 2 * 0.4 / gap**2 / by_nu,
        "h": -2 * 0.2 * nu**2 / by_nu,
        "l": -2 * size / gap / by_nu,
        "delta": 2 * size / gap / by_nu,
    }
    for name, slope in expected.items():
        got = float(branch.bifurcation_nu_sensitivity.sel(parameter=name)[i])
        assert got == pytest.approx(slope, rel=1e-7)
    total = np.sqrt(
        sum(
            (expected[n] * s) ** 2
            for n, s in zip(expected, (0.01, 0.02, 0.005, 0.003), strict=True)
        )
    )
    assert float(branch.bifurcation_nu_std[i]) == pytest.approx(total, rel=1e-7)


def test_what_ends_the_symmetry_has_no_derivative_at_a_pitchfork_but_at_a_fold():
    branch = places(SYMMETRIC, (0.5, 3.0), tolerance={"f": 0.01, "delta": 0.01, "R1": 0.01})
    kinds = branch.bifurcation_kind.values
    slopes = branch.bifurcation_nu_sensitivity
    for i in np.flatnonzero(kinds == Bifurcation.PITCHFORK):
        assert np.isnan(slopes.sel(parameter=["delta", "R1"]).values[i]).all()
        assert np.isfinite(slopes.sel(parameter="f")[i])
        assert np.isnan(branch.bifurcation_nu_std[i])


def test_a_touch_of_both_supports_at_once_has_no_derivative_by_the_offset():
    branch = places(
        replace(STRUCK, delta=0.0, nu=2.9),
        (1.2, 4.0),
        tolerance={"f": 0.01, "delta": 0.01, "R1": 0.1},
    )
    i = int(np.flatnonzero(branch.bifurcation_kind == Bifurcation.GRAZING)[0])
    by = branch.bifurcation_nu_sensitivity[i]
    assert np.isnan(by.sel(parameter="delta"))
    assert np.isnan(branch.bifurcation_nu_std[i])
    assert float(by.sel(parameter="R1")) == pytest.approx(0.0, abs=1e-8)
    assert float(by.sel(parameter="f")) > 0.0


def test_both_supports_share_the_fold_of_a_symmetric_orbit():
    exciter = replace(SYMMETRIC, f=0.3, h=0.05, nu=1.2)
    branch = vp.branch(
        exciter, "nu", (1.0, 3.0), harmonics=1, tolerance={"R1": 0.01, "R2": 0.01, "delta": 0.01}
    )
    (i,) = np.flatnonzero(branch.bifurcation_kind == Bifurcation.FOLD)[:1]
    by = branch.bifurcation_nu_sensitivity[i]
    first, second = float(by.sel(parameter="R1")), float(by.sel(parameter="R2"))
    assert first == pytest.approx(second, rel=1e-6)
    assert float(by.sel(parameter="delta")) == pytest.approx(0.0, abs=1e-5)
    at = [
        nearest(
            vp.branch(replace(exciter, R1=0.7 + s, R2=0.7 + s), "nu", (1.0, 3.0), harmonics=1),
            Bifurcation.FOLD, float(branch.bifurcation_nu[i]),
        )
        for s in (1e-4, -1e-4)
    ]  # fmt: skip
    assert first + second == pytest.approx((at[0] - at[1]) / 2e-4, rel=1e-5)


@pytest.mark.slow
def test_the_deviation_is_that_of_scattered_parts():
    sigma = {"f": 0.002, "R1": 0.004, "delta": 0.001}
    branch = places(STRUCK, (0.9, 1.3), tolerance=sigma)
    i = int(np.flatnonzero(branch.bifurcation_kind == Bifurcation.GRAZING)[0])
    value = float(branch.bifurcation_nu[i])
    rng = np.random.default_rng(4)
    found = []
    for _ in range(200):
        off = {name: getattr(STRUCK, name) + s * rng.standard_normal() for name, s in sigma.items()}
        part = places(replace(STRUCK, **off), (0.9, 1.3))
        found.append(nearest(part, Bifurcation.GRAZING, value))
    assert float(branch.bifurcation_nu_std[i]) == pytest.approx(np.std(found), rel=0.15)


@pytest.mark.parametrize(
    ("tolerance", "message"),
    [
        ({"nu": 0.1}, "tolerance.nu: must be left out: it is followed"),
        ({"k1": 1.0}, "k1: must be above 0 where k1 or h1 vary"),
        ({"friction": 0.1}, "tolerance.friction: must be left out: there is no friction"),
        (
            {"friction_ratio": 0.1},
            "tolerance.friction_ratio: must be left out: there is no friction",
        ),
        ({"f2": 0.1}, "tolerance.f2: must be left out: the force has no second harmonic"),
        ({"wear_exponent": 0.1}, "tolerance.wear_exponent: must be left out: it acts on no motion"),
        ({}, "tolerance: must have at least one parameter"),
    ],
)
def test_parameters_without_a_derivative_are_refused(tolerance, message):
    with pytest.raises(vp.ParameterError, match=message.replace(".", r"\.")):
        places(STRUCK, (0.7, 1.2), tolerance=tolerance)
