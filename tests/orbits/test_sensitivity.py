"""The output `sensitivity`: derivatives of orbits against long arithmetic, closed forms, mirrors and differences."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import mpmath as mp
import numpy as np
import pytest
from long_orbits import sensitivities

import vibropipe as vp
from vibropipe.words.bifurcations import Bifurcation

OUTPUTS = ("harmonics", "impacts", "stability", "energy", "lyapunov", "subharmonics", "sensitivity")
TWO_SIDED = vp.Exciter(l=1.0, nu=0.8, f=0.9, h=0.2, delta=0.1, R1=0.7, R2=0.6)
WITH_REST = vp.Exciter(l=1.0, nu=0.3, f=1.3, h=0.1, delta=0.1, R1=0.3, R2=0.5)
LINEAR = vp.Exciter(l=1.0, nu=0.8, f=0.2, h=0.2, delta=0.1, R1=0.7, R2=0.6)
REST_UNDER_TWO = replace(WITH_REST, f2=0.2, phi2=0.4)
BASIC = ("nu", "f", "h", "l", "delta", "R1", "R2", "load")
SUFFIX = "_sensitivity"
HOPS = 12
MULTIPLIERS = ("floquet_multiplier", "lyapunov_exponent")


def steady(exciter, **options):
    return vp.steady_state(exciter, harmonics=3, **{"outputs": OUTPUTS, **options})


@pytest.mark.parametrize(
    "exciter",
    [
        TWO_SIDED,
        vp.Exciter(l=1.0, nu=2.6, f=2.0, h=0.05, delta=0.6, R1=0.8, R2=0.8),
        vp.Exciter(l=1.0, nu=0.8, f=0.9, h=0.2, delta=0.1, R1=0.7, R2=0.6, load=0.15),
        # Near resonance without damping, where harmonics come from quadrature, and near critical damping.
        vp.Exciter(l=1.0, nu=1.0 + 2.0**-20, f=0.6, delta=0.1, R1=0.7, R2=0.6),
        vp.Exciter(l=1.0, nu=0.8, f=3.0, h=2.0 - 2.0**-30, delta=0.1, R1=0.7, R2=0.6),
        # A second harmonic: flights of one step and of several, resonance of each harmonic, no first harmonic.
        vp.Exciter(l=1.0, nu=0.8, f=0.9, f2=0.4, phi2=0.7, h=0.2, delta=0.1, R1=0.7, R2=0.6),
        vp.Exciter(l=1.0, nu=2.6, f=2.0, f2=1.1, phi2=-2.0, h=0.05, delta=0.6, R1=0.8, R2=0.8),
        vp.Exciter(l=1.0, nu=0.5, f=1.2, f2=0.3, h=1e-4, delta=0.1, R1=0.7, R2=0.6),
        vp.Exciter(l=1.0, nu=1.0, f=1.2, f2=-0.3, h=1e-4, delta=0.1, R1=0.7, R2=0.6),
        # An orbit of three periods.
        vp.Exciter(l=1.0, nu=0.85, f=0.3, h=0.2, delta=0.1, R1=0.7, R2=0.6),
    ],
)
def test_derivatives_agree_with_long_arithmetic(exciter):
    dataset = steady(exciter)
    values, slopes = sensitivities(dataset, 3)
    for name, expected in slopes.items():
        own = values[name].real % 1.0 if name == "impact_phase" else values[name]
        np.testing.assert_allclose(dataset[name].values.ravel(), own, rtol=1e-9, atol=1e-11)
        got = dataset[name + SUFFIX].values.reshape(expected.shape)
        is_struck = ~np.isnan(expected).all(axis=-1)
        assert (np.isnan(got).all(axis=-1) == ~is_struck).all()
        scale = np.abs(expected[is_struck]).max(axis=-1, keepdims=True)
        error = np.abs(got - expected)[is_struck]
        # The multipliers of the resonant case are nearly equal, and as sensitive as their difference is small.
        tolerance = 1e-6 if exciter.h == 0.0 and name in MULTIPLIERS else 1e-8
        assert (error <= tolerance * scale).all(), name


def differences(exciter, dataset, name, parameter, step):
    """Return the derivative of a quantity by differences of fourth order."""
    x, v = float(dataset.displacement_strobe), float(dataset.velocity_strobe)
    change = 0.0
    for factor, weight in ((1, 8), (-1, -8), (2, -1), (-2, 1)):
        moved = replace(exciter, **{parameter: getattr(exciter, parameter) + factor * step})
        start = min(max(x, moved.lower), moved.upper)
        # A chatter is summed from some hop on: its first hops are in every list.
        values = steady(moved, x0=start, v0=v)[name].values
        change = change + weight * (values[:HOPS] if name == "impact_phase" else values)
    return change / (12 * step)


@pytest.mark.parametrize(
    ("exciter", "parameter"),
    [
        *((WITH_REST, name) for name in BASIC),
        *((REST_UNDER_TWO, name) for name in (*BASIC, "f2", "phi2")),
    ],
)
def test_derivatives_through_chatter_and_rest_agree_with_differences(exciter, parameter):
    dataset = steady(exciter)
    rests = [0.0, 1.0] if exciter.f2 else [1.0, 1.0]
    assert dataset.rests_per_orbit.values.tolist() == rests
    for name in ("displacement_mean", "displacement_amplitude", "impact_phase", "energy_damping"):
        expected = differences(exciter, dataset, name, parameter, 1e-4)
        got = dataset[name + SUFFIX].sel(parameter=parameter).values
        got = got[:HOPS] if name == "impact_phase" else got
        # Rounding of the differences, and their fourth order.
        np.testing.assert_allclose(got, expected, rtol=1e-7, atol=1e-9 * np.abs(got).max() + 1e-9)
    assert (dataset[f"floquet_multiplier{SUFFIX}"] == 0.0).all()
    assert np.isnan(dataset[f"lyapunov_exponent{SUFFIX}"]).all()


def test_a_linear_motion_has_the_derivatives_of_its_closed_form():
    dataset = steady(LINEAR)

    def amplitude(nu, f, h):
        return f / mp.sqrt((1 - nu**2) ** 2 + (h * nu) ** 2)

    own = (LINEAR.nu, LINEAR.f, LINEAR.h)
    for order, name in (((1, 0, 0), "nu"), ((0, 1, 0), "f"), ((0, 0, 1), "h")):
        got = dataset[f"displacement_amplitude{SUFFIX}"].sel(parameter=name, harmonic=1)
        assert float(got) == pytest.approx(float(mp.diff(amplitude, own, order)), rel=1e-12)
    assert (dataset[f"displacement_amplitude{SUFFIX}"].sel(harmonic=[2, 3]) == 0.0).all()
    assert np.isnan(dataset[f"displacement_phase{SUFFIX}"].sel(harmonic=[2, 3])).all()
    assert (
        dataset[f"displacement_amplitude{SUFFIX}"].sel(parameter=["l", "delta", "R1"]) == 0
    ).all()


def test_a_linear_motion_under_two_harmonics_has_the_derivatives_of_its_closed_form():
    exciter = replace(LINEAR, f2=0.1, phi2=0.6)
    dataset = steady(exciter)
    assert int(dataset.impacts_per_orbit.sum()) == 0

    def part(k, nu, f, h, f2, phi2):
        force = f if k == 1 else f2 * mp.expj(phi2)
        return force / (1 - (k * nu) ** 2 + 1j * k * h * nu)

    closed = {
        "displacement_strobe": lambda *p: mp.im(part(1, *p) + part(2, *p)),
        "velocity_strobe": lambda *p: p[0] * mp.re(part(1, *p) + 2 * part(2, *p)),
        "displacement_amplitude": lambda *p: abs(part(2, *p)),
        # Damping takes h times the mean square of the velocity.
        "energy_damping": lambda *p: (
            p[2] * mp.pi * p[0] * (abs(part(1, *p)) ** 2 + 4 * abs(part(2, *p)) ** 2)
        ),
    }
    parameters = ("nu", "f", "h", "f2", "phi2")
    own = tuple(getattr(exciter, name) for name in parameters)
    for name, value in closed.items():
        quantity, got = dataset[name], dataset[name + SUFFIX]
        if "harmonic" in quantity.dims:
            quantity, got = quantity.sel(harmonic=2), got.sel(harmonic=2)
        assert float(quantity) == pytest.approx(float(value(*own)), rel=1e-13), name
        for n, parameter in enumerate(parameters):
            order = tuple(int(n == k) for k in range(len(parameters)))
            expected = float(mp.diff(value, own, order))
            by = float(got.sel(parameter=parameter))
            assert by == pytest.approx(expected, rel=1e-11, abs=1e-15), (name, parameter)


def test_the_derivative_by_a_second_harmonic_that_vanishes_is_that_of_its_neighbours():
    """A sweep from f2 = 0 on has it in every row; one without a second harmonic has no such derivative."""
    step = 1e-4
    swept = vp.sweep(TWO_SIDED, {"f2": [-2 * step, -step, 0.0, step, 2 * step]}, outputs=OUTPUTS)
    weights = np.array([1, -8, 0, 8, -1]) / (12 * step)
    for name in (
        "displacement_mean",
        "displacement_amplitude",
        "energy_input",
        "floquet_multiplier",
    ):
        values = swept[name].values
        expected = (weights[:, None] * values.reshape(5, -1)).sum(axis=0)
        got = swept[name + SUFFIX].sel(parameter="f2").values.reshape(5, -1)[2]
        np.testing.assert_allclose(got, expected, rtol=1e-7, atol=1e-9)
        assert (swept[name + SUFFIX].sel(parameter="phi2").values.reshape(5, -1)[2] == 0.0).all()
    assert steady(TWO_SIDED).parameter.values.tolist() == list(BASIC)


def test_derivatives_do_not_depend_on_the_number_of_harmonics():
    """The work of the second harmonic needs its amplitude, also where it is not stored."""
    exciter = replace(TWO_SIDED, f2=0.4, phi2=0.7)
    one = vp.steady_state(exciter, harmonics=1, outputs=OUTPUTS)
    more = vp.steady_state(exciter, harmonics=4, outputs=OUTPUTS)
    bare = vp.steady_state(exciter, outputs=("energy", "sensitivity"))
    for name in (f"energy_input{SUFFIX}", f"energy_damping{SUFFIX}"):
        np.testing.assert_array_equal(one[name], more[name])
        np.testing.assert_array_equal(bare[name], more[name])


def test_a_mirrored_exciter_has_mirrored_derivatives():
    one, two = steady(TWO_SIDED), steady(TWO_SIDED.mirrored())
    signs = {"f": -1.0, "delta": -1.0, "load": -1.0}
    partner = {"R1": "R2", "R2": "R1"}
    for parameter in one.parameter.values:
        other = partner.get(parameter, parameter)
        sign = signs.get(parameter, 1.0)
        for name, own in (("displacement_mean", -1.0), ("displacement_amplitude", 1.0)):
            got = two[name + SUFFIX].sel(parameter=other).values
            expected = sign * own * one[name + SUFFIX].sel(parameter=parameter).values
            np.testing.assert_allclose(got, expected, rtol=1e-9, atol=1e-12)
        got = two[f"impact_velocity_max{SUFFIX}"].sel(parameter=other).values
        expected = sign * one[f"impact_velocity_max{SUFFIX}"].sel(parameter=parameter).values[::-1]
        np.testing.assert_allclose(got, expected, rtol=1e-9)


SYMMETRIC = vp.Exciter(l=1.0, nu=1.9, f=1.5, h=0.1, R1=0.7, R2=0.7)
ONE_SIDED = vp.Exciter(l=1.0, nu=0.85, f=0.65, h=0.1, delta=0.1, R1=0.7, R2=0.7)


@pytest.mark.parametrize(
    ("exciter", "parameter"),
    [
        *((SYMMETRIC, name) for name in ("nu", "f", "h", "l")),
        *((ONE_SIDED, name) for name in ("f", "delta", "R2")),
    ],
)
def test_an_orbit_has_the_derivatives_of_its_closed_form(exciter, parameter):
    is_symmetric, step, change = exciter is SYMMETRIC, 1e-4, 0.0
    closed = vp.symmetric_orbit if is_symmetric else partial(vp.one_sided_orbit, support=2)
    dataset = steady(exciter)
    assert dataset.impacts_per_orbit.values.tolist() == [float(is_symmetric), 1.0]
    for factor, weight in ((1, 8), (-1, -8), (2, -1), (-2, 1)):
        moved = replace(exciter, **{parameter: getattr(exciter, parameter) + factor * step})
        change += weight * float(closed(moved).impact_velocity[0, 0])
    struck = int(closed(exciter).impact_support[0, 0])
    got = dataset[f"impact_velocity_max{SUFFIX}"].sel(parameter=parameter, support=struck)
    sign = 1.0 if struck == 1 else -1.0
    assert float(got) == pytest.approx(sign * change / (12 * step), rel=1e-8)


@pytest.mark.parametrize(
    "exciter",
    [
        vp.Exciter(l=1.0, delta=0.2),  # conservative: no isolated orbit
        vp.Exciter(l=1.0, nu=2.5, f=1.0, h=0.0, R1=1.0, R2=1.0),  # aperiodic
    ],
)
def test_without_an_isolated_orbit_there_is_no_derivative(exciter):
    dataset = steady(exciter, x0=0.5, v0=1.0, patience=256)
    names = [name for name in dataset.data_vars if name.endswith(SUFFIX)]
    assert len(names) >= 12
    for name in names:
        assert np.isnan(dataset[name]).all(), name
        assert "NaN" in dataset[name].attrs["comment"]


def test_the_output_changes_no_other_number_and_is_absent_unless_requested():
    rest = [name for name in OUTPUTS if name != "sensitivity"]
    plain, full = steady(TWO_SIDED, outputs=rest), steady(TWO_SIDED)
    assert not any(name.endswith(SUFFIX) for name in plain.variables)
    for name in plain.variables:
        assert plain[name].values.tobytes() == full[name].values.tobytes(), name
    alone = steady(TWO_SIDED, outputs=["sensitivity"])
    strobes = {f"displacement_strobe{SUFFIX}", f"velocity_strobe{SUFFIX}"}
    assert {name for name in alone.data_vars if name.endswith(SUFFIX)} == strobes
    np.testing.assert_allclose(
        alone[f"velocity_strobe{SUFFIX}"], full[f"velocity_strobe{SUFFIX}"], rtol=1e-9
    )


def test_points_of_a_branch_have_derivatives_except_at_folds():
    exciter = vp.Exciter(l=1.0, nu=0.85, f=0.65, h=0.1, delta=0.1, R1=0.7, R2=0.7)
    outputs = ["harmonics", "impacts", "stability", "sensitivity"]
    branch = vp.branch(exciter, "nu", (0.7, 1.2), outputs=outputs, harmonics=3, max_step=0.1)
    at = int(np.argmin(np.abs(branch.nu.values - exciter.nu)))
    point = replace(exciter, nu=float(branch.nu[at]))
    settled = steady(point)
    for name in ("displacement_amplitude", "impact_velocity_max", "floquet_multiplier"):
        np.testing.assert_allclose(
            branch[name + SUFFIX].values[at], settled[name + SUFFIX].values, rtol=1e-6, atol=1e-9
        )
    without = [Bifurcation.FOLD, Bifurcation.PITCHFORK, Bifurcation.GRAZING]
    singular = branch.bifurcation_point.values[np.isin(branch.bifurcation_kind, without)]
    lost = np.isnan(branch[f"displacement_strobe{SUFFIX}"].values).all(axis=-1)
    assert singular.size
    assert lost[singular].all()
    assert lost.mean() < 0.2


def test_sensitivities_in_si_are_per_unit_of_the_parameter_in_si():
    plain = steady(TWO_SIDED)
    si = vp.to_physical(plain, m=2.0, C=8000.0)
    assert si.parameter.values.tolist()[:3] == ["omega", "F", "H"]
    scale = {"omega": 1 / np.sqrt(4000.0), "F": 1 / 8000.0, "l": 1.0}
    for name, factor in scale.items():
        got = float(si[f"displacement_mean{SUFFIX}"].sel(parameter=name))
        own = {"omega": "nu", "F": "f"}.get(name, name)
        expected = float(plain[f"displacement_mean{SUFFIX}"].sel(parameter=own)) * factor
        assert got == pytest.approx(expected, rel=1e-12)
    columns = vp.table(plain).columns
    assert "impact_velocity_max_sensitivity_1_delta" in columns
