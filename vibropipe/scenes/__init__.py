"""One scene of a study, or one shard of it, becomes a Dataset by calling the public faces."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import xarray as xr

from vibropipe.compiler.sources import code_hash, lab_hash
from vibropipe.jobs.estimates import recall
from vibropipe.jobs.progress import Progress
from vibropipe.jobs.sharding import as_sweep, check_cut, row_range
from vibropipe.lab.effect_scenes import motions_of, solve_effects
from vibropipe.scenes.backbone import solve_backbone
from vibropipe.scenes.motion import solve_motion
from vibropipe.scenes.sweep import solve_sweep, store_sweep
from vibropipe.store import (
    count_equal,
    join,
    provenance,
    read_sidecar,
    write,
    write_sidecar,
)
from vibropipe.study import (
    AccuracyScene,
    BackboneScene,
    EffectsScene,
    HardCasesScene,
    MotionScene,
    Scene,
    Study,
    SweepScene,
    fingerprint,
    scene_effects,
)
from vibropipe.words.regimes import Regime

# What is raced beside the methods of this program.
PEERS = ("scipy", "heyoka")
OF_THE_SOLVER = ("kernel_hash", "versions", "git_commit", "machine")
# What progress counts, by kind of scene.
UNITS = {
    "sweep": "rows",
    "motion": "periods",
    "hard_cases": "cases",
    "accuracy": "races",
    "effects": "timings",
    "backbone": "points",
}


def solve_to_file(
    study: Study,
    name: str,
    path: Path,
    shard: tuple[int, int] | None,
    threads: int,
    progress: Progress | None = None,
) -> None:
    """Solve a scene or a shard into the file `path`; into its sidecar the time it took, and how many of its rows
    are unresolved.

    `progress` is told how much is done, in units of the scene's kind (`UNITS`), and of how much.
    """
    begin = time.perf_counter()
    scene = study.scene(name)
    if isinstance(scene, SweepScene):
        check_cut(scene, shard)
        store_sweep(scene, path, origin(study, scene), shard, progress)
    else:
        write(solve_scene(study, name, shard, progress), path)
    taken = time.perf_counter() - begin
    more = identity(study, scene) | expectation(study, name, shard, threads)
    write_sidecar(path, taken, threads, unresolved=count_unresolved(path), **more)


def identity(study: Study, scene: Scene) -> dict[str, Any]:
    """Return what the data of a scene are made of: hashes of what it says and of the code, for its sidecar."""
    return {"fingerprint": fingerprint(study, scene), "code": code_hash(scene.kind)}


def count_unresolved(path: Path) -> int:
    """Return how many rows of a dataset have no result that can be relied on, 0 where it has no rows."""
    return count_equal(path, "regime", Regime.UNRESOLVED)


def expectation(
    study: Study, name: str, shard: tuple[int, int] | None, threads: int
) -> dict[str, float]:
    """Return the seconds expected of a job as an entry of its sidecar, where a plan has found them."""
    scene, known = study.scene(name), recall(fingerprint(study, name))
    if known is None:
        return {}
    share = 1.0
    if isinstance(scene, SweepScene) and shard is not None:
        first, last = row_range(scene, *shard)
        share = (last - first) / scene.row_count
    return {"expected_seconds": known.seconds(threads, share)}


def join_to_file(
    study: Study,
    name: str,
    shards: Sequence[Path],
    path: Path,
    progress: Progress | None = None,
) -> None:
    """Join all shards of a sweep, in any order; the sidecar tells the time of all jobs together.

    `progress` is told how many rows are joined, and of how many.
    Raises StudyError when there is no such scene, PlanError when it is no sweep, StoreError when
    the shards are not those of this scene.
    """
    scene = as_sweep(study.scene(name))
    begin = time.perf_counter()
    followed = scene.follow_pair()
    # code, versions and machine are those that solved the shards, not those that join them
    words = {key: value for key, value in origin(study, scene).items() if key not in OF_THE_SOLVER}
    dim = followed[0] if followed else None
    join(shards, path, scene.over_arrays(), dim, words, progress)
    taken = [read_sidecar(shard) for shard in shards]
    seconds = sum(float(record.get("seconds", 0)) for record in taken)
    threads = max(int(record.get("threads", 1)) for record in taken)
    seconds += time.perf_counter() - begin
    expected = [float(record.get("expected_seconds", math.nan)) for record in taken]
    more: dict[str, Any] = {}
    if not math.isnan(sum(expected)):
        more["expected_seconds"] = sum(expected)
    more |= identity(study, scene) | {"unresolved": count_unresolved(path)}
    write_sidecar(path, seconds, threads, shards=len(shards), **more)


def solve_scene(
    study: Study,
    name: str,
    shard: tuple[int, int] | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Solve a scene, or shard I of N of a sweep given as (I, N), I counted from 1.

    Raises StudyError when there is no such scene, PlanError when it cannot be cut so.
    """
    scene = study.scene(name)
    dataset = solve(scene, shard, progress)
    # what a face says of its work (the method it chose, the accuracy it reached) stands
    return dataset.assign_attrs(origin(study, scene) | dataset.attrs | chosen(dataset))


def solve(
    scene: Scene, shard: tuple[int, int] | None = None, progress: Progress | None = None
) -> xr.Dataset:
    """Solve a scene, or one shard of it, without saying where it comes from but for its effects."""
    check_cut(scene, shard)
    if isinstance(scene, SweepScene):
        return solve_sweep(scene, shard, progress)
    if isinstance(scene, MotionScene):
        return solve_motion(scene, progress)
    return solve_set(scene, progress).assign_attrs(effects=", ".join(scene_effects(scene)))


def solve_set(
    scene: BackboneScene | HardCasesScene | AccuracyScene | EffectsScene,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Solve a scene whose motions are chosen by its kind."""
    if isinstance(scene, HardCasesScene):
        return solve_cases(scene, progress)
    if isinstance(scene, EffectsScene):
        return solve_effects(scene, progress)
    if isinstance(scene, AccuracyScene):
        return solve_races(scene, progress)
    return solve_backbone(scene)


def origin(study: Study, scene: Scene) -> dict[str, Any]:
    """Return the global attributes of a dataset; titles stay out, since no data depends on them."""
    solver = scene.solver.arguments() if isinstance(scene, MotionScene | SweepScene) else {}
    method = str(solver.get("method", "exact"))
    if isinstance(scene, AccuracyScene):
        method = ", ".join(scene.methods)
    if "steps_per_period" in solver:
        method += f", {solver['steps_per_period']} steps per forcing period"
    return {
        "title": f"{study.name}: {scene.name}",
        "kind": scene.kind,
        **provenance(
            Path(study.source).read_text(encoding="utf-8"),
            fingerprint(study, scene),
            method,
            solver.get("accuracy"),
            packages=PEERS if isinstance(scene, AccuracyScene) else (),
        ),
        **({"lab_hash": lab_hash(scene.kind)} if lab_hash(scene.kind) else {}),
    }


def chosen(dataset: xr.Dataset) -> dict[str, Any]:
    """Return the attributes of a motion to an accuracy: the method chosen for it and what it reached."""
    if "accuracy_reached" not in dataset.attrs:
        return {}
    method, steps = str(dataset.attrs["method"]), dataset.attrs.get("steps_per_period")
    method += f", {steps} steps per forcing period" if steps is not None else ""
    return {"method": method, "accuracy_reached": float(dataset.attrs["accuracy_reached"])}


def solve_cases(scene: HardCasesScene, progress: Progress | None = None) -> xr.Dataset:
    """Measure the hard cases a scene names, or all of them, by every method."""
    from vibropipe.lab.hard_cases import CASES, solve_hard_cases

    named = [case for case in CASES if case.name in scene.cases]
    return solve_hard_cases(named or CASES, progress=progress)


def solve_races(scene: AccuracyScene, progress: Progress | None = None) -> xr.Dataset:
    """Race the methods of a scene on its motions; the times are of this run alone."""
    from vibropipe.lab.work_precision import solve_accuracy

    return solve_accuracy(**race_of(scene), progress=progress)


def race_of(scene: AccuracyScene) -> dict[str, Any]:
    """Return a race as the arguments of `lab.work_precision.solve_accuracy`."""
    return {
        "motions": motions_of(scene),
        "methods": scene.methods,
        "steps": scene.steps_per_period,
        "tolerances": scene.tolerances,
        "peer_periods": scene.peer_periods,
        "repeats": scene.repeats,
    }
