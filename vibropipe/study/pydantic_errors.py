"""From errors of pydantic to problems of a study, with numbers as its file has them: 30 Hz for 188.49555921538757."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from vibropipe.scenes.keys.grids import A_GRID
from vibropipe.scenes.keys.problems import (
    KeyPath,
    Problem,
    describe,
    one_of,
    required,
    unknown,
)
from vibropipe.scenes.keys.values import REFUSED
from vibropipe.scenes.registry import kinds
from vibropipe.study.key_text import allowed_text, field_at, keys_of, model_at, tags
from vibropipe.words.spelling import did_you_mean

_NUMBER = re.compile(r"-?\d[\d.]*(?:e[-+]?\d+)?", re.ASCII)


def quoted(found: str, numbers: Any, written: Any) -> str:
    """Return what a fault found with its numbers as they were written.

    found : what was found, with numbers as Python shows them
    numbers : the value of the faulty key, maybe with lists and mappings, as numbers
    written : the same value as in the file
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


def plain_path(loc: KeyPath) -> KeyPath:
    """Return the path of a pydantic error as in the file of the study, without tags of unions."""
    path: list[str | int] = []
    tagged = tags()
    for index, step in enumerate(loc):
        inside_list = index > 0 and loc[index - 1] == "<list>"
        if step not in tagged and step != "[key]" and not inside_list:
            path.append(step)
    return tuple(path)


def problem_of(error: Any, root: type[BaseModel]) -> Problem:
    """Return an error of pydantic as a problem of a study.

    error : one of `ValidationError.errors()`
    root : the model that was validated
    """
    loc, kind, value = error["loc"], error["type"], error["input"]
    context = error.get("ctx", {})
    path = plain_path(loc)
    found = describe(value)
    if kind in ("too_short", "too_long") and isinstance(value, dict) and value:
        found = f"a mapping of {len(value)}"
    if kind == REFUSED:
        return Problem(path, **{**context, "found": context["found"] or found})
    if kind == "extra_forbidden":
        owner = model_at(loc[:-1], root)
        return unknown(path, list(keys_of(owner)) if owner else [])
    if kind == "literal_error":
        choices = re.findall(r"'([^']*)'", context["expected"])
        if loc[-1] == "[key]":
            return unknown(path, choices)
        return Problem(path, found, one_of(choices), did_you_mean(value, choices))
    if kind.startswith("union_tag"):
        return _untagged(path, value)
    field = field_at(loc, root)
    allowed = allowed_text(field) if field else _model_words(loc, root)
    if kind == "missing":
        return required(path, allowed)
    return Problem(path, found, allowed, must="" if allowed else error["msg"])


def _model_words(loc: KeyPath, root: type[BaseModel]) -> str:
    model = model_at(loc, root)
    return f"a mapping with {', '.join(keys_of(model))}" if model else ""


def _untagged(path: KeyPath, value: Any) -> Problem:
    """Return the fault of a scene without a valid kind, or of a grid without a valid form."""
    if len(path) != 2 or path[0] != "scenes":
        return Problem(path, describe(value), A_GRID)
    known = list(kinds())
    if not isinstance(value, dict):
        return Problem(path, describe(value), f"a mapping with kind ({one_of(known)}) and its keys")
    if "kind" not in value:
        slip = next((key for key in value if did_you_mean(key, ["kind"])), None)
        hint = f"is {describe(slip)} meant to be it?" if slip else ""
        return required((*path, "kind"), one_of(known), hint=hint)
    kind = value["kind"]
    return Problem((*path, "kind"), describe(kind), one_of(known), did_you_mean(kind, known))
