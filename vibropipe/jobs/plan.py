"""The plan of a study: rows, jobs, work and bytes of each scene, known before anything is solved.

The numbers depend on the study alone, not on the machine, because the shards of a scene follow from its work.
"""

from __future__ import annotations

from dataclasses import dataclass

from vibropipe.jobs.sharding import shard_count
from vibropipe.scenes.costs import Work
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.registry import kind_of


@dataclass(frozen=True, kw_only=True)
class ScenePlan(Work):
    """The plan of one scene: its work, and how it is solved.

    Parameters
    ----------
    name, kind : str
        Name and kind of the scene.
    effects : tuple of str
        Physical effects that the study states or the parameters call for.
    shards : int
        Number of jobs that solve the scene.
    is_timed : bool
        Whether the data are measured times; such a scene runs alone on all cores.
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
