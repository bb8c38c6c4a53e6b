"""Identification: parameters found again from noisy motions and responses, with the spread that is stated."""

from __future__ import annotations

import numpy as np
import pytest

import vibropipe as vp

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


def distance(found):
    """Distance from the true parameters in the metric of the covariance: its square is chi-square of 3."""
    off = np.array([float(found[name]) - getattr(TRUE, name) for name in VARY])
    return float(off @ np.linalg.solve(found.parameter_covariance.values, off))


def test_a_motion_without_noise_is_explained_exactly():
    found = vp.identify(KNOWN, measured_motion(0, noise=0.0), VARY)
    for name in VARY:
        # Cubic interpolation between 256 samples of an orbit and its impacts.
        assert float(found[name]) == pytest.approx(getattr(TRUE, name), abs=1e-6)


def test_a_noisy_motion_is_explained_within_its_covariance():
    found = vp.identify(KNOWN, measured_motion(1), VARY)
    # The 99.9 % quantile of chi-square of 3; that of the noise from 57 degrees of freedom within 40 %.
    assert distance(found) < 16.3
    assert float(found.displacement_noise) == pytest.approx(1e-3, rel=0.4)
    assert np.abs(found.displacement_fitted - found.displacement_measured).max() < 5e-3
    std = np.sqrt(np.diag(found.parameter_covariance))
    assert std.tolist() == [float(found[f"{name}_std"]) for name in VARY]


@pytest.mark.slow
def test_the_covariance_is_that_of_many_measurements():
    distances = [distance(vp.identify(KNOWN, measured_motion(seed), VARY)) for seed in range(20)]
    # The mean of 20 chi-squares of 3 has the standard deviation 0.55.
    assert 1.5 < np.mean(distances) < 5.2


def test_a_noisy_response_is_explained_within_its_covariance():
    generator, nu = np.random.default_rng(2), np.linspace(1.2, 1.5, 12)
    sweep = vp.sweep(TRUE, over={"nu": nu})
    noise = {"displacement_amplitude_1": 1e-3, "displacement_mean": 5e-4}
    table = {
        "nu": nu,
        "displacement_amplitude_1": sweep.displacement_amplitude.sel(harmonic=1).values,
        "displacement_mean": sweep.displacement_mean.values,
    }
    for name, sigma in noise.items():
        table[name] = table[name] + sigma * generator.standard_normal(12)
    found = vp.identify(KNOWN, table, VARY, noise=noise)
    assert distance(found) < 16.3
    assert 0.2 < float(found.reduced_chi_square) < 2.5
    assert found.displacement_amplitude_measured.dims == ("measurement", "harmonic")


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
    ],
)  # fmt: skip
def test_wrong_tables_are_refused(table, vary, noise, message):
    with pytest.raises(vp.ParameterError, match=message):
        vp.identify(KNOWN, table, vary, noise=noise)
