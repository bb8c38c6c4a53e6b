"""A dataset recomputed, as a whole or in blocks of rows."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vibropipe.store import Difference, compare

if TYPE_CHECKING:
    from vibropipe.scenes.kind import Kind


class Recomputed(NamedTuple):
    """The recomputed part as text, its differences from the file, and the part that is not compared."""

    checked: str
    differences: list[Difference]
    not_compared: str = ""


TIMES = ("time", "asked_time", "plain_time")
TIMES_NOT_COMPARED = "times, which differ from run to run"


def whole_scene(path: Path, kind: Kind, scene: Any) -> Recomputed:
    """Solve a scene again and compare all but times, which are measured once."""
    if not kind.is_timed:
        return Recomputed("all of it", compare(path, kind.solve(scene)))
    again = kind.solve(scene.model_copy(update={"repeats": 1}))
    differences = compare(path, again, lambda name: name.startswith(TIMES))
    return Recomputed("all of it", differences, TIMES_NOT_COMPARED)


def sample_indices(count: int, n_samples: int, generator: np.random.Generator) -> list[int]:
    """Return a sorted random sample of the indices below `count`; all of them if there are no more."""
    if n_samples >= count:
        return list(range(count))
    return sorted(int(index) for index in generator.choice(count, n_samples, replace=False))


def part_text(part: int, whole: int, noun: str) -> str:
    """Write a part of a whole: 100 of 2,000 rows."""
    nouns = noun if whole == 1 else f"{noun}s"
    if part == whole:
        return f"the only {noun}" if whole == 1 else f"all {whole:,} {nouns}"
    return f"{part:,} of {whole:,} {nouns}"
