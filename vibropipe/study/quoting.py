"""Numbers of a fault as the file of a study has them: 30 Hz for 188.49555921538757."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from vibropipe.scenes.keys.problems import KeyPath, describe

_NUMBER = re.compile(r"-?\d[\d.]*(?:e[-+]?\d+)?", re.ASCII)


def quoted(found: str, numbers: Any, written: Any) -> str:
    """Return what a fault found with its numbers as they were written.

    Parameters
    ----------
    found : str
        What was found, with numbers as Python shows them.
    numbers : object
        The value of the faulty key, maybe with lists and mappings, as numbers.
    written : object
        The same value as in the file.
    """
    if isinstance(written, str) and found == repr(numbers):
        return describe(written)
    texts = dict(_texts(numbers, written))
    return _NUMBER.sub(lambda match: texts.get(match[0], match[0]), found)


def entry(tree: Any, path: KeyPath) -> Any:
    """Return what stands at a path of a tree; None if nothing does."""
    for step in path:
        if isinstance(tree, dict):
            tree = tree.get(step)
        elif isinstance(tree, list) and isinstance(step, int) and step < len(tree):
            tree = tree[step]
        else:
            return None
    return tree


def _texts(numbers: Any, written: Any) -> Iterator[tuple[str, str]]:
    """Yield each number as Python shows it, with its text in the file."""
    if isinstance(numbers, dict) and isinstance(written, dict):
        for key in numbers.keys() & written.keys():
            yield from _texts(numbers[key], written[key])
    elif isinstance(numbers, list) and isinstance(written, list):
        for one, other in zip(numbers, written, strict=False):
            yield from _texts(one, other)
    elif isinstance(numbers, float) and isinstance(written, (str, int, float)):
        yield repr(numbers), str(written)
