"""Joined shards: expected values on the grid, the same bytes for any cut, and named faults."""

import netCDF4
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from store_datasets import expected_grid, motion, rows_of_sweep, shard, write_shards

from vibropipe import store
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.store import StoreError, sweep_files
from vibropipe.store.encoding import chunk_shape

DIMS = {"nu": np.linspace(0.3, 3, 7), "f": np.array([0.5, 1.0, 2.0]), "delta": np.array([0, 0.1])}
ROWS = 42
GRID = SweepGrid(DIMS)


def grid_of(dims, follow=None, way="up"):
    return SweepGrid(dims, follow and (follow, way))


def small_blocks(monkeypatch, rows=8, chunk_bytes=64):
    """Make blocks and chunks so small that a small grid has many."""
    monkeypatch.setattr("vibropipe.store.sweep_files.BLOCK_ROWS", rows)
    monkeypatch.setattr("vibropipe.store.sweep_files.CHUNK_BYTES", chunk_bytes)


def joined(folder, values, dims, follow=None, cuts=(), name="joined.nc", way="up", **scalars):
    grid = grid_of(dims, follow, way)
    paths = write_shards(folder / f"shards-{name}", values, list(cuts), grid, **scalars)
    store.join(paths, folder / name, grid)
    return folder / name


def check_joined(dataset, values, dims, follow):
    """Check the joined dataset against values placed row by row."""
    gridded, impacts = expected_grid(values, dims, follow)
    for name, expected in gridded.items():
        assert dataset[name].dims[: len(dims)] == tuple(dims)
        assert dataset[name].dtype == expected.dtype
        np.testing.assert_array_equal(dataset[name].values, expected)
    ends = np.cumsum(dataset["row_size"].values.reshape(-1))
    pieces = np.split(dataset["impact_velocity"].values, ends[:-1])
    for point, piece in zip(np.ndindex(dataset["row_size"].shape), pieces, strict=True):
        np.testing.assert_array_equal(piece, impacts[point])


@pytest.mark.parametrize("follow", [None, "nu", "f", "delta"])
@pytest.mark.parametrize("small", [True, False])
def test_rows_are_placed_on_the_grid(tmp_path, monkeypatch, follow, small):
    if small:
        small_blocks(monkeypatch)
    values = rows_of_sweep(ROWS, phases=5)
    path = joined(tmp_path, values, DIMS, follow, cuts=[5, 6, 20])
    dataset = store.load(path)
    check_joined(dataset, values, DIMS, follow)
    for name, expected in DIMS.items():
        np.testing.assert_array_equal(dataset[name].values, expected)
        assert dataset[name].attrs["units"] == "1"
    assert dataset["h"].item() == 0.2
    assert "h" in dataset.coords
    assert dataset["harmonic"].values.tolist() == [1, 2, 3]
    assert dataset["row_size"].attrs["sample_dimension"] == "impact"
    assert dataset["displacement_mean"].attrs["long_name"] == "mean displacement"


@settings(max_examples=8)
@given(data=st.data())
def test_any_grid_and_cut_gives_expected_values_and_the_same_bytes(tmp_path_factory, data):
    sizes = data.draw(st.lists(st.integers(1, 9), min_size=1, max_size=3))
    dims = {name: np.arange(size) / 7 for name, size in zip(DIMS, sizes, strict=False)}
    follow = data.draw(st.sampled_from([None, *dims]))
    way = data.draw(st.sampled_from(["up", "both"]))
    coords = grid_of(dims, follow, way).coords
    rows = int(np.prod([len(values) for values in coords.values()]))
    cuts = data.draw(st.lists(st.integers(1, max(1, rows - 1)), max_size=6))
    cuts = [cut for cut in cuts if cut < rows]
    values = rows_of_sweep(rows, seed=data.draw(st.integers(0, 99)))
    folder = tmp_path_factory.mktemp("join")
    with pytest.MonkeyPatch.context() as patch:
        small_blocks(patch, data.draw(st.integers(1, 40)), data.draw(st.sampled_from([8, 50, 400])))
        one = joined(folder, values, dims, follow, name="one.nc", way=way)
        many = joined(folder, values, dims, follow, cuts, name="many.nc", way=way)
    assert one.read_bytes() == many.read_bytes()
    check_joined(store.load(many), values, coords, follow)


def test_a_large_grid_with_blocks_of_default_size_and_any_cut(tmp_path):
    dims = {"nu": np.linspace(0.3, 3, 500), "f": np.linspace(0.05, 2, 400)}
    values = rows_of_sweep(200_000)
    one = joined(tmp_path, values, dims, "nu", name="one.nc")
    many = joined(tmp_path, values, dims, "nu", [1, 70_000, 70_001, 131_072], name="many.nc")
    assert one.read_bytes() == many.read_bytes()
    dataset = store.load(many)
    places = np.arange(200_000).reshape(400, 500).T
    np.testing.assert_array_equal(dataset["regime"].values, values["regime"][places])
    np.testing.assert_array_equal(dataset["row_size"].values, values["row_size"][places])
    assert dataset["impact_velocity"].size == values["row_size"].sum()


def test_a_join_reports_progress(tmp_path, monkeypatch):
    monkeypatch.setattr(sweep_files, "BLOCK_ROWS", 7)
    rows, seen = 60, []
    dims = {"nu": np.arange(10.0), "f": np.arange(6.0)}
    paths = write_shards(tmp_path, rows_of_sweep(rows), [20], grid_of(dims))
    store.join(
        paths, tmp_path / "a.nc", grid_of(dims), progress=lambda *counts: seen.append(counts)
    )
    done = [count for count, _ in seen]
    assert len(done) > 5
    assert done == sorted(set(done))
    assert seen[-1] == (rows, rows)


def test_the_order_of_the_shards_does_not_matter(tmp_path):
    values = rows_of_sweep(ROWS)
    paths = write_shards(tmp_path / "shards", values, [10, 20, 30], GRID)
    store.join(paths, tmp_path / "a.nc", GRID)
    store.join([str(path) for path in reversed(paths)], str(tmp_path / "b.nc"), GRID)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_a_sweep_without_impacts_is_joined(tmp_path):
    values = rows_of_sweep(ROWS)
    values["row_size"][:] = 0
    values["impact_velocity"] = np.empty(0)
    values["impact_support"] = np.empty(0, np.int8)
    dataset = store.load(joined(tmp_path, values, DIMS, cuts=[11]))
    assert dataset["impact_velocity"].size == 0


def test_a_sweep_without_the_output_impacts_is_joined(tmp_path):
    values = rows_of_sweep(ROWS)
    dropped = ["row_size", "impact_velocity", "impact_support"]
    paths = [tmp_path / "0.nc", tmp_path / "1.nc"]
    store.save(shard(values, 0, 12, GRID).drop_vars(dropped), paths[0])
    store.save(shard(values, 12, ROWS, GRID).drop_vars(dropped), paths[1])
    store.join(paths, tmp_path / "joined.nc", GRID)
    dataset = store.load(tmp_path / "joined.nc")
    np.testing.assert_array_equal(dataset["regime"].values.reshape(-1), values["regime"])
    assert "impact" not in dataset.dims


def with_other_value(dims, follow, name, point):
    """Return the grid with one value changed in its last bit."""
    values = dims[name].copy()
    values[point] = np.nextafter(values[point], 9)
    return grid_of(dims | {name: values}, follow)


@pytest.mark.parametrize("follow", [None, "nu", "delta"])
@pytest.mark.parametrize(("name", "point"), [("nu", 0), ("nu", 6), ("f", 2), ("delta", 1)])
def test_shards_of_other_swept_values_are_refused(tmp_path, follow, name, point, monkeypatch):
    monkeypatch.setattr("vibropipe.store.shards.ROWS_AT_ONCE", 4)
    grid, other = grid_of(DIMS, follow), with_other_value(DIMS, follow, name, point)
    paths = write_shards(tmp_path / "shards", rows_of_sweep(ROWS), [10, 20], other)
    row = int(
        np.flatnonzero(np.isin(grid.parameters([name], np.arange(ROWS)), DIMS[name][point]))[0]
    )
    path = paths[np.searchsorted([10, 20], row, "right")].name
    held, wanted = float(other.values[name][point]), float(DIMS[name][point])
    told = (
        rf"{path}: {name} of row {row} differs from the study \(must be {wanted!r}, got {held!r}\): "
        "recompute this shard"
    )
    refused(paths, tmp_path, told, grid)
    store.join(paths, tmp_path / "joined.nc", other)


def test_one_shard_of_another_order_of_rows_is_refused(tmp_path):
    values = rows_of_sweep(ROWS)
    paths = write_shards(tmp_path / "shards", values, [10, 20], GRID)
    store.save(shard(values, 10, 20, grid_of(DIMS, "nu")), paths[1])
    refused(paths, tmp_path, r"0010\.nc: nu of row 10 differs from the study \(must be .*, got ")


@pytest.mark.parametrize("values", [{"h": 0.3}, {"h": 0.2, "R1": 0.7}])
def test_shards_of_other_shared_values_are_refused(tmp_path, shards, values):
    """The same holds for shards that lack a parameter but agree with each other."""
    told = {
        1: r"0000\.nc: h of every row differs from the study \(must be 0\.3, got 0\.2\): recompute",
        2: r"0000\.nc: does not hold the R1 of its rows: delete it",
    }
    refused(shards, tmp_path, told[len(values)], SweepGrid(DIMS, shared=values))
    store.join(shards, tmp_path / "joined.nc", SweepGrid(DIMS, shared={"h": 0.2, "l": 0.5}))


def test_shards_without_their_swept_parameters_are_refused(tmp_path):
    paths = write_shards(tmp_path / "shards", rows_of_sweep(ROWS), [])
    refused(paths, tmp_path, r"0000\.nc: does not hold the nu of its rows: delete it")


def test_attributes_are_those_of_the_shards_and_those_given(tmp_path):
    values = rows_of_sweep(ROWS)
    paths = [tmp_path / "0.nc", tmp_path / "1.nc"]
    store.save(shard(values, 0, 12, GRID).assign_attrs(git_commit="b", method="exact"), paths[0])
    store.save(shard(values, 12, ROWS, GRID).assign_attrs(git_commit="a", method="exact"), paths[1])
    store.join(paths, tmp_path / "joined.nc", GRID, attrs={"title": "New", "follow": None})
    attrs = store.load(tmp_path / "joined.nc").attrs
    assert attrs["Conventions"].startswith("CF")
    assert attrs["title"] == "New"
    assert attrs["follow"] == "null"
    assert attrs["method"] == "exact"
    assert attrs["git_commit"] == '["a", "b"]'
    assert "row_start" not in attrs


def test_chunks_are_written_once_and_complete(tmp_path, monkeypatch):
    # a chunk split between blocks would be written twice, and its first copy would waste space in the file
    small_blocks(monkeypatch, rows=1000, chunk_bytes=4096)
    dims = {"nu": np.arange(70) / 70, "f": np.arange(90) / 90}
    random = np.random.default_rng(0)
    values = rows_of_sweep(6300, phases=16)
    values["displacement"] = random.normal(size=(6300, 16))
    path = joined(tmp_path, values, dims, "nu", cuts=[777])
    with netCDF4.Dataset(path) as file:
        assert file["displacement"].chunking() == [8, 1, 16]
        stored = sum(
            variable.size * variable.dtype.itemsize for variable in file.variables.values()
        )
    assert path.stat().st_size < 1.1 * stored


@pytest.fixture
def shards(tmp_path):
    return write_shards(tmp_path / "shards", rows_of_sweep(ROWS), [10, 20, 30], GRID)


def refused(paths, folder, match, grid=GRID):
    with pytest.raises(StoreError, match=match):
        store.join(paths, folder / "joined.nc", grid)
    assert not (folder / "joined.nc").exists()
    assert [item.name for item in folder.iterdir()] == ["shards"]


def test_no_shards(tmp_path):
    with pytest.raises(StoreError, match="no shards"):
        store.join([], tmp_path / "joined.nc", GRID)


@pytest.mark.parametrize(("missing", "rows"), [(0, "0 to 9"), (1, "10 to 19"), (3, "30 to 41")])
def test_missing_rows_are_named(tmp_path, shards, missing, rows):
    del shards[missing]
    refused(shards, tmp_path, f"rows {rows} of 42 are in none of the 3 shards")


def test_rows_held_twice_are_named_with_both_files(tmp_path, shards):
    values = rows_of_sweep(ROWS)
    store.save(shard(values, 15, 20), tmp_path / "shards" / "again.nc")
    again = [*shards, tmp_path / "shards" / "again.nc"]
    refused(again, tmp_path, r"0010\.nc and .*again\.nc: both hold row 15")
    refused([shards[0], *shards], tmp_path, r"0000\.nc and .*0000\.nc: both hold row 0")


def test_rows_beyond_the_grid_are_refused(tmp_path, shards):
    told = "must hold rows up to 11, got rows up to 41"
    refused(shards, tmp_path, told, SweepGrid({"nu": np.arange(12.0)}))


@pytest.mark.parametrize("damage", ["truncated", "damaged", "empty"])
def test_a_damaged_shard_is_named(tmp_path, shards, damage):
    content = bytearray(shards[2].read_bytes())
    if damage == "damaged":
        content[len(content) // 2] ^= 4
    shards[2].write_bytes({"truncated": content[:-1], "empty": b""}.get(damage, content))
    refused(shards, tmp_path, rf"0020\.nc: is {damage}")


def test_a_missing_shard_is_named(tmp_path, shards):
    shards[1].unlink()
    refused(shards, tmp_path, r"0010\.nc: cannot be read: No such file")


def test_a_dataset_other_than_a_shard_is_named(tmp_path, shards):
    store.save(motion(), tmp_path / "shards" / "motion.nc")
    refused([*shards, tmp_path / "shards" / "motion.nc"], tmp_path, r"motion\.nc: is no shard")


def test_a_shard_with_a_wrong_row_range_is_named(tmp_path, shards):
    wrong = shard(rows_of_sweep(ROWS), 20, 30, GRID).assign_attrs(row_stop=31)
    store.save(wrong, shards[2])
    refused(shards, tmp_path, r"0020\.nc: must hold rows 20 to 30, got 10 rows")


def test_counts_that_do_not_add_up_are_named(tmp_path, shards):
    wrong = shard(rows_of_sweep(ROWS), 20, 30, GRID)
    wrong["row_size"][0] += 1
    store.save(wrong, shards[2])
    refused(shards, tmp_path, r"0020\.nc: must hold as many 'impact' as row_size counts, got \d+")


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda ds: ds.assign_attrs(kernel_hash="f"), "kernel_hash differs"),
        (lambda ds: ds.assign_attrs(fingerprint="f"), "fingerprint differs"),
        (lambda ds: ds.drop_vars("stable"), "only one holds stable"),
        (lambda ds: ds.assign_coords(h=0.3), "values of h differ"),
        (lambda ds: ds.isel(harmonic=[0, 1]), "size of displacement_amplitude differs|harmonic"),
        (
            lambda ds: ds.assign(status=ds.status.astype("i4")),
            "dimensions or type of status differ",
        ),
    ],
)
def test_shards_of_two_sweeps_are_not_joined(tmp_path, shards, change, match):
    store.save(change(shard(rows_of_sweep(ROWS), 20, 30, GRID)), shards[2])
    refused(
        shards,
        tmp_path,
        rf"0000\.nc and .*0020\.nc belong to different sweeps \(.*({match}).*\): recompute",
    )


def test_shards_of_another_fingerprint_than_the_study_s_are_not_joined(tmp_path, shards):
    with pytest.raises(StoreError, match=r"0000\.nc: is a shard of another study, or of this one"):
        store.join(shards, tmp_path / "joined.nc", GRID, {"fingerprint": "other"})
    assert not (tmp_path / "joined.nc").exists()


def test_a_failed_join_keeps_the_previous_file(tmp_path, shards, monkeypatch):
    store.join(shards, tmp_path / "joined.nc", GRID)
    before = (tmp_path / "joined.nc").read_bytes()

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("vibropipe.store.sweep_files._Writer.finish", fail)
    with pytest.raises(StoreError, match=r"joined\.nc: was not written: the disk is full"):
        store.join(shards, tmp_path / "joined.nc", GRID)
    assert (tmp_path / "joined.nc").read_bytes() == before
    assert sorted(item.name for item in tmp_path.iterdir()) == ["joined.nc", "shards"]


@given(
    sizes=st.lists(st.integers(1, 9), min_size=1, max_size=4),
    follow=st.integers(0, 4),
    way=st.sampled_from(["up", "both"]),
    block_elements=st.integers(1, 200),
    chunk_elements=st.integers(1, 200),
)
def test_blocks_of_a_grid_are_its_rows_in_order_and_contain_whole_chunks(
    sizes, follow, way, block_elements, chunk_elements
):
    names = list("abcd")[: len(sizes)]
    dims = {name: np.arange(size) for name, size in zip(names, sizes, strict=True)}
    grid = grid_of(dims, names[follow] if follow < len(names) else None, way)
    chunk_elements = min(block_elements, chunk_elements)
    stop_of_previous = 0
    rows = np.arange(grid.rows)
    filled = np.full(grid.shape, -1)
    chunks = grid.in_grid_order(chunk_shape(grid.row_shape, chunk_elements))
    for block in grid.blocks(chunk_shape(grid.row_shape, block_elements)):
        assert block.start == stop_of_previous
        assert block.stop - block.start <= block_elements
        stop_of_previous = block.stop
        filled[block.where] = grid.to_box(block, rows[block.start : block.stop])
        for box, chunk, size in zip(block.where, chunks, grid.shape, strict=True):
            assert box.start % chunk == 0
            assert box.stop % chunk == 0 or box.stop == size
    assert stop_of_previous == grid.rows
    start, stop = sorted((chunk_elements % (grid.rows + 1), block_elements % (grid.rows + 1)))
    np.testing.assert_array_equal(filled.ravel()[grid.points(start, stop)], rows[start:stop])
    np.testing.assert_array_equal(filled.ravel(), grid.rows_of_points(0, grid.rows))
