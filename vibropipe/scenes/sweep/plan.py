"""What a sweep will cost, and how many of its rows are in memory at once."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from vibropipe.scenes.costs import (
    USUAL_IMPACTS,
    Estimate,
    Sampler,
    Work,
    grid_size,
    steady_bytes,
    thinned,
)
from vibropipe.scenes.keys.grids import ValueGrid
from vibropipe.solve.sweep_grid import SweepGrid

if TYPE_CHECKING:
    from vibropipe.scenes.sweep.keys import SweepScene

SECONDS_PER_ROW = 4e-5
# Rows of a sweep are in memory in blocks of so many, or of fewer where they may take more than so many bytes.
BLOCK_ROWS, BLOCK_BYTES = 4096, 12e6
# An orbit lists no more than so many. Where the force is slower than this, or the spring presses the mass on a
# support, it comes to rest by a chatter from about the first velocity to the second, at which it is completed.
MAX_IMPACTS_KEPT = 8192
SLOW = 1.0
CHATTER = 1.0, 1e-7
FIRST_SAMPLE, GROWTH = 64, 4
# Rows in a row along a followed parameter: enough that the first, which has no neighbour, weighs little.
SEGMENT = 32


def plan(scene: SweepScene) -> Work:
    """Return the work of a sweep: its rows."""
    followed = scene.follow_pair()
    return Work(
        size=grid_size(scene),
        rows=scene.row_count,
        method=", ".join(["exact", *([f"{followed[0]} {followed[1]}"] if followed else [])]),
        outputs=tuple(scene.outputs),
        seconds=scene.row_count * SECONDS_PER_ROW,
        bytes=scene.row_count * steady_bytes(scene.outputs, scene.harmonics),
        pieces=sweep_grid(scene).chains,
        is_parallel=True,
    )


def sweep_grid(scene: SweepScene) -> SweepGrid:
    """Return the grid of a sweep, with the parameters that are the same in every row."""
    values = scene.over_arrays()
    given = scene.resolved_exciter().items()
    shared = {name: value for name, value in given if name not in values}
    return SweepGrid(values, scene.follow_pair(), shared)


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
    if "rest" not in scene.called_effects() or not lossy.size or not (slow or pressed):
        return USUAL_IMPACTS
    first, last = CHATTER
    chatters = 2 * math.log(first / last) / math.log(1 / lossy.max())
    return min(max(USUAL_IMPACTS, chatters), MAX_IMPACTS_KEPT)


def estimate(scene: SweepScene, sampler: Sampler) -> Estimate:
    """Estimate a sweep by rows spread over its grid."""
    effects = scene.called_effects()
    # a small part of a grid may call for less than the whole of it
    small = scene.model_copy(
        update={
            "over": {name: thinned(grid.array(), 2) for name, grid in scene.grids().items()},
            "effects": list(effects),
        }
    )
    kernels = " ".join([scene.kind, *sorted(scene.outputs), *sorted(effects)])
    again, load = sampler.warm(small, kernels)
    # What every job has to do is in the small sample as in the large one.
    base, least, spent = sampler.bytes, small.row_count, 0.0
    for sample in growing_samples(scene):
        taken = sampler.solved(sample)
        spent += taken
        if spent > sampler.budget:
            break
    more = max(1, sample.row_count - least)
    rate, each = max(0.0, taken - again) / more, (sampler.bytes - base) / more
    rest = scene.row_count - least
    return Estimate(again + rate * rest, load, base + each * rest, True, plan(scene).method)


def growing_samples(scene: SweepScene) -> Iterator[SweepScene]:
    """Yield the sweep on ever larger parts of its grid, spread over it, at last on all of it.

    Of a parameter that is followed a segment is taken, since rows are quick where the one before is near.
    """
    arrays = scene.over_arrays()
    followed: str | None = scene.follow.along if scene.follow else None
    others = [name for name in arrays if name != followed]
    n_wanted = FIRST_SAMPLE
    while True:
        part: dict[str, NDArray[np.float64]] = {}
        left = n_wanted
        if followed is not None:
            along = np.sort(arrays[followed])
            length = min(along.size, max(SEGMENT, n_wanted // SEGMENT))
            first = (along.size - length) // 2
            part[followed] = along[first : first + length]
            left = max(1, n_wanted // length)
        for index, name in enumerate(others):
            each = int(np.ceil(left ** (1 / (len(others) - index))))
            part[name] = spread(arrays[name], each)
            left = max(1, left // part[name].size)
        grids = {name: ValueGrid(values=part[name].tolist()) for name in arrays}
        # A part of a grid may call for less than the whole: the sample runs on the scene's own kernel.
        yield scene.model_copy(update={"over": grids, "effects": list(scene.called_effects())})
        if all(part[name].size == arrays[name].size for name in arrays):
            return
        n_wanted *= GROWTH


def spread(values: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """About `count` of the values, each from the middle of its share of them."""
    count = min(count, values.size)
    return values[((np.arange(count) + 0.5) * values.size / count).astype(int)]
