"""Result of recomputing a sample of a dataset."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vibropipe.store import Difference


class Recomputed(NamedTuple):
    """The recomputed part as text, its differences from the file, and the part that is not compared."""

    checked: str
    differences: list[Difference]
    not_compared: str = ""


TIMES = ("time", "asked_time", "plain_time")
TIMES_NOT_COMPARED = "times, which differ from run to run"


def is_timing(name: str) -> bool:
    """Return whether a quantity is a time or follows from times."""
    return name.startswith(TIMES)


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
