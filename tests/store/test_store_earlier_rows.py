"""Rows of an earlier file among solved ones: the same bytes as if all were solved, and damage is found."""

from itertools import pairwise

import numpy as np
import pytest
from store_datasets import rows_of_sweep, shard

from vibropipe import store
from vibropipe.solve.rows.label import ragged_indices
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.store import EarlierRows, NotTakenError, earlier_rows
from vibropipe.store.encoding import encode
from vibropipe.words.vocabulary import describe

WHOLE = {
    "f": np.linspace(0.1, 2, 4),
    "delta": np.linspace(0, 0.2, 3),
    "nu": np.linspace(0.3, 3, 11),
}
GRID = SweepGrid(WHOLE)
VALUES = rows_of_sweep(GRID.rows, phases=3)
EARLIER = {
    "all": {},
    "every other": {"nu": slice(None, None, 2)},
    "a corner": {"f": slice(2), "delta": slice(1, None), "nu": slice(3, 7)},
    "one value": {"f": slice(3, 4), "delta": slice(2, 3)},
}


def chosen(rows: np.ndarray) -> dict[str, np.ndarray]:
    """Return some rows of all."""
    samples = ragged_indices(VALUES["row_size"], rows)
    return {n: v[samples if n.startswith("impact_") else rows] for n, v in VALUES.items()}


def earlier_file(path, part: dict[str, slice]) -> SweepGrid:
    """Write the file of a part of the grid, and return its grid."""
    old = SweepGrid({name: values[part.get(name, slice(None))] for name, values in WHOLE.items()})
    store.write_grid([shard(chosen(old.rows_in(GRID, 0, old.rows)), 0, old.rows, old)], path, old)
    return old


def grown(path, old: SweepGrid, start: int, stop: int, solved: int, size: int):
    """Yield the rows [start, stop), those that are not in the earlier file from blocks of `solved` rows."""
    rows = GRID.rows_in(old, start, stop)
    if rows.min() >= 0:
        rows[0] = -1
    new = start + np.flatnonzero(rows < 0)
    values = chosen(new)
    ends = [*range(0, len(new), solved), len(new)]
    parameters = GRID.parameters([*WHOLE], new)

    def block(first: int, last: int):
        swept = zip(WHOLE, parameters[first:last].T, strict=True)
        rows = shard(values, first, last).assign_coords({n: ("row", column) for n, column in swept})
        return encode(describe(rows))

    blocks = (block(*each) for each in pairwise(ends))
    return EarlierRows(path, old.shape, rows).merge(blocks, GRID, start, size)


@pytest.mark.parametrize("part", EARLIER.values(), ids=EARLIER)
@pytest.mark.parametrize(("solved", "size", "gap"), [(5, 7, 0), (1, 50, 3), (200, 200, 64)])
def test_the_file_is_that_of_rows_that_are_all_solved(
    tmp_path, monkeypatch, part, solved, size, gap
):
    monkeypatch.setattr(earlier_rows, "MAX_GAP", gap)
    old = earlier_file(tmp_path / "old.nc", part)
    store.write_grid([shard(VALUES, 0, GRID.rows, GRID)], tmp_path / "all.nc", GRID)
    store.write_grid(
        grown(tmp_path / "old.nc", old, 0, GRID.rows, solved, size), tmp_path / "a.nc", GRID
    )
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "all.nc").read_bytes()
    first, stop = 20, 101
    store.write_rows([shard(VALUES, first, stop, GRID)], tmp_path / "shard.nc", stop - first)
    rows = grown(tmp_path / "old.nc", old, first, stop, solved, size)
    store.write_rows(rows, tmp_path / "b.nc", stop - first)
    assert (tmp_path / "b.nc").read_bytes() == (tmp_path / "shard.nc").read_bytes()


def test_little_of_a_large_file_is_read_at_once(tmp_path, monkeypatch):
    """Of a file with four times as many rows as are taken."""
    earlier_file(tmp_path / "old.nc", {})
    spans, read = [], earlier_rows._Earlier._consecutive

    def watched(self, start, stop):
        spans.append((start, stop))
        return read(self, start, stop)

    monkeypatch.setattr(earlier_rows._Earlier, "_consecutive", watched)
    taken = np.arange(0, GRID.rows, 4)
    coarse = SweepGrid({"nu": taken / 7})
    rows = EarlierRows(tmp_path / "old.nc", GRID.shape, np.where(taken == 0, -1, taken))
    solved = iter([encode(shard(VALUES, 0, 1, coarse))])
    items = [{i.name: i.values for i in block} for block, _ in rows.merge(solved, coarse, 0, 10)]
    assert len(spans) > len(items)
    assert max(stop - start for start, stop in spans) <= 10
    means = np.concatenate([values["displacement_mean"] for values in items])
    np.testing.assert_array_equal(means, VALUES["displacement_mean"][taken])
    velocities = np.concatenate([values["impact_velocity"] for values in items])
    np.testing.assert_array_equal(velocities, chosen(taken)["impact_velocity"])


def test_a_damaged_chunk_is_found_and_nothing_is_written(tmp_path):
    path = tmp_path / "old.nc"
    old = earlier_file(path, {"nu": slice(None, None, 2)})
    content = bytearray(path.read_bytes())
    mean = chosen(old.rows_in(GRID, 0, old.rows))["displacement_mean"]
    place = content.index(mean[20:24].tobytes())
    content[place] ^= 1
    path.write_bytes(content)
    with pytest.raises(NotTakenError, match=r"old\.nc: cannot be read"):
        store.write_grid(grown(path, old, 0, GRID.rows, 5, 7), tmp_path / "a.nc", GRID)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["displacement_amplitude", "impact_velocity", "h"])
def test_variables_that_are_stored_otherwise_are_not_taken(tmp_path, name):
    path = tmp_path / "old.nc"
    part = {"nu": slice(None, None, 2)}
    old = earlier_file(path, part)
    rows = shard(chosen(old.rows_in(GRID, 0, old.rows)), 0, old.rows, old)
    other = {
        "displacement_amplitude": lambda: rows.isel(harmonic=slice(2)),
        "impact_velocity": lambda: rows.drop_vars("impact_velocity"),
        "h": lambda: rows.assign_coords(h=0.3),
    }[name]()
    store.write_grid([other], path, old)
    with pytest.raises(NotTakenError, match=r"old\.nc"):
        list(grown(path, old, 0, GRID.rows, 5, 7))
