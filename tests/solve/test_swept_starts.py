"""Starts that are swept like parameters."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.solve.sweep.blocks import assemble, solve_shard
from vibropipe.solve.sweep.sweep import grid_of

GIVEN = {"l": 0.5, "h": 0.1, "f": 0.7, "R1": 0.8, "R2": 0.8}
X0, V0 = np.array([-0.4, 0.0, 0.6]), np.array([-0.9, 0.0, 1.3, 0.4])
EXCITER = vp.Exciter(nu=3.48, delta=0.1, **GIVEN)


def test_each_row_is_the_steady_state_from_its_start() -> None:
    """Also from a support, where a start is at rest or in flight."""
    rows = vp.sweep(EXCITER, {"v0": V0, "x0": X0}, outputs=("harmonics", "stability"))
    assert rows.regime.dims == ("v0", "x0")
    assert rows.attrs["start"] == "x0 swept, v0 swept"
    assert len(np.unique(rows.period_multiple)) > 1
    for v0 in V0:
        for x0 in X0:
            alone = vp.sweep(
                EXCITER, {"nu": [3.48]}, x0=x0, v0=v0, outputs=("harmonics", "stability")
            ).isel(nu=0)
            row = rows.sel(x0=x0, v0=v0)
            for name in alone.data_vars:
                np.testing.assert_array_equal(row[name], alone[name], err_msg=f"{name} {x0} {v0}")


def test_starts_and_parameters_are_swept_together_in_any_cuts() -> None:
    exciter, over = vp.Exciter(**GIVEN), {"x0": [-0.2, 0.3], "nu": np.linspace(1, 3, 5)}
    whole = vp.sweep(exciter, over, v0=0.2)
    assert whole.attrs["start"] == "x0 swept, v0 = 0.2"
    for x0 in over["x0"]:
        alone = vp.sweep(exciter, {"nu": over["nu"]}, x0=x0, v0=0.2)
        for name in ("regime", "displacement_strobe", "displacement_amplitude"):
            np.testing.assert_array_equal(whole[name].sel(x0=x0), alone[name])
    grid = grid_of(exciter, over)
    shards = [solve_shard(grid, a, b, start=(None, 0.2)) for a, b in ((3, 10), (0, 3))]
    xr.testing.assert_identical(assemble(shards, grid), whole)


@pytest.mark.slow  # compiles kernels of its own
def test_a_start_off_the_supports_needs_its_effects() -> None:
    """The bound of all motions holds for the farthest start."""
    with pytest.raises(vp.ParameterError, match="must include forcing"):
        vp.sweep(EXCITER, {"x0": [0.0]}, effects=["damping"])
    rows = vp.sweep(
        vp.Exciter(l=0.5, h=0.1), {"v0": [0.0, 2.0]}, effects=["damping"], outputs=("stability",)
    )
    names = rows.status.attrs["flag_meanings"].split()
    assert [names[code] for code in rows.status.values] == ["ok", "support_reached"]


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"x0": 0.1, "over": {"x0": [0.0, 0.1]}}, "x0: must be left out, since x0 is swept"),
        ({"v0": 0.0, "over": {"v0": [0.0, 0.1]}}, "v0: must be left out, since v0 is swept"),
        ({"over": {"x0": [0.0, 0.7]}}, r"x0: must be a finite number from -0.4 to 0.6"),
        ({"over": {"x0": [-0.3], "delta": [0.0, 0.3]}}, r"x0: must be a finite number from -0.2"),
        ({"over": {"v0": [np.inf]}}, "over.v0: must be a non-empty list of finite numbers"),
        (
            {"over": {"x0": [0.0], "nu": [1.0, 2.0]}, "follow": ("nu", "up")},
            "follow: must be left out when x0 is swept, since a followed row starts from its",
        ),
    ],
)  # fmt: skip
def test_starts_that_are_refused(given: dict[str, object], message: str) -> None:
    with pytest.raises(vp.ParameterError, match=message):
        vp.sweep(EXCITER, **given)


def test_starts_in_si_are_lengths_and_velocities() -> None:
    rows = vp.to_physical(
        vp.sweep(EXCITER, {"x0": X0, "v0": V0 / 20}, outputs=("lyapunov",)), 2, 800
    )
    np.testing.assert_array_equal(rows.x0, X0)
    np.testing.assert_array_equal(rows.v0, V0)
    assert (rows.x0.attrs["units"], rows.v0.attrs["units"]) == ("m", "m s-1")
    one = vp.to_physical(vp.sweep(EXCITER, {"x0": X0}, v0=0.1, outputs=("stability",)), 2, 800)
    assert one.attrs["start"] == "x0 swept, v0 = 2 m/s"
