"""The plan of a study: rows, jobs, work and bytes of each scene, known before anything is solved.

The numbers depend on the study alone, not on the machine, because the shards of a scene follow from its work.
"""

from __future__ import annotations

from dataclasses import dataclass

from vibropipe.jobs.sharding import shard_count
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.registry import kind_of


@dataclass(frozen=True)
class ScenePlan:
    """The plan of one scene.

    Parameters
    ----------
    name, kind, size, method : str
        Name and kind of the scene, its grid as text, and the method that solves it.
    rows : int
        Number of steady states, or of points of a curve; 1 for a motion.
    effects : tuple of str
        Physical effects that the study states or the parameters call for.
    outputs : tuple of str
        Outputs that are stored.
    shards : int
        Number of jobs that solve the scene.
    seconds : float
        Approximate work in seconds of one core.
    bytes : float
        Size of the dataset before compression.
    is_parallel : bool
        Whether threads share the work.
    is_timed : bool
        Whether the data are measured times; such a scene runs alone on all cores.
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
    """Return the plan of a scene."""
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
