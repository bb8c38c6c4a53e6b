"""Restitution of a soft support: its damping, what is refused, and what sweeps and derivatives make of it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vibropipe as vp
from vibropipe.physics.restitution import contact_damping, damping_derivatives

PAPER = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, R1=0.7, R2=0.7)


@pytest.mark.parametrize("support", [1, 2])
@pytest.mark.parametrize("R", [1.0, 0.9, 0.7, 0.3, 1e-6])
def test_a_damped_contact_returns_the_share_of_a_restitution(support: int, R: float) -> None:
    exciter = vp.Exciter(l=0.5, nu=1.0, **{f"R{support}": R, f"k{support}": 1e4})
    h = getattr(exciter, f"h{support}")
    assert getattr(exciter, f"R{support}") == R
    assert h == contact_damping(R, 1e4)
    returned = solve_ivp(
        lambda _t, y: [y[1], -1e4 * y[0] - h * y[1]], (0, 1), [0.0, 1.0], rtol=1e-12, atol=1e-15,
        events=lambda t, y: y[0] if t > 1e-6 else 1.0,
    ).y_events[0]  # fmt: skip
    assert -returned[0][1] == pytest.approx(R, rel=1e-6, abs=1e-9)


def test_a_restitution_of_zero_is_the_critical_damping() -> None:
    assert vp.Exciter(l=0.5, nu=1.0, k1=16.0, R1=0.0).h1 == 8.0
    assert vp.Exciter(l=0.5, nu=1.0, k1=16.0).h1 == 0.0


def test_the_end_of_a_contact_pulls_by_18_percent_of_its_largest_force() -> None:
    z = contact_damping(0.7, 1.0) / 2.0
    w = math.sqrt(1.0 - z * z)
    t = np.linspace(0.0, math.pi / w, 100_001)
    y = np.exp(-z * t) * np.sin(w * t) / w
    rate = np.exp(-z * t) * (np.cos(w * t) - z / w * np.sin(w * t))
    force = y + 2.0 * z * rate
    assert -force[-1] / force.max() == pytest.approx(0.1816, abs=1e-4)
    assert -rate[np.argmax(force < 0.0)] == pytest.approx(0.718, abs=5e-4)


def test_what_the_contact_returns_tends_to_the_restitution() -> None:
    reached = []
    for k in (1e2, 1e4, 1e6):
        row = vp.steady_state(replace(PAPER, k1=k, k2=k))
        reached.append(float(-row.impact_velocity_after[0] / row.impact_velocity[0]))
    assert reached == pytest.approx([0.6560, 0.6956, 0.69956], abs=1e-4)


@pytest.mark.parametrize("h1", [0.0, 5.0])
def test_a_second_damping_is_refused(h1: float) -> None:
    with pytest.raises(
        vp.ParameterError, match=r"^h1: must be left out beside R1 below 1, .*R1 = 1 for"
    ):
        vp.Exciter(l=0.5, nu=1.0, k1=1e4, R1=0.7, h1=h1)
    assert vp.Exciter(l=0.5, nu=1.0, k1=1e4, R1=1.0, h1=h1).h1 == h1
    with pytest.raises(
        vp.ParameterError, match=r"^H2: must be left out beside R2 below 1, since R2 and C2"
    ):
        vp.Exciter.from_physical(m=2, C=8000, l=0.01, C2="800 N/mm", R2=0.7, H2="5 N s/m")


def test_a_copy_follows_and_one_of_its_own_numbers_is_the_same() -> None:
    soft = replace(PAPER, k1=100.0)
    assert replace(soft, k1=400.0).h1 == 2.0 * soft.h1
    assert replace(soft, R1=1.0).h1 == 0.0
    assert vp.Exciter(**soft.parameters()._asdict()) == soft
    si = vp.Exciter.from_physical(m=0.35, C=6000, l=0.004, C1=6e5, R1=0.6)
    H1 = si.h1 * math.sqrt(0.35 * 6000)
    assert vp.Exciter.from_physical(
        m=0.35, C=6000, l=0.004, C1=6e5, R1=0.6, H1=H1
    ).h1 == pytest.approx(si.h1, rel=1e-15)


def test_rows_of_a_sweep_have_the_damping_of_their_restitution_and_stiffness() -> None:
    over = {"R1": [0.5, 0.7, 1.0], "k1": [0.0, 200.0]}
    rows = vp.sweep(PAPER, over)
    for i, R in enumerate(over["R1"]):
        for j, k in enumerate(over["k1"]):
            exciter = replace(PAPER, R1=R, k1=k)
            alone = vp.steady_state(exciter, patience=200)
            row = rows.isel(R1=i, k1=j)
            assert float(row.h1) == exciter.h1
            for name in ("impact_velocity_max", "displacement_mean"):
                # a rigid row alone is solved by another kernel
                np.testing.assert_allclose(row[name], alone[name], rtol=1e-12, atol=1e-15)
    assert vp.to_physical(rows, 2, 8000).H1.attrs["units"] == "N s m-1"
    assert "h1" not in vp.sweep(PAPER, {"R1": [0.5, 0.7]})


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda e: vp.sweep(replace(e, R1=1.0, h1=5.0), {"R1": [0.5, 0.7]}), "h1: must be left out beside R1"),
        (lambda e: vp.sweep(e, {"h1": [5.0, 7.0]}), "over.h1: must be left out beside R1"),
        (lambda e: vp.branch(e, "k1", 300.0), "R1: must be left out where k1 or h1 vary: state the damping h1"),
        (lambda e: vp.branch(e, "R1", 0.8), "along.R1: must be left out where k1 is above 0: vary the damping h1"),
        (lambda e: vp.boundary(e, "fold", ("nu", "R1"), ((1, 2), (0.5, 0.8))), "along.R1: must be left out"),
        (lambda e: vp.basins(e, [0.0], [0.0], over={"k1": [100.0, 200.0]}), "R1: must be left out where k1"),
        (lambda e: vp.design(e, {"R1": (0.5, 0.8)}, {"displacement_mean": 0.0}), "vary.R1: must be left out"),
        (lambda e: vp.design(replace(e, k1=0.0), {"k1": (9, 99)}, {"displacement_mean": 0.0}), "R1: must be left"),
        (lambda e: vp.tolerance(e, {"h1": 0.1}), "R1: must be left out where k1 or h1 vary"),
    ],
)  # fmt: skip
def test_calls_without_a_damping_that_follows_refuse_it(call, said) -> None:
    with pytest.raises(vp.ParameterError) as error:
        call(replace(PAPER, k1=200.0))
    assert str(error.value).startswith(said)


def test_sensitivities_include_the_damping() -> None:
    exciter = replace(PAPER, delta=0.02, k1=200.0, k2=500.0, R2=0.6)
    outputs = ["harmonics", "impacts", "energy", "stability", "sensitivity"]
    orbit = vp.steady_state(exciter, outputs=outputs)
    names = ("impact_velocity_max", "impact_velocity", "velocity_phase", "energy_impact")
    for name in ("R1", "k1", "R2"):
        own = getattr(exciter, name)
        step = 1e-5 * own
        one, other = (
            vp.steady_state(replace(exciter, **{name: own + way * step}), outputs=outputs)
            for way in (1, -1)
        )
        for of in names:
            by = ((one[of] - other[of]) / (2.0 * step)).values
            found = orbit[f"{of}_sensitivity"].sel(parameter=name).values
            np.testing.assert_allclose(found, by, rtol=0, atol=1e-6 * np.abs(by).max())


def test_derivatives_of_the_damping() -> None:
    R, k, step = np.array([0.2, 0.7, 1.0 - 1e-3]), np.array([3.0, 1e4, 10.0]), 1e-6
    by_R = (contact_damping(R + step, k) - contact_damping(R - step, k)) / (2 * step)
    by_k = (contact_damping(R, k * (1 + step)) - contact_damping(R, k * (1 - step))) / (
        2 * k * step
    )
    found = damping_derivatives(R, k)
    assert found[0] == pytest.approx(by_R, rel=1e-6)
    assert found[1] == pytest.approx(by_k, rel=1e-6)
