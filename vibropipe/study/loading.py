"""From files to checked studies. One StudyError reports every fault of a file."""

from __future__ import annotations

import copy
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, Field, PrivateAttr, ValidationError

from vibropipe.scenes.keys.grids import StudyModel
from vibropipe.scenes.keys.parts import OWN
from vibropipe.scenes.keys.problems import (
    KeyPath,
    Problem,
    StudyError,
    describe,
    distinct,
    repeated,
)
from vibropipe.scenes.keys.ties import own_names
from vibropipe.scenes.keys.values import NAME, Name, NameRule, TextRule, refuse
from vibropipe.study.key_text import plain_path, problem_of
from vibropipe.study.models import Study, check_study, study_model
from vibropipe.study.physical import (
    as_written,
    both_paths,
    is_physical,
    without_slips,
    without_units,
)
from vibropipe.study.tables import Files, with_tables
from vibropipe.study.yaml_reader import MAX_DEPTH, read_file, read_text, too_deep
from vibropipe.words.spelling import did_you_mean, latin

# Brackets mark the steps of a path that pydantic inserts (`<motion>`, `[key]`).
_BRACKETS = re.compile(r"[<>\[\]]")

Model = TypeVar("Model", bound=BaseModel)


def _separate(value: Any) -> Any:
    # `snakemake --config studies=paper,regimes` passes one string.
    return (
        [name for name in re.split(r"[,\s]+", value) if name] if isinstance(value, str) else value
    )


def _names_once(names: list[str]) -> list[str]:
    if len(set(names)) < len(names):
        refuse(found=", ".join(names), must="must have each study once")
    return names


class Config(StudyModel):
    """`config/config.yaml`: the studies of the default run and the folder of results."""

    studies: Annotated[
        list[Name], Field(min_length=1), BeforeValidator(_separate), AfterValidator(_names_once)
    ] = Field(description="Names of the studies of the default run; each is `config/<name>.yaml`.")
    results: Annotated[str, TextRule(1000)] = Field(
        default="results", description="Folder of all results."
    )
    _folder: Path = PrivateAttr(default_factory=Path)
    _files: dict[str, Path] = PrivateAttr(default_factory=dict)

    def study_file(self, name: str) -> Path:
        """Return the file of a study: the one that was given, else the one beside the list of studies."""
        return self._files.get(name, self._folder / f"{name}.yaml")


def load_config(path: str | Path) -> Config:
    """Read and check a list of studies; each study is a file beside it.

    Raises StudyError with every fault of the file, missing studies included.
    """
    file = Path(path)
    tree, problems = read_file(file)
    config = parse_config(tree, file.parent, source=str(file), problems=problems)
    missing = list(_missing(config, file))
    if missing:
        raise StudyError(str(file), missing)
    return config


def _missing(config: Config, file: Path) -> Iterator[Problem]:
    """Yield the studies of the list that have no file, each with the nearest name that has one."""
    there = sorted(
        entry.stem for entry in file.parent.glob("*.yaml") if entry != file and entry.is_file()
    )
    for place, name in enumerate(config.studies):
        if not config.study_file(name).is_file():
            found = f"{name!r}, but {config.study_file(name)} does not exist"
            allowed = (
                f"the name of a study beside this file ({', '.join(there) or 'there is none'})"
            )
            yield Problem(("studies", place), found, allowed, did_you_mean(name, there))


def parse_config(
    tree: Any, folder: Path, source: str = "config", problems: list[Problem] | None = None
) -> Config:
    """Check a list of studies from a tree of YAML values.

    folder : folder of the studies
    source : name of the file in messages
    problems : faults found while reading
    Raises StudyError with all faults.
    """
    tree, spelled = spell_out(_mapping(tree, source, Config))
    config, more = _validated(Config, tree)
    problems_so_far = distinct([*(problems or []), *spelled, *more])
    if problems_so_far or config is None:
        raise StudyError(source, problems_so_far)
    config._folder = folder
    return config


def config_of_files(studies: Any, results: Any) -> Config:
    """Return a list of studies from their files.

    studies : files of studies, or names of studies in `config` (no suffix); a string holds them separated by commas
    results : folder of all results
    Raises StudyError if two studies have one name, or a name is not valid for a study.
    """
    entries = [str(entry) for entry in _separate(studies)]
    files = {Path(entry).stem: Path(entry) for entry in entries if Path(entry).suffix}
    names = [Path(entry).stem for entry in entries]
    tree = {"studies": names, "results": results}
    config = parse_config(tree, Path("config"), source="the command line")
    config._files = files
    return config


def load_study(path: str | Path) -> Study:
    """Read and check a study; its name is that of the file without suffix.

    Raises StudyError with every fault of the file.
    """
    file = Path(path)
    tree, problems = read_file(file)
    if not NAME.fullmatch(file.stem):
        must = f"file name must be {NameRule().allowed}"
        problems.append(Problem((), describe(file.name), must=must))
    return parse_study(tree, file.stem, str(file), problems, Files(file.parent))


def study_of_text(text: str, name: str) -> Study:
    """Read and check a study from the text that a dataset contains. Raises StudyError with every fault of the text."""
    tree, problems = read_text(text, f"the study {name}")
    return parse_study(tree, name, f"the study {name}", problems, Files(None, text))


def parse_study(
    tree: Any,
    name: str = "study",
    source: str = "study",
    problems: list[Problem] | None = None,
    files: Files | None = None,
) -> Study:
    """Check a study from a tree of YAML values.

    source : name of the file in messages
    problems : faults found while reading
    files : where tables are read (default: the current folder)
    Raises StudyError with all faults.
    """
    tree, spelled = spell_out(_mapping(tree, source, Study))
    tree, slips = without_slips(tree, Study.model_fields)
    files = files or Files(Path())
    tree, unread = with_tables(tree, files)
    written = tree
    tree, misread = without_units(written)
    problems_so_far = [*slips, *(problems or []), *spelled, *unread, *misread]
    context = {OWN: own_names(tree)}
    study, invalid = _validated(study_model(), tree, context)
    broken = frozenset(problem.path for problem in (*problems_so_far, *invalid) if problem.covers)
    sound, dropped = (study, frozenset[KeyPath]()) if study else _salvage(tree, context)
    if sound is not None:
        invalid += check_study(sound, both_paths(broken | dropped))
    if is_physical(tree):
        invalid = [as_written(problem, written, tree) for problem in invalid]
    problems_so_far += invalid
    if problems_so_far or study is None:
        raise StudyError(source, distinct(problems_so_far))
    study._name, study._source, study._files = name, source, files
    study.set_units(written)
    return study


def _mapping(tree: Any, source: str, model: type[BaseModel]) -> dict[str, Any]:
    if isinstance(tree, dict):
        return tree
    allowed = f"a mapping with {', '.join(model.model_fields)}"
    raise StudyError(source, [Problem((), describe(tree), allowed)])


def spell_out(tree: Any, path: KeyPath = ()) -> tuple[Any, list[Problem]]:
    """Return the tree with Greek keys in Latin letters; names of scenes stay as they are."""
    if len(path) > MAX_DEPTH:
        return None, [too_deep(path)]
    if isinstance(tree, list):
        pairs = [spell_out(entry, (*path, index)) for index, entry in enumerate(tree)]
        return [entry for entry, _ in pairs], [problem for _, more in pairs for problem in more]
    if not isinstance(tree, dict):
        return tree, []
    spelled: dict[str, Any] = {}
    problems: list[Problem] = []
    for key, value in tree.items():
        if not isinstance(key, str):
            problems.append(Problem((*path, str(key)), describe(key), "a key of text"))
            continue
        if _BRACKETS.search(key):
            allowed = (
                NameRule().allowed if path == ("scenes",) else "a key of letters, digits and _"
            )
            problems.append(Problem((*path, key), describe(key), allowed))
            continue
        word = key if path == ("scenes",) else latin(key)
        inner, more = spell_out(value, (*path, word))
        problems += more
        if word in spelled:
            problems.append(repeated((*path, word), key))
        else:
            spelled[word] = inner
    return spelled, problems


def _validated(
    model: type[Model], tree: dict[str, Any], context: dict[str, Any] | None = None
) -> tuple[Model | None, list[Problem]]:
    try:
        return model.model_validate(tree, context=context), []
    except ValidationError as error:
        return None, [problem_of(entry, model) for entry in error.errors(include_url=False)]


def _salvage(
    tree: dict[str, Any], context: dict[str, Any]
) -> tuple[Study | None, frozenset[KeyPath]]:
    """Return the valid part of a faulty study (None if there is none), and the paths that were left out.

    The rules that tie keys together are checked on this part, so that one message reports their faults, too.
    """
    tree = copy.deepcopy(tree)
    dropped: set[KeyPath] = set()
    while isinstance(tree.get("scenes"), dict) and tree["scenes"]:
        try:
            return study_model().model_validate(tree, context=context), frozenset(dropped)
        except ValidationError as error:
            paths = {plain_path(entry["loc"]) for entry in error.errors(include_url=False)}
        dropped |= {_drop(tree, path) for path in paths}
    return None, frozenset(dropped)


def _drop(tree: dict[str, Any], path: KeyPath) -> KeyPath:
    """Delete the faulty key, or the scene that lacks a key, from a tree; return its path."""
    depth = 1
    if path[0] == "scenes":
        depth = 4 if path[2:3] in (("exciter",), ("over",), ("start",), ("ties",)) else 3
    elif path[0] == "exciter":
        depth = 2
    path = path[:depth]
    if path == ("title",):
        tree["title"] = "untitled"
        return path
    owner: Any = tree
    for step in path[:-1]:
        owner = owner.get(step, {}) if isinstance(owner, dict) else {}
    if path[-1] in owner:
        del owner[path[-1]]
    elif path[0] == "scenes":
        path = path[:2] if len(path) > 1 else path
        tree["scenes"].pop(path[-1], None) if len(path) > 1 else tree.pop("scenes")
    return path
