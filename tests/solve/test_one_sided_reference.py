"""Folds and flips of one-sided orbits that others published, and the limit of an impact pair."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.words.bifurcations import Bifurcation

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
