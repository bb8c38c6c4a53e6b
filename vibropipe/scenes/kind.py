"""A kind of scene: one record that binds the modules of its folder.

A kind is a package with the following modules. All but `keys` are imported on first use, so that a command that
only reads studies loads neither kernels nor matplotlib.

`keys`      the model of its keys, the checks that involve several keys (`CHECKS`), and `plan(scene) -> Work`: its cost
`solve`     `solve(scene, progress) -> Dataset`: its solution in memory
`pictures`  `PICTURES`: its pictures; by default the first that fits the data is drawn
`report`    `REPORT`: its part of the report
`cut`       only for a kind that can be cut into shards: `store`, `join` and `row_range`; and, only where blocks of rows
            can be solved again, `recompute(path, scene, rows, generator) -> Recomputed`
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibropipe.compiler.sources import file_hash
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.keys.checks import Check
from vibropipe.scenes.keys.problems import Problem
from vibropipe.words.progress import Progress

if TYPE_CHECKING:
    from collections.abc import Iterator

    import xarray as xr
    from matplotlib.figure import Figure

    from vibropipe.report.parts import Answers, Line, Side, Table
    from vibropipe.scenes.costs import Work
    from vibropipe.scenes.rows import Recomputed

MAX_TITLE = 85  # letters of the title of a picture


def showing(options: Any, others: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Return the key `show` of the figure options, empty without options, as a keyword of a picture."""
    return {"show": tuple(options.show) if options is not None else ()}


@dataclass(frozen=True)
class Picture:
    """One picture of a kind of scene.

    Parameters
    ----------
    name : str
        Name in the key `figure.pictures`.
    drawn : callable
        Takes the dataset and keywords; returns the figure, 16 or 7.75 cm wide (`figures.canvas`).
    described : callable
        Takes the same; returns the caption, below the figure: what is drawn, parameters, marks, scatter.
    fits : callable
        Takes a dataset; returns whether the picture can show it (default: any).
    keywords : callable
        Takes the scene's figure options (or None) and the study's datasets by scene; returns the keywords of the
        others (default: none).
    titled : callable
        Takes the same as `drawn`; returns the title, above the figure: a sentence without full stop that says what
        is seen, at most 85 letters (default, or if empty: the title of the scene).
    heading : str
        A question; the picture and what follows it stand under it.
    """

    name: str
    drawn: Callable[..., Figure]
    described: Callable[..., str]
    fits: Callable[[xr.Dataset], bool] = lambda dataset: True
    keywords: Callable[[Any, Mapping[str, xr.Dataset]], dict[str, Any]] = lambda options, others: {}
    titled: Callable[..., str] = lambda dataset, **keywords: ""
    heading: str = ""

    def draw(self, dataset: xr.Dataset, options: Any, others: Mapping[str, xr.Dataset]) -> Figure:
        """Return the figure."""
        return self.drawn(dataset, **self.keywords(options, others))

    def describe(self, dataset: xr.Dataset, options: Any, others: Mapping[str, xr.Dataset]) -> str:
        """Return the caption."""
        return self.described(dataset, **self.keywords(options, others))

    def title(self, dataset: xr.Dataset, options: Any, others: Mapping[str, xr.Dataset]) -> str:
        """Return the title; empty if it is that of the scene."""
        return self.titled(dataset, **self.keywords(options, others))


@dataclass(frozen=True)
class ReportPart:
    """Part of a study's report, written from the datasets of one kind by the labels of its scenes.

    Parameters
    ----------
    noun : str
        What the kind is about, in the line above the title.
    question : str or callable
        The question that the report answers unless the study has one, or a function that takes the datasets.
    answers : callable
        Takes the datasets; returns the answers of each scene, at most three. Those of the scene of the hero stand on
        page 1, the others beside their figures.
    tables : callable
        Takes the datasets; returns the tables.
    methods : callable
        Takes the datasets; returns at most two lines on what is particular to the kind.
    side : callable, optional
        Takes the datasets, that of the hero first; returns what stands beside the answers (default: the exciter with
        its numbers in all scenes).
    rank : int
        The hero is the first picture of the kind with the lowest rank, unless the study chooses it.
    """

    noun: str
    question: str | Callable[[Mapping[str, xr.Dataset]], str]
    answers: Callable[[Mapping[str, xr.Dataset]], Answers] = lambda datasets: {}
    tables: Callable[[Mapping[str, xr.Dataset]], list[Table]] = lambda datasets: []
    methods: Callable[[Mapping[str, xr.Dataset]], list[Line]] = lambda datasets: []
    side: Callable[[Mapping[str, xr.Dataset]], Side] | None = None
    rank: int = 1

    def asked(self, datasets: Mapping[str, xr.Dataset]) -> str:
        """Return the question of the datasets."""
        return self.question if isinstance(self.question, str) else self.question(datasets)


@dataclass(frozen=True)
class Kind:
    """One kind of scene.

    Parameters
    ----------
    package : str
        The package of its modules; its last part is the name of the kind in the key `kind`.
    keys : type of BaseScene
        The model of its keys.
    checks : tuple of Check
        Checks that involve several keys of one scene.
    unit : str
        Unit of progress, in the plural.
    check_among : callable
        Takes a scene, the scenes of its study and the names of invalid ones; yields problems of the scene.
    can_be_cut : bool
        Whether its shards can be solved independently; it then has the module `cut`.
    is_timed : bool
        Whether its data are times; such a scene runs alone on all cores.
    packages : tuple of str
        Further packages that its data depend on, for the provenance.
    holds : callable
        Takes a dataset that does not say of which kind it is, such as one made in Python; returns whether it is of
        this kind (default: of none).
    """

    package: str
    keys: type[BaseScene]
    checks: tuple[Check, ...]
    unit: str
    check_among: Callable[[Any, Mapping[str, BaseScene], Collection[str]], Iterator[Problem]] = (
        lambda scene, scenes, broken: iter(())
    )
    can_be_cut: bool = False
    is_timed: bool = False
    packages: tuple[str, ...] = ()
    holds: Callable[[xr.Dataset], bool] = lambda dataset: False

    @property
    def name(self) -> str:
        """Name of the kind in a study."""
        return self.package.rpartition(".")[2]

    def _module(self, name: str) -> Any:
        return import_module(f"{self.package}.{name}")

    def plan(self, scene: Any) -> Work:
        """Return the planned work of a scene, the same on every machine."""
        return self._module("keys").plan(scene)

    def solve(self, scene: Any, progress: Progress | None = None) -> xr.Dataset:
        """Solve a scene in memory."""
        return self._module("solve").solve(scene, progress)

    def recompute(self, path: Path, scene: Any, rows: int, generator: Any) -> Recomputed:
        """Recompute a dataset and compare it; only a sample of at least `rows` rows by a kind whose `cut` has that."""
        from vibropipe.scenes.rows import whole_scene

        sampled = getattr(self.cut, "recompute", None) if self.can_be_cut else None
        if sampled is None:
            return whole_scene(path, self, scene)
        return sampled(path, scene, rows, generator)

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """All its pictures."""
        return self._module("pictures").PICTURES

    def pictures_of(self, dataset: xr.Dataset, chosen: tuple[str, ...] = ()) -> list[Picture]:
        """Return the chosen pictures, or the first that fits a dataset."""
        if chosen:
            by_name = {picture.name: picture for picture in self.pictures}
            return [by_name[name] for name in chosen]
        return [next(picture for picture in self.pictures if picture.fits(dataset))]

    @property
    def report(self) -> ReportPart:
        """Its part of the report."""
        return self._module("report").REPORT

    @property
    def cut(self) -> Any:
        """The module `cut` of a kind that can be cut."""
        return self._module("cut")

    @functools.cached_property
    def code_hash(self) -> str:
        """Hash (16 hex digits) of the module `solve`, which maps a scene to calls of the solvers."""
        spec = find_spec(self.package)
        if spec is None or spec.origin is None:
            raise ModuleNotFoundError(f"{self.package}: there is no such package")
        return file_hash(Path(spec.origin).with_name("solve.py"))
