"""Powers and forces of an exciter whose housing slides: they balance, and are those of the sampled motion."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from orbit_motions import motion_of
from scipy.interpolate import CubicSpline

import vibropipe as vp

OUTPUTS = ("harmonics", "impacts", "stability", "energy", "power", "frame")
POWERS = ("power_damping", "power_friction", "power_housing_friction", "power_change")


def random_exciter(generator: np.random.Generator, k1: float, friction: float) -> vp.Exciter:
    """Return an exciter with a housing that slides, a soft support 1 if k1 > 0."""
    between = generator.uniform
    return vp.Exciter(
        l=between(0.2, 0.8), nu=between(0.5, 2), f=between(0.3, 1.5), h=between(0.05, 0.3),
        delta=between(-0.1, 0.1), R1=1.0 if k1 else between(0.3, 0.9), R2=between(0.3, 0.9),
        k1=k1, h1=1.0 if k1 else None, friction=friction, mass_ratio=between(0.1, 1),
        housing_friction_1=between(0, 0.3), housing_friction_2=between(0.1, 0.5),
        housing_load=between(-0.05, 0.05), load=between(-0.05, 0.05),
    )  # fmt: skip


CASES = [(number, 150.0 * (number % 3 == 0), 0.05 * (number % 4 == 0)) for number in range(1, 17)]


@pytest.mark.parametrize(("seed", "k1", "friction"), CASES)
def test_powers_and_momentum_balance(seed: int, k1: float, friction: float) -> None:
    exciter = random_exciter(np.random.default_rng(seed), k1, friction)
    row = vp.steady_state(exciter, outputs=OUTPUTS)
    lost = sum(float(row[name]) for name in POWERS if name in row) + float(row.power_impact.sum())
    assert float(row.power_input + row.power_housing_load) == pytest.approx(lost, abs=1e-10)
    assert abs(float(row.power_residual)) < 1e-10
    drift = float(row.housing_velocity_mean) * (exciter.load + exciter.housing_load)
    assert float(row.power_housing_load) == pytest.approx(drift, abs=1e-12)
    if int(row.period_multiple) == 0:
        return
    one, two = row.impulse_per_period.values
    one = 0.0 if k1 else one  # the force of a soft support is part of that on the frame
    mean = float(row.frame_force_mean) + (one - two) / exciter.period
    assert mean == pytest.approx(exciter.load, abs=1e-9)
    for support, R in ((1, exciter.R1), (2, exciter.R2)):
        if not (k1 and support == 1) and not row.rests_per_orbit.sel(support=support):
            struck = float(row.power_struck.sel(support=support))
            taken = float(row.power_impact.sel(support=support))
            assert taken == pytest.approx((1 - R**2) * struck, abs=1e-10)


@pytest.mark.parametrize("seed", [4, 5, 6, 15, 22])
def test_forces_and_powers_are_those_of_the_motion(seed: int) -> None:
    k1 = 150.0 * (seed % 3 == 0)
    exciter = random_exciter(np.random.default_rng(seed), k1, 0.0)
    row = vp.steady_state(exciter, outputs=OUTPUTS)
    m = int(row.period_multiple)
    assert m > 0
    assert not row.rests_per_orbit.any()
    motion = motion_of(exciter, row, samples_per_period=20_000)
    x, v, force = (motion[name].values for name in ("displacement", "velocity", "force"))
    contact = np.where(x > exciter.upper, k1 * (x - exciter.upper) + exciter.h1 * v, 0.0)
    frame = x + exciter.h * v + contact - force
    span = m * exciter.period
    near = {"abs": 3e-4}
    assert np.trapezoid(force * v, motion.tau) / span == pytest.approx(
        float(row.power_input), **near
    )
    assert np.trapezoid(frame, motion.tau) / span == pytest.approx(
        float(row.frame_force_mean), **near
    )
    rms = np.sqrt(np.trapezoid(frame**2, motion.tau) / span)
    assert rms == pytest.approx(float(row.frame_force_rms), **near)
    assert abs(frame).max() == pytest.approx(float(row.frame_force_max), **near)
    assert (force * v).max() == pytest.approx(float(row.power_input_max), abs=1e-3)


def test_what_creeping_costs() -> None:
    common = {"l": 0.375, "nu": 1.2, "f": 1.0, "h": 0.1, "R1": 0.6, "R2": 0.6, "mass_ratio": 0.4}
    rubs = {"housing_friction_1": 0.05, "housing_friction_2": 0.2}
    for load in (-0.02, 0.02):
        row = vp.steady_state(vp.Exciter(**common, **rubs, housing_load=load), outputs=["power"])
        speed = float(row.housing_velocity_mean)
        assert speed > 0
        assert float(row.work_per_distance) == pytest.approx(float(row.power_input) / speed)
        if load < 0:
            assert float(row.efficiency) == pytest.approx(-load * speed / float(row.power_input))
        else:
            assert np.isnan(row.efficiency)
    fixed = vp.steady_state(vp.Exciter(**{**common, "mass_ratio": 0.0}), outputs=["power"])
    assert "efficiency" not in fixed


def coefficients(
    tau: np.ndarray, values: np.ndarray, w: np.ndarray, cuts: np.ndarray
) -> np.ndarray:
    """Return 2/T times the integrals of values exp(-i w tau), by splines of samples between `cuts`, from 0 to T."""
    nodes, weights = np.polynomial.legendre.leggauss(3)
    total = np.zeros(w.size, complex)
    for start, end in itertools.pairwise(cuts):
        inside = (tau > start + 1e-9) & (tau < end - 1e-9)
        spline = CubicSpline(tau[inside], values[inside])
        edges = np.concatenate([[start], tau[inside], [end]])
        middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
        for node, weight in zip(nodes, weights, strict=True):
            at = middle + half * node
            total += (spline(at) * half * weight * np.exp(-1j * w[:, None] * at)).sum(axis=1)
    return 2.0 * total / cuts[-1]


COMMON = {"l": 0.375, "nu": 1.2, "f": 1.0, "h": 0.1, "R1": 0.6, "R2": 0.6, "mass_ratio": 0.44}
RUBS = {"housing_friction_1": 0.05, "housing_friction_2": 0.2}
HARMONICS_OF = {
    "rigid": random_exciter(np.random.default_rng(4), 0.0, 0.0),
    "often held": random_exciter(np.random.default_rng(15), 0.0, 0.0),
    "soft": random_exciter(np.random.default_rng(6), 150.0, 0.0),
    "friction": random_exciter(np.random.default_rng(4), 0.0, 0.05),
    # the second harmonic is the natural frequency of sliding, where the closed form has no digits
    "resonant": vp.Exciter(**{**COMMON, **RUBS, "h": 1e-5, "nu": 0.6}),
    "no friction": vp.Exciter(**COMMON),
}


@pytest.mark.parametrize("name", HARMONICS_OF)
def test_harmonics_of_the_force_are_those_of_the_motion(name: str) -> None:
    exciter = HARMONICS_OF[name]
    row = vp.steady_state(exciter, outputs=("harmonics", "frame"))
    m = int(row.period_multiple)
    assert m > 0
    found = (row.frame_force_amplitude * np.exp(1j * row.frame_force_phase)).values
    motion = motion_of(exciter, row, samples_per_period=20_000)
    tau, x, v, force, velocity = (
        motion[of].values for of in ("tau", "displacement", "velocity", "force", "housing_velocity")
    )
    w, struck = exciter.nu * row.harmonic.values, motion.impact_tau.values
    cuts = np.concatenate([[0.0], struck, [m * exciter.period]])
    # The mass takes the opposite of the force, by parts; a soft support that begins to damp is a kink of its velocity.
    by_momentum = -1j * w * coefficients(tau, v + velocity, w, cuts)
    assert np.allclose(found, by_momentum, rtol=0.0, atol=1e-8 if exciter.k1 else 1e-9)
    if exciter.k1 or exciter.friction:
        return
    R = np.where(motion.impact_support == 1, exciter.R1, exciter.R2)
    impulses = (1 + R) * motion.impact_velocity.values / (1 + exciter.mass_ratio)
    by_forces = coefficients(tau, x + exciter.h * v - force, w, cuts)
    by_forces += 2.0 / cuts[-1] * (impulses * np.exp(-1j * w[:, None] * struck)).sum(axis=1)
    assert np.allclose(found, by_forces, rtol=0.0, atol=1e-9)


def test_harmonics_of_the_force_of_a_heavy_housing() -> None:
    exciter = {**COMMON, "nu": 1.6, "delta": 0.02}

    def force(mass_ratio: float, **rubs: float) -> np.ndarray:
        row = vp.steady_state(
            vp.Exciter(**{**exciter, "mass_ratio": mass_ratio}, **rubs), outputs=["frame"]
        )
        return (row.frame_force_amplitude * np.exp(1j * row.frame_force_phase)).values

    first, second = ((force(ratio, **RUBS) - force(0.0)) / ratio for ratio in (1e-4, 1e-5))
    assert abs(first).max() > 1.0
    assert np.allclose(first, second, rtol=1e-3)


def test_impulses_of_both_bodies() -> None:
    exciter = random_exciter(np.random.default_rng(2), 0.0, 0.0)
    row = vp.steady_state(exciter, outputs=("impacts", "frame"))
    R = np.where(row.impact_support == 1, exciter.R1, exciter.R2)
    expected = (1 + R) * abs(row.impact_velocity) / (1 + exciter.mass_ratio)
    assert np.allclose(row.impact_impulse, expected, rtol=1e-14)
    soft = random_exciter(np.random.default_rng(3), 150.0, 0.0)
    contacts = vp.steady_state(soft, outputs=("impacts", "frame"))
    assert np.isnan(contacts.impact_impulse[contacts.impact_support == 1]).all()
    assert np.isfinite(contacts.impulse_per_period).all()


def test_powers_in_si() -> None:
    exciter = vp.Exciter.from_physical(
        m=0.2, M=0.5, C=8e3, H=4, l=3e-3, F=20, omega="40 Hz", R1=0.6, R2=0.6, D1=1.5, D2=4, P=-0.5
    )
    row = vp.to_physical(vp.steady_state(exciter, outputs=["power"]), exciter)
    assert row.power_input.units == "W"
    assert row.work_per_distance.units == "N"
    speed = float(row.housing_velocity_mean)
    assert float(row.power_housing_load) == pytest.approx(-0.5 * speed, rel=1e-12)
    assert float(row.work_per_distance) == pytest.approx(float(row.power_input) / abs(speed))
