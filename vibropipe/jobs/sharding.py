"""How a sweep is cut: into shards by their work, and these into blocks by what memory holds.

Shards depend on the study alone (and on what the environment says of a shard's work), never on the machine,
so that every machine cuts alike.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable

import numpy as np

from vibropipe.study import Scene, SweepScene, scene_effects
from vibropipe.words.wording import count

# A job costs about a second to start: below this work, cutting costs more than it gains. On a
# cluster, where a job costs ten seconds, set the variable to some minutes.
SHARD_SECONDS = 20.0
SHARD_VARIABLE = "VIBROPIPE_SHARD_SECONDS"
MAX_SHARDS = 1000
# Rows of a sweep are in memory in blocks of so many, or of fewer where they may take more than so many bytes.
BLOCK_ROWS, BLOCK_BYTES = 4096, 12e6

ROW_BYTES = 80
IMPACT_BYTES = 21
USUAL_IMPACTS = 4
# An orbit lists no more than so many. Where the force is slower than this, or the spring presses the mass on a
# support, it comes to rest by a chatter from about the first velocity to the second, at which it is completed.
MOST_IMPACTS = 8192
SLOW = 1.0
CHATTER = 1.0, 1e-7
PHASE_SAMPLES = 256


class PlanError(ValueError):
    """A study cannot be cut as asked; the message says what is allowed."""


def chain_length(scene: SweepScene) -> int:
    """Rows that must be solved one after the other: those along the followed parameter."""
    followed = scene.follow_pair()
    return scene.grids()[followed[0]].size if followed else 1


def shard_count(scene: SweepScene, seconds: float) -> int:
    """Return into how many shards a sweep of so much work is cut: so many that none is longer than a shard
    may be. Cuts fall between chains."""
    wanted = min(max(math.ceil(seconds / shard_seconds()), 1), MAX_SHARDS)
    return min(wanted, scene.row_count // chain_length(scene))


def block_rows(scene: SweepScene) -> int:
    """Return how many rows of a sweep are solved before they are written."""
    return max(1, min(BLOCK_ROWS, int(BLOCK_BYTES / row_memory(scene))))


def row_memory(scene: SweepScene) -> float:
    """Return the bytes that the costliest row of a sweep takes in memory; for an accuracy it is there twice."""
    passes = 1 if scene.solver.arguments().get("accuracy") is None else 2
    return passes * steady_bytes(scene.outputs, scene.harmonics, most_impacts(scene))


def most_impacts(scene: SweepScene) -> float:
    """Return about how many impacts an orbit of a sweep may have: of one that rests, those of two chatters."""
    swept, given = scene.over_arrays(), scene.resolved_exciter()
    values = {name: swept.get(name, np.array([value])) for name, value in given.items()}
    restitution = np.concatenate([values["R1"], values["R2"]])
    lossy = restitution[(restitution > 0) & (restitution < 1)]
    slow = values["nu"].min() < SLOW
    pressed = np.abs(values["delta"]).max() >= values["l"].min()
    if "rest" not in scene_effects(scene) or not lossy.size or not (slow or pressed):
        return USUAL_IMPACTS
    first, last = CHATTER
    chatters = 2 * math.log(first / last) / math.log(1 / lossy.max())
    return min(max(USUAL_IMPACTS, chatters), MOST_IMPACTS)


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
        raise PlanError(f"{SHARD_VARIABLE} = {text!r}: allowed is a number of seconds above 0")
    return seconds


def row_range(scene: SweepScene, shard: int, shards: int) -> tuple[int, int]:
    """Return the rows [start, stop) of shard `shard` of `shards`, counted from 1.

    Raises PlanError for a shard that does not exist or more shards than chains.
    """
    length = chain_length(scene)
    chains = scene.row_count // length
    if not 1 <= shards <= chains:
        raise PlanError(f"{count(shards, 'shard')}: this scene can be cut into 1 to {chains}")
    if not 1 <= shard <= shards:
        raise PlanError(f"shard {shard}: shards are counted from 1 to {shards}")
    return (shard - 1) * chains // shards * length, shard * chains // shards * length


def check_cut(scene: Scene, shard: tuple[int, int] | None) -> None:
    """Raise PlanError unless shard I of N, given as (I, N), can be cut from the scene."""
    if shard is not None:
        row_range(as_sweep(scene), *shard)


def as_sweep(scene: Scene) -> SweepScene:
    """Return a scene that is a sweep; PlanError if it is none."""
    if not isinstance(scene, SweepScene):
        raise PlanError(f"scene {scene.name} is a {scene.kind}: only sweeps are cut into shards")
    return scene


def steady_bytes(outputs: Iterable[str], harmonics: int, impacts: float = USUAL_IMPACTS) -> float:
    """Return the bytes of one steady state with these outputs and so many impacts."""
    costs = {
        "harmonics": 2 * 8 + 4 * 8 * harmonics,
        "impacts": 4 + 2 * 8 + impacts * IMPACT_BYTES,
        "stability": 2 * 16 + 1,
        "motion": 2 * 8 * PHASE_SAMPLES,
        "energy": 5 * 8,
    }
    return ROW_BYTES + sum(costs[output] for output in outputs)
