"""Boundaries over what others are tied to: closed forms, the parameter shaker, exciters by hand, and refusals."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.words.bifurcations import Bifurcation

BASE = vp.Exciter(l=0.5, nu=1)
TIES = {"R2": "R1", "R1": 0.7, "f": "me * nu**2", "h": "2 * zeta", "zeta": 0.075}
BOX = [(0.8, 1.4), (0.2, 0.8)]
LEVEL = {"impact_velocity_max_1": 0.8}
KINDS = ("fold", "pitchfork", "grazing")


def parts(curves: xr.Dataset) -> list[tuple[int, int, int, float, float]]:
    """Return kind, law, and ends in nu of each curve."""
    rows = []
    for number in np.unique(curves.curve_id):
        one = curves.isel(point=curves.curve_id.values == number)
        law = sorted(one.impacts_per_orbit.values[0].astype(int).tolist())
        kind, nu = int(one.boundary_kind[0]), one.nu.values
        rows.append((kind, *law, round(float(nu.min()), 5), round(float(nu.max()), 5)))
    return sorted(rows)


@pytest.fixture(scope="module")
def curves() -> xr.Dataset:
    return vp.boundary(BASE, [*KINDS, LEVEL], ("nu", "me"), BOX, lines=3, ties=TIES)


@pytest.mark.slow
def test_curves_of_an_unbalance_are_those_of_a_shaker(curves):
    # f = e nu^2 by a tie and as a parameter: by laws, and by impacts.
    exciter = vp.Exciter(l=0.5, nu=1, h=0.15, R1=0.7, R2=0.7)
    shaken = vp.boundary(exciter, [*KINDS, LEVEL], ("nu", "shaker"), BOX, lines=3)
    assert parts(curves) == parts(shaken)
    assert {kind for kind, *_rest in parts(curves)} >= {Bifurcation[k.upper()] for k in KINDS}


def test_pitchforks_have_their_closed_form(curves):
    # R2 = R1 keeps the exciter symmetric.
    found = curves.isel(point=curves.boundary_kind.values == Bifurcation.PITCHFORK)
    assert found.sizes["point"] > 50
    exciter = vp.Exciter(l=0.5, h=0.15, R1=0.7, R2=0.7)
    closed = vp.symmetric_orbit_boundaries(exciter, found.nu.values)
    np.testing.assert_allclose(found.me * found.nu**2, closed.pitchfork_f, rtol=1e-9)
    np.testing.assert_array_equal(found.f, found.me * found.nu**2)


def test_a_linear_motion_touches_both_supports_where_its_amplitude_is_l():
    ties = {"f": "me * nu**2", "R2": "R1"}
    exciter = vp.Exciter(l=0.5, nu=1, h=0.15, R1=0.7)
    found = vp.boundary(exciter, "grazing", ("nu", "me"), [(0.5, 0.7), (0.1, 0.9)], 4, ties=ties)
    linear = found.isel(point=found.impacts_per_orbit.values.sum(axis=1) == 0)
    nu = linear.nu.values
    least = 0.5 * np.hypot((1 - nu) * (1 + nu), 0.15 * nu) / nu**2
    assert nu.size > 10
    np.testing.assert_allclose(linear.me, least, rtol=1e-12)


def test_a_name_that_is_tied_to_one_of_both_holds_along_the_other():
    # Every exciter states l, which takes its tie.
    ties = {"f": 0.4, "l": "half"}
    exciter = vp.Exciter(l=1, nu=1)
    found = vp.boundary(exciter, "grazing", ("nu", "half"), [(1.5, 2), (0.2, 0.6)], 4, ties=ties)
    np.testing.assert_array_equal(found.l, found.half)
    assert found.sizes["point"] > 10
    np.testing.assert_allclose(found.half, 0.4 / (found.nu**2 - 1), rtol=1e-12)


def test_points_are_orbits_of_exciters_by_hand(curves):
    level = curves.isel(point=curves.level_of.values == 0)
    stable = np.flatnonzero(level.stable.values == 1)
    assert stable.size > 10
    for point in stable[:: stable.size // 5]:
        row = level.isel(point=point)
        nu, f = float(row.nu), float(row.me) * float(row.nu) ** 2
        alone = vp.steady_state(
            vp.Exciter(l=0.5, nu=nu, f=f, h=0.15, R1=0.7, R2=0.7),
            float(row.displacement_strobe), float(row.velocity_strobe),
        )  # fmt: skip
        assert float(alone.impact_velocity_max[0]) == pytest.approx(0.8, rel=1e-8)


def test_soft_supports_follow_both_parameters():
    exciter = vp.Exciter(l=0.5, nu=1, h=0.1)
    ties = {"k2": "k1", "h1": "0.05 * sqrt(k1)", "h2": "h1", "f": 0.3}
    box = [(0.55, 0.7), (20.0, 40.0)]
    found = vp.boundary(exciter, "grazing", ("nu", "k1"), box, lines=2, ties=ties)
    assert found.sizes["point"] > 5
    np.testing.assert_array_equal(found.h2, 0.05 * np.sqrt(found.k1))
    # The motion without contacts knows no support: it touches them at one frequency, whatever their stiffness.
    free = found.isel(point=found.impacts_per_orbit.values.sum(axis=1) == 0)
    nu = free.nu.values
    assert nu.size > 5
    np.testing.assert_allclose(np.hypot((1 - nu) * (1 + nu), 0.1 * nu), 0.3 / 0.5, rtol=1e-9)


def test_names_and_what_follows_are_described(curves):
    assert curves.attrs["ties"] == "; ".join(f"{name} = {text}" for name, text in TIES.items())
    assert curves.attrs["boundary"] == "nu me"
    assert curves.me.attrs == {"units": "1", "long_name": "me", "symbol": "me"}
    assert curves.meeting_me.attrs["long_name"] == "me at the meeting"
    assert curves.f.dims == ("point",)
    assert float(curves.h) == 0.15
    assert "zeta" not in curves.coords


@pytest.mark.parametrize(
    ("ties", "along", "told"),
    [
        ({"f": "me * nu**2"}, ("nu", "mee"), r"along: must be two of .*, me, got"),
        ({"f": "0.4"}, ("nu", "f"), r"along\.f: must be left out, since it is tied"),
        ({"f": "me - 0.3", "R2": "2 * me"}, ("nu", "me"), r"ties\.R2: must be .* at me = "),
        ({"f": "g * nu"}, ("nu", "h"), r"ties\.f: must have a value for g"),
    ],
)  # fmt: skip
def test_what_cannot_be_followed_is_refused(ties, along, told):
    exciter = vp.Exciter(l=0.5, nu=1)
    with pytest.raises(vp.ParameterError, match=told):
        vp.boundary(exciter, "grazing", along, BOX, 2, ties=ties)
