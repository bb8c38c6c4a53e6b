"""The plan of a study: rows, jobs, work and bytes of each scene, and its run time and disk space on this machine.

The plan depends on the study alone, not on the machine, because the shards of a scene follow from its work. Estimates
are from what solved scenes of the same kinds took: a file beside the compiled kernels sums seconds and bytes of solved
scenes and those of their plans, for each kind with rigid supports, and with each effect of pieces. Their ratio is a
rate of this machine. Where little has been solved, it is close to that of a short loop. A scene that was solved here as
it stands takes what it took.
"""

from __future__ import annotations

import functools
import json
import math
import os
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from vibropipe.compiler.cache import cache_root, has_kernels, one_at_a_time
from vibropipe.compiler.sources import kernel_hash
from vibropipe.scenes.costs import OF_PIECES, PlanError, Work
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.kind import Kind
from vibropipe.scenes.registry import kind_of, kinds
from vibropipe.store import StoreError, atomic_file
from vibropipe.study import Study, fingerprint

# Work of one shard in seconds of one core. A job takes about a second to start, so smaller shards cost more than
# they gain. On a cluster, where a job takes ten seconds to start, set the variable to some minutes.
SHARD_SECONDS = 20.0
SHARD_VARIABLE = "VIBROPIPE_SHARD_SECONDS"
# Largest number of shards of one scene; it bounds the jobs in snakemake's graph.
MAX_SHARDS = 1000


def shard_count(work: Work) -> int:
    """Return the number of shards of a scene: the least for which no shard exceeds `shard_seconds`, within limits."""
    n_shards = min(max(math.ceil(work.seconds / shard_seconds()), 1), MAX_SHARDS)
    return min(n_shards, work.pieces)


def shard_seconds() -> float:
    """Return the work of one shard in seconds of one core, by the environment if the variable is set."""
    text = os.environ.get(SHARD_VARIABLE)
    if text is None:
        return SHARD_SECONDS
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0 < seconds < math.inf:
        raise PlanError(f"{SHARD_VARIABLE}: must be a number of seconds above 0, got {text!r}")
    return seconds


def check_cut(scene: BaseScene, shard: tuple[int, int] | None) -> None:
    """Raise PlanError unless shard I of N, given as (I, N), exists for the scene."""
    if shard is not None:
        as_cut(scene).cut.row_range(scene, *shard)


def as_cut(scene: BaseScene) -> Kind:
    """Return the kind of a scene that can be cut into shards; raise PlanError for a scene that cannot."""
    kind = kind_of(scene)
    if not kind.can_be_cut:
        allowed = " or ".join(name for name, each in kinds().items() if each.can_be_cut)
        raise PlanError(
            f"scenes.{scene.name}: must be of kind {allowed} to be cut into shards, got {scene.kind}"
        )
    return kind


@dataclass(frozen=True, kw_only=True)
class ScenePlan(Work):
    """The plan of one scene: its work, and how it is solved.

    effects : physical effects that the study states or the parameters call for
    shards : number of jobs that solve the scene
    is_timed : whether the data are measured times; such a scene runs alone on all cores
    """

    name: str
    kind: str
    effects: tuple[str, ...]
    shards: int
    is_timed: bool


def plan_scene(scene: BaseScene) -> ScenePlan:
    """Return the plan of a scene."""
    kind = kind_of(scene)
    work = kind.plan(scene)
    return ScenePlan(
        **vars(work),
        name=scene.name,
        kind=scene.kind,
        effects=scene.called_effects(),
        shards=shard_count(work),
        is_timed=kind.is_timed,
    )


FILE_NAME = "rates.json"
# Planned seconds and bytes of solved scenes whose ratio counts as much as that of the loop, and as 1: most of what
# small scenes take is loading, and headers of files.
FEW_SECONDS, FEW_BYTES = 3.0, 2e6
# Weight of all earlier scenes beside a new one of the same size.
MEMORY = 0.7
# Versions of the code that are remembered, for each set of kernels, and scenes with what they took.
VERSIONS, SCENES = 8, 500
# CPU seconds in which a job loads what it needs: a new process, and a scene.
JOB_SECONDS, SCENE_SECONDS = 0.7, 0.1
# Passes of the loop, its length, and the seconds of a pass on the machine whose seconds plans have.
PASSES, LOOP, LOOP_SECONDS = 5, 30_000, 2e-3


class Estimate(NamedTuple):
    """Estimated work of a scene.

    seconds : of one core, with those in which its jobs load what they need; bytes : on disk
    """

    seconds: float
    bytes: float


@dataclass(frozen=True)
class Estimates:
    """Estimates of the scenes of a study.

    searched : scenes whose work depends on what is found, and that were not solved on this machine as they stand
    rough : scenes of whose kind, with such effects, none has been solved on this machine
    uncompiled : scenes of whose kind, with such effects and outputs, none has been solved by this version
    at_rests : searched scenes for which kernels are compiled if a motion is found that rests
    """

    by_scene: dict[str, Estimate]
    searched: tuple[str, ...] = ()
    rough: tuple[str, ...] = ()
    uncompiled: tuple[str, ...] = ()
    at_rests: tuple[str, ...] = ()


def estimate_study(study: Study) -> Estimates:
    """Estimate the scenes of a study from the rates of this machine."""
    plans = [plan_scene(scene) for scene in study.scenes.values()]
    known = _load()
    rough = tuple(plan.name for plan in plans if _name(plan) not in known["rates"])
    compiled = known["compiled"]
    uncompiled = (p.name for p in plans if _version(p) not in compiled.get(_kernels(p), ()))
    taken = {name: known["scenes"].get(fingerprint(study, s)) for name, s in study.scenes.items()}
    by_scene = {
        plan.name: Estimate(*own) if (own := taken[plan.name]) else _estimate(plan, known["rates"])
        for plan in plans
    }
    searched = tuple(p.name for p in plans if not p.is_foreseen and not taken[p.name])
    at_rests = tuple(
        p.name for p in plans if p.name in searched and p.of_rests and not has_kernels(p.of_rests)
    )
    return Estimates(by_scene, searched, rough, tuple(uncompiled), at_rests)


def _estimate(plan: ScenePlan, rates: Mapping[str, list[float]]) -> Estimate:
    """Return the estimate of a scene: its plan times the rates of its kind."""
    measured, planned, stored, expected = rates.get(_name(plan), [0.0] * 4)
    rate = (measured + slowdown() * FEW_SECONDS) / (planned + FEW_SECONDS)
    size = (stored + FEW_BYTES) / (expected + FEW_BYTES)
    loading = JOB_SECONDS * (plan.shards > 1) * plan.shards + SCENE_SECONDS
    return Estimate(loading + rate * plan.seconds, size * plan.bytes)


def record(plan: ScenePlan, share: float, seconds: float, size: float, own: str = "") -> None:
    """Add what a solved scene, or a share of it, took; do nothing if the cache cannot be written.

    share : share of its rows that was solved
    seconds : CPU seconds without compiling
    size : bytes on disk
    own : fingerprint of the scene; "" keeps nothing of this very scene
    """
    new = (max(0.0, seconds - SCENE_SECONDS), share * plan.seconds, size, share * plan.bytes)
    with suppress(OSError, StoreError), one_at_a_time(FILE_NAME):
        known = _load()
        before = known["rates"].get(_name(plan), [0.0] * 4)
        known["rates"][_name(plan)] = [MEMORY * old + x for old, x in zip(before, new, strict=True)]
        if own and share == 1.0:
            scenes = {**known["scenes"], own: [seconds, size]}
            known["scenes"] = dict([*scenes.items()][-SCENES:])
        versions = known["compiled"].setdefault(_kernels(plan), [])
        if _version(plan) not in versions:
            known["compiled"][_kernels(plan)] = [*versions, _version(plan)][-VERSIONS:]
        with atomic_file(_file()) as temporary:
            temporary.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")


@functools.cache
def slowdown() -> float:
    """Return how many times as long this machine takes as the one whose seconds plans have, by a loop."""
    times = []
    for _ in range(PASSES):
        begin, x = time.thread_time(), 0.0
        for k in range(LOOP):
            x = math.sin(x + k)
        times.append(time.thread_time() - begin)
    return min(times) / LOOP_SECONDS


def _name(plan: ScenePlan) -> str:
    """Return the name of the rate of a scene: its kind and its effects of pieces."""
    return " ".join([plan.kind, *(effect for effect in OF_PIECES if effect in plan.effects)])


def _kernels(plan: ScenePlan) -> str:
    """Return the name of the set of kernels of a scene."""
    method = plan.method.split(",")[0]
    return " ".join([plan.kind, method, *sorted(plan.effects), *sorted(plan.outputs)])


def _version(plan: ScenePlan) -> str:
    return f"{kernel_hash()} {kinds()[plan.kind].code_hash}"


def _file() -> Path:
    return cache_root() / FILE_NAME


def _load() -> dict[str, dict[str, Any]]:
    """Return what the file holds; nothing if it is missing or unreadable."""
    with suppress(OSError, ValueError, TypeError, KeyError, AttributeError):
        held = json.loads(_file().read_text(encoding="utf-8"))
        rates = {name: [float(x) for x in rate] for name, rate in held["rates"].items()}
        if all(len(rate) == 4 for rate in rates.values()):
            compiled = {name: list(versions) for name, versions in held["compiled"].items()}
            scenes = {name: [float(x), float(y)] for name, (x, y) in held.get("scenes", {}).items()}
            return {"rates": rates, "compiled": compiled, "scenes": scenes}
    return {"rates": {}, "compiled": {}, "scenes": {}}
