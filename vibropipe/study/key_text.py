"""The values that a key takes, as text derived from the models, for messages and for the table of keys."""

from __future__ import annotations

import types
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.keys.grids import A_GRID, RangeGrid, ValueGrid
from vibropipe.scenes.keys.motions import MotionKeys
from vibropipe.scenes.keys.values import Rule
from vibropipe.scenes.registry import kinds
from vibropipe.study.models import study_model

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
