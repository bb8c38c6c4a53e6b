"""Attractors and basins of exciters with soft supports and dry friction."""

from __future__ import annotations

import numpy as np
import pytest

import vibropipe as vp

FORCED = {"l": 0.5, "nu": 1.8, "f": 0.8, "h": 0.2, "R1": 0.7, "R2": 0.7}
SOFT = vp.Exciter(**FORCED | {"R1": 1.0}, delta=-0.05, k1=200.0, h1=3.0, friction=0.15)
BOTH_SOFT = vp.Exciter(l=0.5, nu=2.3, f=0.6, h=0.05, k1=300.0, k2=300.0, h1=3.0, h2=3.0)
# The mass sticks at the section: near motions slide there.
HELD_AT_SECTION = vp.Exciter(**{**FORCED, "nu": 0.6, "f": 0.7, "h": 0.05}, friction=0.35)
HELD_FOR_EVER = vp.Exciter(**{**FORCED, "nu": 1.0, "f": 1.0}, friction=1.2)
VELOCITIES = np.linspace(-2.0, 2.0, 9)


@pytest.mark.parametrize(
    ("exciter", "x0", "count"),
    [
        (SOFT, np.linspace(-0.55, 0.6, 7), 2),
        pytest.param(BOTH_SOFT, np.linspace(-0.7, 0.7, 7), 2, marks=pytest.mark.slow),
        pytest.param(HELD_AT_SECTION, np.linspace(-0.5, 0.5, 7), 1, marks=pytest.mark.slow),
    ],
    ids=["one soft", "both soft", "held at section"],
)
def test_each_start_settles_on_its_attractor(
    exciter: vp.Exciter, x0: np.ndarray, count: int
) -> None:
    ds = vp.basins(exciter, x0, VELOCITIES, starts=128)
    assert ds.sizes["attractor_id"] == count
    assert (ds.attractor >= 0).all()
    for i, j in ((0, 0), (1, 6), (3, 4), (4, 2), (6, 8)):
        one = vp.steady_state(exciter, x0=x0[i], v0=VELOCITIES[j], outputs=[])
        own = ds.sel(attractor_id=int(ds.attractor[i, j]))
        away = np.hypot(
            own.poincare_displacement - float(one.displacement_strobe),
            own.poincare_velocity - float(one.velocity_strobe),
        )
        assert float(away.min()) < 1e-9
    mirrored = vp.basins(exciter.mirrored(), -x0[::-1], VELOCITIES, starts=128)
    order = [
        int(np.abs(mirrored.displacement_strobe.values + float(x)).argmin())
        for x in ds.displacement_strobe
    ]
    assert (np.array(order)[ds.attractor.values] == mirrored.attractor.values[::-1, ::-1]).all()


def test_a_border_has_its_unstable_orbit() -> None:
    x0 = np.linspace(-0.55, 0.45, 9)
    ds = vp.basins(SOFT, x0, VELOCITIES, starts=128)
    assert ds.sizes["border_orbit"] == 1
    assert abs(ds.border_orbit_multiplier.values[0, 0]) > 1.0
    x, v = float(ds.border_point_displacement[0]), float(ds.border_point_velocity[0])
    after = vp.simulate(SOFT, SOFT.period, x, v, samples_per_period=0)
    assert float(after.displacement_end) == pytest.approx(x, abs=1e-10)
    assert float(after.velocity_end) == pytest.approx(v, abs=1e-10)


def test_places_where_friction_holds_the_mass_attract_nothing() -> None:
    ds = vp.basins(HELD_FOR_EVER, [-0.1, 0.0, 0.3], [0.0, 0.5], starts=16)
    assert ds.sizes["attractor_id"] == 0
    assert (ds.attractor == -1).all()


def test_a_start_beyond_a_soft_support_stays_there() -> None:
    exciter = vp.Exciter(l=0.5, nu=1.0, f=0.0, k1=300.0, friction=200.0)
    assert float(vp.steady_state(exciter, x0=0.6).displacement_strobe) == 0.6
    with pytest.raises(vp.ParameterError, match="between the supports"):
        vp.steady_state(exciter, x0=-0.6)
