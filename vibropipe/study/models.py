"""The models of a study: its head, and its scenes, whose kinds the registry lists.

Every key has a description. The JSON schema and the table of keys in `config/README.md` are generated from these
classes. Rules that tie several keys together are defined by each kind of scene.
"""

from __future__ import annotations

import functools
import operator
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Discriminator, Field, PrivateAttr, Tag, create_model

from vibropipe.figures.units import display_units
from vibropipe.scenes.keys.base import (
    BaseScene,
    Cell,
    Conclusion,
    Prose,
    Question,
    Title,
    drawn_by_others,
)
from vibropipe.scenes.keys.grids import StudyModel
from vibropipe.scenes.keys.parts import DisplayUnits, ExciterKeys, StudyPhysical, Ties
from vibropipe.scenes.keys.problems import REQUIRED, KeyPath, Problem, StudyError, one_of
from vibropipe.scenes.keys.values import Name, NotNull
from vibropipe.scenes.kind import Kind
from vibropipe.scenes.registry import kind_of, kinds
from vibropipe.solve.shown_units import DISPLAY_UNITS, display_units_of, units_as_text
from vibropipe.study.tables import Files
from vibropipe.words.spelling import did_you_mean
from vibropipe.words.wording import count

if TYPE_CHECKING:
    import xarray as xr


def check_study(study: Study, broken: frozenset[KeyPath]) -> Iterator[Problem]:
    """Check the rules of all scenes.

    study : a study whose single keys are valid
    broken : paths of keys that are already reported
    Yields every further fault.
    """
    shared = {path[1:] for path in broken if path[:1] == ("exciter",) and len(path) > 1}
    faulty = {str(path[1]) for path in broken if path[:1] == ("scenes",) and len(path) == 2}
    for name, scene in study.scenes.items():
        own = {path[2:] for path in broken if path[:2] == ("scenes", name)}
        own |= {("exciter", *path) for path in shared if path[0] not in scene.exciter.explicit()}
        kind, own_ties = kind_of(scene), {*getattr(scene, "ties", ())}
        own_problems = [
            problem
            for reads, problems in kind.checks
            if not any(_meets(path, keys) for path in own for keys in reads)
            for problem in problems(scene)
        ]
        if study.ties and "ties" not in type(scene).model_fields:
            tied = one_of(
                each.name for each in kinds().values() if "ties" in each.keys.model_fields
            )
            must = f"must be {tied} beside ties of the study: other kinds have none"
            own_problems.append(Problem(("kind",), repr(kind.name), must=must))
        for problem in (*own_problems, *kind.check_among(scene, study.scenes, faulty)):
            if problem.path[:1] == ("ties",) and not own_ties.intersection(
                problem.path[1:] or own_ties
            ):
                yield problem  # of the study
                continue
            is_there = any(path[: len(problem.path)] == problem.path for path in own)
            if not (is_there and problem.must.startswith(REQUIRED)):
                yield replace(problem, path=("scenes", name, *problem.path))
    if study.table is not None and not any(path[:1] == ("table",) for path in broken):
        yield from _check_table(study.table)
    if study.hero is not None and not any(path[:1] == ("hero",) for path in broken):
        yield from _check_hero(study, study.hero, faulty)


def _check_table(table: ReportTable) -> Iterator[Problem]:
    """Check that each row of a table has as many cells as its head."""
    for number, row in enumerate(table.rows):
        if len(row) != len(table.head):
            must = f"must have a text for each of the {count(len(table.head), 'column')}"
            yield Problem(("table", "rows", number), count(len(row), "text"), must=must)


def _check_hero(study: Study, hero: Hero, faulty: Collection[str]) -> Iterator[Problem]:
    """Check that the picture on page 1 is drawn by a scene of the study."""
    if hero.scene in faulty:
        return
    if hero.scene not in study.scenes:
        allowed = f"a scene of the study ({', '.join(study.scenes)})"
        hint = did_you_mean(hero.scene, study.scenes)
        yield Problem(("hero", "scene"), repr(hero.scene), allowed, hint)
        return
    if hero.scene in drawn_by_others(study.scenes):
        must = "must name a scene with a picture of its own, not one that another draws together with itself"
        yield Problem(("hero", "scene"), repr(hero.scene), must=must)
        return
    drawn = study.scenes[hero.scene].figure.chosen()
    if hero.picture is not None and hero.picture not in drawn:
        key = f"scenes.{hero.scene}.figure.pictures"
        found, hint = repr(hero.picture), did_you_mean(hero.picture, drawn)
        if drawn:
            allowed = f"one of the pictures in {key} ({', '.join(drawn)})"
            yield Problem(("hero", "picture"), found, allowed, hint)
        else:
            yield Problem(("hero", "picture"), found, must=f"must be left out, or in {key}")


def _meets(path: KeyPath, keys: KeyPath) -> bool:
    """Return whether one of two paths contains the other."""
    length = min(len(path), len(keys))
    return path[:length] == keys[:length]


class Hero(StudyModel):
    """The picture on page 1 of the report."""

    scene: Name = Field(description="The scene whose picture it is.")
    picture: Annotated[Name | None, NotNull] = Field(
        default=None, description="One of the pictures that the scene draws (default: its first)."
    )


class ReportTable(StudyModel):
    """A table of the study's own in its report."""

    title: Title = Field(description="Title above the table, one line.")
    head: Annotated[list[Cell], Field(min_length=1, max_length=6)] = Field(
        description="Heads of the columns."
    )
    rows: Annotated[list[list[Cell]], Field(min_length=1, max_length=12)] = Field(
        description="Rows, each with a text for every column."
    )
    note: Prose = Field(default="", description="Note below the table.")


class Study(StudyModel):
    """A study: shared parameters and named scenes; its name is that of the file without suffix."""

    title: Title = Field(description="Title of the study and of its report.")
    question: Question = Field(
        default="",
        description="The question that the study answers, below the title (default: by the kind of its main scene).",
    )
    description: Prose = Field(
        default="", description="What the study is about; stands at the end of the report."
    )
    answers: Annotated[list[Conclusion], Field(max_length=3)] = Field(
        default=[],
        description="Answers of your own at the top of the report, at most three; the first sentence of each is bold "
        "(default: written from the data).",
    )
    table: Annotated[ReportTable | None, NotNull] = Field(
        default=None, description="A table of your own, below the picture on page 1."
    )
    hero: Annotated[Hero | None, NotNull] = Field(
        default=None,
        description="The picture on page 1 of the report (default: the first of the main scene).",
    )
    exciter: ExciterKeys = Field(
        default_factory=ExciterKeys, description="Parameters shared by all scenes."
    )
    ties: Ties = Field(
        default={},
        description="Parameters by expressions of others or of names of one's own, in all scenes, which then "
        "are motions, sweeps, branches, boundaries, basins, designs and identifications.",
    )
    physical: Annotated[StudyPhysical | None, NotNull] = Field(
        default=None,
        description="Parameters with units, in place of those without; datasets are then in SI.",
    )
    units: Annotated[DisplayUnits | None, NotNull] = Field(
        default=None,
        description="Units of figures, tables, captions and texts, for a study with `physical` (default: those in "
        "which it is written).",
    )
    scenes: Annotated[dict[Name, BaseScene], Field(min_length=1, max_length=1000)] = Field(
        description="The scenes by name; the name becomes the name of files."
    )
    _name: str = PrivateAttr("")
    _source: str = PrivateAttr("")
    _files: Files | None = PrivateAttr(None)
    _display_units: str = PrivateAttr("")

    def model_post_init(self, context: Any) -> None:
        """Set the name and the shared parameters of each scene."""
        for name, scene in self.scenes.items():
            scene._name = name
            scene._shared = self.exciter.explicit()
            scene._shared_ties = self.ties
            if self.physical is not None:
                scene._mass_and_stiffness = (self.physical.m, self.physical.C)

    @property
    def name(self) -> str:
        """Name of the study; its results are in `results/<name>`."""
        return self._name

    @property
    def source(self) -> str:
        """File of the study, as messages name it."""
        return self._source

    @property
    def text(self) -> str:
        """Text of its file, with the tables that it names at the end; `study_of_text` reads it again."""
        if self._files and self._files.whole:
            return self._files.whole
        text = Path(self._source).read_text(encoding="utf-8")
        return self._files.after(text) if self._files else text

    def set_units(self, written: Mapping[str, Any]) -> None:
        """Take the units in which it shows its results from the study as it is written."""
        if self.physical is not None:
            chosen = {} if self.units is None else self.units.model_dump(exclude_none=True)
            units = display_units_of(written, chosen)
            self._display_units = units_as_text(units)
            for scene in self.scenes.values():
                scene._units = units

    @property
    def display_units(self) -> str:
        """Units in which a study with `physical` shows its results, as the attribute of datasets; else empty."""
        return self._display_units

    @property
    def units_attrs(self) -> dict[str, str]:
        """The attribute of datasets with these units; none without `physical`."""
        return {DISPLAY_UNITS: self.display_units} if self.display_units else {}

    def shown(
        self, datasets: Mapping[str, xr.Dataset], prefixes: bool = True
    ) -> dict[str, xr.Dataset]:
        """Return its datasets in the units in which it shows them; `prefixes` as in `display_units`."""
        named = {name: data.assign_attrs(self.units_attrs) for name, data in datasets.items()}
        return display_units(named, prefixes)

    @property
    def fingerprints(self) -> dict[str, str]:
        """Fingerprint of each scene by name."""
        return {name: scene.fingerprint() for name, scene in self.scenes.items()}

    def scene(self, name: str) -> Any:
        """Return a scene by name.

        Raises StudyError if there is no such scene; the message suggests the nearest name.
        """
        if name not in self.scenes:
            hint = did_you_mean(name, self.scenes)
            problem = Problem(("scene",), repr(name), one_of(self.scenes), hint)
            raise StudyError(self._source or "study", [problem])
        return self.scenes[name]


def _kind(value: Any) -> str | None:
    kind = value.get("kind") if isinstance(value, dict) else getattr(value, "kind", None)
    return f"<{kind}>" if isinstance(kind, str) else None


def study_model() -> type[Study]:
    """Return the model of a study whose scenes are of the registered kinds."""
    return _study_model(tuple(kinds().values()))


@functools.cache
def _study_model(registered: tuple[Kind, ...]) -> type[Study]:
    tagged: list[Any] = [Annotated[kind.keys, Tag(f"<{kind.name}>")] for kind in registered]
    scene: Any = Annotated[functools.reduce(operator.or_, tagged), Discriminator(_kind)]
    field = Study.model_fields["scenes"]
    scenes = Annotated[dict[Name, scene], Field(min_length=1, max_length=1000)]
    model: type[Study] = create_model(
        "Study", __base__=Study, scenes=(scenes, Field(description=field.description))
    )
    return model
