"""Proved knocks: against marched starts, the marched search of knocks, and enclosures of single motions."""

import numpy as np
import pytest

import vibropipe as vp

pytest.importorskip("flint")

from vibropipe.proof.balls import BITS, arb, ctx
from vibropipe.proof.knock import with_proved_knocks
from vibropipe.proof.returns import Returns
from vibropipe.words.proofs import Proved, Why

RIGID = vp.Exciter(l=0.5, nu=1.8, f=0.4, h=0.15, R1=0.7, R2=0.6)
SOFT = vp.Exciter(l=0.5, nu=2.2, f=0.5, h=0.1, k1=50, h1=1, k2=20, h2=0.5)


@pytest.fixture(scope="module", params=[RIGID, SOFT], ids=["rigid", "soft"])
def proved(request):
    found = vp.attractors(request.param, 512)
    return request.param, with_proved_knocks(found, 300)


def test_proved_knocks_are_below_the_marched_ones(proved):
    _exciter, motions = proved
    for name in ("knock", "knock_impulse"):
        low, marched = motions[f"{name}_low"].values, motions[name].values
        assert (low > 0.002).all()
        assert (low < marched).all()


def test_a_proved_impulse_comes_near_the_marched_one():
    row = vp.attractors(RIGID, 512).drop_dims("impact").isel(attractor_id=0)
    found = vp.prove_knock(row, cells=1000)
    assert found["proved"] == Proved.PROVED
    marched = float(row["knock_impulse"])
    assert 0.99 * marched < float(found["knock_impulse_low"]) < marched
    assert repr(float(found["knock_low"])) in found.attrs["statement"]


def test_starts_within_a_proved_knock_settle_on_the_orbit(proved):
    exciter, motions = proved
    rng = np.random.default_rng(3)
    for n in range(motions.sizes["attractor_id"]):
        row = motions.isel(attractor_id=n)
        assert int(row["period_multiple"]) == 1
        state = np.array([float(row[f"{name}_strobe"]) for name in ("displacement", "velocity")])
        angles = rng.uniform(0.0, 2.0 * np.pi, 12)
        offs = float(row["knock_low"]) * np.column_stack([np.cos(angles), np.sin(angles)])
        kicks = float(row["knock_impulse_low"]) * np.array([[0.0, 1.0], [0.0, -1.0]])
        for off in (*offs, *kicks):
            x, v = state + 0.999 * off
            settled = vp.steady_state(exciter, x0=x, v0=v, outputs=("impacts",))
            there = [float(settled[f"{name}_strobe"]) for name in ("displacement", "velocity")]
            assert there == pytest.approx(state, abs=1e-9)


@pytest.mark.parametrize("exciter", [RIGID, SOFT], ids=["rigid", "soft"])
def test_the_image_of_a_cell_contains_those_of_its_starts(exciter):
    rng = np.random.default_rng(7)
    with ctx.workprec(BITS):
        returns = Returns(exciter, np.zeros((1, 2)), 0.0)
        found = 0
        for _ in range(60):
            centre = rng.uniform(-0.45, 0.45), rng.uniform(-1.0, 1.0)
            half = np.array([4e-3, 4e-3]) * rng.uniform(0.01, 1.0, 2)
            image = returns._image(centre, np.diag(half), 2)
            if image is None:
                continue
            found += 1
            for c in rng.uniform(-1.0, 1.0, (5, 2)):
                x0, v0 = np.array(centre) + half * c
                end = vp.simulate(exciter, 2 * exciter.period, x0, v0, samples_per_period=0)
                for moved, name in zip(image, ("displacement_end", "velocity_end"), strict=True):
                    value = float(end[name])
                    linear = moved.centre + sum(a * b for a, b in zip(moved.slopes, c, strict=True))
                    assert (moved.ball + arb(0, 1e-10)).contains(arb(value))
                    assert (linear + arb(0, 1e-10)).contains(arb(value))
        assert found > 20


def test_no_knock_is_proved_of_what_does_not_attract():
    found = vp.prove_knock(vp.Exciter(l=2.0, nu=1.7, f=0.4, h=0.0), cells=10)
    assert found["proved"] == Proved.UNDECIDED
    assert found["why"] == Why.STABILITY
    assert np.isnan(found["knock_low"])
    assert found.attrs["statement"].startswith("Undecided")


def test_an_unstable_orbit_and_effects_that_are_not_proved_are_refused():
    orbits = vp.symmetric_orbit(vp.Exciter(l=0.5, nu=1.3, f=1.0, h=0.2, R1=0.7, R2=0.7))
    (unstable,) = np.flatnonzero(orbits["admissible"].values & (orbits["stable"].values == 0))
    with pytest.raises(vp.ParameterError, match="must be stable"):
        vp.prove_knock(orbits.isel(solution=int(unstable)), cells=10)
    with pytest.raises(vp.ParameterError, match="friction: must be 0"):
        vp.prove_knock(vp.Exciter(l=0.5, nu=1.0, f=0.8, h=0.1, friction=0.05), cells=10)
    with pytest.raises(vp.ParameterError, match="cells"):
        vp.prove_knock(RIGID, cells=0)
    with pytest.raises(vp.ParameterError, match="mass_ratio"):
        vp.prove_knock(vp.Exciter(l=0.5, nu=1.8, f=0.4, h=0.15, mass_ratio=0.2), cells=10)
