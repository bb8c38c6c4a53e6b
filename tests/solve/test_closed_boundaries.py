"""Where orbits in closed form begin, end and lose their stability: against orbits on both sides of the place."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import vibropipe as vp

TWO_SIDED = vp.Exciter(l=0.5, nu=1.6, f=1.0, h=0.1, R1=0.7, R2=0.7)
ONE_SIDED = vp.Exciter(l=0.5, delta=-0.2, nu=1.2, f=0.2, h=0.1, R1=0.8, R2=0.6)
# Its one-sided orbit doubles its period at nu = 2.66.
NEAR_FLIP = vp.Exciter(l=50.0, delta=-50.0, nu=2.5, f=1.0, h=0.1, R1=0.8, R2=0.8)


def test_the_second_solution_is_a_saddle_that_meets_the_first_at_the_fold() -> None:
    for orbits, boundaries, e in (
        (vp.symmetric_orbit, vp.symmetric_orbit_boundaries, dataclasses.replace(TWO_SIDED, nu=1.3)),
        (vp.one_sided_orbit, vp.one_sided_orbit_boundaries, ONE_SIDED),
    ):
        limits = boundaries(e, e.nu).isel(nu=0)
        fold, first = limits.fold_f.item(), limits.first_impact_f.item()
        assert limits.fold_admissible == 1
        between = orbits(dataclasses.replace(e, f=0.5 * (fold + first)))
        assert between.fold_condition.values[0] > 0 > between.fold_condition.values[1]
        assert between.floquet_multiplier.values[1, 0].real > 1
        assert between.admissible.values.tolist() == [1, 1]
        assert between.stable.values.tolist() == [1, 0]
        below, at = (orbits(dataclasses.replace(e, f=fold * s)) for s in (1 - 1e-9, 1 + 1e-12))
        assert np.isnan(below.impact_velocity).all()
        assert below.admissible.values.tolist() == [0, 0]
        np.testing.assert_allclose(abs(at.impact_velocity), limits.fold_velocity, rtol=1e-5)
        assert at.floquet_multiplier.values[0, 0] == pytest.approx(1, abs=1e-4)
        beyond = orbits(dataclasses.replace(e, f=first * (1 + 1e-9)))
        assert np.isfinite(beyond.impact_velocity.values[:, 0]).tolist() == [True, False]


def root(function: Any, low: float, high: float) -> float:
    """Return a zero by bisection."""
    sign = function(low) > 0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if (function(middle) > 0) == sign else (low, middle)
    return 0.5 * (low + high)


@pytest.mark.parametrize(("low", "high", "stable_side"), [(1.03, 1.06, -1), (1.4, 1.7, 1)])
def test_a_pitchfork_is_where_the_symmetry_breaks(
    low: float, high: float, stable_side: int
) -> None:
    e = vp.Exciter(l=0.5, nu=1.5, f=1.0, h=0.1, R1=0.8, R2=0.8)

    def excess(nu: float) -> float:
        return vp.symmetric_orbit_boundaries(e, nu).pitchfork_f.item() - e.f

    nu = root(excess, low, high)
    at = vp.symmetric_orbit(dataclasses.replace(e, nu=nu)).isel(solution=0)
    assert at.admissible == 1
    assert at.floquet_multiplier.values[0] == pytest.approx(1, abs=1e-10)
    for side, symmetric in ((-stable_side, False), (stable_side, True)):
        near = dataclasses.replace(e, nu=nu + 1e-3 * side)
        orbit = vp.symmetric_orbit(near).isel(solution=0)
        assert (orbit.pitchfork_condition > 0) == (orbit.stable == 1) == symmetric
        # beside the unstable symmetric orbit a motion settles on another one, or on none
        x0, v0 = orbit.displacement_strobe.item(), orbit.velocity_strobe.item() + 1e-3
        settled = vp.steady_state(near, x0, v0)
        returns = settled.period_multiple.item() == 1
        speeds = abs(settled.impact_velocity.values)
        assert (returns and abs(speeds[0] - speeds[-1]) < 1e-9) == symmetric


def test_the_flip_is_where_the_period_doubles() -> None:
    e = NEAR_FLIP

    def condition(nu: float) -> float:
        return vp.one_sided_orbit(dataclasses.replace(e, nu=nu)).flip_condition.values[0]

    nu = root(condition, 2.5, 2.7)
    for side, multiple in ((-1e-2, 1), (1e-2, 2)):
        near = dataclasses.replace(e, nu=nu + side)
        assert vp.steady_state(near).period_multiple == multiple
        assert vp.one_sided_orbit(near).stable.values[0] == (multiple == 1)
    # without an offset, b = 0, nothing depends on the force; else the boundary names it
    offset = vp.Exciter(l=0.5, delta=-0.2, nu=0.8, h=0.1, R1=0.8, R2=0.8)
    limits = vp.one_sided_orbit_boundaries(offset, 0.8).isel(nu=0)
    at = vp.one_sided_orbit(dataclasses.replace(offset, f=limits.flip_f.item())).isel(solution=0)
    assert limits.flip_admissible == at.admissible == 1
    assert at.impact_velocity.values[0] == pytest.approx(limits.flip_velocity.item(), rel=1e-10)
    assert abs(at.floquet_multiplier.values + 1).min() < 1e-10


def test_a_grazing_of_the_flight_changes_the_sign_of_the_clearance() -> None:
    e = dataclasses.replace(ONE_SIDED, delta=-0.2)

    def clearance(f: float) -> float:
        return vp.one_sided_orbit(dataclasses.replace(e, f=f)).clearance.values[0]

    f = root(clearance, 0.1, 1.0)
    inside, outside = (
        vp.one_sided_orbit(dataclasses.replace(e, f=f * s)) for s in (1 - 1e-6, 1 + 1e-6)
    )
    assert inside.admissible.values[0] == 1
    assert outside.admissible.values[0] == 0
    assert inside.clearance.values[0] > 0 > outside.clearance.values[0]
    assert np.isnan(outside.displacement_strobe.values[0])
