"""All orbits of a law: beside closed forms, sweeps, and the folds and flips that others published."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sampling import sampled

import vibropipe as vp
from vibropipe.proof import three
from vibropipe.proof.balls import BITS, ONE, ZERO, Jet, arb, ctx
from vibropipe.proof.given import balls_of
from vibropipe.proof.law import Law
from vibropipe.proof.linear import Equations
from vibropipe.words.bifurcations import Bifurcation
from vibropipe.words.proofs import Proved, ProvedStable, Why

REFERENCE = json.loads(
    (Path(__file__).parents[1] / "reference" / "one_sided.json").read_text(encoding="utf-8")
)
PAPER = vp.Exciter(l=0.5, nu=1.0, f=-1.0, h=0.2, delta=0.01, R1=0.7, R2=0.7)


def published(kind, nu, f):
    exciter = vp.Exciter(l=25.5, delta=-24.5, h=0.04, R1=0.9, nu=nu, f=f)
    found = vp.prove_all(exciter, (2, 1, 0))
    assert found.proved == Proved.PROVED, (kind, found.statement)
    return found.proved_stable.values.tolist()


@pytest.mark.parametrize("index", sampled(range(37), 1, 30))
def test_an_orbit_begins_at_a_published_fold(index):
    nu, f = REFERENCE["fold"][index][:2]
    assert published("fold", nu, f * (1 - 1e-9)) == []
    assert sorted(published("fold", nu, f * (1 + 1e-9))) == [0, 1]


@pytest.mark.parametrize("index", sampled(range(39), 5, 25))
def test_stability_is_lost_at_a_published_flip(index):
    nu, f, velocity = REFERENCE["flip"][index][:3]
    if velocity < 1e-3:
        pytest.skip("its impact is too slow for the digits of the source")
    step = 1e-4 if velocity > 0.01 else 3e-5  # the fold is near where the impact is slow
    sides = [published("flip", nu, f * (1 + s * step)) for s in (-1, 1)]
    assert {max(side) for side in sides} == {0, 1}


@pytest.mark.parametrize(
    ("other", "law", "stable"),
    [
        ({}, (1, 1, 1), [1]),
        ({}, (2, 1, 1), []),
        ({}, (3, 1, 1), []),
        ({"nu": 3.48, "f": 0.7, "h": 0.1, "delta": 0.1, "R1": 0.8, "R2": 0.8}, (1, 1, 1), [1, 0]),
        ({"nu": 2.0, "f": 0.8, "h": 0.15, "delta": 0.05, "R2": 0.6}, (1, 1, 1), [1, 0]),
        ({"nu": 1.3, "f": 1.0, "delta": 0.0}, (1, 1, 1), [0, 1, 1]),
        ({"nu": 1.2, "f": 1.25, "h": 2.0, "delta": 0.0}, (1, 1, 1), [1]),
        ({"f": 0.25, "h": 0.0, "delta": 0.0}, (1, 1, 1), [1]),
        ({"nu": 1.3, "f": 1.0, "delta": 0.02, "load": 0.02}, (1, 1, 1), [0, 1, 1]),
    ],
    ids=str,
)
def test_exactly_these_orbits(other, law, stable):
    exciter = vp.Exciter(**{**PAPER.stated(), **other})
    found = vp.prove_all(exciter, law)
    assert (found.proved, found.why) == (Proved.PROVED, Why.NONE)
    assert sorted(found.proved_stable.values.tolist()) == sorted(stable)
    if not stable:
        assert found.statement == f"This exciter has no orbit ({law[0]}; 1, 1)."
    for k in range(found.sizes["orbit"]):
        # the same orbit, proved from its bounds as a row
        row = found.isel(orbit=k)
        row = row.assign({name: row[f"{name}_low"] for name in ("impact_phase", "impact_velocity")})
        again = vp.prove(row)
        assert again.proved == Proved.PROVED
        assert again.proved_stable == row.proved_stable


def random_exciters(seed, n, reach=(-0.3, 0.3), **others):
    """Random exciters with the offset within a range."""
    rng = np.random.default_rng(seed)
    for _ in range(n):
        nu, f, h, R1, R2 = rng.uniform([0.5, 0.1, 0.0, 0.3, 0.3], [3.5, 1.5, 0.4, 0.95, 0.95])
        values = {"nu": nu, "f": f, "h": h, "delta": rng.uniform(*reach), "R1": R1, "R2": R2}
        yield vp.Exciter(l=0.5, **{**values, **others})


def test_symmetric_orbits_are_those_in_closed_form():
    total = 0
    for k, exciter in enumerate(random_exciters(5, 5, delta=0.0, R1=0.7, R2=0.7)):
        m = 3 if k == 0 else 1
        closed = vp.symmetric_orbit(exciter, m)
        known = closed.impact_velocity.max("impact").values[closed.admissible.values == 1]
        found = vp.prove_all(exciter, (m, 1, 1))
        assert found.proved == Proved.PROVED
        speeds = found.impact_velocity_high.max("impact").values
        is_mirrored = abs(found.impact_velocity_low.sum("impact").values) < 1e-12
        assert np.sort(speeds[is_mirrored]) == pytest.approx(np.sort(known), rel=1e-10)
        total += known.size
    assert total >= 3


def test_one_sided_orbits_are_those_in_closed_form():
    total = 0
    for exciter in random_exciters(6, 20, (-0.5, -0.35)):
        for support, law in ((1, (1, 1, 0)), (2, (1, 0, 1)), (1, (2, 1, 0))):
            closed = vp.one_sided_orbit(exciter, support, law[0])
            known = closed.isel(solution=closed.admissible.values == 1).impact_velocity.values
            found = vp.prove_all(exciter, law)
            assert found.proved == Proved.PROVED
            proved = found.impact_velocity_low.values
            assert np.sort(proved.ravel()) == pytest.approx(np.sort(known.ravel()), rel=1e-10)
            total += known.size
    assert total >= 8


def test_what_a_motion_settles_on_is_among_them():
    settled = 0
    for exciter in random_exciters(8, 20):
        row = vp.steady_state(exciter)
        is_pair = row.period_multiple == 1 and (row.impacts_per_orbit == 1).all()
        if not is_pair or row.rests_per_orbit.any():
            continue
        settled += 1
        found = vp.prove_all(exciter)
        assert found.proved == Proved.PROVED
        off = abs(found.displacement_mean_low - row.displacement_mean)
        off += abs(found.velocity_strobe_low - row.velocity_strobe)
        nearest = int(off.values.argmin())
        assert off[nearest] < 1e-10
        assert found.proved_stable[nearest] == ProvedStable.STABLE
    assert settled >= 4


def test_at_a_pitchfork_it_is_undecided():
    """The symmetric orbit and its mirror pair are one there: no ball tells them apart."""
    start = vp.Exciter(**{**PAPER.stated(), "delta": 0.0})
    branch = vp.branch(start, "nu", 1.3)
    nu = float(branch.bifurcation_nu.values[0])
    found = vp.prove_all(vp.Exciter(**{**start.stated(), "nu": nu}), parts=1000)
    assert (found.proved, found.why) == (Proved.UNDECIDED, Why.PARTS)
    assert found.sizes["orbit"] >= 1


def test_few_intervals_leave_it_undecided():
    found = vp.prove_all(PAPER, parts=10)
    assert (found.proved, found.why) == (Proved.UNDECIDED, Why.PARTS)
    assert "not proved with the parts that were allowed" in found.statement


@pytest.mark.parametrize(
    ("exciter", "law", "message"),
    [
        (
            PAPER,
            (1, 2, 2),
            r"law: must be one of \(m, 1, 1\), \(m, 1, 0\), .*, \(m, 1, 2\) with a whole",
        ),
        (PAPER, (0, 1, 1), "law: must be a whole number from 1 to 100"),
        (PAPER, 3, r"law: must be one of \(m, 1, 1\)"),
        (vp.Exciter(l=0.5, nu=1.0, h=0.1), (1, 1, 1), "f: must not be 0"),
        (vp.Exciter(l=0.5, nu=1.0, f=1.0, f2=0.1), (1, 1, 1), "f2: must be 0"),
        (vp.Exciter(l=0.5, nu=1.0, f=1.0, k1=9.0), (1, 1, 1), "k1: must be 0: soft supports"),
        (vp.Exciter(l=0.5, f=1.0), (1, 1, 1), "nu: "),
    ],
)
def test_what_is_not_covered_is_refused_in_words(exciter, law, message):
    with pytest.raises(vp.ParameterError, match=message):
        vp.prove_all(exciter, law)


THREE = vp.Exciter(l=0.5, nu=1.2, f=0.97, h=0.2, delta=0.25, R1=0.6, R2=0.6)
PAIR = vp.Exciter(l=0.5, nu=0.93, f=0.87, h=0.1, delta=-0.2, R1=0.8, R2=0.8)


@pytest.mark.slow
def test_the_only_orbit_with_three_impacts_is_the_one_that_settles():
    seen = []
    found = vp.prove_all(THREE, (1, 1, 2), progress=lambda *done: seen.append(done))
    row = vp.steady_state(THREE)
    assert found.statement == "This exciter has exactly one orbit (1; 1, 2), stable."
    assert seen[-1] == (1000, 1000)
    for name in ("impact_velocity", "impact_phase"):
        value = row[name].values
        assert (found[f"{name}_low"].values[0] <= value + 1e-14).all()
        assert (value - 1e-14 <= found[f"{name}_high"].values[0]).all()


@pytest.mark.slow
def test_two_orbits_with_three_impacts_meet_at_the_fold_of_their_branch():
    branch = vp.branch(PAIR, "f", (0.6, 1.0))
    (fold,) = branch.bifurcation_f.values[branch.bifurcation_kind.values == Bifurcation.FOLD][:1]
    assert tuple(vp.steady_state(PAIR).impacts_per_orbit.values) == (2, 1)
    for f, stable in ((fold * (1 + 1e-3), [0, 1]), (fold * (1 - 1e-3), [])):
        found = vp.prove_all(replace(PAIR, f=float(f)), (1, 2, 1))
        assert found.proved == Proved.PROVED
        assert sorted(found.proved_stable.values.tolist()) == stable


@pytest.mark.slow
@pytest.mark.parametrize("nu", [1.458, 1.5, 1.55])
def test_orbits_with_three_impacts_in_two_periods_are_found(nu):
    exciter = replace(THREE, nu=nu, f=0.68)
    row = vp.steady_state(exciter)
    assert (int(row.period_multiple), *row.impacts_per_orbit.values) == (2, 1, 2)
    found = vp.prove_all(exciter, (2, 1, 2))
    assert found.proved == Proved.PROVED
    # it may be told from its other forcing period on
    known = np.sort(row.impact_velocity.values)
    own = [
        k
        for k, velocities in enumerate(found.impact_velocity_low.values)
        if (abs(np.sort(velocities) - known) < 1e-12).all()
    ]
    assert len(own) == 1
    assert found.proved_stable[own[0]] == ProvedStable.STABLE


def test_equations_of_three_impacts_hold_along_an_orbit_and_at_no_length():
    row = vp.steady_state(THREE)
    with ctx.workprec(BITS):
        equations = Equations(balls_of(THREE), 1)
        search = three._Search(equations, Law.of_impacts(1, (2, 2, 1)))
        order = [1, 2, 0]  # it begins with the first of two strikes on support 2
        phases = row.impact_phase.values[order]
        lengths = [arb(float(d % 1.0)) for d in np.diff(phases)]
        at = search.linear(*lengths)
        assert abs(three._det4(at.rows)) < 1e-12
        for k in range(4):
            unknowns = search.unknowns(three._solved(at.rows, k), at, *lengths)
            for a, b in zip(unknowns[3:], row.impact_velocity.values[order], strict=True):
                assert abs(a - b) < 1e-10
            assert abs(float(unknowns[0].mid()) % 1.0 - phases[0]) < 1e-10
        # divided by its length, the flight that returns to its support: what holds of all from 0 on, of one of them
        over = search.linear(Jet(arb(0.01, 0.01), [ONE, ZERO]), Jet(arb(0.4), [ZERO, ONE]))
        for s in (1e-6, 0.003, 0.02):
            rows = search.linear(arb(s), arb(0.4)).rows
            for a, b in zip(over.rows[0], rows[0], strict=True):
                assert a.value.contains(b)
                step = arb(2.0**-40)
                more = search.linear(arb(s) + step, arb(0.4)).rows[0]
                slopes = [(c - d) / step for c, d in zip(more, rows[0], strict=True)]
            for a, slope in zip(over.rows[0], slopes, strict=True):
                assert a.slopes[0].overlaps(slope + arb(0, 1e-6))
