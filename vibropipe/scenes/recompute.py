"""A sample of a dataset computed again: what a kind of scene says of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vibropipe.store import Difference


class Recomputed(NamedTuple):
    """What was computed again in words, how the file differs from it, and what was not compared."""

    checked: str
    differences: list[Difference]
    not_compared: str = ""


TIMES = ("time_", "kernel_time", "target_ratio", "target_met")
TIMES_NOT_COMPARED = "times, which are of the run that took them"


def is_timing(name: str) -> bool:
    """Whether a quantity is of the run that took it, such as a time."""
    return name.startswith(TIMES)


def sample_indices(count: int, wanted: int, generator: np.random.Generator) -> list[int]:
    """Return indices below `count` chosen at random, in order; all of them if no more are there."""
    if wanted >= count:
        return list(range(count))
    return sorted(int(index) for index in generator.choice(count, wanted, replace=False))


def part_text(part: int, whole: int, noun: str) -> str:
    """Write a part of a whole: 100 of 2,000 rows."""
    nouns = noun if whole == 1 else f"{noun}s"
    if part == whole:
        return f"the only {noun}" if whole == 1 else f"all {whole:,} {nouns}"
    return f"{part:,} of {whole:,} {nouns}"
