"""Motions and sweeps with a selection of effects."""

from __future__ import annotations

import tracemalloc
from typing import Any

import numpy as np
import pytest

import vibropipe as vp
from vibropipe.march.grid import exact_grid
from vibropipe.physics.effects import ALL_EFFECTS
from vibropipe.solve.motion.run import MotionRequest, closed_form_solver, run_motion
from vibropipe.solve.sweep.blocks import solve_shard
from vibropipe.solve.sweep.sweep import grid_of
from vibropipe.words.parameters import COMMON_EFFECTS
from vibropipe.words.status import Status

FORCED = {"l": 0.5, "nu": 1.0, "f": -1.0, "h": 0.2, "R1": 0.7, "R2": 0.7}
ALL_BUT_1 = [name for name in COMMON_EFFECTS if name != "support_1"]


@pytest.mark.parametrize(
    "parameters",
    [
        {"l": 2.0, "nu": 1.3, "f": 0.3, "h": 0.1},
        {"l": 2.0, "nu": 1.3, "f": 0.3},
        {"l": 2.0, "nu": 0.3, "f": 0.3, "h": 20.0},
        {"l": 2.0, "nu": 0.7, "f": -0.1, "h": 2.0, "delta": 0.3},
        {"l": 3.0, "nu": 1.0, "f": 0.1, "h": 0.2, "delta": -0.1},
    ],
)
def test_a_motion_that_strikes_nothing_is_not_marched(parameters: dict[str, float]) -> None:
    """Its closed form, transient included, agrees with a march."""
    exciter, request = vp.Exciter(**parameters), MotionRequest(0.7, 50.0, 0.1, 0.2, 16)
    assert closed_form_solver(exciter, request) is not None
    closed = run_motion(exciter, request)
    marched = run_motion(exciter, request, exact_grid(ALL_EFFECTS, exciter.parameters()))
    assert not closed.counts.any()
    assert marched.counts.any()
    np.testing.assert_allclose(closed.displacement, marched.displacement, rtol=0, atol=2e-14)
    np.testing.assert_allclose(closed.velocity, marched.velocity, rtol=0, atol=2e-14)
    assert closed.end == pytest.approx(marched.end, abs=2e-14)
    assert all(column.size == 0 for column in closed.contacts.values())


@pytest.mark.parametrize("nu", [1.0, 1.0 + 1e-12])
def test_a_motion_that_grows_is_marched(nu: float) -> None:
    exciter = vp.Exciter(l=0.5, nu=nu, f=0.1)
    assert closed_form_solver(exciter, MotionRequest(0.0, 60.0, 0.0, 0.0)) is None
    assert vp.simulate(exciter, samples_per_period=0).impact_tau.size > 0


def test_a_motion_that_reaches_a_support_left_out_stops_there() -> None:
    exciter = vp.Exciter(**FORCED)
    whole = vp.simulate(exciter, tau_end=20.0)
    ds = vp.simulate(exciter, tau_end=20.0, effects=ALL_BUT_1)
    assert int(ds.status) == Status.SUPPORT_REACHED
    assert "effects" in Status(int(ds.status)).remedy
    assert ds.attrs["effects"] == ", ".join(ALL_BUT_1)
    first = int(np.flatnonzero(whole.impact_support == 1)[0])
    assert ds.impact_tau.values == pytest.approx(whole.impact_tau.values[: first + 1], abs=1e-12)
    until = float(ds.impact_tau[-1])
    assert np.isfinite(ds.displacement[ds.tau < until]).all()
    assert np.isnan(ds.displacement[ds.tau > until]).all()
    assert np.isnan(float(ds.displacement_end))


def test_what_the_parameters_have_can_not_be_left_out() -> None:
    exciter = vp.Exciter(**FORCED)
    with pytest.raises(
        vp.ParameterError, match=r"must include forcing unless f = 0, got damping, .* with f = 1\.0"
    ):
        vp.simulate(exciter, effects=["damping", "support_1", "support_2", "restitution"])
    with pytest.raises(
        vp.ParameterError, match=r"must include damping unless h = 0, .* with h = 0\.4"
    ):
        vp.sweep(exciter, {"h": [0.0, 0.4]}, effects=list(COMMON_EFFECTS)[1:])


def test_effects_of_a_shard_are_those_of_the_whole_sweep() -> None:
    """Rows without damping in a sweep with damping: as shards of their own they use the same kernel, bit for bit."""
    grid = grid_of(vp.Exciter(**FORCED), {"h": [0.0, 0.1, 0.3]})
    options: dict[str, Any] = {"outputs": ("impacts",)}
    with pytest.raises(vp.ParameterError, match="must include damping"):
        solve_shard(grid, 0, 1, **options, effects=list(COMMON_EFFECTS)[1:])
    whole = solve_shard(grid, 0, 3, **options)
    parts = [solve_shard(grid, row, row + 1, **options) for row in range(3)]
    assert {part.attrs["effects"] for part in parts} == {whole.attrs["effects"]}
    for name in ("displacement_strobe", "velocity_strobe", "residual"):
        joined = np.concatenate([part[name].values for part in parts])
        np.testing.assert_array_equal(whole[name].values, joined)


def test_without_the_output_motion_no_sample_is_held() -> None:
    """Ten thousand periods at 256 samples would be 60 MB."""
    exciter = vp.Exciter(**FORCED)
    vp.simulate(exciter, tau_end=1.0, samples_per_period=0)
    tracemalloc.start()
    ds = vp.simulate(exciter, tau_end=6e4, samples_per_period=0)
    _now, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert ds.impact_tau.size > 10_000
    assert "displacement" not in ds
    assert peak < 6e6
