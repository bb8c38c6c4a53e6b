"""Contacts of steady states with soft supports: those of motions, of another integrator, and their rigid limit."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from orbit_motions import motion_of
from scipy.integrate import solve_ivp

import vibropipe as vp

OF_EACH = ("impact_velocity_after", "contact_duration", "contact_force_max", "contact_depth_max")
LARGEST = {
    "contact_duration_max": "contact_duration",
    "support_force_max": "contact_force_max",
    "support_depth_max": "contact_depth_max",
}
SOFT = vp.Exciter(
    nu=0.8, f=0.9, l=0.5, h=0.1, k1=20.0, k2=20.0, h1=0.2, h2=0.2, friction=0.05
)  # fmt: skip
# The second of three contacts lasts over the section.
OVER_THE_SECTION = replace(SOFT, nu=0.6872, delta=0.2)
ONE_RIGID = replace(SOFT, nu=0.7846, k2=0.0, h2=0.0, R2=0.6, friction=0.0)
CHAOTIC = replace(SOFT, nu=0.8821)
LOADED = replace(SOFT, load=0.1, f2=0.2, phi2=0.4, friction=0.0)


def steady(exciter: vp.Exciter, outputs: tuple[str, ...] = ("impacts", "stability")):
    return vp.steady_state(exciter, outputs=outputs)


def starts_of(row) -> np.ndarray:
    return 2 * math.pi / float(row.nu) * (row.impact_period + row.impact_phase).values


@pytest.mark.parametrize(
    "exciter",
    [SOFT, OVER_THE_SECTION, ONE_RIGID, LOADED],
    ids=["soft", "over the section", "one rigid", "loaded"],
)
def test_contacts_are_those_of_the_motion_from_the_section(exciter: vp.Exciter) -> None:
    row = steady(exciter)
    m, n = int(row.period_multiple), row.sizes["impact"]
    assert m > 0
    assert n > 1
    motion = motion_of(exciter, row, 3)
    # The contact under way at the start of a motion is not among its impacts.
    own = motion.impact_tau.values[:n]
    assert own == pytest.approx(starts_of(row), abs=1e-10)
    for name in OF_EACH:
        expected = motion[name].values[:n]
        np.testing.assert_allclose(row[name].values, expected, rtol=1e-10, atol=1e-12)
    for name, of in LARGEST.items():
        for support in (1, 2):
            each = row[of].values[row.impact_support.values == support]
            assert row[name].sel(support=support).values == pytest.approx(each.max(), nan_ok=True)


def test_a_contact_that_lasts_over_the_section_is_whole() -> None:
    row = steady(OVER_THE_SECTION)
    ends = starts_of(row) + row.contact_duration.values
    assert (ends > OVER_THE_SECTION.period * int(row.period_multiple)).any()


def test_a_rigid_support_has_a_velocity_after_and_no_contact() -> None:
    row = steady(ONE_RIGID)
    is_rigid = row.impact_support.values == 2
    assert is_rigid.any()
    assert not is_rigid.all()
    after = row.impact_velocity_after.values
    assert after[is_rigid] == pytest.approx(-0.6 * row.impact_velocity.values[is_rigid], rel=1e-15)
    for name, of in LARGEST.items():
        assert np.isnan(row[of].values[is_rigid]).all()
        assert np.isfinite(row[of].values[~is_rigid]).all()
        assert np.isfinite(row[name].values).tolist() == [True, False]


def contact_by_runge_kutta(exciter: vp.Exciter, tau: float, v: float, support: int) -> list[float]:
    """Return (velocity after, duration, largest force, largest depth), the force by a dense sampling."""
    way, k, damping = (
        (1.0, exciter.k1, exciter.h1) if support == 1 else (-1.0, exciter.k2, exciter.h2)
    )
    at = exciter.delta + way * exciter.l

    def rates(t: float, z: np.ndarray) -> list[float]:
        push = exciter.f * math.sin(exciter.nu * t) - exciter.friction * np.sign(z[1])
        return [z[1], push - exciter.h * z[1] - z[0] - k * (z[0] - at) - damping * z[1]]

    def turns(_t: float, z: np.ndarray) -> float:
        return float(z[1])

    def leaves(_t: float, z: np.ndarray) -> float:
        return float(way * (z[0] - at)) + 1e-15

    turns.terminal = leaves.terminal = True  # type: ignore[attr-defined]
    settings = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14, "dense_output": True}
    inward = solve_ivp(rates, (tau, tau + 9.0), [at, v], events=turns, **settings)
    z = [inward.y[0, -1], -way * 1e-15]
    outward = solve_ivp(rates, (inward.t[-1], tau + 9.0), z, events=leaves, **settings)
    force, depth = 0.0, way * (z[0] - at)
    for part in (inward, outward):
        x, rate = part.sol(np.linspace(part.t[0], part.t[-1], 20001))
        force = max(force, (way * (k * (x - at) + damping * rate)).max())
    return [outward.y[1, -1], outward.t[-1] - tau, force, depth]


def test_contacts_of_a_chaotic_motion_are_those_of_another_integrator() -> None:
    row = steady(CHAOTIC)
    assert int(row.period_multiple) == 0
    n = row.sizes["impact"]
    assert n > 100
    assert np.isfinite(np.array([row[name].values for name in OF_EACH])).all()
    for i in (0, n // 2, n - 1):
        tau, v = starts_of(row)[i], float(row.impact_velocity[i])
        expected = contact_by_runge_kutta(CHAOTIC, tau, v, int(row.impact_support[i]))
        # Between two of the samples the force is larger by less than 1e-8 of it.
        got = [float(row[name][i]) for name in OF_EACH]
        assert got == pytest.approx(expected, rel=1e-7)
    largest = row.support_force_max.values
    each = [row.contact_force_max.values[row.impact_support.values == s].max() for s in (1, 2)]
    assert largest.tolist() == each


def test_a_stiff_contact_tends_to_an_instant() -> None:
    rigid = vp.Exciter(nu=1.0, f=1.0, l=0.5, h=0.1, R1=0.7, R2=0.7)
    struck = float(vp.steady_state(rigid).impact_velocity_max.max())
    share = -math.log(0.7) / math.hypot(math.pi, math.log(0.7))
    for k in (1e4, 1e6, 1e8):
        row = steady(replace(rigid, k1=k, k2=k))
        near = {"rel": 3.0 / math.sqrt(k)}
        # Half a period of the damped contact, less what the damping pulls: it ends where x comes back.
        duration = float(row.contact_duration_max.max())
        assert duration * math.sqrt(k * (1.0 - share**2)) == pytest.approx(math.pi, **near)
        speeds = np.abs(row.impact_velocity_after.values / row.impact_velocity.values)
        assert speeds == pytest.approx(0.7, **near)
        # The depth of the damped oscillation after a quarter of it, and the force with its damping.
        angle = math.acos(share)
        depth = struck / math.sqrt(k) * math.exp(-share * angle / math.sqrt(1.0 - share**2))
        assert float(row.support_depth_max.max()) == pytest.approx(depth, **near)


@pytest.mark.parametrize(
    "exciter",
    [
        vp.Exciter(nu=1.0, f=1.0, l=0.5, h=0.1, R1=0.7, R2=0.7),
        vp.Exciter(nu=1.0, f=1.0, l=0.5, h=0.1, R1=0.7, R2=0.7, friction=0.05),
    ],
    ids=["rigid", "friction"],
)
def test_rigid_supports_have_no_variables_of_contacts(exciter: vp.Exciter) -> None:
    row = steady(exciter)
    assert int(row.impacts_per_orbit.sum()) > 0
    assert not {*OF_EACH, *LARGEST} & {*row.data_vars}


def test_without_impacts_nothing_is_added() -> None:
    assert not {*OF_EACH, *LARGEST} & {*steady(SOFT, ("harmonics", "stability")).data_vars}


def test_a_sweep_has_the_contacts_of_its_rows_in_their_order() -> None:
    over = {"k1": [0.0, 20.0, 200.0], "nu": [0.8, 1.2, 4.0]}
    exciter = replace(SOFT, k2=0.0, h1=0.0, h2=0.0)
    rows = vp.sweep(exciter, over, outputs=("impacts",), follow=("nu", "both"))
    assert rows.support_force_max.dims == ("direction", "k1", "nu", "support")
    assert rows.support_force_max.sel(k1=0.0).isnull().all()
    assert rows.support_force_max.sel(support=2).isnull().all()
    row_of = np.repeat(np.arange(rows.row_size.size), rows.row_size.values.ravel())
    largest = np.full(rows.row_size.size, -np.inf)
    first = (rows.impact_support.values == 1) & np.isfinite(rows.contact_force_max.values)
    np.maximum.at(largest, row_of[first], rows.contact_force_max.values[first])
    kept = rows.support_force_max.sel(support=1).values.ravel()
    np.testing.assert_array_equal(np.where(np.isinf(largest), np.nan, largest), kept)
    assert np.isfinite(kept).any()
    up = rows.sel(direction="up").isel(k1=1, nu=0)
    alone = steady(replace(exciter, k1=20.0))
    assert float(up.support_force_max[0]) == pytest.approx(
        float(alone.support_force_max[0]), rel=1e-10
    )


def test_branches_and_attractors_have_contacts() -> None:
    branch = vp.branch(replace(SOFT, friction=0.0, k1=200.0, k2=200.0), "nu", 0.9)
    assert branch.support_force_max.dims == ("point", "support")
    i = int(np.flatnonzero(branch.stable.values == 1)[-1])
    exciter = replace(SOFT, friction=0.0, k1=200.0, k2=200.0, nu=float(branch.nu[i]))
    start = {
        "x0": float(branch.displacement_strobe[i]), "v0": float(branch.velocity_strobe[i])
    }  # fmt: skip
    row = vp.steady_state(exciter, **start)
    for name in LARGEST:
        assert branch[name][i].values == pytest.approx(row[name].values, rel=1e-9)
    found = vp.attractors(SOFT, starts=16)
    own = steady(SOFT)
    assert float(found.support_force_max[0].max()) == pytest.approx(
        float(own.support_force_max.max()), rel=1e-9
    )
