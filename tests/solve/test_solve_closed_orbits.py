"""Closed forms of orbits and of free motions as datasets, against marches."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import mpmath
import numpy as np
import pytest
import xarray as xr
from comparisons import parameters_of, reference
from hypothesis import given, settings
from hypothesis import strategies as st
from textbook import Flight, Parameters, digits

import vibropipe as vp
from vibropipe.march.grid import exact_grid
from vibropipe.march.log import new_log
from vibropipe.march.state import initial_state
from vibropipe.orbits.return_map import floquet_multipliers, march_periods, state_xv
from vibropipe.orbits.shooting import Shooting, shoot
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.physics.flow import DEGREE

UNIT = vp.Exciter(l=1, nu=1, f=1)


TWO_SIDED = vp.Exciter(l=0.5, nu=1.6, f=1.0, h=0.1, R1=0.7, R2=0.7)
ONE_SIDED = vp.Exciter(l=0.5, delta=-0.2, nu=1.2, f=0.2, h=0.1, R1=0.8, R2=0.6)
# A symmetric orbit after its pitchfork, and a one-sided one after its flip (offset by far more than it moves).
PAST_PITCHFORK = dataclasses.replace(TWO_SIDED, nu=1.4)
PAST_FLIP = vp.Exciter(l=50.0, delta=-50.0, nu=2.7, f=1.0, h=0.1, R1=0.8, R2=0.8)
IMPACTS, SECTION = ("impact_phase", "impact_velocity"), ("displacement_strobe", "velocity_strobe")
COMPARED = (*IMPACTS, "floquet_multiplier", *SECTION)


def march(e: vp.Exciter, x: float, v: float) -> tuple[Any, ...]:
    p = e.parameters()
    grid = exact_grid(ALL_EFFECTS, p)
    return ALL_EFFECTS, p, grid, initial_state(ALL_EFFECTS, p, grid, 0.0, x, v, None)


def image(e: vp.Exciter, x: float, v: float, m: int) -> np.ndarray:
    log, c = new_log(2000, 100), np.empty(DEGREE + 1)
    end, _status = march_periods(*march(e, x, v), np.int64(m), log, c, np.int64(10**6))
    return np.array(state_xv(e.parameters(), end))


@pytest.mark.parametrize(
    ("exciter", "start"),
    [
        (TWO_SIDED, {}),
        (dataclasses.replace(TWO_SIDED, f=-1.0), {}),
        (dataclasses.replace(TWO_SIDED, nu=2.5, f=2.0), {"x0": 0.0, "v0": 1.0}),
        (dataclasses.replace(TWO_SIDED, h=2.0, f=2.5), {}),
        (dataclasses.replace(TWO_SIDED, nu=1.0, h=0.0, f=0.5, R1=0.1, R2=0.1), {}),
        (dataclasses.replace(TWO_SIDED, h=0.0, R1=0.5, R2=0.5, f=0.8), {}),
    ],
)
def test_a_settled_symmetric_orbit_is_the_closed_form(exciter: vp.Exciter, start: Any) -> None:
    settled = vp.steady_state(exciter, **start)
    orbit = vp.symmetric_orbit(exciter)
    assert settled.impacts_per_orbit.values.tolist() == [1, 1]
    first = orbit.isel(solution=0)
    assert (first.admissible, first.stable, first.period_multiple) == (1, 1, 1)
    for name in ("impact_support", "impact_period"):
        np.testing.assert_array_equal(first[name], settled[name])
    for name in COMPARED:
        np.testing.assert_allclose(first[name], settled[name], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    ("exciter", "support", "m", "start"),
    [
        (ONE_SIDED, 1, 1, {}),
        (ONE_SIDED.mirrored(), 2, 1, {}),
        (dataclasses.replace(PAST_FLIP, nu=2.3), 1, 1, {}),
        (dataclasses.replace(PAST_FLIP, nu=2.3, h=0.0, R1=0.5), 1, 1, {}),
        (dataclasses.replace(PAST_FLIP, nu=4.1, R1=0.7), 1, 2, {}),
        (vp.Exciter(l=50.0, delta=-49.0, nu=1.0, f=1.0, R1=0.3), 1, 1, {}),
    ],
)
def test_a_settled_one_sided_orbit_is_the_closed_form(
    exciter: vp.Exciter, support: int, m: int, start: Any
) -> None:
    settled = vp.steady_state(exciter, **start)
    assert settled.impacts_per_orbit.values.tolist() == [2.0 - support, support - 1.0]
    assert settled.period_multiple == m
    orbit = vp.one_sided_orbit(exciter, support, m).isel(solution=0)
    assert (orbit.admissible, orbit.stable, orbit.period_multiple) == (1, 1, m)
    assert (
        orbit.impact_support.values.tolist() == settled.impact_support.values.tolist() == [support]
    )
    # the periods of a longer orbit are counted from another one
    compared = COMPARED if m == 1 else COMPARED[:3]
    for name in compared:
        np.testing.assert_allclose(orbit[name], settled[name], rtol=1e-12, atol=1e-12)


def test_the_symmetric_orbit_of_figure_6_in_20_digits() -> None:
    entry = reference("steady")["fig6"]
    exciter = vp.Exciter(**parameters_of(entry)._asdict())
    orbit = vp.symmetric_orbit(exciter).isel(solution=0)
    assert orbit.displacement_strobe.item() == pytest.approx(float(entry["x_strobe"]), abs=1e-15)
    assert orbit.velocity_strobe.item() == pytest.approx(float(entry["v_strobe"]), abs=1e-15)
    multipliers = [float(real) for real, _imag in entry["multipliers"]]
    np.testing.assert_allclose(orbit.floquet_multiplier, multipliers, rtol=1e-14)
    for name, key in (("impact_phase", "phase"), ("impact_velocity", "velocity_before")):
        expected = [float(impact[key]) for impact in entry["impacts"]]
        np.testing.assert_allclose(orbit[name], expected, rtol=4e-16)


@pytest.mark.parametrize(
    ("orbits", "exciter", "m"),
    [
        (vp.symmetric_orbit, PAST_PITCHFORK, 1),
        (vp.one_sided_orbit, PAST_FLIP, 1),
        (vp.one_sided_orbit, ONE_SIDED, 1),
        (vp.symmetric_orbit, dataclasses.replace(TWO_SIDED, nu=1.3, f=0.15), 1),
        (
            lambda e: vp.symmetric_orbit(e, 3),
            vp.Exciter(l=0.5, nu=3.6, f=1.0, h=0.02, R1=0.9, R2=0.9),
            3,
        ),
    ],
)
def test_stable_or_not_it_is_a_fixed_point_with_its_multipliers(
    orbits: Any, exciter: vp.Exciter, m: int
) -> None:
    orbit = orbits(exciter)
    assert orbit.admissible.values.any()
    for solution in orbit.where(orbit.admissible == 1, drop=True).solution.values:
        one = orbit.sel(solution=solution)
        x, v = one.displacement_strobe.item(), one.velocity_strobe.item()
        log, scratch = new_log(2000, 100), np.empty(DEGREE + 1)
        found = shoot(*march(exciter, x, v), np.int64(m), Shooting(), log, scratch)
        assert found.is_closed
        assert found.distance < 1e-11
        multipliers = one.floquet_multiplier.values
        expected = floquet_multipliers(*found.derivative)
        np.testing.assert_allclose(multipliers, expected, rtol=1e-8, atol=1e-10)
        step = 1e-6
        columns = [
            (image(exciter, x + dx, v + dv, m) - image(exciter, x - dx, v - dv, m)) / (2 * step)
            for dx, dv in ((step, 0.0), (0.0, step))
        ]
        assert np.trace(columns) == pytest.approx(multipliers.sum().real, rel=1e-5, abs=1e-5)


def samples(e: vp.Exciter, orbit: xr.Dataset, n: int) -> np.ndarray:
    """Return x over the flight after the impact on support 1, by the textbook and without supports."""
    # doubles suffice away from the resonance
    near = e.h == 0 and abs(e.nu - 1) < 1e-3
    c = (
        digits(Parameters(*(getattr(e, name) for name in Parameters._fields)), 30)
        if near
        else mpmath.fp
    )
    impact = int(np.argmax(orbit.impact_support.values == 1))
    turn, v = orbit.impact_phase.values[impact], orbit.impact_velocity.values[impact]
    nu, f, h = (c.mpf(value) for value in (e.nu, e.f, e.h))
    tau = 2 * c.pi * c.mpf(turn) / nu
    flight = Flight(c, nu, f, h, (tau, c.mpf(e.upper), -e.R1 * c.mpf(v)))
    ends = np.linspace(0, 1, 801)
    return np.array([float(flight(tau + n * c.pi / nu * c.mpf(s))[0]) for s in ends])


# Two supports within reach, weak and strong damping, and departures at no speed.
REACHING = st.builds(
    vp.Exciter,
    l=st.just(0.5),
    nu=st.floats(0.3, 4),
    f=st.floats(0.05, 4),
    h=st.sampled_from([0.0, 0.1, 2.0, 5.0]),
    delta=st.floats(-0.4, 0.4),
    R1=st.sampled_from([0.0, 0.3, 0.8, 1.0]),
    R2=st.just(0.5),
)


@settings(max_examples=100)
@given(REACHING, st.sampled_from([1, 2, 4]))
def test_admissibility_and_clearance_are_those_of_dense_samples(e: vp.Exciter, n: int) -> None:
    if n == 1:
        e = dataclasses.replace(e, delta=0.0, R2=e.R1)
    orbits = vp.symmetric_orbit(e) if n == 1 else vp.one_sided_orbit(e, 1, n // 2)
    for solution in (1, 2):
        orbit = orbits.sel(solution=solution)
        if not np.isfinite(orbit.impact_velocity).all():
            assert orbit.admissible == 0
            continue
        x = samples(e, orbit, n)
        inner, left, right = x[1:-1], x[:-2], x[2:]
        minima = inner[(inner < left) & (inner < right)] - e.lower
        maxima = e.upper - inner[(inner > left) & (inner > right)]
        clearance = min([*minima, *maxima], default=math.inf)
        size = max(1.0, abs(x).max())
        if math.isfinite(clearance):
            assert orbit.clearance == pytest.approx(clearance, abs=2e-3 * size)
        outside = max((inner - e.upper).max(), (e.lower - inner).max())
        if abs(outside) > 1e-3 and not (outside < 0 and abs(clearance) < 1e-3 * size):
            assert orbit.admissible == (outside < 0)


@settings(max_examples=15)
@given(REACHING, st.sampled_from([1, 3]))
def test_mirrored_exciters_have_mirrored_orbits(e: vp.Exciter, m: int) -> None:
    one, other = vp.one_sided_orbit(e, 1, m), vp.one_sided_orbit(e.mirrored(), 2, m)
    for name in one.data_vars:
        if name in ("impacts_per_orbit", "impacts_per_period"):
            np.testing.assert_array_equal(other[name], one[name][::-1])
        elif name != "impact_support":
            odd = name in ("impact_velocity", "displacement_strobe", "velocity_strobe")
            np.testing.assert_array_equal(other[name], -one[name] if odd else one[name])
    assert (one.impact_support == 1).all()
    assert (other.impact_support == 2).all()
    assert (other.delta, other.f) == (-e.delta, -e.f)
    assert one.attrs == other.attrs
    assert one.attrs["version"] == vp.__version__
    grid = np.array([0.7, e.nu + 1])
    one_limits, other_limits = (
        vp.one_sided_orbit_boundaries(one_of, grid, support)
        for one_of, support in ((e, 1), (e.mirrored(), 2))
    )
    for name in one_limits.data_vars:
        np.testing.assert_array_equal(one_limits[name], other_limits[name])


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (
            lambda: vp.symmetric_orbit(vp.Exciter(l=1, nu=1.0, f=1, delta=0.1)),
            "delta: must be 0 for a symmetric orbit, got 0.1",
        ),
        (
            lambda: vp.symmetric_orbit(vp.Exciter(l=1, nu=1.0, f=1, R1=0.5)),
            "R2: must equal R1 for a symmetric orbit, got R1 = 0.5, R2 = 1.0",
        ),
        (lambda: vp.symmetric_orbit(vp.Exciter(l=1, nu=1.0, f=1), 2), "m: must be odd for a symmetric orbit, got 2"),
        (
            lambda: vp.one_sided_orbit(vp.Exciter(l=1)),
            "f: must not be 0, since these orbits have the period of the force "
            "(free motions: amplitude_frequency), got 0.0",
        ),
        (lambda: vp.one_sided_orbit(UNIT, 3), "support: must be a whole number from 1 to 2, got 3"),
        (lambda: vp.one_sided_orbit(UNIT, 1, 0), "m: must be a whole number from 1 to 1000, got 0"),
        (
            lambda: vp.symmetric_orbit_boundaries(vp.Exciter(l=1), [1.0, -1.0]),
            "nu: must be a list of finite numbers > 0, got [1.0, -1.0]",
        ),
        (
            lambda: vp.one_sided_orbit(vp.Exciter(l=1, f=1e6, nu=1e-4, h=1e4)),
            "nu: must give a flight of less than 1e8 steps of the march, got 0.0001 with 1.26e+09 steps",
        ),
    ],
)  # fmt: skip
def test_other_exciters_are_rejected(call: Any, text: str) -> None:
    with pytest.raises(vp.ParameterError) as error:
        call()
    assert str(error.value) == text


def test_a_root_that_is_no_velocity_has_no_multipliers() -> None:
    exciter = vp.Exciter(l=0.5, nu=2.2, f=0.5, h=0.1, delta=-0.45, R1=0.7, R2=0.8)
    found = vp.one_sided_orbit(exciter)
    assert np.isnan(found.impact_velocity[:, 0]).values.tolist() == [False, True]
    assert np.isnan(found.floquet_multiplier).values.tolist() == [[False] * 2, [True] * 2]


AMPLITUDES = [0.3, 0.5, 0.8, 1.2]


def test_the_impact_velocity_is_that_of_a_simulated_motion() -> None:
    exciter = vp.Exciter(l=0.5, delta=0.1)
    free = vp.amplitude_frequency(exciter, AMPLITUDES)
    for amplitude in AMPLITUDES:
        # x' = amplitude at x = 0
        motion = vp.simulate(exciter, tau_end=20.0, x0=0.0, v0=amplitude)
        for support in (1, 2):
            struck = np.abs(motion.impact_velocity.values[motion.impact_support.values == support])
            velocity = float(free.impact_velocity_max.sel(amplitude=amplitude, support=support))
            if struck.size:
                assert struck == pytest.approx(velocity, rel=1e-13)
            else:
                assert np.isnan(velocity)


def test_it_is_the_backbone_of_eq_10() -> None:
    exciter = vp.Exciter(l=0.5, delta=0.1)
    free = vp.amplitude_frequency(exciter, [0.8, 1.2])
    periods = 2 * np.pi / free.eigenfrequency.values
    backbone = vp.backbone([0.2], np.sort(periods)).sortby("tau_bar", ascending=False)
    velocities = free.impact_velocity_max.sel(support=1).values
    assert backbone.velocity_over_l.values[0] * 0.5 == pytest.approx(velocities, rel=1e-12)
