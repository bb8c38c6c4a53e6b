"""Motions on a ramp, rigid or by pieces, against an ordinary integrator, quadratures and a steady frequency."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from helpers.ramp_twin import Twin
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

import vibropipe as vp

TIMES = ("impact_tau", "rest_start", "rest_end", "grazing_tau")


def drawn(seed: int) -> tuple[vp.Exciter, float, float]:
    """Return an exciter, the frequency at the end and the length of a random ramp that strikes fast enough."""
    rng = np.random.default_rng(seed)
    nu, nu_end = rng.uniform(0.3, 3.0, 2)
    extra = {"f2": rng.uniform(-0.5, 0.5), "phi2": rng.uniform(0, 6)} if seed % 3 == 0 else {}
    extra |= {"load": rng.uniform(-0.2, 0.2)} if seed % 4 == 1 else {}
    h = 0.0 if seed % 5 == 0 else rng.uniform(0, 0.6)
    e = vp.Exciter(
        l=rng.uniform(0.5, 1.0), delta=rng.uniform(-0.2, 0.2), nu=nu, f=rng.uniform(0.5, 2.0), h=h,
        R1=rng.uniform(0.6, 1.0), R2=rng.uniform(0.6, 1.0), **extra,
    )  # fmt: skip
    return e, nu_end, float(10 ** rng.uniform(0.7, 1.8))


@pytest.mark.parametrize("seed", range(12))
def test_impacts_are_those_of_an_ordinary_integrator(seed: int) -> None:
    e, nu_end, span = drawn(seed)
    ds = vp.simulate(e, span, samples_per_period=0, nu_end=nu_end)
    twin = Twin(e, nu_end, span)
    twin.run(*e.check_start(None, 0.0), most=6)
    for name in ("impact_tau", "impact_velocity"):
        expected = twin.events.get(name, [])
        if len(expected) < 6:
            assert ds.sizes["impact"] == len(expected)
        assert ds[name].values[:6] == pytest.approx(expected, abs=1e-11)


@pytest.mark.parametrize(
    ("nu", "nu_end", "span", "h"),
    [
        (0.5, 2.0, 40.0, 0.1),
        (2.0, 0.5, 40.0, 0.1),
        (0.2, 60.0, 2.0, 0.3),
        (0.99, 1.01, 400.0, 0.0),
        (1.0, 3.0, 20.0, 5.0),
    ],
)
def test_a_motion_without_impacts_is_its_integral(
    nu: float, nu_end: float, span: float, h: float
) -> None:
    e = vp.Exciter(l=300.0, nu=nu, f=1.0, h=h)
    ds = vp.simulate(e, span, 0.3, -0.2, nu_end=nu_end)
    free, force = np.emath.sqrt(1 - h * h / 4), Twin(e, nu_end, span).force

    def kernel(t: float) -> float:
        return float(np.real(np.exp(-h / 2 * t) * np.sin(free * t) / free))

    def slope(t: float) -> float:
        return float(np.real(np.exp(-h / 2 * t) * np.cos(free * t))) - h / 2 * kernel(t)

    def response(s: float) -> float:
        return quad(
            lambda t: kernel(s - t) * force(t), 0, s, epsabs=1e-13, epsrel=1e-13, limit=2000
        )[0]

    # from (0.3, -0.2): x' + h x of the unit displacement is its kernel's slope
    for s, x in [
        (float(ds.tau[i]), float(ds.displacement[i])) for i in (len(ds.tau) // 3, len(ds.tau) - 1)
    ]:
        start = 0.3 * (slope(s) + h * kernel(s)) - 0.2 * kernel(s)
        assert x == pytest.approx(start + response(s), abs=2e-12 * max(1.0, abs(x)))
    assert float(ds.frequency[0]) == nu
    assert float(ds.frequency[-1]) == nu_end == float(ds.nu_end)


@pytest.mark.parametrize(
    "further",
    [
        {},
        {"load": 0.2, "R1": 0.0},
        {"f2": 0.4, "phi2": 0.3},
        {"h": 0.0, "R1": 1.0, "R2": 1.0},
        {"l": 0.2, "nu": 0.3, "f": 3.0, "R1": 0.3, "R2": 0.3},
    ],
)
def test_equal_frequencies_give_the_ordinary_motion(further: dict[str, float]) -> None:
    e = vp.Exciter(**{"l": 1.0, "nu": 1.0, "f": 1.0, "h": 0.1, "R1": 0.6, "R2": 0.6} | further)
    ramp = vp.simulate(e, 40.0, tau_start=3.0, nu_end=e.nu)
    plain = vp.simulate(e, 40.0, tau_start=3.0)
    assert plain.sizes["impact"] > 3
    for name in (*TIMES, "impact_velocity", "displacement", "velocity", "force", "tau"):
        np.testing.assert_allclose(ramp[name], plain[name], rtol=0, atol=1e-12, err_msg=name)


def test_a_release_is_where_the_force_turns_positive() -> None:
    e = vp.Exciter(l=0.3, nu=0.2, f=1.0, h=0.1, R1=0.0, R2=0.3)
    ds = vp.simulate(e, 60.0, nu_end=1.2, samples_per_period=0)
    ends = ds.rest_end.values[np.isfinite(ds.rest_end.values)]
    assert ends.size > 5
    force = Twin(e, 1.2, 60.0).force
    for start, end, support in zip(
        ds.rest_start.values, ends, ds.rest_support.values, strict=False
    ):
        wall, sign = (e.upper, -1.0) if support == 1 else (e.lower, 1.0)

        def push(s: float, wall: float = wall, sign: float = sign) -> float:
            return sign * (force(s) - wall)

        held = np.linspace(start, end, 200)[1:-1]
        assert max(map(push, held)) < 0
        assert brentq(push, end - 1e-3, end + 1e-3, xtol=1e-15) == pytest.approx(end, abs=1e-12)


@pytest.mark.parametrize("depth", [1e-9, 1e-11, -1e-11, -1e-9])
def test_a_first_impact_that_nearly_grazes_is_not_missed(depth: float) -> None:
    free = Twin(vp.Exciter(l=50.0, nu=0.6, f=1.0, h=0.1), 1.6, 30.0)
    free.direction = 1
    run = solve_ivp(
        free.rates, (0.0, 30.0), [0.0, 0.0], "DOP853", events=lambda _s, z: z[1],
        rtol=2.3e-14, atol=1e-16, max_step=0.1,
    )  # fmt: skip
    highest = int(run.y_events[0][:, 0].argmax())
    at, peak = float(run.t_events[0][highest]), float(run.y_events[0][highest, 0])
    upper, lower = peak - depth, -50.0
    e = vp.Exciter(
        l=0.5 * (upper - lower), delta=0.5 * (upper + lower), nu=0.6, f=1.0, h=0.1, R1=0.5, R2=0.5
    )
    ds = vp.simulate(e, 30.0, nu_end=1.6, samples_per_period=0)
    if depth < 0:
        assert ds.sizes["impact"] == ds.sizes["grazing"] == 0
        return
    # the speed of a shallow impact: v^2 = 2 depth |x''|
    pull = upper - free.force(at)
    speed = math.sqrt(2 * depth * pull)
    assert float(ds.impact_tau[0]) == pytest.approx(at - speed / pull, abs=0.01 * speed / pull)
    assert float(ds.impact_velocity[0]) == pytest.approx(speed, rel=0.01)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"nu_end": 0.0}, "nu_end"),
        ({"nu_end": "2"}, "nu_end"),
        ({"nu_end": 2.0, "tau_end": 0.0}, "tau_end: must be above tau_start"),
        ({"nu_end": 2.0, "method": "newmark", "steps_per_period": 40}, "method: must be left out"),
        ({"nu_end": 2.0, "accuracy": 1e-6}, "accuracy: must be left out"),
        ({"nu_end": 2.0, "energy": True}, "energy: must be left out"),
        ({"nu_end": 2.0, "effects": ["forcing"]}, "effects: must be left out"),
        ({"nu_end": 2.0, "tau_end": 1e9}, "at most"),
    ],
)
def test_bad_requests_are_refused(given: dict[str, Any], told: str) -> None:
    e = vp.Exciter(l=1.0, nu=1.0, f=1.0)
    with pytest.raises(vp.ParameterError, match=told):
        vp.simulate(e, **given)


SOFT = {
    "l": 0.6,
    "delta": 0.1,
    "nu": 0.7,
    "f": 1.2,
    "h": 0.1,
    "k1": 40.0,
    "h1": 0.5,
    "k2": 90.0,
    "h2": 1.0,
}
COMPARED = ("impact_tau", "impact_velocity", "turn_tau", "stick_start", "stick_end")


def drawn_of_pieces(seed: int) -> tuple[vp.Exciter, float, float, tuple[float, float]]:
    """Return an exciter, the frequency at the end, the length of the ramp and the start."""
    rng = np.random.default_rng(seed)
    nu, nu_end = rng.uniform(0.3, 3.0, 2)
    values: dict[str, float] = {
        "l": rng.uniform(0.4, 1.0), "delta": rng.uniform(-0.2, 0.2), "nu": nu,
        "f": rng.uniform(0.5, 2.0), "h": 0.0 if seed % 5 == 0 else rng.uniform(0, 0.6),
    }  # fmt: skip
    if seed % 3 != 2:
        values |= {"k1": 10 ** rng.uniform(0.5, 3.5), "h1": rng.uniform(0, 3)}
    else:
        values |= {"R1": rng.uniform(0.6, 1.0)}
    if seed % 3 != 1:
        values |= {"k2": 10 ** rng.uniform(0.5, 3.5), "h2": rng.uniform(0, 3)}
    else:
        values |= {"R2": rng.uniform(0.6, 1.0)}
    if seed % 2 == 1:
        values |= {"friction": rng.uniform(0.02, 0.5), "friction_ratio": rng.uniform(1, 1.6)}
    if seed % 4 >= 2:
        values |= {"f2": rng.uniform(-0.5, 0.5), "phi2": rng.uniform(0, 6)}
    if seed % 7 == 3:
        values |= {"load": rng.uniform(-0.2, 0.2)}
    if seed % 4 == 1:
        values |= {"contact_1": 1.0, "contact_2": 1.0}
    if seed % 5 == 2:
        values |= {"shaker": rng.uniform(-0.5, 0.5)}
    return (
        vp.Exciter(**values),
        nu_end,
        float(10 ** rng.uniform(0.7, 1.5)),
        (0.1, rng.uniform(-1, 1)),
    )


def compare(
    e: vp.Exciter, nu_end: float, span: float, start: tuple[float, float], n: int = 24
) -> float:
    """Return the largest deviation of a motion on a ramp from its twin over n events and at the end."""
    twin = Twin(e, nu_end, span)
    end = twin.run(*start, most=n)
    ds = vp.simulate(e, span, *start, samples_per_period=0, nu_end=nu_end)
    worst, seen = 0.0, 0
    for name in COMPARED:
        expected = np.array(twin.events.get(name, []))
        found = ds[name].values[np.isfinite(ds[name].values)] if name in ds else np.empty(0)
        if twin.end == span:
            assert found.size == expected.size, name
        assert found.size >= expected.size, name
        worst = max(worst, np.abs(found[: expected.size] - expected).max(initial=0.0))
        seen += expected.size
    assert seen >= 2
    if twin.end == span:
        ends = [float(ds.displacement_end), float(ds.velocity_end)]
        worst = max(worst, np.abs(np.array(ends) - end[:2]).max())
    return worst


@pytest.mark.parametrize("seed", range(28))
def test_soft_supports_and_friction_are_those_of_an_ordinary_integrator(seed: int) -> None:
    e, nu_end, span, start = drawn_of_pieces(seed)
    assert compare(e, nu_end, span, start) < 1e-10


def test_a_housing_is_refused() -> None:
    with pytest.raises(vp.ParameterError, match="mass_ratio: must be 0 with nu_end"):
        vp.simulate(vp.Exciter(l=1.0, nu=1.0, f=1.0, mass_ratio=0.2), nu_end=2.0)


@pytest.mark.parametrize(
    "further", [{}, {"friction": 0.05, "friction_ratio": 1.3}, {"shaker": 0.4}]
)
def test_equal_frequencies_give_the_ordinary_motion_by_pieces(further: dict[str, Any]) -> None:
    e = vp.Exciter(**SOFT, **further)
    ramp = vp.simulate(e, 40.0, 0.1, 0.2, tau_start=3.0, nu_end=e.nu)
    plain = vp.simulate(e, 40.0, 0.1, 0.2, tau_start=3.0)
    assert plain.sizes["impact"] > 3
    for name in plain.data_vars:
        np.testing.assert_allclose(ramp[name], plain[name], rtol=0, atol=1e-11, err_msg=name)


def test_a_long_stick_under_a_shaker_ends_where_its_force_exceeds_friction() -> None:
    e = vp.Exciter(l=0.5, nu=0.001, f=0.0, h=0.1, shaker=0.1, friction=0.06)
    ds = vp.simulate(e, 1e4, nu_end=1.0, samples_per_period=0)
    slip = float(ds.stick_end[0])
    times = np.linspace(0.0, slip, 400_000)[:-1]
    twin = Twin(e, 1.0, 1e4)
    assert max(abs(twin.force(s)) for s in times[-20_000:]) < 0.06
    assert abs(twin.force(slip)) == pytest.approx(0.06, abs=1e-12)
