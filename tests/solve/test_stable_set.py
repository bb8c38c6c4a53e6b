"""Stable sets of unstable orbits and the least knocks that lead across them, against motions on either side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.solve.basins.attractor_set import AttractorSet
from vibropipe.solve.basins.section_map import SectionMap

PAPER = vp.Exciter(l=0.5, nu=2.5, f=-1.0, h=0.2, R1=0.7, R2=0.7)
THREE = vp.Exciter(l=0.5, nu=3.48, f=0.7, h=0.1, delta=0.1, R1=0.8, R2=0.8)
SYMMETRIC = vp.Exciter(l=0.5, nu=1.61, f=1.66, h=0.02, R1=0.8, R2=0.8)
SOFT = replace(PAPER, R1=1.0, R2=1.0, k1=100.0, k2=100.0, h1=1.0, h2=1.0)
NEAR = 1e-8


def basins_of(exciter, n=40, velocity=2.0):
    xs = np.linspace(exciter.lower, exciter.upper, n)
    return vp.basins(exciter, xs, np.linspace(-velocity, velocity, n), starts=256)


def vertices_of(basins, orbit, count=40):
    """Return some states (n, 2) along the stable set of an orbit, and unit vectors across it."""
    own = basins.stable_set_orbit.values == orbit
    curve = np.column_stack(
        [basins[f"stable_set_{name}"].values[own] for name in ("displacement", "velocity")]
    )
    across = (curve[2:] - curve[:-2])[:, ::-1] * [-1.0, 1.0]
    states = curve[1:-1]
    with np.errstate(invalid="ignore"):
        across /= np.linalg.norm(across, axis=1)[:, None]
        off_support = abs(states[:, 0] - basins.delta.item()) < basins.l.item() - 1e-3
    chosen = np.flatnonzero(np.isfinite(across).all(axis=1) & off_support)
    chosen = chosen[:: max(1, chosen.size // count)]
    assert chosen.size >= count
    return states[chosen], across[chosen]


@pytest.mark.parametrize("exciter", [PAPER, THREE, SYMMETRIC, SOFT])
def test_starts_on_either_side_of_a_stable_set_settle_apart(exciter):
    basins, found = basins_of(exciter), AttractorSet(exciter)
    assert basins.sizes["border_orbit"] > 0
    for orbit in range(basins.sizes["border_orbit"]):
        states, across = vertices_of(basins, orbit)
        sides = [found.settle(states + sign * NEAR * across)[0] for sign in (1.0, -1.0)]
        assert (np.array(sides) >= 0).all()
        assert (sides[0] != sides[1]).all()


@pytest.mark.parametrize("exciter", [PAPER, THREE])
def test_motions_from_a_stable_set_approach_its_orbit(exciter):
    basins, section = basins_of(exciter), SectionMap(exciter)
    for orbit in range(basins.sizes["border_orbit"]):
        own = basins.border_point_orbit.values == orbit
        points = np.column_stack(
            [basins[f"border_point_{name}"].values[own] for name in ("displacement", "velocity")]
        )
        for state in vertices_of(basins, orbit)[0]:
            ahead = section.sections(state, 200)
            away = np.abs((ahead[:, None] - points) / section.scale).max(axis=2).min(axis=1)
            assert away.min() < 1e-5


def test_a_stable_set_is_the_whole_border():
    """On a grid without it, every border start has it within a cell."""
    basins = basins_of(PAPER, n=60)
    at = np.argwhere(basins.border.values)
    starts = np.column_stack([basins.x0.values[at[:, 0]], basins.v0.values[at[:, 1]]])
    curve = np.column_stack([basins.stable_set_displacement, basins.stable_set_velocity])
    cell = [np.diff(basins[name].values[:2]).item() for name in ("x0", "v0")]
    for start in starts:
        assert np.nanmin(np.abs((curve - start) / cell).max(axis=1)) <= 1.0


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"load": 0.05},
        pytest.param({"f2": 0.4, "phi2": 0.7}, marks=pytest.mark.slow),
        {"R1": 1.0, "k1": 40.0, "h1": 2.0, "R2": 1.0, "k2": 1e6, "h2": 300.0},
        {"k1": 1e8, "R1": 0.5},
    ],
    ids=str,
)
def test_a_preimage_is_the_state_before(more):
    section, generator = SectionMap(replace(THREE, **more)), np.random.default_rng(5)
    states = np.column_stack([generator.uniform(-0.4, 0.6, 200), generator.uniform(-2, 2, 200)])
    images, _contacts = section.images(states, 1)
    np.testing.assert_allclose(section.preimages(images), states, atol=1e-10)


@pytest.mark.parametrize("more", [{"R1": 0.0}, {"friction": 0.1}], ids=str)
def test_without_rebound_or_with_friction_there_is_no_one_state_before(more):
    section = SectionMap(replace(THREE, **more))
    assert np.isnan(section.preimages(np.array([[0.1, 0.2]]))).all()


def test_after_a_rest_there_is_no_one_state_before():
    """The motion is released from its support within the period, whatever led it there."""
    exciter = vp.Exciter(l=0.5, nu=0.3, f=1.5, h=0.2, R1=0.5, R2=0.5)
    section = SectionMap(exciter)
    images, contacts = section.images(np.array([[0.0, 0.1], [0.01, 0.12]]), 1)
    assert contacts[0] == contacts[1]
    np.testing.assert_allclose(images[0], images[1], atol=1e-13)
    assert np.isnan(section.preimages(images)).all()


KNOCKED = vp.Exciter(l=0.5, nu=2.0, f=0.8, h=0.1, k1=200.0, h1=1.0, R2=0.75)


def settles(exciter: vp.Exciter, x: float, v: float, own: xr.Dataset) -> bool:
    """Return whether the motion from a state at the section settles on an attractor."""
    row = vp.steady_state(exciter, x0=x, v0=v, harmonics=1, outputs=("harmonics", "impacts"))
    if int(row.period_multiple) != int(own.period_multiple):
        return False
    apart = np.abs(row.displacement_amplitude[0] - own.displacement_amplitude[0])
    return bool(apart < 1e-6) and bool(np.abs(row.displacement_mean - own.displacement_mean) < 1e-6)


@pytest.mark.parametrize("exciter", [THREE, KNOCKED], ids=["three motions", "a soft support"])
def test_smaller_knocks_lead_back_and_a_larger_one_does_not(exciter):
    found = vp.attractors(exciter)
    assert found.attractor_id.size > 1
    for index in range(found.attractor_id.size):
        own = found.isel(attractor_id=index)
        m, impulse = int(own.period_multiple), float(own.knock_impulse)
        assert 0.0 < float(own.knock) <= impulse
        states = np.column_stack([own.poincare_displacement, own.poincare_velocity])[-m:]
        knocks = [(x, v, sign) for x, v in states for sign in (1.0, -1.0)]
        for share in (*np.linspace(0.02, 0.98, 33), 0.9999):
            assert all(settles(exciter, x, v + share * s * impulse, own) for x, v, s in knocks)
        assert not all(settles(exciter, x, v + 1.0001 * s * impulse, own) for x, v, s in knocks)


def test_mirror_images_survive_the_same_knocks():
    one, two = vp.attractors(THREE), vp.attractors(THREE.mirrored())
    for name in ("knock", "knock_impulse"):
        np.testing.assert_allclose(np.sort(one[name]), np.sort(two[name]), rtol=1e-3)


def test_a_lone_motion_is_lost_by_no_knock():
    alone = vp.attractors(vp.Exciter(l=0.5, nu=1.0, f=1.0, h=0.2, R1=0.7, R2=0.7))
    assert alone.attractor_id.size == 1
    assert np.isnan(alone.knock_impulse).all()


def test_in_si_it_is_an_impulse():
    exciter = vp.Exciter.from_physical(
        m="2 kg", C="8 N/m", H=0.4, F="5.6 N", omega=6.96, l="0.5 m", delta="0.1 m", R1=0.8, R2=0.8
    )  # THREE
    plain = vp.attractors(exciter)
    physical = vp.to_physical(plain, exciter)
    assert np.isfinite(plain.knock_impulse).all()
    # m p times what is a velocity in units of the length over 1/p, p = 2 rad/s
    np.testing.assert_allclose(physical.knock_impulse, 2.0 * 2.0 * plain.knock_impulse)
    assert physical.knock_impulse.attrs["units"] == "N s"


def test_a_basin_over_a_parameter_has_the_knocks_of_each_value():
    exciter = vp.Exciter(l=0.5, nu=1.8, f=0.4, h=0.15, R1=0.7, R2=0.6)
    x0, v0 = np.linspace(-0.5, 0.5, 6), np.linspace(-1.0, 1.0, 6)
    over = vp.basins(exciter, x0, v0, starts=256, over={"nu": [1.8, 1.85]})
    assert over["knock"].dims == ("nu", "attractor_id")
    alone = vp.basins(replace(exciter, nu=1.85), x0, v0, starts=256)
    for name in ("knock", "knock_impulse"):
        # towards the stable sets that a single basin has, less may do
        assert (np.sort(over[name].values[1]) >= np.sort(alone[name].values) * (1 - 1e-4)).all()
        np.testing.assert_allclose(np.sort(over[name].values[1]), np.sort(alone[name].values), 0.05)


def test_a_tongue_between_the_directions_is_found_by_the_stable_set():
    exciter = vp.Exciter(l=0.5, nu=1.8, f=0.4, h=0.15, R1=0.7, R2=0.6)
    grid = np.linspace(-0.5, 0.5, 21), np.linspace(-1.0, 1.0, 21)
    scattered, found = vp.attractors(exciter, 1024), vp.basins(exciter, *grid, starts=1024)
    assert (found["knock"].values <= scattered["knock"].values).all()
    curve = np.column_stack(
        [found[f"stable_set_{name}"].values for name in ("displacement", "velocity")]
    )
    for n in range(found.sizes["attractor_id"]):
        row = found.isel(attractor_id=n)
        state = [float(row[f"{name}_strobe"]) for name in ("displacement", "velocity")]
        away = np.nanmin(np.hypot(*(curve - state).T))
        # the border of two basins is as near as its stable set
        assert float(row["knock"]) == pytest.approx(away, rel=0.01)
        assert float(row["knock"]) <= away * 1.002
