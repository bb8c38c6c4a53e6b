"""Harmonics of the force and subharmonics of orbits of several forcing periods: against the spectrum of samples."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from orbit_motions import motion_of

import vibropipe as vp

LOSSY = {"l": 0.5, "h": 0.2, "R1": 0.7, "R2": 0.7}
# Samples of a forcing period. The kinks of x at the impacts alias by about 1e-8 of its scale.
SAMPLES, ALIASING = 2**14, 1e-7
HARMONICS = 6
EXCITERS = {
    "two periods": vp.Exciter(nu=1.6, f=1.58, delta=0.01, **LOSSY),
    "two periods, one support": vp.Exciter(
        nu=0.7206030150753768, f=0.2557788944723618, delta=0.01, **LOSSY
    ),
    "three periods": vp.Exciter(nu=1.45, f=1.35, delta=0.01, **LOSSY),
    "three periods with a rest": vp.Exciter(
        nu=1.740677966101695, f=1.054237288135593, delta=0.5, l=0.5, h=0.05, R1=0.3, R2=0.1
    ),
    "eight periods": vp.Exciter(nu=1.72, f=1.8, delta=0.01, **LOSSY),
    # nu/2 is the undamped eigenfrequency: no closed form, since the dynamic stiffness vanishes.
    "resonance between harmonics": vp.Exciter(
        nu=2.0, f=0.3, h=0.0, l=0.5, delta=0.1, R1=0.7, R2=0.6
    ),
}
MULTIPLES = dict(zip(EXCITERS, (2, 2, 3, 3, 8, 2), strict=True))


def solve(exciter: vp.Exciter, harmonics: int = HARMONICS, **start: float) -> xr.Dataset:
    outputs = ("harmonics", "subharmonics", "motion", "poincare")
    return vp.steady_state(exciter, harmonics=harmonics, outputs=outputs, **start)


def complex_amplitudes(orbit: xr.Dataset, name: str) -> np.ndarray:
    values: np.ndarray = (orbit[f"{name}_amplitude"] * np.exp(1j * orbit[f"{name}_phase"])).values
    return values


@pytest.mark.parametrize("name", EXCITERS)
def test_they_are_the_spectrum_of_the_motion_over_the_orbit(name: str) -> None:
    """The first harmonic is that of the force, though the orbit has had its first at nu/m."""
    exciter, m = EXCITERS[name], MULTIPLES[name]
    orbit = solve(exciter)
    assert int(orbit.period_multiple) == m
    motion = motion_of(exciter, orbit, samples_per_period=SAMPLES)
    spectrum = 2 * np.fft.rfft(motion.displacement.values[: m * SAMPLES]) / (m * SAMPLES)
    harmonics = complex_amplitudes(orbit, "displacement")
    np.testing.assert_allclose(harmonics, spectrum[m::m][:HARMONICS], atol=ALIASING)
    rates = 1j * np.arange(1, HARMONICS + 1) * exciter.nu * harmonics
    np.testing.assert_allclose(complex_amplitudes(orbit, "velocity"), rates, rtol=1e-12, atol=1e-15)
    j = orbit.subharmonic.values
    assert j.tolist() == list(range(1, 4 * HARMONICS + 1))
    between = j % m != 0
    subharmonics = complex_amplitudes(orbit, "subharmonic_displacement")
    assert np.isnan(subharmonics[~between]).all()
    np.testing.assert_allclose(subharmonics[between], spectrum[j[between]], atol=ALIASING)
    assert np.abs(subharmonics[between]).max() > 1e-3


@pytest.mark.parametrize("name", ["two periods", "three periods with a rest", "eight periods"])
def test_mean_harmonics_and_subharmonics_add_up_to_the_motion(name: str) -> None:
    orbit = solve(EXCITERS[name], harmonics=800)
    m = MULTIPLES[name]
    # Terms up to 4 * 800/m = 400 nu or more; those of a kink fall off as 1/k^2, so that their rest is of order 1/k.
    turns = m * orbit.phase.values[:, None]
    x = np.full(turns.size, float(orbit.displacement_mean))
    for name_of, factor in (("displacement", 1.0), ("subharmonic_displacement", 1.0 / m)):
        amplitudes = np.nan_to_num(complex_amplitudes(orbit, name_of))
        k = factor * np.arange(1, amplitudes.size + 1)
        kept = k <= 400
        rotation = np.exp(2j * np.pi * np.fmod(k[kept] * turns, 1.0))
        x += (amplitudes[kept] * rotation).real.sum(axis=1)
    np.testing.assert_allclose(x, orbit.displacement.values, atol=2e-3)


@pytest.mark.parametrize("name", ["two periods", "three periods", "eight periods"])
def test_they_do_not_depend_on_the_period_that_the_orbit_starts_with(name: str) -> None:
    """Started a forcing period later, harmonics stay and subharmonic j turns by 2 pi j/m."""
    exciter, m = EXCITERS[name], MULTIPLES[name]
    orbit = solve(exciter)
    later = solve(
        exciter, x0=float(orbit.poincare_displacement[1]), v0=float(orbit.poincare_velocity[1])
    )
    assert int(later.period_multiple) == m
    x, v = orbit.poincare_displacement.values, later.poincare_displacement.values
    steps = [n for n in range(m) if np.allclose(np.roll(x[:m], -n), v[:m], atol=1e-9)]
    assert len(steps) == 1
    one, two = (complex_amplitudes(each, "displacement") for each in (orbit, later))
    np.testing.assert_allclose(two, one, atol=1e-11)
    one, two = (complex_amplitudes(each, "subharmonic_displacement") for each in (orbit, later))
    turned = one * np.exp(2j * np.pi * steps[0] * orbit.subharmonic.values / m)
    np.testing.assert_allclose(two, turned, atol=1e-11)


def test_an_orbit_of_one_period_and_a_motion_without_an_orbit_have_no_subharmonics() -> None:
    over = {"f": [0.04, 0.5, 1.4]}  # without impact, m = 1, aperiodic
    rows = vp.sweep(
        vp.Exciter(nu=1.2, delta=0.01, **LOSSY), over, outputs=("subharmonics", "harmonics")
    )
    assert rows.period_multiple.values.tolist() == [1, 1, 0]
    assert rows.sizes["subharmonic"] == 4 * rows.sizes["harmonic"]
    assert np.isnan(rows.subharmonic_displacement_amplitude.values).all()
    assert np.isnan(rows.subharmonic_displacement_phase.values).all()
    assert np.isfinite(rows.displacement_amplitude.values).all()


def test_a_conservative_orbit_has_harmonics_of_its_own_frequency() -> None:
    exciter = vp.Exciter(l=0.5, nu=1.0)
    orbit = solve(exciter, x0=0.0, v0=-0.8)
    curves = vp.amplitude_frequency(exciter, [0.8], harmonics=HARMONICS)
    np.testing.assert_allclose(orbit.base_frequency, curves.eigenfrequency.values[0], rtol=1e-12)
    for name in ("displacement_amplitude", "velocity_amplitude"):
        np.testing.assert_allclose(orbit[name].values, curves[name].values[0], atol=1e-12)
