"""Misspelt keys at the top of a study."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from vibropipe.scenes.keys.problems import Problem, unknown
from vibropipe.words.spelling import nearest


def without_slips(
    tree: dict[str, Any], known: Collection[str]
) -> tuple[dict[str, Any], list[Problem]]:
    """Return a tree under the keys that were meant, and the fault of each misspelt one.

    What follows then finds only faults that a misspelt key does not explain: without `physical`, every unit is one.
    """
    renamed = dict(tree)
    problems = []
    for key in tree:
        meant = None if key in known else nearest(key, known)
        if meant is not None and meant not in renamed:
            renamed[meant] = renamed.pop(key)
            problems.append(unknown((key,), list(known)))
    return renamed, problems
