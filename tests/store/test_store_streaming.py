"""Rows written as they are solved, in shards or blocks: the same file as written at once, with all outputs."""

import math
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from store_datasets import IDENTITY, rows_of_sweep, shard, write_shards

import vibropipe as vp
from vibropipe import store
from vibropipe.physics.derivatives import DIFFERENTIATED
from vibropipe.solve.sweep.blocks import solve_blocks, solve_shard
from vibropipe.solve.sweep.sweep import grid_of
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.store import encoding, sweep_files

ROWS = 60
DIMS = {"nu": np.linspace(0.3, 3, 10), "f": np.linspace(0.1, 2, 6)}
VALUES = rows_of_sweep(ROWS, phases=16)
GRID = SweepGrid(DIMS)


def blocks(
    size: int, start: int = 0, stop: int = ROWS, values: dict = VALUES, grid: SweepGrid = GRID
) -> list[xr.Dataset]:
    ends = [*range(start, stop, size), stop]
    return [shard(values, first, last, grid) for first, last in pairwise(ends)]


def write_rows(datasets: Iterable[xr.Dataset], path: Path) -> None:
    store.write_rows(datasets, path, ROWS)


def write_grid(datasets: Iterable[xr.Dataset], path: Path) -> None:
    store.write_grid(datasets, path, GRID)


@pytest.fixture(params=[encoding.CHUNK_BYTES, 64], ids=["usual chunks", "tiny chunks"])
def chunks(request, monkeypatch):
    monkeypatch.setattr(encoding, "CHUNK_BYTES", request.param)
    monkeypatch.setattr(sweep_files, "CHUNK_BYTES", request.param)


@pytest.mark.parametrize("size", [1, 7, 20, ROWS])
@pytest.mark.parametrize("start", [0, 20])
def test_blocks_of_any_size_give_the_rows_written_at_once(tmp_path, chunks, start, size):
    store.write_rows(blocks(size, start), tmp_path / "a.nc", ROWS - start)
    assert [path.name for path in tmp_path.iterdir()] == ["a.nc"]
    store.save(shard(VALUES, start, ROWS, GRID), tmp_path / "b.nc")
    xr.testing.assert_identical(store.load(tmp_path / "a.nc"), store.load(tmp_path / "b.nc"))


@pytest.mark.parametrize("follow", [None, "nu"])
@pytest.mark.parametrize("size", [6, 25, ROWS])
def test_a_grid_is_bitwise_that_of_joined_shards(tmp_path, chunks, follow, size):
    grid = SweepGrid(DIMS, follow and (follow, "up"))
    store.join(write_shards(tmp_path, VALUES, [20, 50], grid), tmp_path / "joined.nc", grid)
    before = set(tmp_path.iterdir())
    store.write_grid(blocks(size, grid=grid), tmp_path / "grid.nc", grid)
    assert set(tmp_path.iterdir()) - before == {tmp_path / "grid.nc"}
    assert (tmp_path / "grid.nc").read_bytes() == (tmp_path / "joined.nc").read_bytes()


def test_rows_written_in_blocks_can_be_joined(tmp_path, chunks):
    store.write_rows(blocks(7, 0, 30), tmp_path / "1.nc", 30)
    store.write_rows(blocks(9, 30), tmp_path / "2.nc", 30)
    store.join([tmp_path / "1.nc", tmp_path / "2.nc"], tmp_path / "a.nc", GRID)
    store.write_grid(blocks(ROWS), tmp_path / "b.nc", GRID)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_rows_without_impacts_are_written(tmp_path):
    quiet = {name: values for name, values in VALUES.items() if not name.startswith("impact_")}
    quiet["row_size"] = np.zeros(ROWS, np.int32)
    quiet["impact_velocity"] = np.empty(0)
    store.write_rows(blocks(25, values=quiet), tmp_path / "a.nc", ROWS)
    store.save(shard(quiet, 0, ROWS, GRID), tmp_path / "b.nc")
    xr.testing.assert_identical(store.load(tmp_path / "a.nc"), store.load(tmp_path / "b.nc"))


def test_a_block_is_written_before_the_next_one_is_requested(tmp_path, monkeypatch):
    monkeypatch.setattr(sweep_files, "BLOCK_BYTES", 20 * 4096 * 8)
    rows, sizes = rows_of_sweep(ROWS, phases=4096), []

    def watched():
        for block in blocks(20, values=rows):
            sizes.append(sum(path.stat().st_size for path in tmp_path.iterdir()))
            yield block

    store.write_rows(watched(), tmp_path / "a.nc", ROWS)
    block = 20 * 4096 * 8
    assert sizes[0] < block < sizes[1]
    assert sizes[2] > 2 * block


@pytest.mark.parametrize("write", [write_rows, write_grid])
@pytest.mark.parametrize(
    ("given", "told"),
    [
        (blocks(20)[:2], "40 rows came, 60 were expected"),
        ([*blocks(20), *blocks(20)], "block of row 0: row 60 is next"),
        (blocks(20)[::2], "block of row 40: row 20 is next"),
        ([], "0 rows came"),
    ],
    ids=["too few", "too many", "a gap", "none"],
)
def test_rows_that_do_not_follow_each_other_leave_what_was_there(tmp_path, write, given, told):
    path = tmp_path / "a.nc"
    path.write_bytes(b"old")
    with pytest.raises(ValueError, match=told):
        write(given, path)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("write", [write_rows, write_grid])
@pytest.mark.parametrize("error", [KeyboardInterrupt, MemoryError])
def test_an_error_between_blocks_leaves_nothing(tmp_path, write, error):
    def broken():
        yield blocks(20)[0]
        raise error

    for path in (tmp_path / "a.nc", tmp_path / "new" / "newer" / "a.nc"):
        with pytest.raises(error):
            write(broken(), path)
        assert list(tmp_path.iterdir()) == []


SOFT = vp.Exciter(l=0.5, h=0.1, k1=20.0, h1=0.2, k2=20.0, h2=0.2, friction=0.05)
OVER_SOFT = {
    "k1": np.array([20.0, 200.0]),
    "nu": np.array([0.8, 1.2, 5.0]),
    "f": np.array([0.01, 0.9]),
}
IMPACTS = ("impacts",)
OF_EACH = ("impact_velocity_after", "contact_duration", "contact_force_max", "contact_depth_max")
LARGEST = ("contact_duration_max", "support_force_max", "support_depth_max")
CONTACTS = (*OF_EACH, *LARGEST, "row_size")


def check_alike(stored, whole, names):
    for name in names:
        assert stored[name].dims == whole[name].dims
        np.testing.assert_array_equal(stored[name].values, whole[name].values)
        assert stored[name].attrs["units"] == whole[name].attrs["units"]


def whole_and_joined(folder, exciter, over, outputs, follow):
    """Return a sweep that is solved at once, and one in shards."""
    grid, paths = grid_of(exciter, over, follow), []
    length = max(grid.chain_length, 2)
    for start in range(0, grid.rows, length):
        part = solve_shard(grid, start, start + length, outputs=outputs)
        paths.append(folder / f"{start}.nc")
        store.save(part.assign_attrs(IDENTITY), paths[-1])
    store.join(paths[::-1], folder / "joined.nc", grid)
    whole = vp.sweep(exciter, over, outputs=outputs, follow=follow)
    return whole, store.load(folder / "joined.nc")


@pytest.mark.parametrize("follow", [None, ("nu", "both")])
def test_contacts_join_like_all_quantities(tmp_path, follow):
    whole, joined = whole_and_joined(tmp_path, SOFT, OVER_SOFT, IMPACTS, follow)
    # The rows of small forces have no impact, and those with impacts lie in several shards.
    assert (whole.row_size == 0).any()
    assert (whole.row_size > 0).any()
    check_alike(joined, whole, CONTACTS)


@pytest.mark.parametrize("follow", [None, ("nu", "up")])
def test_sensitivities_join_like_all_quantities(tmp_path, follow):
    rigid = vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7)
    over = {"nu": np.array([0.4, 0.9, 1.3]), "f": np.array([0.3, 1.0])}
    outputs = ("harmonics", "impacts", "sensitivity")
    whole, joined = whole_and_joined(tmp_path, rigid, over, outputs, follow)
    assert joined.parameter.values.tolist() == list(DIFFERENTIATED)
    names = [name for name in whole.data_vars if name.endswith("_sensitivity")]
    assert "impact_phase_sensitivity" in names
    check_alike(joined, whole, names)


def test_contacts_are_written_block_by_block(tmp_path):
    grid = grid_of(SOFT, OVER_SOFT, None)
    blocks = (
        block.assign_attrs(IDENTITY)
        for block in solve_blocks(grid, range(grid.rows), 5, outputs=IMPACTS)
    )
    store.write_grid(blocks, tmp_path / "streamed.nc", grid)
    whole = vp.sweep(SOFT, OVER_SOFT, outputs=IMPACTS)
    check_alike(store.load(tmp_path / "streamed.nc"), whole, CONTACTS)


def test_contacts_have_si_units_and_columns():
    m, C = 2.0, 8000.0
    whole = vp.sweep(SOFT, OVER_SOFT, outputs=IMPACTS)
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
