"""Cost of a sweep, and number of its rows in memory at once."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from vibropipe.scenes.costs import Work, slowness, steady_bytes, stored_name
from vibropipe.scenes.rows import row_grid

if TYPE_CHECKING:
    from vibropipe.scenes.sweep.keys import SweepScene

SECONDS_PER_ROW = 4e-5
# Largest number of rows in memory at once, and largest number of their bytes.
BLOCK_ROWS, BLOCK_BYTES = 4096, 12e6
# Impacts of a row without an orbit: it lists those of 64 forcing periods, about one on each support in each of them.
APERIODIC_IMPACTS = 128
# Largest number of impacts that an orbit can list. The mass comes to rest by chatter if nu is below SLOW or the
# spring presses it on a support. CHATTER: impact velocities at which a chatter begins and at which it is completed.
MAX_IMPACTS_KEPT = 8192
SLOW = 1.0
CHATTER = 1.0, 1e-7


def plan(scene: SweepScene) -> Work:
    """Return the work of a sweep, from its number of rows."""
    grid = row_grid(scene)
    dims = [stored_name(scene, name) for name in grid.dims]
    pair = scene.follow_pair()
    followed = [f"{stored_name(scene, pair[0])} {pair[1]}"] if pair else []
    return Work(
        size=" x ".join(f"{size} {name}" for name, size in zip(dims, grid.shape, strict=True)),
        rows=scene.row_count,
        method=", ".join(["exact", *followed]),
        outputs=tuple(scene.outputs),
        seconds=scene.row_count * SECONDS_PER_ROW * slowness(scene),
        bytes=scene.row_count
        * steady_bytes(scene.outputs, scene.harmonics, effects=scene.all_effects()),
        pieces=grid.chains,
        is_parallel=True,
    )


def block_rows(scene: SweepScene) -> int:
    """Return the number of rows that are solved before they are written."""
    return max(1, min(BLOCK_ROWS, int(BLOCK_BYTES / row_memory(scene))))


def row_memory(scene: SweepScene) -> float:
    """Return the bytes of the largest row in memory; a requested accuracy needs it twice."""
    passes = 1 if scene.solver.arguments().get("accuracy") is None else 2
    outputs, harmonics = scene.outputs, scene.harmonics
    return passes * steady_bytes(outputs, harmonics, max_impacts(scene), scene.all_effects())


def max_impacts(scene: SweepScene) -> float:
    """Return roughly the largest number of impacts of a row: without an orbit, or with rest that of two chatters."""
    swept, exciter = scene.over_arrays(), scene.resolved_exciter()
    values = {name: swept.get(name, np.array([value])) for name, value in exciter.items()}
    restitution = np.concatenate([values["R1"], values["R2"]])
    lossy = restitution[(restitution > 0) & (restitution < 1)]
    is_slow = values["nu"].min() < SLOW
    load = np.abs(values.get("load", np.zeros(1))).max()
    is_pressed = np.abs(values["delta"]).max() + load >= values["l"].min()
    if "rest" not in scene.called_effects() or not lossy.size or not (is_slow or is_pressed):
        return APERIODIC_IMPACTS
    first, last = CHATTER
    chatters = 2 * math.log(first / last) / math.log(1 / lossy.max())
    return min(max(APERIODIC_IMPACTS, chatters), MAX_IMPACTS_KEPT)
