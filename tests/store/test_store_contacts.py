"""Contacts with soft supports of a sweep in shards and in blocks: on disk they are those in memory, and have units."""

import math

import numpy as np
import pytest
from store_datasets import IDENTITY

import vibropipe as vp
from vibropipe import store
from vibropipe.solve.sweep.blocks import solve_blocks, solve_shard
from vibropipe.solve.sweep.sweep import grid_of
from vibropipe.store.sweep_files import write_grid

EXCITER = vp.Exciter(l=0.5, h=0.1, k1=20.0, h1=0.2, k2=20.0, h2=0.2, friction=0.05)
OVER = {"k1": np.array([20.0, 200.0]), "nu": np.array([0.8, 1.2, 5.0]), "f": np.array([0.01, 0.9])}
OUTPUTS = ("impacts",)
OF_EACH = ("impact_velocity_after", "contact_duration", "contact_force_max", "contact_depth_max")
LARGEST = ("contact_duration_max", "support_force_max", "support_depth_max")


def check_alike(stored, whole):
    for name in (*OF_EACH, *LARGEST, "row_size"):
        assert stored[name].dims == whole[name].dims
        np.testing.assert_array_equal(stored[name].values, whole[name].values)
        assert stored[name].attrs["units"] == whole[name].attrs["units"]


@pytest.mark.parametrize("follow", [None, ("nu", "both")])
def test_contacts_join_like_all_quantities(tmp_path, follow):
    whole = vp.sweep(EXCITER, OVER, outputs=OUTPUTS, follow=follow)
    # The rows of small forces have no impact, and those with impacts lie in several shards.
    assert (whole.row_size == 0).any()
    assert (whole.row_size > 0).any()
    grid, paths = grid_of(EXCITER, OVER, follow), []
    length = max(grid.chain_length, 2)
    for start in range(0, grid.rows, length):
        part = solve_shard(grid, start, start + length, outputs=OUTPUTS)
        paths.append(tmp_path / f"{start}.nc")
        store.write(part.assign_attrs(IDENTITY), paths[-1])
    store.join(paths[::-1], tmp_path / "joined.nc", grid)
    check_alike(store.load(tmp_path / "joined.nc"), whole)


def test_contacts_are_written_block_by_block(tmp_path):
    grid = grid_of(EXCITER, OVER, None)
    blocks = (
        block.assign_attrs(IDENTITY)
        for block in solve_blocks(grid, 0, grid.rows, 5, outputs=OUTPUTS)
    )
    write_grid(blocks, tmp_path / "streamed.nc", grid)
    check_alike(store.load(tmp_path / "streamed.nc"), vp.sweep(EXCITER, OVER, outputs=OUTPUTS))


def test_contacts_have_si_units_and_columns():
    m, C = 2.0, 8000.0
    whole = vp.sweep(EXCITER, OVER, outputs=OUTPUTS)
    physical = vp.to_physical(whole, m, C)
    factors = {
        "contact_duration_max": (math.sqrt(m / C), "s"),
        "support_force_max": (C, "N"),
        "support_depth_max": (1.0, "m"),
        "contact_duration": (math.sqrt(m / C), "s"),
        "contact_force_max": (C, "N"),
        "contact_depth_max": (1.0, "m"),
        "impact_velocity_after": (math.sqrt(C / m), "m s-1"),
    }
    for name, (factor, units) in factors.items():
        assert physical[name].attrs["units"] == units
        np.testing.assert_allclose(physical[name].values, whole[name].values * factor, rtol=1e-14)
    points, impacts = vp.table(physical), vp.table(physical, impacts=True)
    assert points.attrs["units"]["support_force_max_2"] == "N"
    assert {*OF_EACH} <= {*impacts.columns}
    assert len(impacts) == whole.sizes["impact"]
