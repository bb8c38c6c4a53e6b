"""The values that a key takes, as text derived from the models, for messages and for the table of keys.

From errors of pydantic to problems of a study, with numbers as its file has them: 30 Hz for 188.49555921538757.
"""

from __future__ import annotations

import re
import types
from collections.abc import Iterator
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.keys.grids import A_GRID, RangeGrid, ValueGrid
from vibropipe.scenes.keys.motions import MotionKeys
from vibropipe.scenes.keys.problems import KeyPath, Problem, describe, one_of, required, unknown
from vibropipe.scenes.keys.values import REFUSED, Rule
from vibropipe.scenes.registry import kinds
from vibropipe.study.models import study_model
from vibropipe.words.spelling import did_you_mean
from vibropipe.words.wording import count

_GRIDS: dict[str, type[BaseModel]] = {
    "<values>": ValueGrid,
    "<list>": ValueGrid,
    "<range>": RangeGrid,
}

NUMBERS = ("none", "one", "two")


def tags() -> dict[str, type[BaseModel]]:
    """Return the model of each tag that pydantic inserts into paths."""
    return {**{f"<{kind.name}>": kind.keys for kind in kinds().values()}, **_GRIDS}


def allowed_text(field: FieldInfo) -> str:
    """Return the values that a key takes as text, such as `a finite number > 0`.

    Raises TypeError if the type of the key has no text.
    """
    for entry in field.metadata:
        if isinstance(entry, Rule):
            return entry.allowed
    text = _type_text(field.annotation)
    least, most = (
        next((n for entry in field.metadata if (n := getattr(entry, name, None))), 0)
        for name in ("min_length", "max_length")
    )
    if not least or not text.startswith("a mapping"):
        return text
    return f"{text}, {'exactly' if least == most else 'at least'} {NUMBERS[least]}"


def _type_text(annotation: Any) -> str:
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        rules = [entry.allowed for entry in arguments[1:] if isinstance(entry, Rule)]
        return rules[0] if rules else _type_text(arguments[0])
    if origin is Literal:
        return " or ".join(str(choice) for choice in arguments)
    if origin in (Union, types.UnionType):
        inner = [argument for argument in arguments if argument is not type(None)]
        return A_GRID if len(inner) > 1 else _type_text(inner[0])
    if origin is list:
        entry = _type_text(arguments[0])
        if entry.startswith("a list of "):
            return f"a list of lists of {entry.removeprefix('a list of ')}"
        nouns = [f"{noun}s" for noun in ("number", "name") if noun in entry]
        return f"a list of {nouns[0] if nouns else entry.replace(' or ', ', ')}"
    if origin is dict:
        return f"a mapping of {_entries(arguments[1])}"
    if annotation is bool:
        return "true or false"
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return f"a mapping with {', '.join(keys_of(annotation))}"
    raise TypeError(f"no words for {annotation!r}")


def _entries(annotation: Any) -> str:
    """Return the entries of a mapping as text."""
    while get_args(annotation):
        if any(isinstance(entry, Rule) for entry in get_args(annotation)[1:]) and (
            get_origin(get_args(annotation)[0]) is list
        ):
            return "lists of numbers by name"
        if get_origin(annotation) is list:
            return "pairs [low, high] by parameter"
        annotation = get_args(annotation)[0]
    if issubclass(annotation, (float, str)):
        return "numbers by name" if annotation is float else "text by name"
    if issubclass(annotation, MotionKeys):
        return "motions by name"
    if issubclass(annotation, BaseScene):
        return "scenes by name"
    if issubclass(annotation, (ValueGrid, RangeGrid)):
        return "grids by parameter"
    return f"{{{', '.join(keys_of(annotation))}}} by parameter"


def keys_of(model: type[BaseModel]) -> dict[str, FieldInfo]:
    """Return the fields of a model by key; a key that is a word of Python is the alias of its field."""
    return {field.alias or name: field for name, field in model.model_fields.items()}


def model_at(
    loc: tuple[str | int, ...], root: type[BaseModel] | None = None
) -> type[BaseModel] | None:
    """Return the model that the `loc` of a pydantic error points at, None if it points at none."""
    model: type[BaseModel] | None = root or study_model()
    tagged = tags()
    by_name = False  # whether the next step is a key of a mapping whose values share one model
    for step in loc:
        if by_name:
            by_name = False
        elif step in tagged:
            model = tagged[str(step)]
        else:
            field = keys_of(model).get(str(step)) if model else None
            model = _nested(field.annotation) if field else None
            by_name = (
                model is not None and field is not None and get_origin(field.annotation) is dict
            )
    return model


def field_at(loc: tuple[str | int, ...], root: type[BaseModel] | None = None) -> FieldInfo | None:
    """Return the field that the `loc` of a pydantic error points at, None if it points at none."""
    owner = model_at(loc[:-1], root) if loc else None
    return keys_of(owner).get(str(loc[-1])) if owner else None


def _nested(annotation: Any) -> type[BaseModel] | None:
    """Return the model inside an annotation: itself, that of an optional key, or that of the values of a mapping."""
    if isinstance(annotation, type):
        return annotation if issubclass(annotation, BaseModel) else None
    if get_origin(annotation) in (Union, types.UnionType):
        inner = [argument for argument in get_args(annotation) if argument is not type(None)]
        return _nested(inner[0]) if len(inner) == 1 else None
    if get_origin(annotation) is dict:
        return _nested(get_args(annotation)[1])
    return None


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
    if kind in ("too_short", "too_long") and value:
        if isinstance(value, list):
            side, n = ("least", "min_length") if kind == "too_short" else ("most", "max_length")
            must = f"must have at {side} {count(context[n], 'entry', 'entries')}"
            return Problem(path, found, must=must)
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
