"""Motions on a ramp against quadratures, an ordinary integrator and the motion at a steady frequency."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

import vibropipe as vp

TIMES = ("impact_tau", "rest_start", "rest_end", "grazing_tau")


def force(e: vp.Exciter, nu_end: float, span: float, s: Any, start: float = 0.0) -> Any:
    phase = e.nu * start + e.nu * s + (nu_end - e.nu) / span * s * s / 2
    return e.f * np.sin(phase) + e.f2 * np.sin(2 * phase + e.phi2)


def integrated(
    e: vp.Exciter, nu_end: float, span: float, x: float, v: float, n_impacts: int
) -> list[tuple[float, float]]:
    """Return times and velocities of the first impacts by DOP853 with steps in which its dense output is exact."""

    def rates(s: float, z: Any) -> list[float]:
        return [z[1], force(e, nu_end, span, s) + e.load - e.h * z[1] - z[0]]

    def upper(s: float, z: Any) -> float:
        return float(e.upper - z[0])

    def lower(s: float, z: Any) -> float:
        return float(z[0] - e.lower)

    for event in (upper, lower):
        event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
    found: list[tuple[float, float]] = []
    s, z = 0.0, [x, v]
    while len(found) < n_impacts and s < span:
        step = 0.12 / max(e.nu, nu_end, 1.0)
        run = solve_ivp(
            rates, (s, span), z, "DOP853", events=(upper, lower), rtol=2.3e-14, atol=1e-16,
            max_step=step,
        )  # fmt: skip
        if run.status != 1:
            break
        s, (x, v) = float(run.t[-1]), run.y[:, -1]
        found.append((s, float(v)))
        wall, R = (e.upper, e.R1) if v > 0 else (e.lower, e.R2)
        z = [wall, -R * v]
    return found


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
    expected = np.array(integrated(e, nu_end, span, *e.check_start(None, 0.0), 6)).reshape(-1, 2)
    if len(expected) < 6:
        assert ds.sizes["impact"] == len(expected)
    assert ds.impact_tau.values[:6] == pytest.approx(expected[:, 0], abs=1e-11)
    assert ds.impact_velocity.values[:6] == pytest.approx(expected[:, 1], abs=1e-11)


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
    free = np.emath.sqrt(1 - h * h / 4)

    def kernel(t: float) -> float:
        return float(np.real(np.exp(-h / 2 * t) * np.sin(free * t) / free))

    def slope(t: float) -> float:
        return float(np.real(np.exp(-h / 2 * t) * np.cos(free * t))) - h / 2 * kernel(t)

    def response(s: float) -> float:
        return quad(
            lambda t: kernel(s - t) * float(force(e, nu_end, span, t)), 0, s, epsabs=1e-13,
            epsrel=1e-13, limit=2000,
        )[0]  # fmt: skip

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
    for start, end, support in zip(
        ds.rest_start.values, ends, ds.rest_support.values, strict=False
    ):
        wall, sign = (e.upper, -1.0) if support == 1 else (e.lower, 1.0)

        def push(s: float, wall: float = wall, sign: float = sign) -> float:
            return sign * (float(force(e, 1.2, 60.0, s)) - wall)

        held = np.linspace(start, end, 200)[1:-1]
        assert max(map(push, held)) < 0
        assert brentq(push, end - 1e-3, end + 1e-3, xtol=1e-15) == pytest.approx(end, abs=1e-12)


@pytest.mark.parametrize("depth", [1e-9, 1e-11, -1e-11, -1e-9])
def test_a_first_impact_that_nearly_grazes_is_not_missed(depth: float) -> None:
    free = vp.Exciter(l=50.0, nu=0.6, f=1.0, h=0.1)

    def rates(s: float, z: Any) -> list[float]:
        return [z[1], float(force(free, 1.6, 30.0, s)) - free.h * z[1] - z[0]]

    def at_rest(_s: float, z: Any) -> float:
        return float(z[1])

    run = solve_ivp(
        rates,
        (0.0, 30.0),
        [0.0, 0.0],
        "DOP853",
        events=at_rest,
        rtol=2.3e-14,
        atol=1e-16,
        max_step=0.1,
    )
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
    pull = upper - float(force(free, 1.6, 30.0, at))
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
