"""Derivatives and errors of orbits with soft supports and friction: against differences, other cases and 40 digits."""

from __future__ import annotations

from dataclasses import replace
from decimal import Decimal
from typing import Any

import housings
import numpy as np
import pytest
import xarray as xr
from long_pieces import solve_orbit

import vibropipe as vp
from vibropipe.lab.power_series import period_of
from vibropipe.words.status import Status

OUTPUTS = (
    "harmonics", "impacts", "stability", "energy", "lyapunov", "subharmonics", "sensitivity",
    "power", "frame",
)  # fmt: skip
SUFFIX = "_sensitivity"
OF_HOUSING = ("mass_ratio", "housing_friction_1", "housing_friction_2", "housing_load")
SOFT = vp.Exciter(l=0.5, nu=0.9, f=1.0, h=0.2, k1=50.0, h1=1.0, k2=800.0, h2=0.5, load=0.05)
RUBBED = vp.Exciter(l=0.5, nu=1.3, f=1.2, h=0.1, delta=0.05, R1=0.6, k2=300.0, h2=2.0, friction=0.1)
STICKING = vp.Exciter(l=0.4, nu=0.5, f=0.6, h=0.1, R1=0.5, R2=0.6, friction=0.15, f2=0.2, phi2=0.4)
RESTING = vp.Exciter(l=1.0, nu=0.3, f=1.3, h=0.1, delta=0.1, R1=0.3, R2=0.5, friction=0.05)
# At the phase 0 the mass rests on a support, or is held by friction.
BEGINS_AT_REST = vp.Exciter(l=0.5, nu=0.27, f=1.5, load=1.3, h=0.1, R1=0.5, R2=0.5, friction=0.03)
BEGINS_HELD = vp.Exciter(l=1.0, nu=0.82, f=1.5, h=0.1, delta=0.02, R1=0.7, R2=0.7, friction=0.7)
SLIDING = vp.Exciter(l=0.3, nu=1.1, f=1.0, h=0.1, R1=0.6, R2=0.75, mass_ratio=0.4, housing_friction_1=0.3,
                     housing_friction_2=0.5, housing_load=0.05)  # fmt: skip
# On a soft support, with friction within; its housing stops and slips off again.
SLIDING_SOFT = vp.Exciter(l=0.4, nu=1.3, f=1.1, h=0.15, delta=0.05, load=0.02, k1=60.0, h1=1.0, R2=0.6, friction=0.05,
                          mass_ratio=0.3, housing_friction_1=0.4, housing_friction_2=0.6)  # fmt: skip
# Slides all the time, under two harmonics of the force.
ALWAYS = vp.Exciter(l=0.3, nu=2.2, f=1.3, h=0.3, R1=0.3, R2=0.3, f2=0.4, phi2=0.3, mass_ratio=1.5,
                    housing_friction_1=0.02, housing_friction_2=0.03)  # fmt: skip
# Static friction is larger than kinetic.
STATIC = replace(STICKING, friction_ratio=1.6, friction=0.12)
STATIC_REST = vp.Exciter(
    l=0.5, nu=0.3, f=0.9, h=0.1, delta=0.02, R1=0.5, R2=0.4, friction=0.04, friction_ratio=2.0
)
# Soft supports that only push; one pushes again before the mass has left it.
NO_PULL = replace(RUBBED, R1=1.0, k1=90.0, h1=5.0, contact_1="no_pull", contact_2="no_pull")
RELOADED = vp.Exciter(
    l=0.5, nu=4.0, f=2.9, h=0.23, load=-2.6, k2=25.0, h2=5.3, R1=0.5, contact_2="no_pull", f2=-0.9
)
SLIDING_NO_PULL = replace(SLIDING_SOFT, contact_1="no_pull", h1=6.0)
CASES = {"soft": SOFT, "rubbed": RUBBED, "sticking": STICKING, "resting": RESTING}
CASES |= {"no pull": NO_PULL, "reloaded": RELOADED, "sliding, no pull": SLIDING_NO_PULL}
CASES |= {"static": STATIC, "static rest": STATIC_REST}
CASES |= {"begins at rest": BEGINS_AT_REST, "begins held": BEGINS_HELD}
CASES |= {"sliding rest": housings.RESTING, "stopped rest": housings.STOPPED}
CASES |= {"sliding": SLIDING, "sliding on soft supports": SLIDING_SOFT, "sliding always": ALWAYS}
# Sets of effects that rows of no other test have: compiling their kernels takes minutes.
PATIENT = ("reloaded", "sliding, no pull")


def case_of(name: str, *more: Any) -> Any:
    """Return the parameters of a test of a case, which is slow if its kernels serve it alone."""
    return pytest.param(name, *more, marks=[pytest.mark.slow] if name in PATIENT else [])


def steady(exciter: vp.Exciter, **options: float) -> xr.Dataset:
    """Return the steady state with all that is differentiated."""
    return vp.steady_state(exciter, harmonics=3, outputs=OUTPUTS, **options)


def apart(name: str, one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """Return one - two of a quantity, of phases by the shorter way round."""
    with np.errstate(invalid="ignore"):
        moved = one - two
    size = {"impact_phase": 1.0}.get(name, 2 * np.pi)
    return (moved + 0.5 * size) % size - 0.5 * size if name.endswith("_phase") else moved


def differences(
    exciter: vp.Exciter, dataset: xr.Dataset, parameter: str, share: float = 3e-5
) -> dict[str, np.ndarray]:
    """Return the derivatives of all quantities by differences of fourth order."""
    own = getattr(exciter, parameter)
    step = share * max(abs(own), 0.1)
    x, v = float(dataset.displacement_strobe), float(dataset.velocity_strobe)
    slopes: dict[str, np.ndarray] = {}
    for factor, weight in ((1, 8), (-1, -8), (2, -1), (-2, 1)):
        near = steady(replace(exciter, **{parameter: own + factor * step}), x0=x, v0=v)
        for name in dataset:
            base = str(name).removesuffix(SUFFIX)
            if base != name:
                moved = apart(base, near[base].values, dataset[base].values)
                slopes[base] = slopes.get(base, 0.0) + weight * moved / (12 * step)
    return slopes


@pytest.mark.parametrize(
    ("case", "parameters"),
    [
        ("soft", ("nu", "f", "h", "l", "delta", "load", "k1", "k2", "h1", "h2")),
        ("rubbed", ("nu", "f", "h", "R1", "load", "k2", "h2", "friction")),
        ("sticking", ("nu", "f", "h", "l", "R1", "R2", "friction", "f2", "phi2")),
        ("static", ("nu", "f", "h", "l", "R1", "R2", "friction", "friction_ratio", "f2")),
        ("static rest", ("nu", "f", "delta", "R1", "friction", "friction_ratio")),
        ("no pull", ("nu", "f", "h", "l", "delta", "k1", "h1", "k2", "h2", "friction")),
        case_of("reloaded", ("nu", "f", "h", "load", "k2", "h2", "f2", "phi2")),
        ("resting", ("nu", "f", "delta", "R1", "friction")),
        ("begins at rest", ("nu", "f", "load", "R1", "friction")),
        ("begins held", ("nu", "f", "h", "delta", "R2", "friction")),
        ("sliding", ("nu", "h", "delta", "R1", *OF_HOUSING)),
        ("sliding on soft supports", ("nu", "f", "load", "k1", "h1", "friction", *OF_HOUSING)),
        case_of("sliding, no pull", ("nu", "f", "k1", "h1", "friction", "mass_ratio")),
        ("sliding rest", ("nu", "f", "h", "l", "delta", "R1", "R2", "f2", *OF_HOUSING)),
        ("stopped rest", ("nu", "f", "h", "load", "R1", "R2", "phi2", *OF_HOUSING)),
        ("sliding always", ("nu", "f2", "phi2", "l", *OF_HOUSING)),
    ],
)
def test_derivatives_are_those_of_neighbours(case: str, parameters: tuple[str, ...]) -> None:
    exciter = CASES[case]
    dataset = steady(exciter)
    assert int(dataset.impacts_per_orbit.sum()) > 0
    for parameter in parameters:
        for name, expected in differences(exciter, dataset, parameter).items():
            got = dataset[name + SUFFIX].sel(parameter=parameter).values
            if name.endswith("_phase") and name != "impact_phase" and "sub" not in name:
                of = name.replace("velocity", "displacement").replace("phase", "amplitude")
                is_there = dataset[of].values > 1e-6
                got, expected = got[is_there], expected[is_there]
            is_known = np.isfinite(expected)
            if name != "lyapunov_exponent" or np.isfinite(dataset[name]):
                assert (np.isfinite(got) == is_known).all(), (name, parameter)
            scale = 1.0 + np.abs(expected[is_known]).max(initial=0.0)
            np.testing.assert_allclose(
                got[is_known], expected[is_known], rtol=0, atol=1e-6 * scale,
                err_msg=f"{name} by {parameter}",
            )  # fmt: skip


# Power of the scale of lengths with which quantities grow; the others have none.
LENGTHS = (
    "displacement", "velocity", "impact_velocity", "housing_velocity", "work_per_distance", "frame_force",
)  # fmt: skip
SQUARES = ("energy", "power")
OF_LENGTH = ["f", "l", "delta", "load", "f2", "friction", *OF_HOUSING[1:]]


@pytest.mark.parametrize("case", [case_of(name) for name in CASES])
def test_derivatives_are_homogeneous(case: str) -> None:
    """Euler's theorem: all lengths and forces together scale the motion, exactly."""
    dataset = steady(CASES[case])
    for name in map(str, dataset):
        if not name.endswith(SUFFIX):
            continue
        base = name.removesuffix(SUFFIX)
        power = 2 if base.startswith(SQUARES) else 1 if base.startswith(LENGTHS) else 0
        power = 0 if base.endswith("phase") else power
        by = dataset[name].sel(parameter=[k for k in OF_LENGTH if k in dataset.parameter])
        own = np.array([getattr(CASES[case], str(k)) for k in by.parameter.values])
        terms = np.where(own == 0.0, 0.0, by.values * own)
        expected = power * dataset[base].values if power else np.zeros(dataset[base].shape)
        known = np.isfinite(terms).all(axis=-1) & np.isfinite(expected)
        scale = 1.0 + np.abs(terms[known]).max(initial=0.0)
        np.testing.assert_allclose(
            terms.sum(axis=-1)[known], expected[known], rtol=0, atol=1e-10 * scale, err_msg=name
        )


@pytest.mark.parametrize("h2", [1e5, 9e6, 1e9])
def test_slow_contacts_have_derivatives_of_integrals(h2: float) -> None:
    """They were NaN after two seconds: rounding of the velocity at their start hid that it had decayed."""
    exciter = vp.Exciter(l=0.5, nu=0.17, f=2.87, h=0.0063, k1=1e-3, h1=0.0, k2=66.7, h2=h2)
    row = vp.steady_state(exciter, outputs=("energy", "harmonics", "sensitivity"))
    for name in ("nu", "f", "l"):
        value = getattr(exciter, name)
        above, below = (
            vp.steady_state(replace(exciter, **{name: value * (1 + step)}), outputs=("energy",))
            for step in (1e-4, -1e-4)
        )
        slope = float(above.energy_input - below.energy_input) / (2e-4 * value)
        derivative = float(row.energy_input_sensitivity.sel(parameter=name))
        assert derivative == pytest.approx(slope, rel=1e-3)
        assert np.isfinite(row.displacement_amplitude_sensitivity.sel(parameter=name)[1:]).all()


def test_without_contact_they_are_those_of_a_rigid_exciter() -> None:
    rigid = vp.Exciter(l=1.0, nu=0.8, f=0.2, h=0.2, delta=0.1, load=0.05)
    expected, got = steady(rigid), steady(replace(rigid, k1=40.0, h1=1.0))
    for name in expected:
        if str(name).endswith(SUFFIX) and name != "energy_friction" + SUFFIX:
            wanted = expected[name].values
            found = got[name].sel(parameter=expected.parameter).values
            is_known = np.isfinite(wanted) & np.isfinite(found)
            if "phase" not in str(name):
                assert (is_known == np.isfinite(wanted)).all(), name
            np.testing.assert_allclose(found[is_known], wanted[is_known], rtol=1e-7, atol=1e-12)
    by = got.displacement_amplitude_sensitivity.sel(parameter=["k1", "h1"])
    assert (by.sel(harmonic=1) == 0.0).all()


def test_they_tend_to_those_of_rigid_supports() -> None:
    rigid = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.3, R1=1.0, R2=0.6)
    expected = steady(rigid).impact_velocity_max_sensitivity.drop_sel(parameter="R1")
    far = [
        np.abs(
            steady(replace(rigid, k1=k)).impact_velocity_max_sensitivity.sel(
                parameter=expected.parameter
            )
            - expected
        ).max()
        for k in (1e4, 1e6, 1e8)
    ]
    # By the duration of a contact, pi / sqrt(k).
    assert far[2] < 0.01
    assert far[1] / far[0] == pytest.approx(0.1, rel=0.3)
    assert far[2] / far[1] == pytest.approx(0.1, rel=0.3)


def test_what_has_no_derivative_is_nan() -> None:
    by = steady(replace(SOFT, k2=0.0, h2=0.0, R2=0.7)).displacement_mean_sensitivity
    known = {str(name): bool(np.isfinite(by.sel(parameter=name))) for name in by.parameter.values}
    # A rigid support has no stiffness to vary, and friction, and what is static of it alone, cannot be less than none.
    assert [name for name in known if not known[name]] == ["k2", "friction", "friction_ratio"]
    held = steady(vp.Exciter(l=0.5, nu=0.9, f=0.1, h=0.2, friction=0.5), x0=0.2, v0=0.0)
    assert np.isnan(held.displacement_strobe_sensitivity).all()
    assert np.isnan(held.displacement_strobe_error)


def error_ratios(exciter: vp.Exciter) -> dict[str, float]:
    """Return true over stated errors of a steady state between two supports."""
    ds = vp.steady_state(exciter, harmonics=3, outputs=("harmonics", "impacts", "stability"))
    x, v, m = float(ds.displacement_strobe), float(ds.velocity_strobe), int(ds.period_multiple)
    true = solve_orbit(exciter, x, v, m, 3)
    period = period_of(exciter.nu)
    position = ds.impact_phase.values + ds.impact_period.values
    amplitudes = ds.displacement_amplitude.values * np.exp(1j * ds.displacement_phase.values)
    multipliers = true.multipliers
    stated = ds.floquet_multiplier.values
    pairs = min(multipliers, multipliers[::-1], key=lambda found: abs(stated - found).sum())
    assert len(true.contacts) == len(position)

    def distance(one: float, other: Decimal) -> float:
        return abs(float(Decimal(float(one)) - other))

    found = {
        "displacement_strobe": [distance(x, true.section[0])],
        "velocity_strobe": [distance(v, true.section[1])],
        "displacement_mean": [abs(float(ds.displacement_mean) - true.amplitudes[0].real)],
        "displacement_amplitude": abs(amplitudes - 2.0 * true.amplitudes[1:]),
        "floquet_multiplier": abs(stated - pairs),
        "impact_phase": [
            distance(at, tau / period) for at, (tau, _) in zip(position, true.contacts, strict=True)
        ],
        "impact_velocity": [
            distance(at, velocity)
            for at, (_, velocity) in zip(ds.impact_velocity.values, true.contacts, strict=True)
        ],
    }
    return {
        name: float(np.max(np.atleast_1d(errors) / np.atleast_1d(ds[f"{name}_error"].values)))
        for name, errors in found.items()
    }


def random_exciter(seed: int) -> vp.Exciter:
    """Draw an exciter with a soft support, or friction, or both, whose steady state has contacts and no rest."""
    draw = np.random.default_rng([11, seed])
    while True:
        ranges = {"nu": (0.4, 2), "f": (0.3, 2), "h": (0.05, 0.4), "l": (0.2, 0.8)}
        ranges |= {"delta": (-0.1, 0.1), "R1": (0.4, 0.9), "R2": (0.4, 0.9), "load": (-0.1, 0.1)}
        values = {name: draw.uniform(*ends) for name, ends in ranges.items()}
        kind = draw.integers(3)
        for i in "12"[: 2 - kind]:
            soft = {f"k{i}": 10 ** draw.uniform(0.5, 6), f"h{i}": draw.uniform(0, 5)}
            values |= soft | {f"R{i}": 1.0}
        if kind > 0:
            values["friction"] = draw.uniform(0.01, 0.2)
        if draw.random() < 0.4:
            values |= {"f2": draw.uniform(0.1, 0.8), "phi2": draw.uniform(0, 6)}
        exciter = vp.Exciter(**values)
        ds = vp.steady_state(exciter, outputs=("impacts",))
        # The solver in 40 digits begins no motion within a contact.
        is_between = exciter.lower < float(ds.displacement_strobe) < exciter.upper
        impacts, rests = float(ds.impacts_per_orbit.sum()), float(ds.rests_per_orbit.sum())
        if int(ds.period_multiple) > 0 and is_between and 0 < impacts < 30 and rests == 0:
            return exciter


def test_multipliers_beside_a_grazing_have_derivatives() -> None:
    exciter = random_exciter(25)
    dataset = steady(exciter)
    got = dataset.floquet_multiplier_sensitivity.sel(parameter="nu").values
    expected = differences(exciter, dataset, "nu", 1e-6)["floquet_multiplier"]
    assert abs(expected[0]) > 1000 * abs(dataset.floquet_multiplier.values[0])
    np.testing.assert_allclose(got, expected, rtol=1e-7, atol=1e-10)


@pytest.mark.parametrize("seed", range(8))
def test_stated_errors_hold(seed: int) -> None:
    for name, ratio in error_ratios(random_exciter(seed)).items():
        assert ratio < 2.0, name


@pytest.mark.slow
def test_stated_errors_hold_for_2000_exciters() -> None:
    every = [error_ratios(random_exciter(seed)) for seed in range(2000)]
    for name in every[0]:
        ratios = np.array([each[name] for each in every])
        assert (ratios > 1.0).mean() <= 0.02, name
        assert ratios.max() < 3.0, name
        # An error that is always far too large would pass as well.
        assert np.median(ratios) > 0.0005, name


def test_a_sweep_to_an_accuracy_has_the_errors_of_its_rows() -> None:
    exciter = replace(SOFT, friction=0.05)
    ds = vp.sweep(exciter, {"nu": [0.7, 0.9, 1.4]}, accuracy=1e-10)
    assert (ds.status == Status.OK).all()
    assert ((ds.error > 1e-17) & (ds.error < 1e-11)).all()
    strict = vp.sweep(exciter, {"nu": [0.7, 0.9, 1.4]}, accuracy=1e-15)
    assert (strict.status == Status.INACCURATE).any()
