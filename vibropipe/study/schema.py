"""The JSON schema and the table of keys of a study, generated from the models.

`python -m vibropipe.study` writes both into `config/`; a test fails if they are out of date.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel

from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.keys.grids import A_GRID, RangeGrid, ValueGrid
from vibropipe.scenes.keys.motions import MotionKeys
from vibropipe.scenes.keys.parts import (
    DisplayUnits,
    ExciterKeys,
    Follow,
    Solver,
    Start,
    StudyPhysical,
)
from vibropipe.scenes.keys.problems import Problem, StudyError
from vibropipe.scenes.kind import Kind
from vibropipe.scenes.registry import kinds
from vibropipe.study.key_text import allowed_text, keys_of
from vibropipe.study.loading import Config
from vibropipe.study.models import Hero, ReportTable, study_model
from vibropipe.study.quantities import WRITTEN
from vibropipe.words.parameters import PARAMETERS, STARTS
from vibropipe.words.spelling import OLD_KEYS, greek

BEGIN = "<!-- table of keys: begin, written by `python -m vibropipe.study` -->"
END = "<!-- table of keys: end -->"


def json_schema() -> dict[str, Any]:
    """Return the JSON schema (draft 2020-12) of a study, by which editors check it."""
    schema: dict[str, Any] = _tidy(study_model().model_json_schema())
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    return {**head, **schema, **_names_without_ties()}


def _names_without_ties() -> dict[str, Any]:
    """Return the rule that names of one's own vary only beside ties, of the study or of the scene."""
    names = [*PARAMETERS, *STARTS, *(each for each in WRITTEN.values() if each not in PARAMETERS)]
    known = {"propertyNames": {"enum": [*dict.fromkeys([*names, *map(greek, names)])]}}
    tied = [kind.name for kind in kinds().values() if kind.keys.FOLLOWS_TIES]
    untied = {"not": {"required": ["ties"]}}
    scene = {
        "if": {**untied, "properties": {"kind": {"enum": tied}}},
        "then": {"properties": {"over": known, "along": known, "vary": known}},
    }
    return {"if": untied, "then": {"properties": {"scenes": {"additionalProperties": scene}}}}


def _tidy(node: Any) -> Any:
    """Return a schema that allows Greek spellings, forbids empty values and lacks pydantic's titles."""
    if isinstance(node, list):
        return [_tidy(entry) for entry in node]
    if not isinstance(node, dict):
        return node
    choices = node.get("anyOf", [])
    if {"type": "null"} in choices:
        others = [choice for choice in choices if choice != {"type": "null"}]
        node = {key: value for key, value in node.items() if key != "anyOf"}
        node = {**node, **others[0]} if len(others) == 1 else {**node, "anyOf": others}
    tidy = {key: _tidy(value) for key, value in node.items() if not _is_noise(key, value)}
    if isinstance(tidy.get("properties"), dict):
        properties = tidy["properties"]
        properties |= {greek(key): value for key, value in properties.items()}
        properties |= {old: properties[key] for old, key in OLD_KEYS.items() if key in properties}
    if "propertyNames" in tidy and "enum" in tidy["propertyNames"]:
        names = tidy["propertyNames"]["enum"]
        tidy["propertyNames"]["enum"] = list(dict.fromkeys([*names, *map(greek, names)]))
    if tidy.get("enum", [])[: len(PARAMETERS)] == list(PARAMETERS):
        units = [name for name in WRITTEN.values() if name not in PARAMETERS]
        tidy["enum"] = [
            *tidy["enum"],
            *units,
            *(greek(name) for name in units if greek(name) != name),
        ]
    return tidy


def _is_noise(key: str, value: Any) -> bool:
    """Return whether an entry is a title of pydantic or an empty default."""
    return (key == "title" and isinstance(value, str)) or (key == "default" and value in (None, ""))


def table_of_keys() -> str:
    """Return the tables of all keys in Markdown, one for each mapping of a study."""
    common = tuple(BaseScene.model_fields)
    parts = [
        _table("`config.yaml`", Config),
        _table("A study, `<study>.yaml`", study_model()),
        _table("`hero` of a study", Hero),
        _table("`table` of a study", ReportTable),
        _table("Every scene", BaseScene, "Beside `kind` and the keys of that kind."),
        *(part for kind in kinds().values() for part in _kind_tables(kind, common)),
        _table(
            "`exciter`",
            ExciterKeys,
            note="Also spelled `ν`, `δ`, `R₁`, `R₂`. In brackets: if given nowhere.",
        ),
        _table(
            "`physical` of a study",
            StudyPhysical,
            note=(
                "In place of `exciter`, which then gives only what has no unit: R1, R2, friction_ratio, contact_1, "
                "contact_2 and wear_exponent. Grids and starts have units, too, and "
                "`over` and `follow` name `omega`, `F`, `H`. A scene or a motion may have a `physical` of its own, "
                "without `m` and `C`. Also spelled `ω`, `δ`."
            ),
        ),
        _table("`units` of a study", DisplayUnits, note="For a study with `physical`."),
        _table("`start`", Start),
        _table("One of `motions`", MotionKeys),
        _table("`follow`", Follow),
        _table("`solver`", Solver),
        _table("A grid as a range", RangeGrid, note=f"A grid is {A_GRID}."),
        _table("A grid by its values", ValueGrid, note="A plain list says the same."),
    ]
    return "\n\n".join(parts)


def _kind_tables(kind: Kind, common: tuple[str, ...]) -> Iterator[str]:
    """Yield the tables of one kind: its keys, mappings of its own, and the keys that only its motions have."""
    name = f"`kind: {kind.name}`"
    yield _table(name, kind.keys, without=common)
    for key in ("over", "figure"):
        model = kind.keys.model_fields[key].annotation if key in kind.keys.model_fields else None
        if isinstance(model, type) and issubclass(model, BaseModel) and model.model_fields:
            yield _table(f"`{key}` of {name}", model)
    motions = kind.keys.model_fields.get("motions")
    entry = get_args(motions.annotation)[1] if motions else MotionKeys
    if entry is not MotionKeys:
        common_keys = tuple(MotionKeys.model_fields)
        yield _table(
            f"One of `motions` of {name}",
            entry,
            "Beside `exciter`, `start` and `periods`.",
            common_keys,
        )


def _table(
    title: str, model: type[BaseModel], note: str = "", without: tuple[str, ...] = ()
) -> str:
    lines = [f"### {title}", ""]
    if note:
        lines += [note, ""]
    lines += ["| key | takes | default | meaning |", "|---|---|---|---|"]
    for name, field in keys_of(model).items():
        if name in without:
            continue
        default = (
            "required"
            if field.is_required()
            else _default(field.get_default(call_default_factory=True))
        )
        nested = isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel)
        takes = f"see `{name}`" if nested else allowed_text(field).replace("|", "\\|")
        lines.append(f"| `{name}` | {takes} | {default} | {field.description} |")
    return "\n".join(lines)


def _default(value: Any) -> str:
    if value is None or value == "" or isinstance(value, BaseModel):
        return ""
    if isinstance(value, list):
        return f"`[{', '.join(f'{v:g}' if isinstance(v, float) else str(v) for v in value)}]`"
    return f"`{value:g}`" if isinstance(value, float) else f"`{value}`"


def schema_text() -> str:
    """Return the text of `config/study.schema.json`."""
    return json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n"


def readme_text(old: str) -> str:
    """Return the text of `config/README.md` with its table of keys renewed."""
    head, begin, body = old.partition(BEGIN)
    _, end, tail = body.partition(END)
    if not begin or not end:
        must = f"must have the lines {BEGIN} and {END}"
        raise StudyError("README.md", [Problem((), "no table of keys", must=must)])
    return f"{head}{BEGIN}\n\n{table_of_keys()}\n\n{END}{tail}"


def write(folder: Path) -> None:
    """Write the schema and renew the table of keys in a folder with a `README.md`."""
    (folder / "study.schema.json").write_text(schema_text(), encoding="utf-8")
    readme = folder / "README.md"
    readme.write_text(readme_text(readme.read_text(encoding="utf-8")), encoding="utf-8")
