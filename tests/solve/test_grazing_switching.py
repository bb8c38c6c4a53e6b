"""Branches that meet at a grazing are all found, from whichever of them the search begins."""

from __future__ import annotations

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.words.bifurcations import Bifurcation

UNEQUAL = vp.Exciter(l=0.5, nu=1.44, f=0.25, h=0.1, R1=0.6, R2=0.75)
SYMMETRIC = vp.Exciter(l=0.5, nu=1.05, f=0.25, h=0.2, R1=0.7, R2=0.7)
OFFSET = vp.Exciter(l=0.5, nu=1.344, f=0.4426, h=0.2471, delta=-0.1464, R1=0.6691, R2=0.5649)
ALL = ("flip", "pitchfork", "grazing")

Law = tuple[int, int, int]


def laws_of(dataset) -> list[Law]:
    """Return (m; p1, p2) of each point."""
    impacts = dataset["impacts_per_orbit"].fillna(0).values.astype(int)
    multiples = dataset["period_multiple"].values
    return [(int(m), int(a), int(b)) for m, (a, b) in zip(multiples, impacts, strict=True)]


def stretches_of(dataset) -> dict[Law, tuple[float, float]]:
    """Return for each law the range of the frequencies at which it is stable on some branch."""
    laws, stable = np.array(laws_of(dataset)), dataset["stable"].values == 1
    found = {tuple(law) for law in laws[stable].tolist()}
    return {
        law: tuple(dataset["nu"].values[stable & (laws == law).all(axis=1)][[0, -1]].tolist())
        for law in sorted(found)
    }


def stable_laws_at(dataset, nu: float) -> set[Law]:
    """Return the laws that are stable at a frequency which is a point of every branch across it."""
    here = (dataset["nu"].values == nu) & (dataset["stable"].values == 1)
    return {law for law, is_here in zip(laws_of(dataset), here, strict=True) if is_here}


def attractor_laws(exciter: vp.Exciter) -> set[Law]:
    """Return the laws of the attractors that 128 starts settle on."""
    found = vp.attractors(exciter, starts=128)
    impacts = found["impacts_per_orbit"].fillna(0).values.astype(int)
    multiples = found["period_multiple"].values
    return {(int(m), int(a), int(b)) for m, (a, b) in zip(multiples, impacts, strict=True)}


def bifurcations_of(dataset) -> set[tuple[str, float]]:
    """Return the kind and the place of each bifurcation, to 1e-8."""
    codes, at = dataset["bifurcation_kind"].values, dataset["bifurcation_nu"].values
    names = [Bifurcation(code).name for code in codes]
    return {(name, round(float(value), 8)) for name, value in zip(names, at, strict=True)}


@pytest.mark.parametrize("R2", [0.6, 0.75])
def test_both_motions_that_coexist_lead_to_the_other(R2: float) -> None:
    """From rest the motion without impacts settles, from v0 = 1 the one on both supports: one begins at the other."""
    exciter = vp.Exciter(l=0.5, nu=1.44, f=0.25, h=0.1, R1=0.6, R2=R2)
    slow, fast = (
        vp.branch(exciter, "nu", (0.8, 3), v0=v0, switch=["grazing"]) for v0 in (0.0, 1.0)
    )
    assert laws_of(slow)[slow["branch_id"].values.tolist().index(0)] == (1, 0, 0)
    assert laws_of(fast)[fast["branch_id"].values.tolist().index(0)] == (1, 1, 1)
    assert set(laws_of(slow)) == set(laws_of(fast))
    assert bifurcations_of(slow) == bifurcations_of(fast)


def test_impacts_on_both_supports_that_lose_their_speed_together_leave_none() -> None:
    """With delta = 0 the motion without impacts touches both supports at once, whatever their restitution."""
    fast = vp.branch(UNEQUAL, "nu", (0.8, 3), v0=1.0, at=[1.6], switch=["grazing"])
    assert stable_laws_at(fast, 1.6) == {(1, 0, 0), (1, 1, 1)}
    grazing = float(fast["bifurcation_nu"][fast["bifurcation_kind"] == Bifurcation.GRAZING].max())
    amplitude = UNEQUAL.f / np.hypot(1 - grazing**2, UNEQUAL.h * grazing)
    assert amplitude == pytest.approx(UNEQUAL.l, rel=1e-12)


@pytest.mark.parametrize(
    ("f", "nu", "rarely"),
    [
        (0.25, 0.72, (3, 1, 1)),  # once in three periods of the motion without impacts
        (0.25, 0.9, (1, 1, 0)),
        (0.5, 0.358, (3, 4, 4)),  # an impact more in three half-periods of (1; 1, 1)
        (0.5, 0.4, (1, 1, 2)),
    ],
)
def test_what_starts_settle_on_is_on_the_branches(f: float, nu: float, rarely: Law) -> None:
    exciter = vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7, nu=1.05, f=f)
    followed = vp.branch(exciter, "nu", (0.3, 1.2), at=[nu], switch=ALL)
    settled = attractor_laws(vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7, nu=nu, f=f))
    assert rarely in settled
    assert settled <= stable_laws_at(followed, nu)


@pytest.mark.parametrize(
    "exciter",
    [OFFSET, vp.Exciter(l=0.5, nu=1.1383, f=0.8685, h=0.23, R1=0.4035, R2=0.7229)],
    ids=["(2; 2, 1)", "(3; 4, 3)"],
)
def test_what_is_left_without_an_impact_has_its_least_period(exciter: vp.Exciter) -> None:
    """The orbit that settles is one of the grazing of (1; 1, 0), or (1; 1, 1), once in two or three of its periods."""
    followed = vp.branch(exciter, "nu", (0.7, 2.2), switch=["grazing"])
    assert int(followed["period_multiple"][0]) > 1
    sizes = followed["row_size"].values
    ends = np.cumsum(sizes)
    for point in np.flatnonzero(followed["period_multiple"].values > 1):
        n, m = int(sizes[point]), int(followed["period_multiple"][point])
        own = np.abs(followed["impact_velocity"].values[ends[point] - n : ends[point]])
        for parts in (q for q in range(2, m + 1) if m % q == 0 and n % q == 0):
            turned = np.roll(own, n // parts)
            # two orbits meet at a grazing and at a flip, and nowhere else
            at_end = point in followed["bifurcation_point"].values
            assert at_end or np.abs(own - turned).max() > 1e-9, (point, m, n)


def test_the_search_finds_the_same_from_each_stable_motion() -> None:
    """Each stable motion of a symmetric exciter leads to all others."""
    first = vp.branch(SYMMETRIC, "nu", (0.6, 2), switch=ALL)
    expected = bifurcations_of(first), set(laws_of(first))
    for nu, start in ((0.65, {}), (0.75, {}), (0.9, {"v0": 0.3}), (1.5, {"v0": 1.5})):
        exciter = vp.Exciter(l=0.5, nu=nu, f=0.25, h=0.2, R1=0.7, R2=0.7)
        again = vp.branch(exciter, "nu", (0.6, 2), switch=ALL, **start)
        assert (bifurcations_of(again), set(laws_of(again))) == expected
