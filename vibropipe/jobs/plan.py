"""What a study will do before it does it: rows, jobs, work and bytes of each scene.

The numbers here depend on the study alone, never on the machine: by its work a sweep is cut into shards.
"""

from __future__ import annotations

import functools
import hashlib
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vibropipe.compiler.sources import PACKAGE
from vibropipe.jobs.sharding import (
    IMPACT_BYTES,
    USUAL_IMPACTS,
    shard_count,
    steady_bytes,
)
from vibropipe.study import (
    AccuracyScene,
    BackboneScene,
    EffectsScene,
    HardCasesScene,
    MotionScene,
    Scene,
    SweepScene,
    scene_effects,
)
from vibropipe.study.accuracy import PEERS
from vibropipe.words.wording import count

SECONDS_PER_ROW = 4e-5
SECONDS_PER_POINT = 20e-6
SECONDS_PER_STEP = 10e-9
SECONDS_PER_PERIOD = 1e-6
# Hard cases that are made of very many motions or impacts, and all others.
SECONDS_OF_CASES = {
    "grazing_free": 1.0,
    "ideal_free": 1.8,
    "ideal_marched": 2.0,
    "million_periods": 2.0,
}
SECONDS_PER_CASE, USUAL_CASES = 0.03, 30
HARD_CASES_BYTES = 40e3
# A race of an own method, and of a peer, whether or not it is installed here.
SECONDS_PER_RACE, SECONDS_PER_PEER_RACE = 0.05, 0.25
SECONDS_PER_TRIAL, SECONDS_PER_ROUND = 0.1, 0.012

# Heads of some thirty variables are most of a small file.
HEAD_BYTES = 9e4
RACE_BYTES, TRIAL_BYTES = 89, 400

DRAWN = ("figures", "report", "words", "lab/work_precision_summary.py")


@dataclass(frozen=True)
class ScenePlan:
    """What one scene comes to.

    rows: steady states, or points of a curve, or 1 for a motion; effects: the physics it states or calls
    for; shards: jobs that solve it; seconds: rough work of one core; bytes: in the dataset before compression.
    """

    name: str
    kind: str
    size: str
    rows: int
    method: str
    effects: tuple[str, ...]
    outputs: tuple[str, ...]
    shards: int
    seconds: float
    bytes: float


def plan_scene(scene: Scene) -> ScenePlan:
    """Say what a scene comes to."""
    if isinstance(scene, SweepScene):
        return _sweep(scene)
    if isinstance(scene, HardCasesScene):
        return _hard_cases(scene)
    if isinstance(scene, AccuracyScene):
        return _races(scene)
    if isinstance(scene, EffectsScene):
        return _trials(scene)
    return _motion(scene) if isinstance(scene, MotionScene) else _backbone(scene)


@functools.cache
def drawing_hash() -> str:
    """Hash (16 hex digits) of all sources and templates that figures and reports depend on."""
    digest = hashlib.sha256()
    for entry in DRAWN:
        for source in _files(PACKAGE / entry):
            digest.update(source.relative_to(PACKAGE).as_posix().encode() + b"\0")
            digest.update(source.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def _files(path: Path) -> Iterable[Path]:
    if not path.is_dir():
        return [path]
    return sorted(item for item in path.rglob("*") if item.suffix in (".py", ".typ", ".mplstyle"))


def _sweep(scene: SweepScene) -> ScenePlan:
    followed = scene.follow_pair()
    seconds = scene.row_count * SECONDS_PER_ROW
    stored = scene.row_count * steady_bytes(scene.outputs, scene.harmonics)
    return ScenePlan(
        name=scene.name,
        kind=scene.kind,
        size=_product(scene),
        rows=scene.row_count,
        method=", ".join(["exact", *([f"{followed[0]} {followed[1]}"] if followed else [])]),
        effects=scene_effects(scene),
        outputs=tuple(scene.outputs),
        shards=shard_count(scene, seconds),
        seconds=seconds,
        bytes=stored,
    )


def _motion(scene: MotionScene) -> ScenePlan:
    recorded = scene.tau_end * scene.resolved_exciter()["nu"] / (2 * math.pi)
    periods = scene.settle_periods + recorded
    chosen = scene.solver.arguments()
    steps = chosen.get("steps_per_period", 0)
    stored = USUAL_IMPACTS * recorded * IMPACT_BYTES
    if "motion" in scene.outputs:
        # tau, displacement, velocity and force; the exact motion beside newmark's
        stored += scene.samples_per_period * recorded * 8 * (6 if steps else 4)
    if {"harmonics", "stability", "energy"} & set(scene.outputs):
        stored += steady_bytes(scene.outputs, scene.harmonics)
    return ScenePlan(
        name=scene.name,
        kind=scene.kind,
        size=f"tau {scene.tau_end:g}",
        rows=1,
        method=_method(chosen),
        effects=scene_effects(scene),
        outputs=tuple(scene.outputs),
        shards=1,
        seconds=periods * (SECONDS_PER_PERIOD + steps * SECONDS_PER_STEP),
        bytes=stored,
    )


def _backbone(scene: BackboneScene) -> ScenePlan:
    each = 8 + 1 + 2 * 8 + 4 * 8 * scene.harmonics if scene.over_amplitude else 8
    return ScenePlan(
        name=scene.name,
        kind=scene.kind,
        size=_product(scene),
        rows=scene.row_count,
        method="exact",
        effects=scene_effects(scene),
        outputs=("harmonics",) if scene.over_amplitude else (),
        shards=1,
        seconds=scene.row_count * SECONDS_PER_POINT,
        bytes=scene.row_count * each,
    )


def _hard_cases(scene: HardCasesScene) -> ScenePlan:
    cases = len(scene.cases)
    return ScenePlan(
        name=scene.name,
        kind=scene.kind,
        size=count(cases, "case") if cases else "all cases",
        rows=max(1, cases),
        method="exact, newmark",
        effects=scene_effects(scene),
        outputs=(),
        shards=1,
        seconds=case_seconds(scene.cases),
        bytes=HARD_CASES_BYTES,
    )


def case_seconds(names: Sequence[str]) -> float:
    """Return the rough seconds of hard cases by name; of all of them if none is named."""
    if not names:
        return sum(SECONDS_OF_CASES.values()) + USUAL_CASES * SECONDS_PER_CASE
    return sum(SECONDS_OF_CASES.get(name, SECONDS_PER_CASE) for name in names)


def _races(scene: AccuracyScene) -> ScenePlan:
    peers = len(scene.motions) * sum(
        len(scene.settings(method)) for method in scene.methods if method in PEERS
    )
    return ScenePlan(
        name=scene.name,
        kind=scene.kind,
        size=count(len(scene.motions), "motion"),
        rows=scene.row_count,
        method=", ".join(scene.methods),
        effects=scene_effects(scene),
        outputs=(),
        shards=1,
        seconds=(scene.row_count - peers) * SECONDS_PER_RACE + peers * SECONDS_PER_PEER_RACE,
        bytes=HEAD_BYTES + scene.row_count * RACE_BYTES,
    )


def _trials(scene: EffectsScene) -> ScenePlan:
    return ScenePlan(
        name=scene.name,
        kind=scene.kind,
        size=count(scene.row_count, "motion"),
        rows=scene.row_count,
        method="exact",
        effects=scene_effects(scene),
        outputs=(),
        shards=1,
        seconds=scene.row_count * (SECONDS_PER_TRIAL + scene.repeats * SECONDS_PER_ROUND),
        bytes=HEAD_BYTES + scene.row_count * TRIAL_BYTES,
    )


def _product(scene: Scene) -> str:
    return " x ".join(f"{grid.size} {name}" for name, grid in scene.grids().items())


def _method(chosen: Mapping[str, Any]) -> str:
    if "accuracy" in chosen:
        return f"accuracy {chosen['accuracy']:g}"
    steps = chosen.get("steps_per_period")
    return f"{chosen['method']}, {steps} steps" if steps else str(chosen["method"])
