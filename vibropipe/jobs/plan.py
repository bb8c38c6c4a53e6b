"""The plan of a study: rows, jobs, work and bytes of each scene, known before anything is solved.

The numbers depend on the study alone, not on the machine, because the shards of a scene follow from its work.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass

from vibropipe.scenes.costs import PlanError, Work
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.kind import Kind
from vibropipe.scenes.registry import kind_of, kinds

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
