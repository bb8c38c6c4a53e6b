"""A sweep equals its rows, each solved alone, for any cuts, chains and number of threads."""

from __future__ import annotations

import itertools
import re
import time
from typing import Any

import numba
import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.lab.bench_items import limit_threads
from vibropipe.solve import threads
from vibropipe.solve.rows import many as rows
from vibropipe.solve.sweep.blocks import PATIENCE, assemble, solve_blocks, solve_shard
from vibropipe.solve.sweep.sweep import grid_of
from vibropipe.solve.threads import row_blocks

EXCITER = vp.Exciter(l=0.5, h=0.2, delta=0.01, R1=0.7, R2=0.6)
OVER = {"f": np.array([0.05, 0.4, 1.5]), "nu": np.linspace(0.4, 2.2, 7)}
EVERY = ("harmonics", "impacts", "motion", "stability", "energy")


@pytest.fixture(scope="module")
def whole() -> xr.Dataset:
    return vp.sweep(EXCITER, OVER, outputs=EVERY)


def test_dimensions_come_in_the_order_given(whole: xr.Dataset) -> None:
    assert whole.regime.dims == ("f", "nu")
    assert whole.displacement_amplitude.dims == ("f", "nu", "harmonic")
    assert whole.impact_velocity_max.dims == ("f", "nu", "support")
    assert whole.displacement.dims == ("f", "nu", "phase")
    assert whole.floquet_multiplier.dtype == complex
    assert whole.row_size.attrs["sample_dimension"] == "impact"
    assert int(whole.row_size.sum()) == whole.sizes["impact"]
    turned = vp.sweep(EXCITER, {"nu": OVER["nu"], "f": OVER["f"]}, outputs=EVERY)
    xr.testing.assert_identical(turned.regime.transpose("f", "nu"), whole.regime)


def test_each_row_is_its_steady_state(whole: xr.Dataset) -> None:
    ends = np.cumsum(whole.row_size.values.ravel())
    for row, (i, j) in enumerate(np.ndindex(3, 7)):
        f, nu = OVER["f"][i], OVER["nu"][j]
        alone = vp.steady_state(
            vp.Exciter(l=0.5, h=0.2, delta=0.01, R1=0.7, R2=0.6, f=f, nu=nu),
            harmonics=3,
            patience=PATIENCE,
        )
        at = whole.isel(f=i, nu=j)
        for name in (
            "regime",
            "period_multiple",
            "residual",
            "displacement_mean",
            "velocity_amplitude",
            "energy_input",
        ):
            np.testing.assert_array_equal(at[name].values, alone[name].values)
        mine = slice(ends[row] - whole.row_size.values[i, j], ends[row])
        np.testing.assert_array_equal(
            whole.impact_velocity.values[mine], alone.impact_velocity.values
        )


def test_motion_energy_and_harmonics_tell_of_the_same_orbit(whole: xr.Dataset) -> None:
    orbits = whole.where(whole.period_multiple > 0)
    assert float(abs(orbits.energy_residual).max()) < 1e-9
    mean = orbits.displacement.mean("phase")
    # The tolerance is the error of the trapezoidal mean of 256 samples of a motion with corners.
    np.testing.assert_allclose(mean.values, orbits.displacement_mean.values, atol=2e-3)
    assert float(orbits.displacement.max()) <= EXCITER.upper + 1e-12
    assert float(orbits.displacement.min()) >= EXCITER.lower - 1e-12


@pytest.mark.parametrize("follow", [None, ("nu", "up"), ("f", "down"), ("f", "both")])
@pytest.mark.parametrize("cuts", [2, 3])
def test_the_cut_does_not_matter(follow: Any, cuts: int) -> None:
    grid = grid_of(EXCITER, OVER, follow)
    shards = [solve_shard(grid, a, b) for a, b in itertools.pairwise(grid.cuts(cuts))]
    joined = assemble(shards[::-1], grid)
    xr.testing.assert_identical(joined, vp.sweep(EXCITER, OVER, follow=follow))


@pytest.mark.parametrize("follow", [None, ("nu", "up"), ("f", "down"), ("f", "both")])
def test_the_pieces_rows_are_solved_in_do_not_matter(follow: Any, monkeypatch: Any) -> None:
    """Chains longer than a piece continue in the next one."""
    expected = vp.sweep(EXCITER, OVER, follow=follow)
    monkeypatch.setattr(threads, "ROWS_PER_CALL", 4)
    xr.testing.assert_identical(vp.sweep(EXCITER, OVER, follow=follow), expected)


@pytest.mark.parametrize("follow", [None, ("nu", "up"), ("f", "down"), ("f", "both")])
@pytest.mark.parametrize("accuracy", [None, 1e-9])
def test_blocks_are_the_sweep_cut_between_chains(
    follow: Any, accuracy: Any, monkeypatch: Any
) -> None:
    monkeypatch.setattr(threads, "ROWS_PER_CALL", 2)
    monkeypatch.setattr(threads, "MIN_ROWS_PER_CALL", 2)
    grid = grid_of(EXCITER, OVER, follow)
    count, chain = grid.rows, grid.chain_length
    blocks = list(solve_blocks(grid, range(count), 8, accuracy=accuracy))
    ends = [0, *(block.attrs["row_stop"] for block in blocks)]
    assert [block.attrs["row_start"] for block in blocks] == ends[:-1]
    sizes = np.diff(ends)
    assert sizes.sum() == count
    assert len(blocks) > 1
    assert set(sizes % chain) == {0}
    assert sizes[:-1].min() >= 8
    assert sizes.max() <= 8 + max(2, chain)
    whole = vp.sweep(EXCITER, OVER, follow=follow, accuracy=accuracy)
    xr.testing.assert_identical(assemble(blocks, grid), whole)


def test_little_is_solved_ahead_of_what_is_taken(monkeypatch: Any) -> None:
    """No row is solved after the generator is closed."""
    monkeypatch.setattr(threads, "ROWS_PER_CALL", 2)
    monkeypatch.setattr(threads, "MIN_ROWS_PER_CALL", 2)
    piece_rows = []

    def watched(*arguments: Any) -> Any:
        piece_rows.append(len(arguments[1]))
        return solve_piece(*arguments)

    solve_piece = rows.solve_piece
    monkeypatch.setattr(rows, "solve_piece", watched)
    over = {"nu": np.linspace(1, 3, 200)}
    blocks = solve_blocks(grid_of(EXCITER, over), range(200), 8)
    assert next(blocks).sizes["row"] == 8
    time.sleep(0.2)
    ahead = max(numba.get_num_threads() + 1, 4) * 2
    assert 8 <= sum(piece_rows) <= 8 + ahead
    blocks.close()
    solved = sum(piece_rows)
    time.sleep(0.05)
    assert sum(piece_rows) == solved <= 8 + ahead


def ends_of(count: int, chain: int) -> list[int]:
    """Return the ends of all calls."""
    (pieces,) = row_blocks(count, chain)
    return [0, *itertools.chain.from_iterable(ends[1:] for ends in pieces)]


@pytest.mark.parametrize(("count", "chain"), [(1, 1), (1000, 1), (5000, 1), (4900, 7), (3000, 300)])
def test_pieces_become_shorter_towards_the_end(count: int, chain: int) -> None:
    ends = ends_of(count, chain)
    sizes = np.diff(ends)
    assert (ends[0], ends[-1]) == (0, count)
    assert 0 < sizes.min() <= sizes.max() <= threads.ROWS_PER_CALL
    for first, stop in itertools.pairwise(ends):
        if chain < threads.MIN_ROWS_PER_CALL:
            assert stop % chain == 0
            most = max(threads.MIN_ROWS_PER_CALL, (count - first) // threads.TAIL_FRACTION)
            assert stop - first <= most
    if chain < threads.MIN_ROWS_PER_CALL < count:
        assert sizes[-1] <= threads.MIN_ROWS_PER_CALL


@pytest.mark.parametrize(
    ("count", "chain", "ends"),
    [
        (10, 1, [0, 4, 8, 10]),
        (9, 3, [0, 3, 6, 9]),
        (8, 2, [0, 4, 8]),
        (20, 10, [0, 4, 8, 10, 14, 18, 20]),
    ],
)
def test_pieces_are_whole_chains_or_parts_of_one(count, chain, ends, monkeypatch) -> None:
    monkeypatch.setattr(threads, "ROWS_PER_CALL", 4)
    assert ends_of(count, chain) == ends


def test_threads_do_not_matter(whole: xr.Dataset) -> None:
    with limit_threads(1):
        xr.testing.assert_identical(vp.sweep(EXCITER, OVER, outputs=EVERY), whole)


def test_what_is_not_asked_is_not_there() -> None:
    bare = vp.sweep(EXCITER, {"nu": [0.9, 1.1]}, outputs=())
    for name in ("displacement_mean", "impact_velocity", "displacement", "stable", "energy_input"):
        assert name not in bare
    assert bare.regime.dims == ("nu",)


def test_hysteresis_shows_when_a_sweep_is_followed() -> None:
    """Beyond resonance a two-sided and a non-impacting motion are both stable; the direction selects one."""
    e = vp.Exciter(l=0.5, h=0.2, nu=1.0, f=0.5, R1=0.7, R2=0.7)
    nu = np.linspace(0.8, 3.0, 45)
    up, down = (vp.sweep(e, {"nu": nu}, follow=("nu", way)) for way in ("up", "down"))
    struck_up, struck_down = (s.impacts_per_orbit.sum("support").values > 0 for s in (up, down))
    assert struck_up.sum() > struck_down.sum() + 5
    assert up.stable.values.all()
    assert down.stable.values.all()


@pytest.mark.parametrize("along", ["nu", "f"])
@pytest.mark.parametrize("accuracy", [None, 1e-9])
def test_both_directions_are_the_sweeps_up_and_down(along: str, accuracy: Any) -> None:
    options = {"outputs": EVERY, "accuracy": accuracy}
    both = vp.sweep(EXCITER, OVER, follow=(along, "both"), **options)
    assert both.regime.dims == ("direction", "f", "nu")
    assert both.direction.values.tolist() == ["up", "down"]
    parts = [vp.sweep(EXCITER, OVER, follow=(along, way), **options) for way in ("up", "down")]
    for way, part in zip(("up", "down"), parts, strict=True):
        assert part.regime.dims == ("f", "nu")
        half = both.sel(direction=way, drop=True)
        for name, values in part.data_vars.items():
            if "impact" not in values.dims:
                assert half[name].values.tobytes() == values.values.tobytes(), name
    for name, values in both.data_vars.items():
        if "impact" in values.dims:
            impacts = np.concatenate([part[name].values for part in parts])
            assert values.values.tobytes() == impacts.tobytes(), name
    assert not np.array_equal(*(part.impact_velocity_max.values for part in parts), equal_nan=True)


def test_mirrored_exciters_give_mirrored_sweeps() -> None:
    over = {"f": OVER["f"], "nu": OVER["nu"][::2]}
    mirrored = vp.sweep(EXCITER.mirrored(), {"f": -over["f"][::-1], "nu": over["nu"]}, -0.1, 0.2)
    plain = vp.sweep(EXCITER, over, 0.1, -0.2)
    flipped = mirrored.isel(f=slice(None, None, -1))
    np.testing.assert_array_equal(flipped.displacement_mean.values, -plain.displacement_mean.values)
    np.testing.assert_array_equal(
        flipped.displacement_amplitude.values, plain.displacement_amplitude.values
    )
    np.testing.assert_array_equal(
        flipped.impact_velocity_max.sel(support=1).values,
        plain.impact_velocity_max.sel(support=2).values,
    )


@pytest.mark.parametrize(
    ("over", "more", "named"),
    [
        ({"mu": [1.0]}, {}, "over: must have keys among nu, f, h, l, delta, R1, R2, k1, "),
        ({"nu": []}, {}, "over.nu: must be a non-empty list of finite numbers, got []"),
        ({"nu": [1.0, 1.0]}, {}, "over.nu: must be values that differ from each other, got [1.0, 1.0]"),
        ({"nu": [1.0, np.nan]}, {}, "over.nu: must be a non-empty list of finite numbers, got [1.0, nan]"),
        ({"nu": [-1.0, 1.0]}, {}, "nu: must be a finite number > 0, got -1.0"),
        ({"R1": [0.5, 1.5]}, {}, "R1: must be a number from 0 to 1, got 1.5"),
        ({"l": [0.2, 0.5]}, {"x0": 0.4}, "(between the supports), got 0.4"),
        ({"nu": [1.0]}, {"follow": ("f", "up")}, "follow.along: must be a swept parameter (nu), got 'f'"),
        ({"nu": [1.0]}, {"follow": ("nu", "sideways")}, "follow.direction: must be up, down or both, got 'sideways'"),
        ({"nu": [1.0]}, {"outputs": ("harmonic",)}, "outputs: must be a list of "),
        ({"nu": [1.0]}, {"outputs": ("harmonic",)}, "got ('harmonic',)"),
        ({"nu": [1.0]}, {"harmonics": 0}, "harmonics: must be a whole number from 1 to 1000, got 0"),
        ({"nu": [1.0]}, {"harmonics": True}, "harmonics: must be a whole number from 1 to 1000, got True"),
        ({}, {}, "over: must have at least one parameter with its values, got {}"),
    ],
)  # fmt: skip
def test_a_mistake_is_named(over: dict, more: dict, named: str) -> None:
    with pytest.raises(vp.ParameterError) as error:
        vp.sweep(EXCITER, over, **more)
    assert named in str(error.value)
    assert re.search(r": must .*, got \S", str(error.value))
