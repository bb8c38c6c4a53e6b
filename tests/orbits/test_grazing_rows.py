"""Rows that graze a support: rounding decides whether they strike it, and has no say in labels and multipliers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.physics.linear import linear_multipliers
from vibropipe.words.regimes import Regime


def exactly_grazing(**kwargs: Any) -> vp.Exciter:
    """An exciter whose linear motion has the amplitude f/h = l."""
    return vp.Exciter(**{"l": 0.5, "nu": 1.0, "f": 0.1, "h": 0.2, "R1": 0.7, "R2": 0.6, **kwargs})


def assert_grazes(exciter: vp.Exciter, row: Any) -> None:
    assert int(row.regime) == Regime.NO_IMPACT
    assert int(row.period_multiple) == 1
    assert row.impacts_per_orbit.values.tolist() == [0.0, 0.0]
    assert row.sizes["impact"] == 0
    assert np.isnan(row.impact_velocity_max).all()
    assert float(row.grazings_per_orbit.sum()) >= 1.0
    expected = np.sort_complex(linear_multipliers(exciter.parameters()))
    np.testing.assert_allclose(np.sort_complex(row.floquet_multiplier.values), expected, rtol=1e-9)
    assert int(row.stable) == 1


@pytest.mark.parametrize(
    "kwargs", [{}, {"f": -0.1}, {"R1": 1.0, "R2": 0.0}, {"l": 0.25, "f": 0.05}]
)
def test_an_exactly_grazing_row_is_the_linear_motion(kwargs: dict[str, float]) -> None:
    """It was one-sided with the impact velocity 1.4e-16 and the multiplier 1e14."""
    exciter = exactly_grazing(**kwargs)
    assert_grazes(exciter, vp.steady_state(exciter))


@pytest.mark.parametrize("delta", [0.1, -0.1, 0.25, -0.3])
def test_one_support_that_is_grazed_alone(delta: float) -> None:
    """Rounding of its position may lead to the orbit with an impact that is stable beside the grazing one."""
    exciter = exactly_grazing(l=0.5 + abs(delta), delta=delta)
    row = vp.steady_state(exciter)
    assert int(row.period_multiple) == 1
    assert int(row.stable) == 1
    assert (np.abs(row.impact_velocity.values) > 1e-3).all()
    if row.sizes["impact"] == 0:
        assert_grazes(exciter, row)
        assert row.grazings_per_orbit.values[0 if delta > 0 else 1] == 0.0


@pytest.mark.parametrize("others", [{}, {"k2": 100.0, "R2": 1.0}])
def test_a_soft_support_that_is_grazed(others: dict[str, float]) -> None:
    """A grazing at the end of a step was one again and again, up to the limit on impacts."""
    exciter = exactly_grazing(**{"k1": 1e4, "h1": 10.0, "R1": 1.0, **others})
    row = vp.steady_state(exciter)
    assert int(row.regime) == Regime.NO_IMPACT
    assert row.sizes["impact"] == 0
    assert float(np.abs(row.floquet_multiplier).max()) < 1.0


@pytest.mark.parametrize("off", [-1e-6, -1e-9, -1e-12, -1e-15, 1e-15])
def test_next_to_a_grazing(off: float) -> None:
    """Within rounding of it and below no impact is left; the amplitude is that of the linear motion."""
    row = vp.steady_state(exactly_grazing(f=0.1 * (1.0 + off)))
    assert int(row.regime) == Regime.NO_IMPACT
    assert float(row.displacement_amplitude[0]) == pytest.approx(0.5 * (1.0 + off), rel=1e-13)
    assert float(np.abs(row.floquet_multiplier).max()) < 1.0


@pytest.mark.parametrize("off", [1e-12, 1e-9, 1e-6])
def test_beyond_a_grazing_impacts_are_above_the_threshold(off: float) -> None:
    row = vp.steady_state(exactly_grazing(f=0.1 * (1.0 + off)))
    assert int(row.regime) != Regime.NO_IMPACT or row.period_multiple == 0
    if row.sizes["impact"]:
        assert float(np.abs(row.impact_velocity).min()) > 1e-9 * 0.5


@pytest.mark.parametrize("unit", [1.0, 3.0, 50.0, 1000.0, 1e6])
def test_a_grazing_at_the_section_counts_once(unit: float) -> None:
    """With l = 500 and f = 100 support 2 was grazed twice in an orbit."""
    row = vp.steady_state(exactly_grazing(l=0.5 * unit, f=0.1 * unit))
    assert row.grazings_per_orbit.values.max() == 1.0


def test_rows_of_a_sweep_keep_grazings_out_of_impacts() -> None:
    f = 0.1 * (1.0 + np.array([-1e-3, 0.0, 1e-15]))
    rows = vp.sweep(exactly_grazing(), over={"f": f}, follow=("f", "up"))
    assert (rows.regime == Regime.NO_IMPACT).all()
    assert np.isnan(rows.impact_velocity_max).all()
    assert float(np.abs(rows.floquet_multiplier).max()) < 1.0


def test_a_free_vibration_that_grazes() -> None:
    row = vp.steady_state(vp.Exciter(l=0.5), x0=0.5)
    assert int(row.regime) == Regime.NO_IMPACT
    assert row.grazings_per_orbit.values.tolist() == [1.0, 1.0]
    slower = vp.steady_state(vp.Exciter(l=0.5, delta=-0.1), x0=0.3, v0=math.sqrt(0.16 - 0.09))
    assert slower.grazings_per_orbit.values.tolist() == [1.0, 0.0]
