"""Least knocks that a motion does not survive: against steady states from disturbed starts, mirror images and units."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp

THREE = vp.Exciter(l=0.5, nu=3.48, f=0.7, h=0.1, delta=0.1, R1=0.8, R2=0.8)
SOFT = vp.Exciter(l=0.5, nu=2.0, f=0.8, h=0.1, k1=200.0, h1=1.0, R2=0.75)


def settles(exciter: vp.Exciter, x: float, v: float, own: xr.Dataset) -> bool:
    """Return whether the motion from a state at the section settles on an attractor."""
    row = vp.steady_state(exciter, x0=x, v0=v, harmonics=1, outputs=("harmonics", "impacts"))
    if int(row.period_multiple) != int(own.period_multiple):
        return False
    apart = np.abs(row.displacement_amplitude[0] - own.displacement_amplitude[0])
    return bool(apart < 1e-6) and bool(np.abs(row.displacement_mean - own.displacement_mean) < 1e-6)


@pytest.mark.parametrize("exciter", [THREE, SOFT], ids=["three motions", "a soft support"])
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
