"""Shards and blocks of sweeps stay within their limits of time and memory."""

import json
import re
import subprocess
import sys
from pathlib import Path

import growth
import pytest

from vibropipe.jobs import plan
from vibropipe.jobs.plan import plan_scene
from vibropipe.jobs.solving import join_to_file, origin, solve_to_file
from vibropipe.orbits import window
from vibropipe.scenes import costs
from vibropipe.scenes.sweep import keys as keys_of
from vibropipe.scenes.sweep.cut import row_range
from vibropipe.scenes.sweep.keys import SECONDS_PER_ROW, SweepScene
from vibropipe.scenes.sweep.solve import solve_rows
from vibropipe.solve.rows import row_results
from vibropipe.store import StoreError, load, write
from vibropipe.study import load_study, parse_study
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
        write(load(shard).assign_attrs(origin(study, study.scene("s"))), shard)
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
