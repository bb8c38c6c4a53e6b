"""Bifurcations that are enclosed: against published ones, closed forms and followed branches."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest

import vibropipe as vp
from vibropipe.proof import bifurcation, equations
from vibropipe.proof.balls import arb
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.proofs import Proved, Why

PUBLISHED = json.loads(
    (Path(__file__).parents[1] / "reference" / "one_sided.json").read_text(encoding="utf-8")
)
EXCITER = vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.1, R1=0.8, R2=0.7)
SYMMETRIC = replace(EXCITER, R2=0.8)


@pytest.mark.parametrize("kind", ["fold", "flip"])
def test_published_bifurcations_are_enclosed(kind: str) -> None:
    proved = 0
    for nu, f, *_ in PUBLISHED[kind][::4]:
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


def pitchfork_force(e: vp.Exciter) -> mp.mpf:
    """Return the force of (C19) of docs/closed-forms.md in long arithmetic."""
    nu, h, b, R = (mp.mpf(value) for value in (e.nu, e.h, e.l, e.R1))
    t, omega = mp.pi / nu, mp.sqrt(1 - h**2 / 4)
    half, eps = mp.exp(-h * t / 2), mp.exp(-h * t)
    shear = -half * mp.sin(omega * t) / omega
    D = (1 - half) ** 2 + 2 * half * (1 + mp.cos(omega * t))
    V = (1 - eps - h * shear) / (2 * D)
    P = mp.mpc(1 - nu**2, h * nu)
    W = P * mp.mpc(((1 - R) / 2 + (1 + R) * V) / nu, (1 + R) * shear / D)
    regular = (1 - R) * (1 - R * eps) + R * D + (1 + R) * shear * W.imag
    v = (1 + R) * shear * nu**2 * b / regular
    return abs(1j * b * P + v * W)


def is_enclosed(exciter: vp.Exciter, along: str) -> bool:
    """Return whether the closed form of the pitchfork lies between bounds that are at most two doubles apart."""
    with mp.workdps(40):
        near = replace(exciter, f=float(pitchfork_force(exciter)) * 1.001)
        orbit_nearby = vp.symmetric_orbit(near).isel(solution=0)
        found = vp.prove_bifurcation(orbit_nearby, "pitchfork", along)
        assert found.proved == Proved.PROVED
        ends = [float(found[f"{along}_{end}"]) for end in ("low", "high")]
        assert ends[1] - ends[0] <= 2 * np.spacing(ends[1])
        exciters = [replace(near, **{along: value}) for value in ends]
        low, high = (pitchfork_force(each) - mp.mpf(each.f) for each in exciters)
        return bool(low * high <= 0)


@pytest.mark.parametrize("along", ["f", "nu", "h", "l"])
@pytest.mark.parametrize("nu", [0.9, 1.2, 1.5])
def test_pitchforks_are_those_of_their_closed_form(nu: float, along: str) -> None:
    assert is_enclosed(replace(SYMMETRIC, nu=nu), along)


@pytest.mark.parametrize("equation", ["mirror", "multiplier", "restitution"])
def test_a_mutation_of_an_equation_of_a_pitchfork_is_found(monkeypatch, equation: str) -> None:
    more = arb(1 + 2.0**-33)
    image, multiplier, end_of = (
        bifurcation.mirrored,
        bifurcation.trace_and_determinant,
        equations.end_of,
    )
    if equation == "mirror":
        monkeypatch.setattr(
            bifurcation, "mirrored",
            lambda law, half: [a * more if n == 1 else a for n, a in enumerate(image(law, half))],
        )  # fmt: skip
    elif equation == "multiplier":
        monkeypatch.setattr(
            bifurcation, "trace_and_determinant",
            lambda *given: [a * more for a in multiplier(*given)],
        )  # fmt: skip
    else:
        monkeypatch.setattr(
            equations, "end_of",
            lambda model, flight: end_of(model, flight._replace(free=flight.free * more)),
        )  # fmt: skip
    assert not is_enclosed(replace(SYMMETRIC, nu=0.9), "f")


def test_pitchforks_and_touches_of_both_supports_are_those_of_a_branch() -> None:
    branch = vp.branch(SYMMETRIC, "nu", (0.55, 1.1), switch=("pitchfork",))
    seen = []
    for n, point in enumerate(branch.bifurcation_point.values):
        kind = Bifurcation(int(branch.bifurcation_kind[n])).name.lower()
        row = branch.drop_dims("impact").isel(point=point)
        found = vp.prove_bifurcation(row, kind, "nu")
        assert found.proved == Proved.PROVED
        assert branch.bifurcation_nu[n].item() == pytest.approx(float(found.nu_low), rel=1e-13)
        seen.append((kind, int(found.grazing_support)))
    assert {("pitchfork", 0), ("grazing", 1), ("grazing", 2), ("grazing", 3)} <= {*seen}
    proof = vp.prove(branch)
    assert (proof.bifurcation_proved == Proved.PROVED).all()
    n = len(seen)
    assert f"all {n} folds, flips, pitchforks and grazings are proved." in proof.statement


def test_a_touch_that_is_struck_when_marched_again_is_enclosed() -> None:
    # from the stored section at delta = 0.0538 three impacts follow, one of them the touch
    branch = vp.branch(replace(EXCITER, nu=0.9), "delta", (-0.4, 0.4))
    proof = vp.prove(branch)
    assert branch.bifurcation_kind.values.tolist() == [Bifurcation.GRAZING] * 2
    assert (proof.bifurcation_proved == Proved.PROVED).all()
    np.testing.assert_allclose(proof.bifurcation_delta_low, branch.bifurcation_delta, rtol=1e-12)
    without = vp.branch(replace(EXCITER, nu=0.9), "delta", (-0.4, 0.4), outputs=["stability"])
    assert (vp.prove(without).bifurcation_proved == Proved.PROVED).any()


def test_both_supports_are_touched_where_the_closed_form_ceases_to_be_a_motion() -> None:
    orbit_nearby = vp.symmetric_orbit(replace(SYMMETRIC, nu=0.71)).isel(solution=0)
    found = vp.prove_bifurcation(orbit_nearby, "grazing", "nu")
    assert found.statement.startswith("The orbit (1; 1, 1) touches both supports, a grazing,")
    low, high = float(found.nu_low), float(found.nu_high)
    outside, inside = (
        vp.symmetric_orbit(replace(SYMMETRIC, nu=nu)).isel(solution=0)
        for nu in (low * (1 - 1e-9), high * (1 + 1e-9))
    )
    assert not outside.admissible
    assert inside.admissible
    assert 0 < inside.clearance < 1e-7


@pytest.mark.parametrize(
    ("other", "along"),
    [({}, "delta"), ({"R2": 0.7}, "nu"), ({"load": 0.01}, "nu"), ({"f2": 0.01}, "nu")],
)
def test_without_symmetry_there_is_no_pitchfork(other: dict[str, float], along: str) -> None:
    row = vp.symmetric_orbit(replace(SYMMETRIC, nu=0.9)).isel(solution=0).assign_coords(other)
    found = vp.prove_bifurcation(row, "pitchfork", along)
    assert found.proved == Proved.UNDECIDED
    assert found.why == Why.SYMMETRY
    assert "their own mirror images along this parameter" in found.statement


def test_supports_on_either_side_of_a_loaded_equilibrium_are_symmetric() -> None:
    row = vp.symmetric_orbit(replace(SYMMETRIC, nu=0.9, f=0.392)).isel(solution=0)
    loaded = row.assign_coords(load=0.25, delta=0.25)
    ends = [float(vp.prove_bifurcation(each, "pitchfork", "f").f_low) for each in (row, loaded)]
    assert ends[0] == ends[1] > 0


def test_a_pitchfork_is_no_regular_fold() -> None:
    branch = vp.branch(SYMMETRIC, "nu", (0.9, 1.1))
    (at,) = branch.bifurcation_point.values
    row = branch.drop_dims("impact").isel(point=at)
    assert vp.prove_bifurcation(row, "fold", "nu").proved == Proved.UNDECIDED


def test_what_is_none_is_undecided() -> None:
    found = vp.prove_bifurcation(EXCITER, "fold", "R2")
    assert found.proved == Proved.UNDECIDED
    assert np.isnan(found.R2_low)
    assert "Undecided" in found.attrs["statement"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("cusp", "nu"), "kind: must be one of fold, flip, pitchfork, grazing, got 'cusp'"),
        (("fold", "m"), "along: must be one of nu, f, h, .*, got 'm'"),
        (("fold", "k1"), "along: must be another parameter: support 1 is rigid"),
    ],
)
def test_wrong_arguments(arguments: tuple[str, str], message: str) -> None:
    with pytest.raises(vp.ParameterError, match=message):
        vp.prove_bifurcation(EXCITER, *arguments)
