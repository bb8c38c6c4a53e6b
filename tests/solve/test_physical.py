"""Datasets in SI: against an integration in SI, the scale of lengths, and a mass M in place of m/M."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

import vibropipe as vp
from vibropipe.solve.physical import physical_grid
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.words.outputs import OUTPUTS
from vibropipe.words.vocabulary import VOCABULARY, physical_quantity, quantity

M, C, H, F, OMEGA, L, DELTA, R1, R2 = 2.0, 8000.0, 40.0, 120.0, 55.0, 0.008, 0.001, 0.7, 0.6
P = math.sqrt(C / M)
EXCITER = vp.Exciter.from_physical(m=M, C=C, H=H, F=F, omega=OMEGA, l=L, delta=DELTA, R1=R1, R2=R2)


def integrate(t_end: float) -> dict[str, np.ndarray | float]:
    """Return impacts, end state and energies of m x'' + H x' + C x = F sin(omega t) between the supports."""

    def rates(t, state):
        x, v = state[:2]
        force = F * math.sin(OMEGA * t)
        return [v, (force - H * v - C * x) / M, force * v, H * v * v]

    def upper(t, state):
        return state[0] - (L + DELTA)

    def lower(t, state):
        return state[0] + (L - DELTA)

    for event, direction in ((upper, 1), (lower, -1)):
        event.terminal, event.direction = True, direction
    t, state, impacts, lost = 0.0, np.zeros(4), [], [0.0, 0.0]
    while t < t_end:
        run = solve_ivp(
            rates, (t, t_end), state, method="DOP853", rtol=1e-12, atol=1e-15,
            events=(upper, lower),
        )  # fmt: skip
        t, state = run.t[-1], run.y[:, -1].copy()
        if run.status == 1:
            support = 1 if run.t_events[0].size else 2
            restitution = R1 if support == 1 else R2
            impacts.append((t, support, state[1], -restitution * state[1]))
            lost[support - 1] += 0.5 * M * (1 - restitution**2) * state[1] ** 2
            state[1] *= -restitution
    times, supports, before, after = map(np.array, zip(*impacts, strict=True))
    return {
        "impact_time": times, "impact_support": supports, "impact_velocity": before,
        "impact_velocity_after": after, "displacement_end": state[0], "velocity_end": state[1],
        "energy_input": state[2], "energy_damping": state[3], "energy_impact": np.array(lost),
        "energy_change": 0.5 * C * state[0] ** 2 + 0.5 * M * state[1] ** 2,
    }  # fmt: skip


def test_a_motion_in_si_is_that_of_the_equation_in_si() -> None:
    t_end = 0.9
    motion = vp.simulate(EXCITER, tau_end=t_end * P, energy=True)
    physical = vp.to_physical(motion, "2 kg", "8 N/mm")
    expected = integrate(t_end)
    assert physical.sizes["impact"] > 12
    for name, values in expected.items():
        np.testing.assert_allclose(physical[name], values, rtol=1e-8, err_msg=name)
    assert physical["time"].values[-1] == pytest.approx(t_end, rel=1e-15)
    np.testing.assert_allclose(
        physical["force"], F * np.sin(OMEGA * physical["time"]), rtol=0, atol=1e-10 * F
    )
    given = {"m": M, "C": C, "H": H, "F": F, "omega": OMEGA, "l": L, "delta": DELTA}
    assert {name: float(physical[name]) for name in given} == given
    assert physical.attrs["start"] == "x0 = 0 m, v0 = 0 m/s"


def test_every_variable_states_its_unit_in_si() -> None:
    physical = vp.to_physical(vp.simulate(EXCITER, tau_end=20.0, energy=True), M, C)
    units = {name: variable.attrs["units"] for name, variable in physical.variables.items()}
    assert {name: unit for name, unit in units.items() if unit != "1"} == {
        "time": "s", "omega": "rad s-1", "F": "N", "H": "N s m-1", "l": "m", "delta": "m",
        "m": "kg", "C": "N m-1", "displacement": "m", "velocity": "m s-1", "force": "N",
        "displacement_end": "m", "velocity_end": "m s-1", "impact_time": "s",
        "impact_velocity": "m s-1", "impact_velocity_after": "m s-1", "rest_start": "s",
        "rest_end": "s", "grazing_time": "s", "energy_input": "J", "energy_damping": "J",
        "energy_impact": "J", "energy_change": "J", "energy_residual": "J",
    }  # fmt: skip
    assert physical["time"].attrs["symbol"] == "$t$"
    assert physical["rest_start"].attrs["symbol"] == "$t_{rest}$"
    assert physical["omega"].attrs["long_name"] == "angular frequency of excitation"


# Powers of the unit of length, by the dimension; times do not depend on it.
POWERS = {"length": 1, "velocity": 1, "force": 1, "energy": 2, "power": 2, "impulse": 1}


def datasets(unit: float) -> dict[str, xr.Dataset]:
    """Return datasets of all quantities, with lengths that are `unit` times larger."""
    exciter = vp.Exciter(
        l=0.5 * unit, nu=0.9, f=0.8 * unit, h=0.15, delta=0.125 * unit, R1=0.7, R2=0.6
    )
    symmetric = vp.Exciter(l=0.5 * unit, nu=0.9, f=0.8 * unit, h=0.15, R1=0.7, R2=0.7)
    newmark = {"method": "newmark", "steps_per_period": 64}
    return {
        "motion": vp.simulate(exciter, tau_end=30.0, energy=True),
        "newmark": vp.simulate(exciter, tau_end=30.0, **newmark),
        "rest": vp.simulate(vp.Exciter(l=0.5 * unit, nu=0.2, f=2.0 * unit, R1=0.3), tau_end=30.0),
        "steady": vp.steady_state(exciter),
        "sweep": vp.sweep(exciter, over={"nu": [0.6, 0.9, 1.7]}, outputs=OUTPUTS),
        "symmetric": vp.symmetric_orbit(symmetric),
        "one-sided": vp.one_sided_orbit(exciter),
        "boundaries": vp.symmetric_orbit_boundaries(symmetric, nu=[0.9, 1.5]),
        "branch": vp.branch(symmetric, "nu", (0.8, 2.0)),
        "branch of f": vp.branch(symmetric, "f", (0.6 * unit, 0.9 * unit)),
        "free": vp.amplitude_frequency(exciter, amplitude=np.array([0.25, 0.5, 1.0]) * unit),
    }


def test_every_length_in_the_data_has_the_dimension_of_a_length() -> None:
    # The unit of length is free: a power of two scales exactly what the vocabulary says, and nothing else.
    unit = 2.0**10
    for (name, small), large in zip(datasets(1.0).items(), datasets(unit).values(), strict=True):
        for key, variable in small.variables.items():
            if variable.dtype.kind not in "fc":
                continue
            power = POWERS.get(quantity(str(key)).dimension, 0)
            if str(key).endswith("_sensitivity"):
                names = small["parameter"].values
                power = power - np.array([POWERS.get(quantity(n).dimension, 0) for n in names])
            np.testing.assert_array_equal(
                large[key].values,
                variable.values * unit ** np.asarray(power),
                err_msg=f"{name}: {key}",
            )


def test_a_sweep_in_si_has_the_frequencies_that_were_given() -> None:
    omega = np.linspace(20.0, 200.0, 37)
    sweep = vp.sweep(EXCITER, over={"nu": omega / P, "f": [F / C, 2 * F / C]}, follow=("nu", "up"))
    physical = vp.to_physical(sweep, M, C)
    np.testing.assert_array_equal(physical["omega"], omega)
    np.testing.assert_array_equal(physical["F"], [F, 2 * F])
    assert physical["displacement_amplitude"].dims == ("omega", "F", "harmonic")
    assert float(physical["impact_velocity_max"].sel(omega=55, F=120, support=1)) == pytest.approx(
        float(sweep["impact_velocity_max"].isel(nu=7, f=0, support=0)) * P, rel=1e-15
    )
    np.testing.assert_allclose(physical["base_frequency"], sweep["base_frequency"] * P, rtol=1e-15)
    xr.testing.assert_equal(
        physical["displacement_phase"].variable,
        sweep["displacement_phase"].rename(nu="omega", f="F").variable,
    )
    grid = SweepGrid(
        {"nu": omega / P, "f": np.array([F / C, 2 * F / C])}, ("nu", "up"), {"h": EXCITER.h}
    )
    stored = physical_grid(grid, M, C)
    assert (stored.dims, stored.follow) == (("omega", "F"), ("omega", "up"))
    assert stored.shared == {"H": H, "m": M, "C": C}
    np.testing.assert_array_equal(stored.values["omega"], physical["omega"])


def test_the_backbone_is_in_si() -> None:
    tau_bar = np.array([4.0, 5.0, 6.0])
    physical = vp.to_physical(vp.backbone([0.0, 0.2], tau_bar), M, C)
    assert physical["velocity_over_l"].dims == ("delta_over_l", "free_period")
    np.testing.assert_allclose(physical["free_period"], tau_bar / P, rtol=1e-15)
    np.testing.assert_allclose(physical["omega_bar"], 2 * np.pi * P / tau_bar, rtol=1e-15)
    assert physical["velocity_over_l"].attrs["units"] == "s-1"


def test_lazy_data_stay_lazy() -> None:
    sweep = vp.sweep(EXCITER, over={"nu": [0.5, 0.9]})
    lazy = vp.to_physical(sweep.chunk(), M, C)
    assert lazy["displacement_mean"].chunks is not None
    xr.testing.assert_identical(lazy.compute(), vp.to_physical(sweep, M, C))


def test_a_dataset_is_not_converted_twice_and_keeps_the_one_it_was_made_of() -> None:
    motion = vp.simulate(EXCITER, tau_end=5.0)
    before = motion.copy(deep=True)
    physical = vp.to_physical(motion, M, C)
    xr.testing.assert_identical(motion, before)
    with pytest.raises(
        vp.ParameterError, match=r"^dataset: must be non-dimensional, got one in SI$"
    ):
        vp.to_physical(physical, M, C)
    with pytest.raises(vp.ParameterError, match=r"^C: .*got '8 N' \(N is no unit of stiffness\)$"):
        vp.to_physical(motion, M, "8 N")


def test_names_in_si_are_distinct() -> None:
    names = [name for name in VOCABULARY if quantity(name).dimension]
    assert {"time", "omega", "F", "H", "impact_time"} <= {*names}
    assert physical_quantity("tau").units == quantity("time").units == "s"
    assert physical_quantity("tau_error").units == "s"


m = 0.35
GIVEN = {
    "m": m,
    "C": 6000.0,
    "H": 4.583,
    "F": 12.0,
    "l": 0.004,
    "omega": 188.5,
    "R1": 0.6,
    "R2": 0.75,
}
HOUSED = vp.Exciter.from_physical(**GIVEN, M=1.0, D1=0.5, D2=0.8)


def test_sensitivities_are_those_by_the_mass():
    told = vp.to_physical(
        vp.steady_state(HOUSED, outputs=["harmonics", "impacts", "sensitivity"]), HOUSED
    )
    of_mass = told.sel(parameter="M")
    for name in ("housing_velocity_mean", "impact_velocity_max"):
        above, below = (
            vp.to_physical(
                vp.steady_state(vp.Exciter.from_physical(**GIVEN, M=mass, D1=0.5, D2=0.8)), HOUSED
            )[name]
            for mass in (1.0001, 0.9999)
        )  # fmt: skip
        assert np.allclose(of_mass[f"{name}_sensitivity"], (above - below) / 2e-4, rtol=1e-5)


def test_deviations_of_the_mass_and_of_its_ratio_are_one():
    known = vp.tolerance(HOUSED, {"mass_ratio": 0.35**2 / m * 0.01, "R1": 0.01}, samples=64)
    told = vp.tolerance(HOUSED, {"M": "10 g", "R1": 0.01}, samples=64)
    assert float(told.M_std) == pytest.approx(0.01)
    assert told.M_std.attrs["units"] == "kg"
    assert np.allclose(vp.to_physical(known, HOUSED).M_std, 0.01)
    for name in ("impact_velocity_max_std", "housing_velocity_mean_contribution"):
        assert np.allclose(told[name], vp.to_physical(known, HOUSED)[name])
    # a part with a greater mass moves the quantity as its derivative says
    moved = told.housing_velocity_mean_deviation.sel(parameter="M", side="above")
    assert float(moved) == pytest.approx(
        0.03 * float(told.housing_velocity_mean_sensitivity.sel(parameter="M")), rel=0.05
    )


def test_what_is_derived_from_a_ratio_follows_the_mass():
    per_ratio = ("bifurcation", "parameter")
    dataset = xr.Dataset(
        {
            "mass_ratio_lower": 0.25,
            "mass_ratio_upper": 0.5,
            "mass_ratio_tolerance": ("design", [0.001, 0.002]),
            "bifurcation_mass_ratio": ("bifurcation", [0.35, 0.7]),
            "bifurcation_mass_ratio_std": ("bifurcation", [0.01, 0.02]),
            "bifurcation_mass_ratio_sensitivity": (per_ratio, [[1.0, 2.0], [3.0, 4.0]]),
            "parameter_covariance": (("parameter", "other_parameter"), [[4.0, 1.0], [1.0, 9.0]]),
        },
        {
            "mass_ratio": ("design", [0.35, 0.5]),
            "parameter": ["R1", "nu"],
            "other_parameter": ["R1", "nu"],
        },
        {"subject_to": "mass_ratio < 0.4"},
    )
    found = vp.to_physical(dataset, "0.35 kg", "0.35 N/m")
    assert np.allclose([found.M_lower, found.M_upper], [0.7, 1.4])
    assert np.allclose(found.M_tolerance, [0.35 / 0.35**2 * 0.001, 0.35 / 0.5**2 * 0.002])
    assert np.allclose(found.bifurcation_M, [1.0, 0.5])
    assert np.allclose(found.bifurcation_M_std, [0.01 * 0.35 / 0.35**2, 0.02 * 0.35 / 0.7**2])
    slopes = np.array([-0.35 / 0.35**2, -0.35 / 0.7**2])[:, None] * [[1.0, 2.0], [3.0, 4.0]]
    assert np.allclose(found.bifurcation_M_sensitivity, slopes)
    assert found.attrs["subject_to"] == "mass_ratio < 0.4"

    found = vp.to_physical(
        dataset.isel(design=0).assign_coords(
            parameter=["mass_ratio", "R1"], other_parameter=["mass_ratio", "R1"]
        ),
        "0.35 kg", "0.35 N/m",
    )  # fmt: skip
    by = -1.0 / 0.35
    assert np.allclose(found.parameter_covariance, [[4.0 * by**2, by], [by, 9.0]])
    assert list(found.other_parameter) == ["M", "R1"]


def test_a_deviation_of_a_mass_needs_one_mass():
    held = vp.Exciter.from_physical(**GIVEN)
    with pytest.raises(vp.ParameterError, match="M: must be left out: the housing is fixed"):
        vp.tolerance(held, {"M": "10 g"})
    with pytest.raises(vp.ParameterError, match="M: must be left out beside a range of mass_ratio"):
        vp.design(
            HOUSED,
            {"mass_ratio": (0.3, 0.4)},
            {"impact_velocity_max_1": "0.4 m/s"},
            tolerance={"M": "10 g"},
        )
