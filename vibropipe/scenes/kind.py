"""A kind of scene: one record that binds the rooms of its folder.

A kind is a package with these modules; all but `keys` are imported on first use, so that a command that only
reads studies loads neither kernels nor matplotlib:

`keys`      the model of its keys and the rules that tie them (`CHECKS`)
`plan`      `plan(scene) -> Work` and `estimate(scene, sampler) -> Estimate`: what it will cost
`solve`     `solve(scene, progress) -> Dataset`: the scene, whole and in memory
`pictures`  `PICTURES`: its pictures, the first that fits drawn where the study chooses none
`report`    `REPORT`: its part of the report
`verify`    `recompute(path, scene, rows, generator) -> Recomputed`: a sample computed again and compared
`cut`       of a kind that can be cut into shards: `store`, `join` and `row_range`
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

if TYPE_CHECKING:
    from collections.abc import Iterator

    import xarray as xr
    from matplotlib.figure import Figure

    from vibropipe.report.section import Section
    from vibropipe.scenes.costs import Estimate, Sampler, Work
    from vibropipe.scenes.recompute import Recomputed

Progress = Callable[[int, int], None]  # called as progress(done, total); total is 0 where unknown


@dataclass(frozen=True)
class Picture:
    """One picture of a kind of scene.

    Parameters
    ----------
    name : str
        What a study chooses it by.
    fits : callable
        Whether a dataset can be drawn so.
    draw, describe : callable
        Take the dataset, the scene's figure options (None for none) and the study's datasets by scene; return
        the figure, and what to see in it.
    """

    name: str
    fits: Callable[[xr.Dataset], bool]
    draw: Callable[[xr.Dataset, Any, Mapping[str, xr.Dataset]], Figure]
    describe: Callable[[xr.Dataset, Any, Mapping[str, xr.Dataset]], str]


def only_picture(
    name: str,
    draw: Callable[[xr.Dataset], Figure],
    describe: Callable[[xr.Dataset], str],
    fits: Callable[[xr.Dataset], bool] = lambda dataset: True,
) -> Picture:
    """Return a picture that has no options."""
    return Picture(
        name,
        fits,
        lambda dataset, options, others: draw(dataset),
        lambda dataset, options, others: describe(dataset),
    )


def _no_sections(datasets: Mapping[str, xr.Dataset]) -> list[Section]:
    return []


def _no_notes(datasets: Mapping[str, xr.Dataset]) -> list[str]:
    return []


@dataclass(frozen=True)
class ReportPart:
    """What a kind of scene adds to the report of a study, from the datasets of that kind by scene.

    sections: further sections; accuracy_notes: sentences about how far the numbers can be trusted.
    """

    sections: Callable[[Mapping[str, xr.Dataset]], list[Section]] = _no_sections
    accuracy_notes: Callable[[Mapping[str, xr.Dataset]], list[str]] = _no_notes


def _no_problems(
    scene: Any, scenes: Mapping[str, BaseScene], broken: Collection[str]
) -> Iterator[Problem]:
    return iter(())


@dataclass(frozen=True)
class Kind:
    """One kind of scene.

    Parameters
    ----------
    package : str
        The package that holds its rooms; its last part is the name of the kind, as `kind:` in a study says it.
    keys : type of BaseScene
        The model of its keys.
    checks : tuple of Check
        Rules that tie keys of one scene.
    unit : str
        What progress counts, in the plural.
    check_among : callable
        Yields faults of a scene among the scenes of its study, told the names of those already known as faulty.
    can_be_cut : bool
        Whether shards of it can be solved apart; the room `cut` is there.
    is_timed : bool
        Whether its data are times; such a scene has all cores to itself and is told apart by `lab_hash`.
    packages : tuple of str
        Packages that take part beside the usual ones, for the provenance.
    """

    package: str
    keys: type[BaseScene]
    checks: tuple[Check, ...]
    unit: str
    check_among: Callable[[Any, Mapping[str, BaseScene], Collection[str]], Iterator[Problem]] = (
        _no_problems
    )
    can_be_cut: bool = False
    is_timed: bool = False
    packages: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The kind as a study says it."""
        return self.package.rpartition(".")[2]

    def _room(self, name: str) -> Any:
        return import_module(f"{self.package}.{name}")

    def plan(self, scene: Any) -> Work:
        """Return the work of a scene; the same on every machine."""
        work: Work = self._room("plan").plan(scene)
        return work

    def estimate(self, scene: Any, sampler: Sampler) -> Estimate:
        """Return what a scene will take on this machine."""
        estimate: Estimate = self._room("plan").estimate(scene, sampler)
        return estimate

    def solve(self, scene: Any, progress: Progress | None = None) -> xr.Dataset:
        """Solve a scene in memory."""
        dataset: xr.Dataset = self._room("solve").solve(scene, progress)
        return dataset

    def recompute(self, path: Path, scene: Any, rows: int, generator: Any) -> Recomputed:
        """Compute at least `rows` rows of a dataset again, where there are as many, and compare them."""
        found: Recomputed = self._room("verify").recompute(path, scene, rows, generator)
        return found

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """All its pictures."""
        pictures: tuple[Picture, ...] = self._room("pictures").PICTURES
        return pictures

    def pictures_of(self, dataset: xr.Dataset, chosen: tuple[str, ...] = ()) -> list[Picture]:
        """Return the pictures chosen, or the first that fits a dataset."""
        if chosen:
            by_name = {picture.name: picture for picture in self.pictures}
            return [by_name[name] for name in chosen]
        return [next(picture for picture in self.pictures if picture.fits(dataset))]

    @property
    def report(self) -> ReportPart:
        """Its part of the report."""
        part: ReportPart = self._room("report").REPORT
        return part

    @property
    def cut(self) -> Any:
        """The room of a kind that can be cut."""
        return self._room("cut")

    @functools.cached_property
    def code_hash(self) -> str:
        """Hash (16 hex digits) of what turns a scene of this kind into numbers, beside the solvers' kernel_hash."""
        spec = find_spec(self.package)
        if spec is None or spec.origin is None:
            raise ModuleNotFoundError(f"{self.package}: there is no such package")
        return file_hash(Path(spec.origin).with_name("solve.py"))
