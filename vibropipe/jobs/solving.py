"""A scene of a study, or a shard of it, becomes a file that says where it comes from."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import xarray as xr

from vibropipe.compiler.sources import kernel_hash
from vibropipe.jobs.estimates import load_estimate
from vibropipe.jobs.sharding import as_cut, check_cut
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.kind import Kind, Progress
from vibropipe.scenes.registry import kind_of
from vibropipe.store import (
    count_equal,
    provenance,
    read_sidecar,
    write,
    write_sidecar,
)
from vibropipe.study import Study, fingerprint
from vibropipe.words.regimes import Regime

OF_THE_SOLVER = ("kernel_hash", "versions", "git_commit", "machine")


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

    `progress` is told how much is done, in units of the scene's kind, and of how much.
    """
    begin = time.perf_counter()
    scene = study.scene(name)
    kind = kind_of(scene)
    check_cut(scene, shard)
    if kind.can_be_cut:
        kind.cut.store(scene, path, origin(study, scene), shard, progress)
    else:
        write(solve_scene(study, name, progress), path)
    elapsed = time.perf_counter() - begin
    more = identity(study, scene) | expected_seconds(study, name, shard, threads)
    write_sidecar(path, elapsed, threads, unresolved=count_unresolved(path), **more)


def solve_scene(study: Study, name: str, progress: Progress | None = None) -> xr.Dataset:
    """Solve a scene in memory. Raises StudyError when there is no such scene."""
    scene = study.scene(name)
    dataset = kind_of(scene).solve(scene, progress)
    if "effects" not in dataset.attrs:
        dataset = dataset.assign_attrs(effects=", ".join(scene.called_effects()))
    # what a face says of its work (the method it chose, the accuracy it reached) stands
    return dataset.assign_attrs(origin(study, scene) | dataset.attrs | accuracy_attrs(dataset))


def join_to_file(
    study: Study,
    name: str,
    shards: Sequence[Path],
    path: Path,
    progress: Progress | None = None,
) -> None:
    """Join all shards of a scene, in any order; the sidecar tells the time of all jobs together.

    `progress` is told how many rows are joined, and of how many.
    Raises StudyError when there is no such scene, PlanError when it cannot be cut, StoreError when
    the shards are not those of this scene.
    """
    scene = study.scene(name)
    kind = as_cut(scene)
    begin = time.perf_counter()
    # code, versions and machine are those that solved the shards, not those that join them
    attrs = {key: value for key, value in origin(study, scene).items() if key not in OF_THE_SOLVER}
    kind.cut.join(scene, shards, path, attrs, progress)
    sidecars = [read_sidecar(shard) for shard in shards]
    seconds = sum(float(record.get("seconds", 0)) for record in sidecars)
    threads = max(int(record.get("threads", 1)) for record in sidecars)
    seconds += time.perf_counter() - begin
    expected = sum(float(record.get("expected_seconds", math.nan)) for record in sidecars)
    more: dict[str, Any] = {} if math.isnan(expected) else {"expected_seconds": expected}
    more |= identity(study, scene) | {"unresolved": count_unresolved(path)}
    write_sidecar(path, seconds, threads, shards=len(shards), **more)


def code_hash(kind: Kind) -> str:
    """Return the hashes of all sources that the data of a kind of scene depend on."""
    return f"{kernel_hash()} {kind.code_hash}"


def identity(study: Study, scene: BaseScene) -> dict[str, Any]:
    """Return what the data of a scene are made of: hashes of what it says and of the code, for its sidecar."""
    return {"fingerprint": fingerprint(study, scene), "code": code_hash(kind_of(scene))}


def count_unresolved(path: Path) -> int:
    """Return how many rows of a dataset have no result that can be relied on, 0 where it has no rows."""
    return count_equal(path, "regime", Regime.UNRESOLVED)


def expected_seconds(
    study: Study, name: str, shard: tuple[int, int] | None, threads: int
) -> dict[str, float]:
    """Return the seconds expected of a job as an entry of its sidecar, where a plan has found them."""
    scene, estimate = study.scene(name), load_estimate(fingerprint(study, name))
    if estimate is None:
        return {}
    share = 1.0
    if shard is not None:
        first, last = as_cut(scene).cut.row_range(scene, *shard)
        share = (last - first) / scene.row_count
    return {"expected_seconds": estimate.seconds(threads, share)}


def origin(study: Study, scene: BaseScene) -> dict[str, Any]:
    """Return the global attributes of a dataset; titles stay out, since no data depends on them."""
    kind = kind_of(scene)
    return {
        "title": f"{study.name}: {scene.name}",
        "kind": scene.kind,
        **provenance(
            Path(study.source).read_text(encoding="utf-8"),
            fingerprint(study, scene),
            scene.method_text(),
            scene.accuracy_asked(),
            packages=kind.packages,
        ),
        **({"lab_hash": kind.code_hash} if kind.is_timed else {}),
    }


def accuracy_attrs(dataset: xr.Dataset) -> dict[str, Any]:
    """Return the attributes of a motion to an accuracy: the method chosen for it and what it reached."""
    if "accuracy_reached" not in dataset.attrs:
        return {}
    method, steps = str(dataset.attrs["method"]), dataset.attrs.get("steps_per_period")
    method += f", {steps} steps per forcing period" if steps is not None else ""
    return {"method": method, "accuracy_reached": float(dataset.attrs["accuracy_reached"])}
