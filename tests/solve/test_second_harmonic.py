"""A second harmonic of the force, in every part of the program that knows the force."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from comparisons import reference
from hypothesis import given, settings
from hypothesis import strategies as st
from long_orbits import true_values
from orbit_motions import motion_of
from strategies import Case, cases

import vibropipe as vp
from vibropipe.lab.reference_solver import ReferenceSolver
from vibropipe.physics.load import NEVER, force_at, force_value, release_wait_of_second
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status

FORCED: dict[str, Any] = {"l": 0.5, "nu": 1.0, "f": -1.0, "h": 0.2, "R1": 0.7, "R2": 0.7}
TWO = vp.Exciter(**FORCED, f2=0.4, phi2=0.7)
ALONE = vp.Exciter(**{**FORCED, "f": 0.0}, f2=0.9, phi2=0.4)
SLOW = vp.Exciter(l=0.5, nu=0.2, f=0.5, h=0.2, R1=0.6, R2=0.6, f2=0.9, phi2=2.0)
NEWMARK: dict[str, Any] = {"method": "newmark", "steps_per_period": 4000}


def test_the_reference_is_met() -> None:
    entry = reference("effects")["second_harmonic"]
    ds = vp.simulate(TWO, float(entry["tau_end"]), x0=0.0, energy=True)
    (x, v), *_ = ReferenceSolver(TWO).run(0.0, 0.0, [40]).states  # type: ignore[list-item]
    for name, twin in (("x_end", x), ("v_end", v)):
        own = float(ds["displacement_end" if name == "x_end" else "velocity_end"])
        assert abs(own - float(entry[name])) < 1e-13
        assert abs(float(twin) - float(entry[name])) < 1e-15
    times = np.array([float(event["tau"]) for event in entry["events"]])
    assert np.abs(ds.impact_tau.values - times).max() < 1e-13
    assert abs(float(ds.energy_residual)) < 1e-12
    assert "second_harmonic" in ds.attrs["effects"]
    np.testing.assert_allclose(
        ds.force, -np.sin(ds.tau) + 0.4 * np.sin(2 * ds.tau + 0.7), atol=1e-12
    )


@pytest.mark.parametrize("exciter", [TWO, ALONE, SLOW], ids=["two", "alone", "slow"])
def test_motions_agree_with_the_twin(exciter: vp.Exciter) -> None:
    end = 2.5 * exciter.period
    ds = vp.simulate(exciter, end, 0.1, -0.2, energy=True)
    twin = ReferenceSolver(exciter).run(0.1, -0.2, [mp_decimal(end)])
    assert float(ds.displacement_end) == pytest.approx(float(twin.states[0][0]), abs=1e-12)
    assert float(ds.velocity_end) == pytest.approx(float(twin.states[0][1]), abs=1e-12)
    kinds = [event[1] for event in twin.events]
    assert ds.sizes["rest"] == kinds.count("rest")
    ends = [float(event[0]) for event in twin.events if event[1] == "release"]
    ends += [math.inf] * (kinds.count("rest") - len(ends))
    np.testing.assert_allclose(ds.rest_end, ends, atol=1e-11)
    assert abs(float(ds.energy_residual)) < 1e-12


def mp_decimal(value: float) -> Any:
    """Return a float as a Decimal, exactly."""
    from decimal import Decimal

    return Decimal(value)


@pytest.mark.slow
@pytest.mark.parametrize("exciter", [TWO, ALONE])
def test_newmark_converges_to_it_with_its_order(exciter: vp.Exciter) -> None:
    exact = vp.simulate(exciter, 9.0, 0.1)
    errors = []
    for steps in (500, 1000, 2000):
        ds = vp.simulate(exciter, 9.0, 0.1, method="newmark", steps_per_period=steps, energy=True)
        errors.append(abs(float(ds.displacement_end - exact.displacement_end)))
        assert abs(float(ds.energy_residual)) < 1e-10
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("exciter", [TWO, ALONE, SLOW])
def test_a_steady_state_is_that_of_a_long_motion(exciter: vp.Exciter) -> None:
    outputs = ("harmonics", "impacts", "motion", "stability", "energy", "poincare")
    steady = vp.steady_state(exciter, 0.1, outputs=outputs)
    m = int(steady.period_multiple)
    assert m > 0
    ds = motion_of(exciter, steady, samples_per_period=2048, energy=True)
    assert float(ds.displacement_end) == pytest.approx(float(steady.displacement_strobe), abs=1e-9)
    xs = ds.displacement.values[:-1]
    for k in range(4):
        wave = np.mean(xs * np.exp(-2j * np.pi * k * m * np.arange(xs.size) / xs.size))
        if k == 0:
            assert float(steady.displacement_mean) == pytest.approx(wave.real, abs=1e-5)
            continue
        own = steady.displacement_amplitude.values[k - 1] * np.exp(
            1j * steady.displacement_phase.values[k - 1]
        )
        assert own == pytest.approx(2 * wave, abs=1e-5)
    assert m * float(steady.energy_input) == pytest.approx(float(ds.energy_input), rel=1e-8)
    assert abs(float(steady.energy_residual)) < 1e-11


@pytest.mark.parametrize(("nu", "f"), [(0.3, 0.2), (2.0, 0.0), (0.5, 0.1)])
def test_linear_motion_in_closed_form(nu: float, f: float) -> None:
    """Without impacts the steady motion is the sum of both responses, also in energy and samples."""
    e = vp.Exciter(l=50.0, nu=nu, f=f, h=0.3, f2=0.7, phi2=1.1)
    outputs = ("harmonics", "motion", "energy", "stability")
    ds = vp.steady_state(e, outputs=outputs)
    responses = [
        amplitude * np.exp(1j * (phase - np.pi / 2)) / complex(1 - w * w, 0.3 * w)
        for amplitude, phase, w in ((f, 0.0, nu), (0.7, 1.1, 2 * nu))
    ]
    np.testing.assert_allclose(
        ds.displacement_amplitude[:2], np.abs(responses), rtol=1e-13, atol=1e-15
    )
    turns = 2 * np.pi * ds.phase.values
    expected = sum((z * np.exp(1j * k * turns)).real for k, z in enumerate(responses, 1))
    np.testing.assert_allclose(ds.displacement, expected, atol=1e-13)
    assert float(ds.displacement_strobe) == pytest.approx(expected[0], abs=1e-13)
    assert abs(float(ds.energy_residual)) < 1e-12
    motion = motion_of(e, ds, 3, energy=True)
    assert float(motion.displacement_end) == pytest.approx(expected[0], abs=1e-12)
    assert float(motion.energy_input) == pytest.approx(3 * float(ds.energy_input), rel=1e-12)


@given(
    f=st.floats(-2, 2),
    f2=st.floats(-2, 2),
    phi2=st.floats(-7, 7),
    load=st.floats(-4, 4),
    turn=st.floats(0, 1),
)
def test_the_release_is_the_first_zero_of_the_force(
    f: float, f2: float, phi2: float, load: float, turn: float
) -> None:
    p = vp.Exciter(l=1.0, nu=1.3, f=f, f2=f2, phi2=phi2).parameters()
    wait = release_wait_of_second(p, 1.0, load, turn)
    size = abs(f) + abs(f2) + abs(load)
    until = min(wait, 1.0)
    before = turn + until * np.linspace(0, 1, 4000)[:-1]
    pressing = f * np.sin(2 * np.pi * before) + f2 * np.sin(4 * np.pi * before + phi2) + load
    assert wait == 0.0 or pressing.max(initial=-math.inf) <= 1e-13 * size
    if 0.0 < wait < NEVER:
        assert abs(force_value(force_at(p, 1.0, turn + wait, 1), 1) + load) <= 1e-14 * size


@pytest.mark.parametrize("harmonic", ["f", "f2"])
@pytest.mark.parametrize(
    "held", [{"friction": 0.3}, {"delta": -0.8, "R1": 0.0, "R2": 0.0}], ids=["friction", "support"]
)
def test_a_force_that_only_reaches_what_holds_the_mass_frees_it_never(
    held: dict[str, float], harmonic: str
) -> None:
    exciter = vp.Exciter(**{"l": 0.5, "nu": 1.0, "h": 0.2, harmonic: 0.3} | held)
    motion = vp.simulate(exciter, 20 * exciter.period, samples_per_period=0)
    until = motion.stick_end if "friction" in held else motion.rest_end
    np.testing.assert_array_equal(until, [math.inf])
    above = vp.simulate(
        dataclasses.replace(exciter, **{harmonic: 0.3 * (1 + 1e-9)}), exciter.period
    )
    assert (above.stick_end if "friction" in held else above.rest_end)[0] < math.inf


def test_a_row_does_not_depend_on_the_second_harmonic_of_others() -> None:
    exciter = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, R2=0.7, friction=1.0)
    rows, alone = vp.sweep(exciter, {"f2": [0.0, 0.1]}), vp.steady_state(exciter)
    assert rows.regime[0] == alone.regime == Regime.NO_IMPACT
    assert rows.status[0] == alone.status == Status.OK


def test_second_harmonic_of_zero_is_none() -> None:
    """f2 = 0 keeps the bits, whatever its phase."""
    base = vp.Exciter(**FORCED)
    for ds, other in (
        (vp.simulate(base, 30.0), vp.simulate(dataclasses.replace(base, phi2=0.3), 30.0)),
        (vp.steady_state(base), vp.steady_state(dataclasses.replace(base, phi2=0.3))),
    ):
        assert ds.equals(other.drop_vars("phi2"))


def check_the_kernel_of_two_harmonics_computes_one(case: Case) -> None:
    """A tiny second harmonic changes a motion by as little, up to its first impact."""
    if case.exciter.f == 0.0 or case.method:
        return
    end = min(case.tau_end, 1.0)
    tiny = dataclasses.replace(case.exciter, f2=case.exciter.f * 1e-13, phi2=0.4)
    one, two = (
        vp.simulate(e, end, case.x0, case.v0, samples_per_period=0) for e in (case.exciter, tiny)
    )
    if one.sizes["impact"] + two.sizes["impact"] + one.sizes["grazing"] + two.sizes["grazing"]:
        return
    size = (
        case.exciter.l + abs(case.exciter.delta) + abs(case.x0) + abs(case.v0) + abs(case.exciter.f)
    )
    assert float(one.displacement_end) == pytest.approx(
        float(two.displacement_end), abs=1e-10 * size
    )


test_the_kernel_of_two_harmonics_computes_one = settings(max_examples=60)(
    given(cases())(check_the_kernel_of_two_harmonics_computes_one)
)


@settings(max_examples=20)
@given(turns=st.floats(0, 1), x0=st.floats(-0.4, 0.4))
def test_a_shift_of_phase_is_a_shift_of_time(turns: float, x0: float) -> None:
    """The second harmonic alone is a force of twice the frequency, shifted by phi2."""
    phi2 = 2 * np.pi * turns
    double = vp.Exciter(l=0.5, nu=2.0, f=0.9, h=0.2, R1=0.7, R2=0.7)
    alone = vp.Exciter(l=0.5, nu=1.0, f2=0.9, phi2=phi2, h=0.2, R1=0.7, R2=0.7)
    start = phi2 / 2.0
    one = vp.simulate(double, start + 4.0, x0, tau_start=start, samples_per_period=0)
    two = vp.simulate(alone, 4.0, x0, samples_per_period=0)
    assert float(one.displacement_end) == pytest.approx(float(two.displacement_end), abs=1e-10)


def test_the_mirror_image_moves_as_the_exciter() -> None:
    one, two = vp.simulate(TWO, 20.0, 0.1, 0.3), vp.simulate(TWO.mirrored(), 20.0, -0.1, -0.3)
    np.testing.assert_array_equal(one.displacement, -two.displacement)
    np.testing.assert_array_equal(one.impact_tau, two.impact_tau)


def test_branches_are_followed_under_two_harmonics() -> None:
    branch = vp.branch(TWO, "nu", 1.1, x0=0.1)
    last = branch.isel(point=-1)
    moved = dataclasses.replace(TWO, nu=float(last.nu))
    again = vp.steady_state(moved, float(last.displacement_strobe), float(last.velocity_strobe))
    assert float(again.displacement_mean) == pytest.approx(float(last.displacement_mean), abs=1e-9)
    free = vp.Exciter(l=1.0, nu=1.7, f=0.5, h=0.2, R1=0.7, R2=0.7, f2=0.3, phi2=0.2)
    linear = vp.branch(free, "f", 3.0)
    grazing = float(linear.bifurcation_f.values[0]) if linear.sizes["bifurcation"] else 3.0
    ds = vp.simulate(
        dataclasses.replace(free, f=grazing, l=100.0), 40 * free.period, samples_per_period=4096
    )
    late = ds.displacement.values[-4097:]
    assert max(late.max(), -late.min()) == pytest.approx(1.0, abs=1e-4)


@pytest.mark.slow
def test_basins_and_sweeps_take_a_second_harmonic() -> None:
    grid = np.linspace(-0.3, 0.3, 3)
    basins = vp.basins(TWO, grid, grid, starts=32)
    assert (basins.attractor.values >= 0).all()
    swept = vp.sweep(vp.Exciter(**FORCED), {"f2": [0.0, 0.4], "phi2": [0.0, 0.7]}, x0=0.0)
    own = vp.steady_state(TWO, 0.0, harmonics=3)
    row = swept.sel(f2=0.4, phi2=0.7)
    assert float(row.displacement_mean) == float(own.displacement_mean)


def test_what_has_no_closed_form_says_so() -> None:
    for call in (lambda: vp.symmetric_orbit(TWO), lambda: vp.one_sided_orbit(TWO, 1, 1)):
        with pytest.raises(vp.ParameterError, match="f2: must be 0 for an orbit in closed form"):
            call()


def test_errors_of_rows_hold():
    """Against orbits in long arithmetic, and linear motions in closed form."""
    rng, ratios, count = np.random.default_rng(8), [], 0
    while count < 25:
        nu, f2, phi2 = rng.uniform(0.4, 3.0), rng.uniform(-1, 1), rng.uniform(-3, 3)
        delta, R1, R2 = rng.uniform(-0.8, 0.8), rng.uniform(0.2, 0.9), rng.uniform(0.2, 0.9)
        f, h = rng.uniform(0.2, 2), rng.uniform(0.02, 0.5)
        exciter = vp.Exciter(l=1, nu=nu, f=f, h=h, delta=delta, R1=R1, R2=R2, f2=f2, phi2=phi2)
        row = vp.steady_state(exciter, harmonics=3)
        impacts, m = row.sizes["impact"], int(row.period_multiple)
        if m == 0 or impacts > 8 or row.rests_per_orbit.any():
            continue
        count += 1
        if impacts:
            true = true_values(row, 3)
            true["impact_phase"] = true["impact_phase"].real % 1.0
        else:
            parts = [f / (1 - nu**2 + 1j * h * nu)]
            parts.append(f2 * np.exp(1j * phi2) / (1 - 4 * nu**2 + 2j * h * nu))
            true = {"displacement_strobe": np.array([sum(parts).imag])}
            true["displacement_amplitude"] = np.array([*np.abs(parts), 0.0])
        for name, values in true.items():
            if f"{name}_error" in row and name not in ("lyapunov_exponent", "impact_velocity_max"):
                miss = np.abs(row[name].values.ravel() - values)
                stated = row[f"{name}_error"].values.ravel()
                assert np.isfinite(stated).all(), name
                ratios += (miss[miss > 0] / stated[miss > 0]).tolist()
    assert len(ratios) > 200
    assert max(ratios) < 30.0
    assert np.mean(np.array(ratios) > 3.0) <= 0.01
    # An error that is always far too large would pass as well.
    assert np.median(ratios) > 0.005


def test_a_first_harmonic_parts_impacts_that_were_equal():
    """Under the second harmonic alone: what the larger of two impacts becomes has no derivative by f."""
    outputs = ("harmonics", "impacts", "sensitivity")
    row = vp.steady_state(ALONE, 0.1, outputs=outputs)
    assert row.impacts_per_orbit.values.tolist() == [2.0, 2.0]
    slopes = row.impact_velocity_max_sensitivity
    assert np.isnan(slopes.sel(parameter="f")).all()
    assert np.isfinite(slopes.drop_sel(parameter="f")).all()
    # Each impact by itself has one.
    assert np.isfinite(row.impact_velocity_sensitivity).all()


def test_an_accuracy_may_be_asked_of_a_sweep():
    exciter = vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7, nu=1.0, f2=0.3, f=0.8)
    rows = vp.sweep(exciter, {"nu": np.linspace(0.8, 1.4, 12)}, accuracy=1e-10)
    has_orbit = rows.period_multiple > 0
    assert has_orbit.sum() > 6
    assert (rows.error.where(has_orbit, drop=True) < 1e-10).all()


def test_points_of_a_branch_have_errors_and_sensitivities():
    outputs = ("harmonics", "impacts", "sensitivity")
    point = vp.branch(TWO, "nu", 1.1, x0=0.1, outputs=outputs).isel(point=-1)
    start = float(point.displacement_strobe), float(point.velocity_strobe)
    row = vp.steady_state(dataclasses.replace(TWO, nu=float(point.nu)), *start, outputs=outputs)
    for name in ("displacement_mean_sensitivity", "impact_velocity_max_sensitivity"):
        np.testing.assert_allclose(point[name], row[name], rtol=1e-8, atol=1e-9)
    assert 0.0 < float(point.displacement_mean_error) < 1e-12
