"""Sweeps and branches over parameters with units: those without, converted."""

from __future__ import annotations

import numpy as np
import pint
import pytest
import xarray as xr

import vibropipe as vp

UNITS = pint.UnitRegistry()
EXCITER = vp.Exciter.from_physical(
    m="0.35 kg", C="6 N/mm", H="4.583 N s/m", F="12 N", l="4 mm", omega="30 Hz", R1=0.6, R2=0.75
)
P = np.sqrt(6000.0 / 0.35)
HERTZ = np.array([20.0, 30.0, 40.0])
PLAIN = vp.to_physical(vp.sweep(EXCITER, {"nu": 2 * np.pi * HERTZ / P, "R1": [0.5, 0.6]}), EXCITER)


@pytest.mark.parametrize(
    "omega",
    [
        ["20 Hz", "30 Hz", "40 Hz"],
        HERTZ * UNITS.Hz,
        [h * UNITS.Hz for h in HERTZ],
        2 * np.pi * HERTZ,
    ],
    ids=["text", "a quantity", "quantities", "numbers in SI"],
)
def test_a_sweep_over_omega_is_that_over_nu_in_si(omega):
    rows = vp.sweep(EXCITER, {"omega": omega, "R1": [0.5, 0.6]})
    assert rows.identical(PLAIN)


def test_lengths_and_starts_have_units_too():
    over, plain = {"delta": ["0 mm", "0.1 mm"]}, {"delta": [0.0, 1e-4]}
    rows = vp.sweep(EXCITER, {**over, "v0": ["0 mm/s", "300 mm/s"]}, x0="1 mm")
    expected = vp.sweep(EXCITER, {**plain, "v0": [0.0, 0.3 / P]}, x0=1e-3)
    assert rows.identical(vp.to_physical(expected, EXCITER))
    assert rows.delta.attrs["units"] == "m"
    followed = vp.sweep(EXCITER, {"omega": HERTZ * UNITS.Hz}, follow=("omega", "up"))
    nu = {"nu": 2 * np.pi * HERTZ / P}
    assert followed.identical(vp.to_physical(vp.sweep(EXCITER, nu, follow=("nu", "up")), EXCITER))


def test_a_branch_over_omega_is_that_over_nu_in_si():
    ends = ("15 Hz", "50 Hz")
    branch = vp.branch(
        EXCITER, "omega", ends, v0="0.5 m/s", harmonics=1, tolerance={"F": "0.1 N"}, at=("25 Hz",)
    )
    plain = vp.branch(
        EXCITER, "nu", tuple(2 * np.pi * np.array([15.0, 50.0]) / P), v0=0.5 / P, harmonics=1,
        tolerance={"f": 0.1 / 6000.0}, at=(2 * np.pi * 25.0 / P,),
    )  # fmt: skip
    assert branch.identical(vp.to_physical(plain, EXCITER))
    assert (np.abs(branch.omega.values - 2 * np.pi * 25.0) < 1e-9).any()
    # one value with a unit is enough
    nu = tuple(2 * np.pi * np.array([15.0, 50.0]) / P)
    mixed = vp.branch(EXCITER, "nu", nu, v0=0.5, harmonics=1, tolerance={"delta": "10 um"})
    plain = vp.branch(EXCITER, "nu", nu, v0=0.5 / P, harmonics=1, tolerance={"delta": 1e-5})
    assert mixed.sizes == plain.sizes
    np.testing.assert_allclose(
        mixed.bifurcation_omega_std, plain.bifurcation_nu_std * P, rtol=1e-9, equal_nan=True
    )
    law = vp.branch(EXCITER, "omega", ends, law=(1, 1, 1), harmonics=1)
    assert law.attrs["law"] == "(1; 1, 1)"
    assert law.omega.attrs["units"] == "rad s-1"


@pytest.mark.parametrize(
    ("over", "message"),
    [
        ({"omega": ["20 mm"]}, "mm is no unit of frequency"),
        ({"omega": ["-3 Hz"]}, "omega: must be a finite number > 0"),
        ({"M": ["1 kg"]}, "M: must be given as mass_ratio = m/M where it varies"),
        ({"omega": ["20 Hz"], "v0": ["1 mm"]}, "v0: must be"),
        (
            {"m": ["1 kg", "2 kg"]},
            "^m: does not vary in a call: make an exciter for each value. What varies is omega, F, ",
        ),
        ({"C": [6000.0]}, "^C: does not vary in a call"),
        (
            {"m_e": ["1 g"]},
            "^m_e: does not vary in a call: vary shaker, which is m_e e / m, in its place$",
        ),
        ({"slope": [0.1]}, "^slope: does not vary in a call: vary load"),
    ],
)
def test_wrong_units_are_told(over, message):
    with pytest.raises(vp.ParameterError, match=message):
        vp.sweep(EXCITER, over)


def test_an_exciter_without_units_knows_no_omega():
    plain = vp.Exciter(l=0.5, f=1.0, nu=1.0)
    with pytest.raises(vp.ParameterError, match=r"got 'omega' \(did you mean 'nu'\?\)"):
        vp.sweep(plain, {"omega": [1.0]})


def test_boundaries_and_basins_have_units_too():
    found = vp.boundary(
        EXCITER, "grazing", ("omega", "F"), (("20 Hz", "40 Hz"), ("8 N", "16 N")), lines=2
    )
    nu = tuple(2 * np.pi * np.array([20.0, 40.0]) / P)
    plain = vp.boundary(EXCITER, "grazing", ("nu", "f"), (nu, (8 / 6000.0, 16 / 6000.0)), lines=2)
    assert found.identical(vp.to_physical(plain, EXCITER))
    x0, v0 = np.linspace(-3.0, 3.0, 5), np.linspace(-0.5, 0.5, 5)
    basins = vp.basins(EXCITER, x0 * UNITS.mm, v0 * UNITS.m / UNITS.s)
    expected = vp.to_physical(vp.basins(EXCITER, 1e-3 * x0, v0 / P), EXCITER)
    np.testing.assert_array_equal(basins.attractor, expected.attractor)
    np.testing.assert_allclose(basins.x0, 1e-3 * x0)
    assert basins.v0.attrs["units"] == "m s-1"


@pytest.mark.slow
def test_designs_have_units_too():
    found = vp.design(
        EXCITER,
        vary={"F": ("8 N", "16 N"), "delta": ("-0.5 mm", "0.5 mm")},
        target={"impact_velocity_max_1": 0.55 * UNITS.m / UNITS.s},
        subject_to={
            "impact_velocity_max_2": "> 0.1, < 700 mm/s",
            "impacts_per_period_1": (0.9, 1.1),
        },
        minimise="F",
        tolerance={"delta": "0.01 mm"},
        allow={"impact_velocity_max_1": "20 mm/s"},
        v0="0.2 m/s",
        samples=64,
        designs=2,
    )
    plain = vp.design(
        EXCITER,
        vary={"f": (8 / 6000.0, 16 / 6000.0), "delta": (-0.5e-3, 0.5e-3)},
        target={"impact_velocity_max_1": 0.55 / P},
        subject_to={
            "impact_velocity_max_2": (0.1 / P, 0.7 / P),
            "impacts_per_period_1": (0.9, 1.1),
        },
        minimise="f",
        tolerance={"delta": 1e-5},
        allow={"impact_velocity_max_1": 0.02 / P},
        v0=0.2 / P,
        samples=64,
        designs=2,
    )
    expected = vp.to_physical(plain, EXCITER)
    assert found.sizes == expected.sizes
    np.testing.assert_allclose(found.F, expected.F, rtol=1e-9)
    np.testing.assert_allclose(found.impact_velocity_max.isel(design=0, support=0), 0.55, rtol=1e-8)
    assert float(found.impact_velocity_max.isel(design=0, support=1)) < 0.7
    assert 8.0 < float(found.F[0]) < 16.0
    assert (found["yield"] == expected["yield"]).all()
    in_si = vp.design(
        EXCITER,
        {"F": (8.0, 16.0)},
        target={"impact_velocity_max_1": 0.5},
        v0=0.2,
        samples=64,
        designs=1,
    )
    np.testing.assert_allclose(in_si.impact_velocity_max.values[0, 0], 0.5, rtol=1e-8)


def test_what_a_design_with_units_misses_is_told_without_numbers():
    with pytest.warns(vp.UnsolvedWarning, match="No design that was found is met: ") as told:
        found = vp.design(
            EXCITER,
            {"F": ("11 N", "12 N")},
            v0=0.2,
            target={"impact_velocity_max_1": "0.9 m/s"},
            samples=16,
        )
    assert found.design_result.values[0] != 0
    assert "0.9" not in str(told[0].message)


@pytest.mark.parametrize(
    ("goals", "message"),
    [
        ({"target": {"impact_velocity_max_1": "0.5 mm"}}, "target.impact_velocity_max_1: must be"),
        (
            {"subject_to": {"impact_velocity_max_1": "< 5 N"}},
            "subject_to.impact_velocity_max_1: must be",
        ),
        ({"target": {"impact_velocity": "1 m/s"}}, "impact_velocity"),
        ({"subject_to": {"impact_velocity_max_1": "less than 1 m/s"}}, "impact_velocity_max_1"),
    ],
)
def test_goals_with_wrong_units_are_told(goals, message):
    with pytest.raises(vp.ParameterError, match=message):
        vp.design(EXCITER, {"F": ("8 N", "16 N")}, **goals)


def test_tolerances_have_units_too():
    spread = vp.tolerance(EXCITER, {"delta": "0.01 mm", "F": 0.1 * UNITS.N, "R1": 0.01}, samples=64)
    plain = vp.tolerance(EXCITER, {"delta": 1e-5, "f": 0.1 / 6000.0, "R1": 0.01}, samples=64)
    expected = vp.to_physical(plain, EXCITER)
    assert spread.sizes == expected.sizes
    np.testing.assert_allclose(
        spread.displacement_mean_std, expected.displacement_mean_std, rtol=1e-9
    )
    assert spread.displacement_mean_std.attrs["units"] == "m"


def test_motions_and_steady_states_take_starts_and_times_with_units():
    given = {
        "m": "2 kg",
        "C": "200 N/m",
        "H": "3 kg/s",
        "F": "1.2 N",
        "l": "5 mm",
        "R1": 0.7,
        "R2": 0.6,
    }
    exciter = vp.Exciter.from_physical(**given, omega="18 rad/s")
    p = 10.0  # rad/s
    plain = vp.to_physical(vp.simulate(exciter, 2 * p, 1e-3, 3e-3 / p, tau_start=0.1 * p), exciter)
    motion = vp.simulate(exciter, "2 s", x0="1 mm", v0="3 mm/s", tau_start="100 ms")
    xr.testing.assert_allclose(motion, plain, rtol=1e-12)
    assert motion["displacement"].attrs["units"] == "m"
    assert float(motion["time"][-1]) == pytest.approx(2.0, rel=1e-12)
    # the end that is left out is that of a motion without units
    assert float(vp.simulate(exciter, x0="1 mm")["time"][-1]) == pytest.approx(60.0 / p)
    ramp = vp.simulate(exciter, 4.0, x0="0 mm", nu_end="25 rad/s")
    assert float(ramp["omega_end"]) == pytest.approx(25.0)
    row = vp.steady_state(exciter, x0="1 mm", v0="10 mm/s")
    same = vp.to_physical(vp.steady_state(exciter, 1e-3, 0.01 / p), exciter)
    xr.testing.assert_allclose(row, same, rtol=1e-12)
    for name, call in (
        ("x0", lambda: vp.simulate(exciter, x0="1 kg")),
        ("tau_end", lambda: vp.simulate(exciter, "2 mm")),
        ("housing_v0", lambda: vp.simulate(exciter, "2 s", housing_v0="1 mm")),
        ("v0", lambda: vp.steady_state(exciter, v0="1 mm")),
    ):
        with pytest.raises(vp.ParameterError, match=f"{name}: must be"):
            call()


SPEED = {"impact_velocity_max_1": "> 1 m/s, < 0.5 m/s"}


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: vp.sweep(EXCITER, {"omega": [-8]}), "over.omega: must be a finite number > 0, got [-8]"),
        (lambda: vp.branch(EXCITER, "omega", ("5 Hz", "8 Hz")), "(omega = 30 Hz), got ('5 Hz', '8 Hz')"),
        (lambda: vp.branch(EXCITER, "omega", "40 Hz", at=["50 Hz"]),
         "at: must be numbers from 30 to 40 Hz (omega), got ['50 Hz']"),
        (lambda: vp.branch(EXCITER, "omega", 200.0, at=[9]), " to 200 rad/s (omega), got [9]"),
        (lambda: vp.branch(EXCITER, "nu", 5.0, at=[9]), " to 5.0 (nu), got [9]"),
        (lambda: vp.branch(EXCITER, "omega", "30 Hz"), "must differ from the exciter's own omega, got '30 Hz'"),
        (lambda: vp.simulate(EXCITER, "1 s", x0="60 mm"),
         "x0: must be a finite number from -4 to 4 mm (between the supports), got '60 mm'"),
        (lambda: vp.sweep(EXCITER, {"x0": ["1 mm", "0.9 m"]}),
         "over.x0: must be a finite number from -4 to 4 mm (between the supports), got ['1 mm', '0.9 m']"),
        (lambda: vp.sweep(EXCITER, {"omega": ["9 Hz"]}, x0=0.06),
         "x0: must be a finite number from -0.004 to 0.004 m (between the supports), got 0.06"),
        (lambda: vp.sweep(EXCITER, {"H1": ["1 N s/m"]}),
         "must be 0 where C1 = 0: a rigid support has a restitution, no damping, got ['1 N s/m']"),
        (lambda: vp.simulate(EXCITER, "1e9 s"), " steps of the march, got '1e9 s' with 3.9e+11 steps"),
        (lambda: vp.design(EXCITER, {"F": ("2 N", "1 N")}, {"velocity_mean": 1}),
         "vary.F: must be a pair of increasing numbers, got ('2 N', '1 N')"),
        (lambda: vp.design(EXCITER, {"F": ("1 N", "2 N")}, subject_to=SPEED),
         "subject_to.impact_velocity_max_1: must have its lower bound below the upper one, got '> 1 m/s, < 0.5 m/s'"),
        (lambda: vp.tolerance(EXCITER, {"F": "-1 N"}), "tolerances.F: must be a finite number > 0, got '-1 N'"),
        (lambda: vp.simulate(EXCITER, "1 s", tau_start="2 s"),
         "tau_end: must be a finite number >= tau_start, got '1 s'"),
        (lambda: vp.simulate(EXCITER, "1 s", nu_end=-2), "nu_end: must be a finite number > 0, got -2"),
        (lambda: vp.simulate(EXCITER, "3"), "got '3' (it has no unit)"),
        (lambda: vp.sweep(EXCITER, {"nu": [9, 9]}), "over.nu: must be values that differ from each other, got [9, 9]"),
        (lambda: vp.boundary(EXCITER, "fold", ("omega", "C1"), (("9 Hz", "20 Hz"), ("0 N/mm", "9 N/mm"))),
         "C1: must be above 0 where it varies, since 0 stands for a rigid support, got 0.0"),
        (lambda: vp.sweep(EXCITER, {"delta": ["1 km"], "l": ["1e-15 m"], "omega": ["9 Hz"]}),
         " distinct floating-point numbers, got l = 1e-15 m, delta = 1000.0 m"),
        (lambda: vp.sweep(EXCITER, {"load": ["6 MN"], "l": ["1e-15 m"], "omega": ["9 Hz"]}),
         "l: must be at least 1e-15 |delta - load/C| so that the supports are distinct floating-point numbers, "
         "got l = 1e-15 m, delta = 0.0 m, load/C = 1000.0 m"),
    ],
)  # fmt: skip
def test_errors_speak_of_what_was_given(call, message):
    with pytest.raises(vp.ParameterError) as error:
        call()
    assert str(error.value).endswith(message)
