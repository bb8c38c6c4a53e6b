"""What a study will do before it does it: rows, jobs, work and bytes of each scene.

The numbers here depend on the study alone, never on the machine: by its work a scene is cut into shards.
"""

from __future__ import annotations

from dataclasses import dataclass

from vibropipe.jobs.sharding import shard_count
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.registry import kind_of


@dataclass(frozen=True)
class ScenePlan:
    """What one scene comes to.

    rows: steady states, or points of a curve, or 1 for a motion; effects: the physics it states or calls
    for; shards: jobs that solve it; seconds: rough work of one core; bytes: in the dataset before compression;
    is_parallel: whether threads share the work; is_timed: whether its data are times, so that it has all cores to
    itself.
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
    is_parallel: bool
    is_timed: bool


def plan_scene(scene: BaseScene) -> ScenePlan:
    """Say what a scene comes to."""
    kind = kind_of(scene)
    work = kind.plan(scene)
    return ScenePlan(
        name=scene.name,
        kind=scene.kind,
        size=work.size,
        rows=work.rows,
        method=work.method,
        effects=scene.called_effects(),
        outputs=work.outputs,
        shards=shard_count(work),
        seconds=work.seconds,
        bytes=work.bytes,
        is_parallel=work.is_parallel,
        is_timed=kind.is_timed,
    )
