"""Difficult steady states: long orbits, weak stability, slow drift, coexisting attractors."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from comparisons import Orbit, brute_force_orbit, determinant, linear_amplitude
from oracles import Oracle
from sampling import sampled
from textbook import Parameters

import vibropipe as vp
from vibropipe.words.regimes import Regime
from vibropipe.words.status import Status

NO_IMPACT, ONE_SIDED_1, ONE_SIDED_2, TWO_SIDED, WITH_REST, APERIODIC, UNBOUNDED, UNRESOLVED = Regime
TURN = 2 * math.pi

TWO = Parameters(f=1.0, h=0.1, l=0.5, R1=0.7, R2=0.7)
NARROW = Parameters(f=1.0, h=0.1, l=0.5, delta=-0.5, R1=0.8, R2=0.8)
ONE = Parameters(f=1.0, h=0.1, l=50.0, delta=-50.0, R1=0.8, R2=0.8)
LOOSE = Parameters(f=1.0, h=0.05, l=0.5, delta=0.1, R1=0.9, R2=0.9)

# exciter, frequency, forcing periods of its orbit, impacts on each support
LONG_ORBITS = [
    (ONE, 2.7, 2, (2, 0)),
    (ONE, 3.1, 4, (5, 0)),
    (ONE, 8.813, 5, (2, 0)),
    (LOOSE, 1.3, 8, (8, 16)),
    (NARROW, 5.2113, 9, (4, 0)),
    (TWO, 1.2781, 10, (10, 15)),
    (LOOSE, 0.9, 11, (11, 19)),
    (ONE, 6.7, 12, (4, 0)),
    (LOOSE, 0.9216, 14, (14, 24)),
    (ONE, 7.1, 16, (10, 0)),
    (ONE, 5.089, 18, (15, 0)),
    (ONE, 2.9727, 20, (20, 0)),
    (ONE, 4.807, 24, (16, 0)),
    (NARROW, 3.2535, 32, (24, 0)),
    (ONE, 8.7103, 32, (8, 0)),
]
# from rest these are chaotic for about as long as `patience` may be; how long, rounding decides
LONG_TRANSIENTS = {(2.9727, 20)}


def steady(p: Parameters, **start: float) -> Any:
    return vp.steady_state(vp.Exciter(**p._asdict()), **start)


def strobes(p: Parameters, ds: Any, periods: int) -> np.ndarray:
    """Return the states of the oracle at the starts of forcing periods, from the strobe of a dataset."""
    motion = Oracle(p).run(
        TURN / p.nu * periods, float(ds.displacement_strobe), float(ds.velocity_strobe)
    )
    states = [motion.state(TURN / p.nu * n) for n in range(periods + 1)]
    return np.array(states, dtype=float)


def check_same_orbit(p: Parameters, ds: Any, patient: Orbit) -> None:
    """Assert that the orbit closes after m periods, not sooner, and is the one of a long march."""
    m = int(ds.period_multiple)
    assert m == patient.period_multiple
    assert tuple(ds.impacts_per_orbit.values) == patient.struck
    states = strobes(p, ds, m)
    assert np.abs(states[-1] - states[0]).max() < 1e-10
    for shorter in range(1, m):
        assert np.abs(states[shorter] - states[0]).max() > 1e-8
    assert np.abs(states - np.array(patient.strobe)).max(axis=1).min() < 1e-6
    product = np.prod(ds.floquet_multiplier.values)
    struck = (int(patient.struck[0]), int(patient.struck[1]))
    assert product == pytest.approx(determinant(p, m, struck), rel=1e-7, abs=1e-10)
    assert int(ds.stable) == 1


@pytest.mark.parametrize(("p", "nu", "m", "struck"), sampled(LONG_ORBITS, *LONG_ORBITS[::2]))
def test_orbits_of_many_periods(p: Parameters, nu: float, m: int, struck: tuple[int, int]) -> None:
    p = p._replace(nu=nu)
    patient = brute_force_orbit(p, patience=3000)
    assert (patient.period_multiple, patient.struck) == (m, struck)
    x0, v0 = patient.strobe if (p.nu, m) in LONG_TRANSIENTS else (0.0, 0.0)
    ds = steady(p, x0=round(x0, 3), v0=round(v0, 3))
    check_same_orbit(p, ds, patient)
    assert int(ds.regime) == (TWO_SIDED if struck[1] else ONE_SIDED_1)
    assert float(ds.base_frequency) == pytest.approx(nu / m, rel=1e-14)


@pytest.mark.parametrize(
    ("p", "start"),
    [
        (TWO._replace(nu=2.85), (0.0, 0.0)),
        (TWO._replace(nu=2.85), (0.0, 1.0)),
        (TWO._replace(nu=2.85), (0.0, 3.0)),
        (LOOSE._replace(nu=2.325), (0.0, 0.0)),
        (LOOSE._replace(nu=2.325), (0.0643336, 0.627654)),
        (LOOSE._replace(nu=1.2), (0.0, 0.0)),
        (LOOSE._replace(nu=1.2), (-0.2662341762634425, 0.3155260032169539)),
    ],
)
def test_coexisting_orbits_are_told_apart_by_the_start(
    p: Parameters, start: tuple[float, float]
) -> None:
    """The orbit is the one on which the motion from this start settles."""
    x0, v0 = start
    patient = brute_force_orbit(p, x0, v0, patience=1000)
    ds = steady(p, x0=x0, v0=v0)
    check_same_orbit(p, ds, patient)
    assert int(ds.regime) == (TWO_SIDED if patient.struck[0] else NO_IMPACT)


# -- weak stability and slow drift -------------------------------------------------------------


@pytest.mark.parametrize("nu", [0.6, 1.0, 1.3, 40.0])
def test_a_weakly_damped_linear_orbit(nu: float) -> None:
    """Multipliers of modulus 0.999: the transient takes 20,000 periods to decay."""
    p = Parameters(nu=nu, h=nu * 1e-3 / math.pi, f=0.1 * abs(1 - nu**2) + 1e-5, l=20.0)
    ds = steady(p)
    assert int(ds.regime) == NO_IMPACT
    assert int(ds.period_multiple) == 1
    modulus = np.abs(ds.floquet_multiplier.values)
    np.testing.assert_allclose(modulus, math.exp(-1e-3), rtol=1e-9)
    amplitude = ds.displacement_amplitude.values
    assert amplitude[0] == pytest.approx(linear_amplitude(p), rel=1e-9)
    assert np.abs(amplitude[1:]).max() < 1e-12
    assert int(ds.stable) == 1


def test_a_weakly_stable_striking_orbit() -> None:
    """Near the loss of stability of the symmetric orbit: multiplier 0.999."""
    p = TWO._replace(nu=1.47453125)
    ds = steady(p)
    check_same_orbit(p, ds, brute_force_orbit(p, patience=25_000))
    assert np.abs(ds.floquet_multiplier.values).max() == pytest.approx(0.999, abs=1e-4)
    assert int(ds.regime) == TWO_SIDED


def test_a_slow_drift_is_not_a_steady_state() -> None:
    """At resonance the amplitude grows for 2,200 periods before the first impact."""
    p = Parameters(nu=1.0, h=1e-4, f=1e-5, l=0.05, R1=0.7, R2=0.7)
    ds = steady(p)
    assert int(ds.regime) in (TWO_SIDED, UNRESOLVED)
    if int(ds.regime) == TWO_SIDED:
        check_same_orbit(p, ds, brute_force_orbit(p, patience=4000))
    else:
        assert int(ds.status) != Status.OK
        assert int(ds.period_multiple) == 0


# -- nothing settles ---------------------------------------------------------------------------


@pytest.mark.parametrize("nu", sampled([1.1, 1.15, 1.2, 1.25]))
def test_aperiodic_motion(nu: float) -> None:
    """No orbit in 5,000 periods; means over the window agree with those of a long march."""
    p = TWO._replace(nu=nu)
    patient = brute_force_orbit(p, patience=4000, most=500)
    assert patient.period_multiple == 0
    ds = steady(p)
    assert int(ds.regime) == APERIODIC
    assert int(ds.period_multiple) == 0
    assert int(ds.window_periods) > 50
    np.testing.assert_allclose(ds.impacts_per_orbit.values, patient.struck, atol=0.1)
    assert np.isfinite(ds.displacement_amplitude.values).all()


@pytest.mark.parametrize(
    "p",
    [
        Parameters(nu=1.0, f=1.0, l=1e9),
        Parameters(nu=1.0, f=-1e-6, l=1e9, delta=10.0),
        Parameters(nu=2.0, f=1.0, l=1e9, delta=-1e9),
        Parameters(nu=2.0, f=-1.0, l=1e9, delta=1e9, R1=0.5),
    ],
)
def test_growth_without_bound_is_labelled(p: Parameters) -> None:
    """Resonance without damping: of the free mass, and of a mass hopping on an ideal support."""
    ds = steady(p)
    assert int(ds.regime) == UNBOUNDED
    assert int(ds.period_multiple) == 0


def test_a_slow_approach_is_not_called_unbounded() -> None:
    """R = 0.9999 without damping: the motion grows to (4/3)/(1 - R), by 1e-4 of the remainder per period."""
    ds = steady(Parameters(nu=2.0, f=1.0, l=1e9, delta=1e9, R2=0.9999))
    assert int(ds.regime) == UNRESOLVED
    assert int(ds.period_multiple) == 0


def test_a_bounded_motion_without_damping_is_not_called_unbounded() -> None:
    ds = steady(Parameters(nu=1.0, f=0.3, l=0.5))
    assert int(ds.regime) in (APERIODIC, UNRESOLVED)
    assert np.isfinite(ds.displacement_amplitude.values).all()


def test_a_chatter_of_a_thousand_million_impacts_is_given_up() -> None:
    """R = 1 - 1e-9, pressed against the support: more impacts in a period than are marched."""
    p = Parameters(f=0.1, l=0.5, delta=-1.5, h=1.0, R1=1 - 1e-9, R2=1 - 1e-9)
    ds = steady(p, x0=-1.0, v0=-1e-4)
    assert int(ds.regime) == UNRESOLVED
    assert int(ds.status) == Status.MAX_IMPACTS


# -- free motions and rests --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("delta", "v0", "regime"),
    [
        (0.0, 0.3, NO_IMPACT),
        (0.0, 0.51, TWO_SIDED),
        (0.0, 5.0, TWO_SIDED),
        (0.01, -0.495, ONE_SIDED_2),
        (-0.01, 0.495, ONE_SIDED_1),
        (0.1, 0.7, TWO_SIDED),
    ],
)
def test_a_conservative_motion_has_its_own_frequency(delta: float, v0: float, regime: int) -> None:
    """Half a revolution on the circle of radius |v0|, less the parts beyond the supports."""
    ds = steady(Parameters(l=0.5, delta=delta), v0=v0)
    upper, lower, radius = 0.5 + delta, 0.5 - delta, abs(v0)
    half = math.asin(min(1.0, upper / radius)) + math.asin(min(1.0, lower / radius))
    assert int(ds.regime) == regime
    assert float(ds.base_frequency) == pytest.approx(math.pi / half, rel=1e-12)


@pytest.mark.parametrize(
    ("nu", "R"),
    [(0.3, 0.0), (0.3, 0.3), (0.3, 0.7), (0.5, 0.0), (0.5, 0.3), (0.7, 0.0), (0.7, 0.3)],
)
def test_orbits_with_rest_forget_their_start(nu: float, R: float) -> None:
    p = Parameters(nu=nu, f=1.5, h=0.2, l=0.5, R1=R, R2=R)
    motion = Oracle(p).run(5 * TURN / nu)
    assert motion.rests
    ds = steady(p)
    assert int(ds.regime) == WITH_REST
    assert ds.rests_per_orbit.values.tolist() == [1, 1]
    assert np.abs(ds.floquet_multiplier.values).max() == 0
    strobe = [float(part) for part in motion.state(4 * TURN / nu)]
    computed = [float(ds.displacement_strobe), float(ds.velocity_strobe)]
    np.testing.assert_allclose(computed, strobe, rtol=0, atol=1e-12)


@pytest.mark.parametrize("f", [0.0, 0.1])
def test_a_mass_pushed_for_ever_rests_for_ever(f: float) -> None:
    p = Parameters(f=f, h=0.2, l=0.5, delta=-0.8, R1=0.7, R2=0.7)
    ds = steady(p, x0=-0.5, v0=3.0)
    assert int(ds.regime) == WITH_REST
    assert float(ds.displacement_mean) == pytest.approx(-0.3, abs=1e-15)
    assert np.abs(ds.displacement_amplitude.values).max() < 1e-15


def test_a_damped_free_motion_ends_at_the_equilibrium() -> None:
    ds = steady(Parameters(h=0.2, l=0.5, R1=0.7, R2=0.7), x0=0.1, v0=3.0)
    assert int(ds.regime) == NO_IMPACT
    assert float(ds.displacement_mean) == pytest.approx(0, abs=1e-12)
    assert np.abs(ds.displacement_amplitude.values).max() < 1e-12


@pytest.mark.parametrize(("h", "delta"), [(0.05, 0.0), (0.1, 0.2), (0.3, 0.1)])
def test_an_equilibrium_is_an_orbit_of_one_period(h: float, delta: float) -> None:
    """Also where rounding is all that is left of the motion, which then repeats after any number of periods."""
    starts = {"x0": np.linspace(-0.2, 0.5, 40), "v0": [0.1, 0.3]}
    rows = vp.sweep(vp.Exciter(l=0.5, h=h, delta=delta, R1=0.6, R2=0.6), starts)
    assert (rows.period_multiple == 1).all()
