"""Folds, flips and branches that others published."""

from __future__ import annotations

import json
from pathlib import Path

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


# A. Ghosh, D. J. W. Simpson, arXiv 2510.16218 (2025): orbits (2; 1, 0), support 1 at 1 and support 2 out of reach.
REFERENCE = json.loads(
    (Path(__file__).parents[1] / "reference" / "one_sided.json").read_text(encoding="utf-8")
)
M = 2


def exciter_at(nu: float, f: float) -> vp.Exciter:
    return vp.Exciter(l=25.5, delta=-24.5, h=0.04, R1=0.9, nu=nu, f=f)


def rows_of(kind: str) -> dict[str, np.ndarray]:
    return dict(zip(REFERENCE["columns"], np.array(REFERENCE[kind]).T, strict=True))


def boundaries_at(nu: np.ndarray):
    each = np.unique(nu)
    return vp.one_sided_orbit_boundaries(exciter_at(1.0, 1.0), each, 1, M).sel(nu=nu)


def test_folds_are_those_of_others() -> None:
    rows = rows_of("fold")
    assert rows["nu"].size == 37
    ours = boundaries_at(rows["nu"])
    # Their Newton ends at 1e-5 in the multiplier, whose square is what f is off by; velocities go with its first power.
    assert abs(rows["multiplier_2"] - 1.0).max() < 1e-5
    assert abs(ours.fold_f.values - rows["f"]).max() < 5e-11
    assert abs(ours.fold_velocity.values - rows["impact_velocity"]).max() < 5e-5
    assert (ours.fold_admissible.values == 1).all()


def test_flips_are_those_of_others() -> None:
    # The source says that they are off by up to 1e-5; the next test compares the orbits themselves.
    rows = rows_of("flip")
    assert rows["nu"].size == 40
    # Their curve goes on to one orbit whose velocity points away from the support: it is no motion, and we have none.
    is_motion = rows["impact_velocity"] > 0.0
    assert np.count_nonzero(~is_motion) == 1
    ours = boundaries_at(rows["nu"])
    assert np.isnan(ours.flip_f.values[~is_motion]).all()
    assert abs(ours.flip_f.values - rows["f"])[is_motion].max() < 1e-5
    assert (ours.flip_admissible.values[is_motion] == 1).all()


def test_orbits_at_the_flips_of_others_have_their_velocities_and_multipliers() -> None:
    rows = rows_of("flip")
    for nu, f, velocity, *multipliers in zip(*rows.values(), strict=True):
        if velocity <= 0.0:
            continue
        orbit = vp.one_sided_orbit(exciter_at(nu, f), 1, M).isel(solution=0)
        assert orbit.impact_velocity.item() == pytest.approx(velocity, abs=5e-11)
        # Theirs are differences of the return map.
        assert orbit.floquet_multiplier.values == pytest.approx(np.array(multipliers), abs=2e-8)


@pytest.mark.parametrize(
    ("kind", "index", "within"),
    [("fold", 1, 5e-11), ("fold", 30, 5e-11), ("flip", 5, 1e-5), ("flip", 25, 1e-5)],
)
def test_a_branch_meets_them(kind: str, index: int, within: float) -> None:
    """Along f, from a stable orbit beside."""
    nu, f = (float(rows_of(kind)[name][index]) for name in ("nu", "f"))
    for other in (1.001 * f, 0.999 * f):
        exciter = exciter_at(nu, other)
        start = vp.one_sided_orbit(exciter, 1, M).isel(solution=0)
        if bool(start.stable) and bool(start.admissible):
            break
    to = 2.0 * f - other
    section = float(start.displacement_strobe), float(start.velocity_strobe)
    branch = vp.branch(exciter, "f", to, *section)
    assert int(branch.period_multiple[0]) == M
    code = Bifurcation[kind.upper()]
    met = branch.bifurcation_f.values[branch.bifurcation_kind.values == code]
    assert abs(met - f).min() < within
    assert abs(met - boundaries_at(np.array([nu]))[f"{kind}_f"].item()).min() < 1e-13


@pytest.mark.parametrize("R", [0.3, 0.6, 0.9])
def test_the_fold_of_fast_excitation_is_that_of_an_impact_pair(R: float) -> None:
    """A mass without a spring strikes both walls in each period from f = nu^2 l rho / sqrt(1 + rho^2) on.

    With x'' = f sin(nu tau + phase) between walls that are struck half a period apart with v, and left with R v,
    v (1 - R) = -2 f cos(phase) / nu and 2 l = pi (1 + R) v / (2 nu) - 2 f sin(phase) / nu^2; so l nu^2 / f =
    -cos(phase) / rho - sin(phase), which is sqrt(1 + 1 / rho^2) at most. The spring adds a share of 1 / nu^2.
    """
    rho = 2.0 / np.pi * (1.0 - R) / (1.0 + R)
    limit = rho / np.hypot(1.0, rho)
    exciter = vp.Exciter(l=0.5, h=0.0, R1=R, R2=R)
    fast, faster = vp.symmetric_orbit_boundaries(exciter, [100.0, 1000.0]).fold_f.values
    off = [fast / (100.0**2 * exciter.l) - limit, faster / (1000.0**2 * exciter.l) - limit]
    assert abs(off[1]) < 1e-6
    assert off[0] / off[1] == pytest.approx(100.0, rel=1e-3)


@pytest.mark.parametrize(
    ("kind", "box"),
    [("fold", ((0.789, 0.7995), (0.36, 0.39))), ("flip", ((0.801, 0.82), (0.33, 0.36)))],
)
def test_boundaries_are_their_curves(kind: str, box: tuple[tuple[float, float], ...]) -> None:
    found = vp.boundary(exciter_at(0.8, 0.35), kind, within=box, lines=3)
    own = (found.period_multiple.values == M) & (found.impacts_per_orbit.values == [1, 0]).all(1)
    nu, f = found.nu.values[own], found.f.values[own]
    assert nu.size > 20
    assert abs(f - boundaries_at(nu)[f"{kind}_f"].values).max() < 1e-11
    rows = rows_of(kind)
    inside = (rows["nu"] > nu.min()) & (rows["nu"] < nu.max())
    assert np.count_nonzero(inside) > 10
    # Their points lie on the polygon through ours but for its distance from the curve, the square of a step.
    order = np.argsort(nu)
    polygon = np.interp(rows["nu"][inside], nu[order], f[order])
    assert abs(polygon - rows["f"][inside]).max() < 1e-5
