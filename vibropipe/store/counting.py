"""Counting over a dataset's file without holding it in memory."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

import numpy as np

from vibropipe.store.shards import opened

__all__ = ["count_equal"]

# Values read at once.
SLAB = 2**22


def count_equal(path: str | PathLike[str], name: str, value: int) -> int:
    """Return how many values of the variable ``name`` are ``value``; 0 where there is no such variable.

    Raises StoreError if the file cannot be read.
    """
    with opened(Path(path)) as file:
        if name not in file.variables:
            return 0
        variable = file.variables[name]
        if not variable.dimensions:
            return int(np.asarray(variable[...]) == value)
        length = variable.shape[0]
        step = max(1, SLAB // max(1, variable.size // max(1, length)))
        parts = (variable[first : first + step] for first in range(0, length, step))
        return sum(int(np.count_nonzero(np.asarray(part) == value)) for part in parts)
