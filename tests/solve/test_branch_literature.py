"""Branches against known exciters: the paper's, those of Budd and Dux, and that of Dankowicz and Schilder."""

from __future__ import annotations

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.regimes import Regime


def bifurcations(branch, kind, along):
    return branch[f"bifurcation_{along}"].values[branch.bifurcation_kind.values == kind]


def budd_dux_quadratic(sigma, nu, r, n):
    """(a, b, c) of a v^2 + 2 b v + c = 0 for the impact velocity v of the (1, n) orbits of x'' + x = cos(nu t), x <
    sigma: one impact in n periods of the force [1].

    Between impacts x = C cos(t - nT/2) + g cos(nu (t + t0)), g = 1 / (1 - nu^2), since x and the force are the same at
    both ends. The velocities there give C and sin(nu t0), the position cos(nu t0); their squares add up to 1.

    [1] C. Budd, F. Dux, "Chattering and related behaviour in impact oscillators", Philosophical Transactions of the
    Royal Society of London A 347 (1994) 365-389.
    """
    half = (1 + r) / np.tan(n * np.pi / nu) / 2
    return half**2 + ((1 - r) / (2 * nu)) ** 2, sigma * half, sigma**2 - 1 / (1 - nu**2) ** 2


@pytest.mark.parametrize(("nu", "n"), [(2.6, 1), (4.5, 2), (6.5, 3)])
def test_budd_and_dux_1_n_orbits(nu: float, n: int) -> None:
    r, far = 0.8, 20.0
    exciter = vp.Exciter(l=far, nu=nu, f=1.0, h=0.0, delta=-0.02 - far, R1=r)
    start = vp.one_sided_orbit(exciter, 1, n).isel(solution=0)
    branch = vp.branch(
        exciter, "delta", (-0.5 - far, 0.5 - far),
        float(start.displacement_strobe), float(start.velocity_strobe),
    )  # fmt: skip
    first = branch.isel(point=branch.period_multiple.values == n)
    assert first.sizes["point"] == branch.sizes["point"] > 20
    for sigma, v in zip(branch.delta.values + far, branch.impact_velocity.values, strict=True):
        a, b, c = budd_dux_quadratic(sigma, nu, r, n)
        assert a * v * v + 2 * b * v + c == pytest.approx(0.0, abs=1e-14)
    # Both roots meet, b^2 = a c, at a fold; the branch turns there from one to the other.
    folds = bifurcations(branch, Bifurcation.FOLD, "delta") + far
    assert folds.size == (n > 1)
    for sigma in folds:
        a, b, c = budd_dux_quadratic(sigma, nu, r, n)
        assert b * b == pytest.approx(a * c, rel=1e-10)
    # Where the impact itself grazes, v = 0, sigma is the amplitude of the response to the force.
    grazings = bifurcations(branch, Bifurcation.GRAZING, "delta") + far
    assert min(abs(grazings - 1 / (nu**2 - 1))) < 1e-12


def test_dankowicz_and_schilder_impact_oscillator() -> None:
    # H. Dankowicz, F. Schilder, "Recipes for Continuation", SIAM (2013), example 15.2: x'' + 0.1 x' + x = A cos t, a
    # stop at x = 1 with the restitution 0.8; from the impacting orbit at A = 1 down to the one that grazes.
    far = 4.0
    exciter = vp.Exciter(l=1 + far, nu=1.0, f=1.0, h=0.1, delta=-far, R1=0.8)
    branch = vp.branch(exciter, "f", 0.01, at=np.linspace(0.1, 0.9, 9), switch=["grazing"])
    struck = branch.isel(point=branch.branch_id.values == 0)
    for f, v in zip(struck.f.values, struck.impact_velocity.values, strict=True):
        cosine, sine = phase_of_impact(f, v)
        assert cosine**2 + sine**2 == pytest.approx(1.0, abs=1e-10)
    grazing = bifurcations(branch, Bifurcation.GRAZING, "f")
    assert grazing == pytest.approx(0.1, abs=1e-12)  # A^2 = (1 - w^2)^2 + (c w)^2
    # The orbit with impacts turns at a fold before, where it loses its stability.
    (fold,) = bifurcations(branch, Bifurcation.FOLD, "f")
    assert fold < 0.1
    assert set(struck.stable.values[struck.f.values > 0.11]) == {1}


def phase_of_impact(f, v):
    """Cosine and sine of the phase of the force at an impact with velocity v, by superposition.

    The response to an impulse of -1.8 v in each period, just before the next one, is the sum of the free vibrations
    after all earlier ones; what lacks to x = 1, x' = v is the response to the force, of amplitude f / h at resonance.
    """
    h, rate = 0.1, complex(-0.05, np.sqrt(1 - 0.05**2))
    decay = np.exp(2 * np.pi * rate)
    ring = -1.8 * v / rate.imag * decay / (1 - decay)
    return (1.0 - ring.imag) * h / f, (v - (rate * ring).imag) * h / f


@pytest.mark.parametrize("f", [0.25, 0.5])
def test_the_papers_exciter_jumps_at_the_fold_and_the_grazing(f: float) -> None:
    exciter = vp.Exciter(l=0.5, nu=1.05, f=f, h=0.2, R1=0.7, R2=0.7)
    nu = np.linspace(1.0, 2.7, 171)
    branch = vp.branch(exciter, "nu", (0.9, 3.0), at=nu, switch=["grazing"])
    (fold,) = bifurcations(branch, Bifurcation.FOLD, "nu")
    # Above resonance the motion without impacts grazes where (1 - nu^2)^2 + (h nu)^2 = (f / l)^2.
    b = 1 - exciter.h**2 / 2
    grazing = np.sqrt(b + np.sqrt(b * b - 1 + (f / exciter.l) ** 2))
    assert min(abs(bifurcations(branch, Bifurcation.GRAZING, "nu") - grazing)) < 1e-12
    up, down = (vp.sweep(exciter, {"nu": nu}, follow=("nu", way)) for way in ("up", "down"))
    stable = branch.stable.values == 1
    for sweep in (up, down):
        for k in range(nu.size):
            distance = abs(branch.displacement_strobe - sweep.displacement_strobe[k])
            distance += abs(branch.velocity_strobe - sweep.velocity_strobe[k])
            assert distance.values[(branch.nu.values == nu[k]) & stable].min() < 1e-9
    last_up, last_down = (nu[s.regime.values == Regime.TWO_SIDED].max() for s in (up, down))
    step = nu[1] - nu[0]
    assert last_up < fold < last_up + step
    # Followed down, the motion after a step of nu overshoots a little and may strike one value before the grazing.
    assert abs(last_down - grazing) < step
