"""How a scene is cut into shards by its work.

Shards depend on the study alone (and on what the environment says of a shard's work), never on the machine,
so that every machine cuts alike.
"""

from __future__ import annotations

import math
import os

from vibropipe.scenes.costs import PlanError, Work
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.kind import Kind
from vibropipe.scenes.registry import kind_of

# A job costs about a second to start: below this work, cutting costs more than it gains. On a
# cluster, where a job costs ten seconds, set the variable to some minutes.
SHARD_SECONDS = 20.0
SHARD_VARIABLE = "VIBROPIPE_SHARD_SECONDS"
MAX_SHARDS = 1000


def shard_count(work: Work) -> int:
    """Return into how many shards a scene is cut: so many that none is longer than a shard may be."""
    wanted = min(max(math.ceil(work.seconds / shard_seconds()), 1), MAX_SHARDS)
    return min(wanted, work.pieces)


def shard_seconds() -> float:
    """Return the work of one shard in seconds of one core, from the environment if it says so."""
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
    """Raise PlanError unless shard I of N, given as (I, N), can be cut from the scene."""
    if shard is not None:
        as_cut(scene).cut.row_range(scene, *shard)


def as_cut(scene: BaseScene) -> Kind:
    """Return the kind of a scene that can be cut into shards; PlanError if it cannot."""
    kind = kind_of(scene)
    if not kind.can_be_cut:
        raise PlanError(
            f"scenes.{scene.name}: must be a sweep to be cut into shards, got a {scene.kind}"
        )
    return kind
