"""The grid of a sweep: one position for each row, cuts between chains; starts are swept like parameters."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
import xarray as xr
from command_line import printed
from hypothesis import given
from hypothesis import strategies as st

import vibropipe as vp
from vibropipe.solve.sweep.blocks import assemble, solve_shard
from vibropipe.solve.sweep.sweep import grid_of
from vibropipe.solve.sweep.sweep_grid import SweepGrid
from vibropipe.solve.threads import row_blocks


@st.composite
def grids(draw: st.DrawFn) -> SweepGrid:
    names = draw(st.permutations(["nu", "f", "delta", "R1"]))[: draw(st.integers(1, 4))]
    values = {
        name: draw(st.lists(st.integers(-9, 9), min_size=1, max_size=5, unique=True))
        for name in names
    }
    along = draw(st.sampled_from([None, *names]))
    follow = None if along is None else (along, draw(st.sampled_from(["up", "down", "both"])))
    arrays = {name: np.array(items, float) for name, items in values.items()}
    return SweepGrid(arrays, follow, {"l": 0.5})


def grid_by_loops(grid: SweepGrid) -> tuple[list[dict[str, Any]], list[int]]:
    """Return the coordinates of each row, and the rows in the order in which they are solved, by plain loops."""
    along, directions = grid.follow or (None, "up")
    others = [name for name in grid.values if name != along]
    rows, solved_rows = [], []
    ways = ["up", "down"] if directions == "both" else [directions]
    for direction, *point in itertools.product(ways, *(grid.values[name] for name in others)):
        fixed = dict(zip(others, point, strict=True)) | {"l": 0.5, "direction": direction}
        chain = [{along: value} for value in grid.values[along]] if along else [{}]
        positions = sorted(range(len(chain)), key=lambda k: chain[k].get(along, 0))
        solved_rows += [
            len(rows) + k for k in (positions if direction == "up" else positions[::-1])
        ]
        rows += [fixed | followed for followed in chain]
    return rows, solved_rows


@given(grid=grids())
def test_rows_and_their_order_are_those_of_plain_loops(grid: SweepGrid) -> None:
    rows, solved_rows = grid_by_loops(grid)
    names = [*grid.values, "l"]
    numbers = np.arange(grid.rows)
    expected = np.array([[row[name] for name in names] for row in rows])
    np.testing.assert_array_equal(grid.parameters(names, numbers), expected)
    np.testing.assert_array_equal(grid.solved(0, grid.rows), solved_rows)
    for row in numbers:
        indices = grid.indices(int(row))
        assert [grid.coords[n][k] for n, k in zip(grid.dims, indices, strict=True)] == [
            rows[row][n] for n in grid.dims
        ]
        assert np.ravel_multi_index(indices, grid.shape) == grid.points(row, row + 1)[0]
        assert grid.rows_of_points(*(grid.points(row, row + 1)[0] + [0, 1])) == row
        assert grid.text(int(row)) == ", ".join(f"{n} = {rows[row][n]}" for n in grid.dims)


@given(grid=grids(), other=st.data())
def test_rows_of_another_grid_are_those_with_equal_values(
    grid: SweepGrid, other: st.DataObject
) -> None:
    grid, ways = SweepGrid(grid.values), [-9.0, 9.5, *range(-8, 9)]
    lists = {
        n: other.draw(st.lists(st.sampled_from(ways), min_size=1, unique=True)) for n in grid.values
    }
    old = SweepGrid({name: np.array(sorted(values), float) for name, values in lists.items()})
    held = {tuple(v): row for row, v in enumerate(old.parameters([*lists], np.arange(old.rows)))}
    expected = [held.get(tuple(v), -1) for v in grid.parameters([*lists], np.arange(grid.rows))]
    assert grid.rows_in(old, 0, grid.rows).tolist() == expected
    assert grid.rows_in(old, grid.rows // 2, grid.rows).tolist() == expected[grid.rows // 2 :]


def test_values_of_another_grid_are_equal_to_the_last_bit() -> None:
    grid = SweepGrid({"delta": np.array([0.0, 0.1, 0.3])})
    old = SweepGrid({"delta": np.array([-0.0, np.nextafter(0.1, 1), 0.3])})
    assert grid.rows_in(old, 0, 3).tolist() == [-1, -1, 2]


@given(grid=grids(), shards=st.integers(1, 30))
def test_cuts_are_whole_chains_of_about_one_length(grid: SweepGrid, shards: int) -> None:
    shards = min(shards, grid.chains)
    ends = grid.cuts(shards)
    assert (ends[0], ends[-1], len(ends)) == (0, grid.rows, shards + 1)
    sizes = np.diff(ends) // grid.chain_length
    assert sizes.max() - sizes.min() <= 1
    for start, stop in itertools.pairwise(ends):
        assert sorted(grid.solved(start, stop)) == list(range(start, stop))


@pytest.mark.parametrize("rows", [1, 500, 5000])
@pytest.mark.parametrize("chain", [1, 7, 700])
@pytest.mark.parametrize("block_rows", [1, 300, 10**6])
def test_blocks_have_the_rows_wanted(rows: int, chain: int, block_rows: int) -> None:
    rows *= chain
    blocks = row_blocks(rows, chain, block_rows)
    ends = [block[-1][-1] for block in blocks]
    begins = [block[0][0] for block in blocks]
    assert [0, *ends[:-1]] == begins
    assert ends[-1] == rows
    assert all(
        stop - first >= block_rows for first, stop in zip(begins[:-1], ends[:-1], strict=True)
    )
    assert all(end % chain == 0 for end in ends)


def test_the_values_of_a_grid_stay_as_they_were_given() -> None:
    values = np.array([1.0, 2.0])
    grid = SweepGrid({"nu": values})
    values[0] = 9
    assert grid.values["nu"].tolist() == [1, 2]
    with pytest.raises(ValueError, match="read-only"):
        grid.values["nu"][0] = 9


def test_nothing_slow_is_loaded_for_a_grid() -> None:
    code = (
        "import sys, vibropipe.solve.sweep.sweep_grid\n"
        "print({'numba', 'xarray', 'h5py', 'netCDF4'} & set(sys.modules))"
    )
    assert printed(code) == "set()\n"


def test_a_grid_in_both_directions_has_all_chains_up_first() -> None:
    grid = SweepGrid({"nu": np.array([1.0, 2.0]), "f": np.array([3.0])}, ("nu", "both"))
    assert (grid.dims, grid.shape, grid.chains) == (("direction", "nu", "f"), (2, 2, 1), 2)
    assert [grid.text(row) for row in range(grid.rows)] == [
        "direction = up, nu = 1.0, f = 3.0",
        "direction = up, nu = 2.0, f = 3.0",
        "direction = down, nu = 1.0, f = 3.0",
        "direction = down, nu = 2.0, f = 3.0",
    ]
    assert grid.solved(0, 4).tolist() == [0, 1, 3, 2]


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
