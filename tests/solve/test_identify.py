"""Identification: parameters found again from noisy motions and responses, with the spread that is stated."""

from __future__ import annotations

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.solve.fit import fit_model
from vibropipe.words.designs import FitResult, FoundResult, Twin

TRUE = vp.Exciter(l=0.5, nu=1.0, f=-0.7, h=0.2, delta=0.03, R1=0.75, R2=0.65)
KNOWN = vp.Exciter(l=0.5, nu=1.0, f=-0.7, h=0.2)
VARY = {"delta": (-0.1, 0.1), "R1": (0.5, 0.9), "R2": (0.5, 0.9)}


def measured_motion(seed, noise=1e-3, n=60):
    """Displacements of the motion at random phases, by a march of its own, with noise."""
    generator = np.random.default_rng(seed)
    orbit = vp.steady_state(TRUE)
    start = float(orbit.displacement_strobe), float(orbit.velocity_strobe)
    motion = vp.simulate(TRUE, 2 * np.pi, *start, samples_per_period=4096)
    chosen = generator.choice(4096, n, replace=False)
    x = motion.displacement.values[chosen] + noise * generator.standard_normal(n)
    return {"phase": chosen / 4096, "displacement": x}


def noisy_response(true, nu, noise, generator):
    """Amplitude and mean of an exciter over nu, with noise."""
    sweep = vp.sweep(true, over={"nu": nu})
    exact = {
        "displacement_amplitude_1": sweep.displacement_amplitude.sel(harmonic=1).values,
        "displacement_mean": sweep.displacement_mean.values,
    }
    noisy = {
        name: exact[name] + sigma * generator.standard_normal(len(nu))
        for name, sigma in noise.items()
    }
    return {"nu": nu, **noisy}, sweep


def distance(found):
    """Distance from the true parameters in the metric of the covariance: its square is chi-square of 3."""
    off = np.array([float(found[name]) - getattr(TRUE, name) for name in VARY])
    return float(off @ np.linalg.solve(found.parameter_covariance.values, off))


def test_a_motion_without_noise_is_explained_exactly():
    found = vp.identify(KNOWN, measured_motion(0, noise=0.0), VARY)
    assert int(found.fit_result) == FitResult.EXPLAINED
    for name in VARY:
        # Cubic interpolation between 256 samples of an orbit and its impacts.
        assert float(found[name]) == pytest.approx(getattr(TRUE, name), abs=1e-6)


@pytest.mark.filterwarnings("error")
def test_a_response_without_noise_is_found_to_its_rounding():
    known = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.2, R1=0.7, R2=0.7)
    nu = np.array([0.9, 1.0, 1.1, 1.2])
    exact = vp.sweep(known, {"nu": nu}).impact_velocity_max.sel(support=1).values
    found = vp.identify(known, {"nu": nu, "impact_velocity_max_1": exact}, {"f": (0.5, 1.5)})
    assert float(found.f) == pytest.approx(1.0, abs=1e-12)
    assert 0.0 < float(found.f_std) < 1e-12
    assert "twin" not in found.dims


def test_a_measured_value_with_a_unit_is_refused_in_its_unit():
    exciter = vp.Exciter.from_physical(m="2 kg", C="8 N/mm", l="8 mm", R1=0.7)
    table = {"omega (Hz)": [8, -10], "displacement_mean (mm)": [1.0, 1.0]}
    with pytest.raises(vp.ParameterError, match=r"measured.omega: .* > 0, got -10.0 Hz in line 2$"):
        vp.identify(exciter, table, {"F": ("100 N", "200 N")})


def test_a_noisy_motion_is_explained_within_its_covariance():
    found = vp.identify(KNOWN, measured_motion(1), VARY)
    # The 99.9 % quantile of chi-square of 3; that of the noise from 57 degrees of freedom within 40 %.
    assert distance(found) < 16.3
    assert float(found.displacement_noise) == pytest.approx(1e-3, rel=0.4)
    assert int(found.fit_result) == FitResult.EXPLAINED
    assert (found.parameter_result == FoundResult.DETERMINED).all()
    assert np.abs(found.displacement_fitted - found.displacement_measured).max() < 5e-3
    std = np.sqrt(np.diag(found.parameter_covariance))
    assert std.tolist() == [float(found[f"{name}_std"]) for name in VARY]
    rows = vp.table(found)
    assert rows.phase.tolist() == found.phase.values.tolist()
    assert np.allclose(
        rows.displacement_fitted - rows.displacement_measured,
        found.displacement_fitted - found.displacement_measured,
    )


@pytest.mark.slow
def test_the_covariance_is_that_of_many_measurements():
    distances = [distance(vp.identify(KNOWN, measured_motion(seed), VARY)) for seed in range(20)]
    # The mean of 20 chi-squares of 3 has the standard deviation 0.55.
    assert 1.5 < np.mean(distances) < 5.2


def test_a_noisy_response_is_explained_within_its_covariance():
    generator, nu = np.random.default_rng(2), np.linspace(1.2, 1.5, 12)
    noise = {"displacement_amplitude_1": 1e-3, "displacement_mean": 5e-4}
    table, _sweep = noisy_response(TRUE, nu, noise, generator)
    found = vp.identify(KNOWN, table, VARY, noise=noise)
    assert distance(found) < 16.3
    assert 0.2 < float(found.reduced_chi_square) < 2.5
    assert found.displacement_amplitude_measured.dims == ("measurement", "harmonic")


def test_amplitudes_alone_fit_the_mirrored_exciter_as_well(monkeypatch):
    """They do not tell the supports apart; a mean has a sign, which does. One search finds one of both."""
    monkeypatch.setattr(fit_model, "REFINED", 1)
    generator, nu = np.random.default_rng(3), np.linspace(1.2, 1.5, 12)
    noise = {"displacement_amplitude_1": 1e-4, "displacement_mean": 1e-4}
    table, _sweep = noisy_response(TRUE, nu, noise, generator)
    assert "twin" not in vp.identify(KNOWN, table, VARY, noise=noise).dims
    name = "displacement_amplitude_1"
    found = vp.identify(KNOWN, {"nu": nu, name: table[name]}, VARY, noise={name: noise[name]})
    assert found.twin_kind.values.tolist() == [Twin.OTHER]
    assert float(found.twin_excess[0]) == pytest.approx(0.0, abs=1e-9)
    for own, other, sign in (("delta", "delta", -1), ("R1", "R2", 1), ("R2", "R1", 1)):
        assert float(found[f"{own}_twin"][0]) == sign * float(found[other])


# Displacements as a wrong sensor gives them: (factor, what is added).
WRONG = {
    "ten times": (10.0, 0.0),
    "micrometres": (1e-3, 0.0),
    "stuck": (0.0, 0.3),
    "dead": (0.0, 0.0),
}


@pytest.mark.parametrize("noise", [None, {"displacement": 1e-3}])
@pytest.mark.parametrize("wrong", WRONG)
def test_hopeless_data_are_not_explained(wrong, noise):
    factor, added = WRONG[wrong]
    table = measured_motion(1)
    table["displacement"] = factor * table["displacement"] + added
    found = vp.identify(KNOWN, table, VARY, noise=noise, samples=32)
    expected = FitResult.BEYOND_NOISE if factor else FitResult.CONSTANT
    assert int(found.fit_result) == expected
    chi, limit = float(found.reduced_chi_square), float(found.reduced_chi_square_limit)
    assert chi > 10 * limit
    if wrong == "micrometres" and noise:
        assert chi == pytest.approx(6.8e4, rel=0.1)


def test_noise_alone_is_not_explained():
    # A force that may vanish fits silence.
    quiet = vp.Exciter(l=5.0, nu=0.7, f=0.2, h=0.1)
    noise = 1e-3 * np.random.default_rng(4).standard_normal(40)
    table = {"phase": np.arange(40) / 40, "displacement": noise}
    found = vp.identify(quiet, table, {"f": (0.0, 0.3)}, noise={"displacement": 1e-3}, samples=8)
    assert float(found.reduced_chi_square) < float(found.reduced_chi_square_limit)
    assert int(found.fit_result) == FitResult.CONSTANT


def test_a_file_may_begin_with_the_mark_of_a_spreadsheet(tmp_path):
    table = measured_motion(1)
    rows = [f"{phase},{x}" for phase, x in zip(table["phase"], table["displacement"], strict=True)]
    (tmp_path / "motion.csv").write_text(
        "\n".join(["phase,displacement", *rows]), encoding="utf-8-sig"
    )
    found = vp.identify(KNOWN, tmp_path / "motion.csv", VARY, samples=32)
    assert found.R1.item() == vp.identify(KNOWN, table, VARY, samples=32).R1.item()


@pytest.mark.parametrize(
    ("names", "got"),
    [
        (["displacment"], r"got displacment \(did you mean 'displacement'\?\)"),
        (["displacement", "velocity"], "got displacement, velocity"),
        ([], "got nothing"),
    ],
)
def test_a_phase_wants_the_displacement_beside_it(names, got):
    table = {"phase": np.arange(40) / 40} | {name: np.arange(40) / 40 for name in names}
    must = "measured: must have the column displacement, and no other, beside the phase, "
    with pytest.raises(vp.ParameterError, match=must + got):
        vp.identify(KNOWN, table, VARY)


@pytest.mark.parametrize("order", ["shuffled", "noise about a mean"])
def test_what_a_mean_fits_as_well_is_not_explained(order):
    """The noise that is estimated is then all that was measured, and any motion is within it."""
    exciter = vp.Exciter(l=0.5, nu=1.2, f=0.8, h=0.15, delta=0.05, R1=0.7, R2=0.6)
    nu = np.linspace(0.8, 2.2, 15)
    rows = vp.sweep(exciter, {"nu": nu}, harmonics=1)
    amplitude, random = rows.displacement_amplitude.sel(harmonic=1).values, np.random.default_rng(1)
    if order == "shuffled":
        measured = random.permutation(amplitude)
    else:
        measured = amplitude.mean() + 0.2 * random.standard_normal(15)
    table = {"nu": nu, "displacement_amplitude_1": measured}
    found = vp.identify(exciter, table, {"R1": (0.4, 0.9), "R2": (0.4, 0.9)}, samples=32)
    assert float(found.reduced_chi_square) < float(found.reduced_chi_square_limit)
    assert int(found.fit_result) == FitResult.CONSTANT


def linear_response(nu, seed=3):
    """Amplitudes of a motion without impacts, with noise of 1e-4: f over |1 - nu^2 + i h nu|."""
    generator = np.random.default_rng(seed)
    amplitudes = 0.2 / np.hypot(1 - nu**2, 0.1 * nu)
    return {
        "nu": nu,
        "displacement_amplitude_1": amplitudes + 1e-4 * generator.standard_normal(nu.size),
    }


LINEAR = vp.Exciter(l=5.0, nu=1.0, f=0.2, h=0.1)


def test_a_parameter_without_effect_is_not_determined():
    table = linear_response(np.linspace(0.6, 0.8, 12))
    found = vp.identify(LINEAR, table, {"f": (0.1, 0.3), "R2": (0.5, 0.9)}, samples=16)
    assert int(found.fit_result) == FitResult.EXPLAINED
    assert float(found.R2_std) == np.inf
    assert found.parameter_result.values.tolist() == [
        FoundResult.DETERMINED,
        FoundResult.UNDETERMINED,
    ]
    assert np.abs(found.singular_vector[-1]).values == pytest.approx([0.0, 1.0], abs=1e-6)
    # What is determined has the deviation that it has alone.
    alone = vp.identify(LINEAR, table, {"f": (0.1, 0.3)}, samples=16)
    assert float(found.f_std) == pytest.approx(float(alone.f_std) * np.sqrt(11 / 10), rel=1e-2)
    assert abs(float(found.f) - 0.2) < 4 * float(found.f_std)


def test_a_combination_alone_is_not_determined():
    # At one frequency the amplitude tells f over |1 - nu^2 + i h nu| alone.
    table = linear_response(np.full(12, 0.9))
    found = vp.identify(LINEAR, table, {"f": (0.1, 0.3), "h": (0.05, 0.2)}, samples=16)
    assert [float(found.f_std), float(found.h_std)] == [np.inf, np.inf]
    covariance = found.parameter_covariance.values
    assert covariance[0, 1] == covariance[1, 0] == np.inf
    f, h = float(found.f), float(found.h)
    amplitude = f / np.hypot(0.19, 0.9 * h)
    assert amplitude == pytest.approx(0.2 / np.hypot(0.19, 0.09), rel=1e-3)
    # Along the direction, in shares of the ranges, the amplitude stays.
    along = found.singular_vector[-1].values * [0.2, 0.15]
    change = along[0] / f - 0.81 * h * along[1] / (0.19**2 + 0.81 * h**2)
    assert change == pytest.approx(0.0, abs=1e-6)


def test_a_parameter_that_ended_at_its_range_is_named():
    found = vp.identify(KNOWN, measured_motion(1), {**VARY, "R1": (0.5, 0.7)}, samples=32)
    assert float(found.R1) == pytest.approx(0.7, abs=1e-6)
    assert int(found.parameter_result.sel(parameter="R1")) == FoundResult.AT_RANGE
    assert int(found.fit_result) == FitResult.BEYOND_NOISE


def test_a_value_at_an_end_of_its_range_is_that_end():
    table = measured_motion(3)
    found = vp.identify(KNOWN, table, {"delta": (0.0, 0.02), "R1": (0.5, 0.9), "R2": (0.7, 0.9)})
    assert int(found.parameter_result.sel(parameter="R2")) == FoundResult.AT_RANGE
    assert float(found.R2) == 0.7
    below = vp.identify(KNOWN, table, {"delta": (-0.1, 0.0), "R1": (0.5, 0.9), "R2": (0.5, 0.9)})
    assert int(below.parameter_result.sel(parameter="delta")) == FoundResult.AT_RANGE
    assert float(below.delta) == 0.0


def test_the_covariance_in_si_is_that_of_the_deviations():
    table = linear_response(np.linspace(0.6, 0.8, 12))
    found = vp.identify(LINEAR, table, {"f": (0.1, 0.3), "h": (0.05, 0.2)}, samples=16)
    physical = vp.to_physical(found, m=2.0, C=8000.0)
    assert (
        physical.other_parameter.values.tolist() == physical.parameter.values.tolist() == ["F", "H"]
    )
    deviations = [float(physical.F_std), float(physical.H_std)]
    assert np.sqrt(np.diag(physical.parameter_covariance)) == pytest.approx(deviations, rel=1e-12)


def test_too_few_numbers_do_not_tell_their_noise():
    for n, result in ((10, FitResult.NOT_JUDGED), (11, FitResult.EXPLAINED)):
        several = linear_response(np.linspace(0.6, 0.8, n))
        found = vp.identify(LINEAR, several, {"f": (0.1, 0.3)}, samples=16)
        assert int(found.fit_result) == result
    table = linear_response(np.linspace(0.6, 0.8, 4))
    found = vp.identify(LINEAR, table, {"f": (0.1, 0.3)}, samples=16)
    assert int(found.fit_result) == FitResult.NOT_JUDGED
    given = vp.identify(
        LINEAR, table, {"f": (0.1, 0.3)}, noise={"displacement_amplitude_1": 1e-4}, samples=16
    )
    assert int(given.fit_result) == FitResult.EXPLAINED


def test_chaos_and_borders_of_laws_make_no_deviation_small():
    # At nu = 1.572 the motion is chaotic, and elsewhere a law ends nearby: differences across them are no derivatives.
    true = vp.Exciter(l=0.5, nu=1.0, f=0.5, h=0.2, delta=-0.3, R1=0.75, R2=0.65)
    nu, generator = np.linspace(0.8, 2.2, 30), np.random.default_rng(5)
    noise = {"displacement_amplitude_1": 2e-3, "displacement_mean": 2e-3}
    table, sweep = noisy_response(true, nu, noise, generator)
    assert sweep.period_multiple.values[16] == 0
    vary = {"delta": (-0.4, 0.0), "R1": (0.5, 0.9), "R2": (0.5, 0.9)}
    found = vp.identify(true, table, vary, noise=noise)
    assert int(found.fit_result) == FitResult.EXPLAINED
    off = np.array([float(found[name]) - getattr(true, name) for name in vary])
    # The 99.9 % quantile of chi-square of 3; R2 was 26 deviations off.
    assert float(off @ np.linalg.solve(found.parameter_covariance.values, off)) < 16.3


def test_a_difference_at_an_end_of_a_range_has_the_width_that_it_has():
    elastic = vp.Exciter(l=0.5, nu=1.0, f=-0.7, h=0.2, R1=0.9, R2=1.0)
    orbit = vp.sweep(
        elastic, over={"nu": np.linspace(0.9, 1.1, 12)}, outputs=["sensitivity", "harmonics"]
    )
    table = {"nu": orbit.nu.values, "displacement_mean": orbit.displacement_mean.values}
    found = vp.identify(
        elastic, table, {"R2": (0.9, 1.0)}, noise={"displacement_mean": 1e-3}, samples=16
    )
    slopes = orbit.displacement_mean_sensitivity.sel(parameter="R2").values
    assert float(found.R2) == pytest.approx(1.0, abs=1e-9)
    assert float(found.R2_std) == pytest.approx(1e-3 / np.linalg.norm(slopes), rel=1e-3)


def test_a_curve_is_a_target_of_a_design():
    target = {"displacement": np.column_stack([*measured_motion(0, noise=0.0).values()])}
    like = vp.Exciter(l=0.5, nu=1.0, f=-0.7, h=0.2, R1=0.75, R2=0.65)
    found = vp.design(like, {"delta": (-0.1, 0.1)}, target, samples=64)
    assert float(found.delta[0]) == pytest.approx(0.03, abs=1e-6)
    assert float(found.displacement_misfit[0]) < 1e-6
    # With another restitution the curve is met in least squares only: no offset nearby meets it better.
    unlike = vp.Exciter(l=0.5, nu=1.0, f=-0.7, h=0.2, R1=0.7, R2=0.65)
    best = vp.design(unlike, {"delta": (-0.1, 0.1)}, target, samples=64)
    for move in (-1e-3, 1e-3):
        at = float(best.delta[0]) + move
        near = vp.design(unlike, {"delta": (at, at + 1e-9)}, target, samples=8)
        assert float(near.displacement_misfit[0]) > float(best.displacement_misfit[0])


@pytest.mark.parametrize(
    ("table", "vary", "noise", "message"),
    [
        ([1, 2], VARY, None, "measured: must be a table"),
        ({"displacement_mean": [0.1]}, VARY, None, "measured: must be a table"),
        ({"nu": [1.0], "speed": [1.0]}, VARY, None, "measured: must be a quantity"),
        ({"nu": [1.0, 2.0], "displacement_mean": [1.0]}, VARY, None, "columns of different lengths"),
        ({"nu": [1.0, np.nan], "displacement_mean": [1.0, 1.0]}, VARY, None, "finite numbers"),
        ({"nu": [1.0], "displacement_mean": [1.0]}, {"nu": (1, 2)}, None, "must leave out nu"),
        ({"nu": [1.0], "displacement_mean": [1.0]}, VARY, None, "more numbers than parameters"),
        ({"nu": [1.0], "displacement_mean": [1.0]}, VARY, {"x": 1.0}, "noise: must have the measured"),
        ({"nu": [1.0], "displacement_mean": [1.0], "velocity_mean": [1.0]}, VARY, None, "noise: is required"),
        ({"R1": [0.7, 1.5], "displacement_mean": [1.0, 1.0]}, {"f": (0, 1)}, None,
         r"^measured.R1: must be a number from 0 to 1, got 1.5 in line 2$"),
        ({"nu": [-1.2, 1.0], "displacement_mean": [1.0, 1.0]}, {"f": (0, 1)}, None,
         r"^measured.nu: must be a finite number > 0, got -1.2 in line 1$"),
        ({"k1": [0.0, 1.0], "displacement_mean": [1.0, 1.0]}, {"f": (0, 1)}, None, "^measured.k1: must be above"),
        ({"housing_load": [0, 1], "displacement_mean": [1, 1]}, {"f": (0, 1)}, None, "housing_load: must be left out"),
    ],
)  # fmt: skip
def test_wrong_tables_are_refused(table, vary, noise, message):
    with pytest.raises(vp.ParameterError, match=message):
        vp.identify(KNOWN, table, vary, noise=noise)
