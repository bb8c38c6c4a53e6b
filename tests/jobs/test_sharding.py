"""Shards and blocks of sweeps, of one direction or both: limits of time and memory, files, verification."""

import json
import re
import subprocess
import sys
from pathlib import Path

import growth
import netCDF4
import numpy as np
import pytest
import xarray as xr

import vibropipe as vp
from vibropipe.jobs import plan
from vibropipe.jobs.plan import plan_scene
from vibropipe.jobs.solving import join_to_file, origin, solve_scene, solve_to_file
from vibropipe.jobs.verify import verify
from vibropipe.orbits import window
from vibropipe.scenes import costs
from vibropipe.scenes.sweep import keys as keys_of
from vibropipe.scenes.sweep.cut import row_range
from vibropipe.scenes.sweep.keys import SECONDS_PER_ROW, SweepScene
from vibropipe.scenes.sweep.solve import solve_rows
from vibropipe.solve.rows import row_results
from vibropipe.store import StoreError, load, save
from vibropipe.study import Study, load_study, parse_study, study_of_text
from vibropipe.words.outputs import OUTPUTS

SLOW = {"nu": [0.01, 0.05, 300], "f": [0.5, 2, 300]}
QUICK = {"nu": [2, 3, 1000], "f": [0.05, 0.5, 1000]}
PRESSED = {"exciter": {"delta": 1.5}, "start": {"x0": 1.5}}
ALL = {"outputs": list(OUTPUTS)}
DOWN = {"follow": {"along": "nu", "direction": "down"}}
ACCURACY = {"solver": {"accuracy": 1e-6}}
PEAK = """\
import sys
from pathlib import Path
from growth import peak_memory
from vibropipe.jobs.solving import solve_to_file
from vibropipe.study import load_study
study, output, shard = sys.argv[1:]
solve_to_file(load_study(study), "s", Path(output), tuple(map(int, shard.split("/"))), 1)
print(peak_memory())
"""


def study_of(grid: dict, R: float, points: int | None = None, **keys: object) -> dict:
    """A study of one sweep; `grid` gives start, stop and number of points, which `points` replaces."""
    over = {
        name: {"start": start, "stop": stop, "points": points or count}
        for name, (start, stop, count) in grid.items()
    }
    exciter = {"l": 0.5, "h": 0.1, "R1": R, "R2": 0.5}
    return {
        "title": "t",
        "exciter": exciter,
        "scenes": {"s": {"kind": "sweep", "over": over} | keys},
    }


def sweep_of(*arguments: object, **keys: object) -> SweepScene:
    return parse_study(study_of(*arguments, **keys)).scene("s")


def test_kernels_and_plan_agree_on_the_room_of_a_row():
    assert keys_of.MAX_IMPACTS_KEPT == row_results.ORBIT_LOG_CAPACITY
    assert costs.SIZES["tau"] == row_results.PHASES
    assert costs.SUBHARMONICS == row_results.SUBHARMONICS_PER_HARMONIC
    assert costs.SIZES["visit"] == window.LISTED_PERIODS


@pytest.mark.parametrize("seconds", [1, 20, 300, 1e6])
@pytest.mark.parametrize(("grid", "keys"), [(SLOW, {}), (QUICK, ALL), (SLOW, ACCURACY)])
def test_a_shard_takes_no_longer_and_a_block_no_more_than_it_may(grid, keys, seconds, monkeypatch):
    monkeypatch.setenv(plan.SHARD_VARIABLE, str(seconds))
    scene = sweep_of(grid, 0.7, **keys)
    shards = plan.shard_count(keys_of.plan(scene))
    sizes = []
    for shard in range(1, shards + 1):
        start, stop = row_range(scene, shard, shards)
        sizes.append(stop - start)
    assert sum(sizes) == scene.row_count
    assert keys_of.block_rows(scene) * keys_of.row_memory(scene) <= keys_of.BLOCK_BYTES
    if shards < plan.MAX_SHARDS:
        assert max(sizes) * SECONDS_PER_ROW <= seconds + SECONDS_PER_ROW


@pytest.mark.parametrize(
    ("grid", "R", "keys"),
    [(SLOW, 0.7, {}), (SLOW, 0.9, {}), (SLOW, 0.99, {}), (QUICK, 0.99, {}), (QUICK, 0.9, PRESSED)],
)
def test_rows_take_no_more_memory_than_planned(grid, R, keys):
    scene = sweep_of(grid, R, points=4, **keys)
    solved = solve_rows(scene, 0, scene.row_count)
    assert solved["row_size"].values.mean() <= keys_of.max_impacts(scene)
    fixed = sum(value.nbytes for value in solved.data_vars.values() if "impact" not in value.dims)
    planned = costs.steady_bytes(scene.outputs, scene.harmonics, 0)
    assert fixed / scene.row_count == pytest.approx(planned, rel=0.1)


def test_the_size_of_a_map_with_chaos_is_planned():
    """Of the default study `regimes`, on a coarser grid: one in ten rows has the impacts of a whole window."""
    scene = load_study(Path(__file__).parents[2] / "config/regimes.yaml").scenes["regime_map"]
    grids = {name: grid.model_copy(update={"points": 20}) for name, grid in scene.over.items()}
    coarse = scene.model_copy(update={"over": grids})
    solved, planned = solve_rows(coarse, 0, 400), plan_scene(coarse)
    assert planned.rows == 400
    assert solved.nbytes == pytest.approx(planned.bytes - costs.HEAD_BYTES, rel=0.3)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("R1: 0.7", "R1: 0.6", "R1 of every row differs from the study (must be 0.7, got 0.6)"),
        ("[1, 1.5, 2]", "[1, 1.4, 2]", "nu of row 1 differs from the study (must be 1.5, got 1.4)"),
    ],
)
def test_shards_of_other_parameters_are_not_joined(old, new, message, tmp_path):
    """Even if the shards agree with each other and their attributes are those of the study."""
    text = (
        "{title: t, exciter: {l: 0.5, h: 0.2, R1: 0.7},"
        " scenes: {s: {kind: sweep, over: {f: [0.2, 1], nu: [1, 1.5, 2]}}}}"
    )
    (tmp_path / "t.yaml").write_text(text)
    (tmp_path / "other.yaml").write_text(text.replace(old, new))
    study, other = load_study(tmp_path / "t.yaml"), load_study(tmp_path / "other.yaml")
    shards, target = [tmp_path / "1.nc", tmp_path / "2.nc"], tmp_path / "s.nc"
    for index, shard in enumerate(shards, 1):
        solve_to_file(other, "s", shard, (index, 2), 1)
        save(load(shard).assign_attrs(origin(study, study.scene("s"))), shard)
    remedy = "recompute this shard (delete it and rerun; only missing files are recomputed)"
    with pytest.raises(StoreError, match=re.escape(f"1.nc: {message}: {remedy}")):
        join_to_file(study, "s", shards, target)
    assert not target.exists()
    for index, shard in enumerate(shards, 1):
        solve_to_file(study, "s", shard, (index, 2), 1)
    join_to_file(study, "s", shards, target)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("grid", "R", "keys"),
    [
        (SLOW, 0.9, {}),
        (SLOW, 0.99, {}),
        (SLOW, 0.7, ALL | DOWN | {"harmonics": 20}),
        (SLOW, 0.7, ALL | ACCURACY | {"harmonics": 20}),
        (QUICK, 0.9, PRESSED),
        (QUICK, 0.7, {}),
        (QUICK, 0.7, {"harmonics": 200}),
    ],
)
def test_a_solving_job_holds_less_than_500_megabytes(grid, R, keys, tmp_path, monkeypatch):
    """Long shards that need much memory: slow forces, hard supports, every output, an accuracy."""
    monkeypatch.setenv(plan.SHARD_VARIABLE, "300")
    study = tmp_path / "t.yaml"
    study.write_text(json.dumps(study_of(grid, R, **keys)))
    scene = sweep_of(grid, R, **keys)
    shards = plan.shard_count(keys_of.plan(scene))
    command = [sys.executable, "-c", PEAK, str(study), str(tmp_path / "1.nc"), f"{shards}/{shards}"]
    folder = Path(growth.__file__).parent
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    assert float(done.stdout) < 500e6


# The followed parameter is not the last one, so that the order of the rows differs from that of the dataset.
TEXT = """\
title: t
exciter: {l: 0.5, h: 0.2, R1: 0.7, R2: 0.7}
scenes:
  map:
    kind: sweep
    over: {nu: {start: 0.9, stop: 2.7, points: 9}, f: [0.2, 0.5, 1]}
    follow: {along: nu, direction: both}
"""


@pytest.fixture(scope="module")
def study() -> Study:
    return study_of_text(TEXT, "t")


@pytest.fixture(scope="module")
def whole(study: Study, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("results") / "t" / "map.nc"
    solve_to_file(study, "map", path, None, 1)
    return path


def halves() -> list[xr.Dataset]:
    """Return the sweeps up and down."""
    exciter = vp.Exciter(l=0.5, h=0.2, R1=0.7, R2=0.7)
    over = {"nu": np.linspace(0.9, 2.7, 9), "f": [0.2, 0.5, 1]}
    return [vp.sweep(exciter, over, follow=("nu", way)) for way in ("up", "down")]


def test_the_plan_counts_the_rows_of_both(study: Study) -> None:
    plan = plan_scene(study.scene("map"))
    assert (plan.rows, plan.size) == (54, "2 direction x 9 nu x 3 f")
    assert plan.method == "exact, nu both"


def test_a_scene_holds_the_sweeps_up_and_down(whole: Path) -> None:
    stored = vp.load(whole)
    assert stored.regime.dims == ("direction", "nu", "f")
    assert stored.direction.dtype.kind == "U"
    parts = halves()
    for way, part in zip(("up", "down"), parts, strict=True):
        half = stored.sel(direction=way, drop=True)
        for name, values in part.data_vars.items():
            if "impact" not in values.dims:
                assert half[name].values.tobytes() == values.values.tobytes(), name
    velocity = np.concatenate([part.impact_velocity.values for part in parts])
    assert stored.impact_velocity.values.tobytes() == velocity.tobytes()


@pytest.mark.parametrize("shards", [2, 3, 6])
def test_the_file_does_not_depend_on_the_cut(
    study: Study, whole: Path, tmp_path: Path, shards: int
) -> None:
    parts = [tmp_path / "shards" / f"{part}.nc" for part in range(1, shards + 1)]
    for part, path in enumerate(parts, 1):
        solve_to_file(study, "map", path, (part, shards), 1)
    join_to_file(study, "map", parts[::-1], tmp_path / "map.nc")
    joined = tmp_path / "map.nc"
    assert joined.read_bytes() == whole.read_bytes()
    xr.testing.assert_identical(vp.load(joined), solve_scene(study, "map").assign_attrs(
        vp.load(joined).attrs
    ))  # fmt: skip


def test_it_is_verified_and_a_changed_direction_is_found(whole: Path, tmp_path: Path) -> None:
    verdicts = list(verify(whole, rows=1000))
    assert [str(verdict) for verdict in verdicts] == ["map: all 54 rows: same, bit for bit"]
    changed = vp.load(whole)
    changed["residual"][1, 4, 2] += 1e-16
    from vibropipe.store import save

    save(changed, tmp_path / "map.nc")
    (verdict,) = verify(tmp_path / "map.nc", rows=1000)
    assert len(verdict.faults) == 1
    assert verdict.faults[0].startswith("residual at direction = down, nu = ")
    turned = vp.load(whole).assign_coords(direction=["down", "up"])
    turned["direction"].attrs = changed["direction"].attrs
    save(turned, tmp_path / "map.nc")
    (verdict,) = verify(tmp_path / "map.nc", rows=1000)
    assert set(verdict.faults) == {"direction at [0]: 'down' in the file, 'up' computed again"}


def test_a_study_opens_lazily_and_becomes_a_table(whole: Path) -> None:
    node = vp.open_study(whole.parent)["map"]
    assert node.displacement_amplitude.chunks is not None
    assert node.direction.dtype.kind == "U"
    up = node.impact_velocity_max.sel(direction="up", f=0.5, support=1)
    np.testing.assert_array_equal(up.values, halves()[0].impact_velocity_max.sel(f=0.5, support=1))
    for table in (vp.table(node), vp.table(whole)):
        assert list(table.columns[:3]) == ["direction", "nu", "f"]
        assert table["direction"].tolist() == ["up"] * 27 + ["down"] * 27
    impacts = vp.table(whole, impacts=True)
    assert len(impacts) == sum(part.sizes["impact"] for part in halves())
    with netCDF4.Dataset(whole) as file:
        assert file.variables["direction"].long_name == "direction in which the sweep was followed"
