"""Motions by pieces on a ramp against an ordinary integrator, quadratures and the motion at a steady frequency."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from helpers.ramp_twin import Twin

import vibropipe as vp

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


def drawn(seed: int) -> tuple[vp.Exciter, float, float, tuple[float, float]]:
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
    e, nu_end, span, start = drawn(seed)
    assert compare(e, nu_end, span, start) < 1e-10


def test_a_housing_is_refused() -> None:
    with pytest.raises(vp.ParameterError, match="mass_ratio: must be 0 with nu_end"):
        vp.simulate(vp.Exciter(l=1.0, nu=1.0, f=1.0, mass_ratio=0.2), nu_end=2.0)


@pytest.mark.parametrize(
    "further", [{}, {"friction": 0.05, "friction_ratio": 1.3}, {"shaker": 0.4}]
)
def test_equal_frequencies_give_the_ordinary_motion(further: dict[str, Any]) -> None:
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
