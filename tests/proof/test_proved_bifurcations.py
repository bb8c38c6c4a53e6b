"""Bifurcations that are enclosed: against published ones, closed forms and followed branches."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.proofs import Proved

PUBLISHED = json.loads(
    (Path(__file__).parents[1] / "reference" / "one_sided.json").read_text(encoding="utf-8")
)
EXCITER = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.1, R1=0.8, R2=0.7)


def rows_of(kind: str) -> list[tuple[float, float]]:
    return [(row[0], row[1]) for row in PUBLISHED[kind]]


@pytest.mark.parametrize("kind", ["fold", "flip"])
def test_published_bifurcations_are_enclosed(kind: str) -> None:
    proved = 0
    for nu, f in rows_of(kind)[::4]:
        # folds are sought from the side where there are orbits
        near = f * (1 + 1e-6) if kind == "fold" else f
        exciter = vp.Exciter(l=25.5, delta=-24.5, nu=nu, f=near, h=0.04, R1=0.9)
        orbits = vp.one_sided_orbit(exciter, 1, 2)
        orbit = orbits.isel(solution=int(np.flatnonzero(np.isfinite(orbits.clearance))[0]))
        found = vp.prove_bifurcation(orbit, kind, "f")
        # their Newton ends at 1e-5 in the eigenvalue: flips far from nu = 0.8 are off by up to 1e-5
        assert float(found.f_low) == pytest.approx(f, abs=2e-5 if kind == "flip" else 1e-9)
        closed = vp.one_sided_orbit_boundaries(exciter, [nu], 1, 2)[f"{kind}_f"].item()
        assert float(found.f_low) == pytest.approx(closed, rel=1e-12)
        assert found.f_high - found.f_low <= 2 * np.spacing(f)
        assert Bifurcation(int(found.bifurcation_kind)) == Bifurcation[kind.upper()]
        assert found.proved == Proved.PROVED
        proved += 1
    assert proved >= 8


def test_branches_find_what_is_enclosed() -> None:
    branch = vp.branch(EXCITER, "nu", (0.6, 1.6), switch=("pitchfork",))
    kinds = {"fold": 0, "flip": 0, "grazing": 0}
    for n in range(branch.sizes["bifurcation"]):
        kind = Bifurcation(int(branch.bifurcation_kind[n])).name.lower()
        if kind not in kinds:
            continue
        point = branch.isel(point=int(branch.bifurcation_point[n]))
        if point.rests_per_orbit.any() or not point.impacts_per_orbit.any():
            continue
        found = vp.prove_bifurcation(point, kind, "nu")
        if found.proved == Proved.PROVED:
            kinds[kind] += 1
            middle = float(found.nu_low + found.nu_high) / 2
            assert branch.bifurcation_nu[n].item() == pytest.approx(middle, rel=1e-12)
    assert kinds["grazing"] >= 2


def test_a_grazing_orbit_touches_when_it_is_marched() -> None:
    branch = vp.branch(EXCITER, "nu", (0.6, 1.6))
    is_grazing = branch.bifurcation_kind.values == Bifurcation.GRAZING
    found = None
    for n in np.flatnonzero(is_grazing):
        point = branch.isel(point=int(branch.bifurcation_point[n]))
        if point.impacts_per_orbit.any():
            found = vp.prove_bifurcation(point, "grazing", "nu")
            break
    assert found is not None
    assert found.proved == Proved.PROVED
    support = int(found.grazing_support)
    exciter = replace(EXCITER, nu=float(found.nu_low))
    start = float(found.impact_phase_low[0]) * exciter.period
    wall = exciter.upper if int(found.impact_support[0]) == 1 else exciter.lower
    R = exciter.R1 if int(found.impact_support[0]) == 1 else exciter.R2
    m = int(found.period_multiple)
    motion = vp.simulate(
        exciter, start + m * exciter.period, wall, -R * float(found.impact_velocity_low[0]),
        tau_start=start, samples_per_period=4000,
    )  # fmt: skip
    x = motion.displacement.values[50:-50]
    gaps = exciter.upper - x if support == 1 else x - exciter.lower
    inner = gaps[(gaps < np.roll(gaps, 1)) & (gaps < np.roll(gaps, -1))]
    assert abs(inner).min() < 1e-5  # of the parabola between samples


def test_what_is_none_is_undecided() -> None:
    found = vp.prove_bifurcation(EXCITER, "fold", "R2")
    assert found.proved == Proved.UNDECIDED
    assert np.isnan(found.R2_low)
    assert "Undecided" in found.attrs["statement"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("cusp", "nu"), "kind: must be one of fold, flip, grazing, got 'cusp'"),
        (("fold", "k1"), "along: must be one of nu, f, h, .*, got 'k1'"),
    ],
)
def test_wrong_arguments(arguments: tuple[str, str], message: str) -> None:
    with pytest.raises(vp.ParameterError, match=message):
        vp.prove_bifurcation(EXCITER, *arguments)
