"""Datasets to figures: the only floor that knows matplotlib.

A kind of picture is one module with a function ``draw_...(dataset, options) -> Figure``, its words
in ``captions.py``, and one row in ``PICTURES``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import xarray as xr
from matplotlib.figure import Figure

from vibropipe.figures.amplitude_frequency import draw_amplitude_frequency
from vibropipe.figures.backbone import draw_backbone
from vibropipe.figures.captions import (
    describe_amplitude_frequency,
    describe_backbone,
    describe_impacts,
    describe_map,
    describe_motion,
    describe_sweep,
)
from vibropipe.figures.effect_costs import describe_effects, draw_effects
from vibropipe.figures.hard_cases import describe_hard_cases, draw_hard_cases
from vibropipe.figures.impacts import draw_impacts_only
from vibropipe.figures.motion import draw_motion
from vibropipe.figures.options import Options, options_of
from vibropipe.figures.regime_map import draw_regime_map
from vibropipe.figures.style import house_style, save
from vibropipe.figures.sweep import MOST_LINES, axis_and_rest, draw_sweep
from vibropipe.figures.work_precision import draw_work_precision
from vibropipe.figures.work_precision_text import describe_work_precision
from vibropipe.store import read_scenes

__all__ = ["caption", "draw", "draw_scene", "draw_study", "picture_of"]


class Scene(Protocol):
    """What a picture needs to know of a scene."""

    @property
    def kind(self) -> str:
        """Name of the kind of scene."""

    @property
    def figure(self) -> Any:
        """Options of the picture: ``periods`` and ``beside``, each of which may be None."""


class Study(Protocol):
    """What the pictures need to know of a study."""

    @property
    def name(self) -> str:
        """Name of the study and of its folder of results."""

    @property
    def scenes(self) -> Mapping[str, Any]:
        """Scenes by name."""

    @property
    def fingerprints(self) -> Mapping[str, str]:
        """What the dataset of a scene must have been made of; a scene left out is not checked."""


@dataclass(frozen=True)
class Picture:
    """One row of the table: scenes of ``kind`` whose dataset ``fits`` are drawn by ``draw``.

    ``describe`` says what to see in the picture, where the study does not.
    """

    kind: str
    fits: Callable[[xr.Dataset], bool]
    draw: Callable[[xr.Dataset, Options], Figure]
    describe: Callable[[xr.Dataset, Options], str]


def _any(dataset: xr.Dataset) -> bool:
    return True


def _no_samples(dataset: xr.Dataset) -> bool:
    return not dataset.sizes.get("tau")


def _over_amplitude(dataset: xr.Dataset) -> bool:
    return "eigenfrequency" in dataset


def _is_map(dataset: xr.Dataset) -> bool:
    _, rest = axis_and_rest(dataset)
    return any(dataset.sizes[name] > MOST_LINES for name in rest)


# the first row that fits draws the scene
PICTURES: tuple[Picture, ...] = (
    Picture("motion", _no_samples, draw_impacts_only, describe_impacts),
    Picture("motion", _any, draw_motion, describe_motion),
    Picture("backbone", _over_amplitude, draw_amplitude_frequency, describe_amplitude_frequency),
    Picture("backbone", _any, draw_backbone, describe_backbone),
    Picture("sweep", _is_map, draw_regime_map, describe_map),
    Picture("sweep", _any, draw_sweep, describe_sweep),
    Picture("hard_cases", _any, draw_hard_cases, describe_hard_cases),
    Picture("accuracy", _any, draw_work_precision, describe_work_precision),
    Picture("effects", _any, draw_effects, describe_effects),
)


def picture_of(kind: str, dataset: xr.Dataset) -> Picture:
    """Return the row of the table that draws ``dataset``; ValueError if there is none."""
    for picture in PICTURES:
        if picture.kind == kind and picture.fits(dataset):
            return picture
    known = ", ".join(dict.fromkeys(picture.kind for picture in PICTURES))
    raise ValueError(f"no picture of kind {kind!r}; there are pictures of: {known}")


def draw(kind: str, dataset: xr.Dataset, options: Options | None = None) -> Figure:
    """Draw one dataset of a scene of ``kind`` in the house style."""
    with house_style():
        return picture_of(kind, dataset).draw(dataset, options or Options())


def draw_scene(
    study: Study,
    scene_name: str,
    dataset: xr.Dataset,
    folder: Path,
    others: Mapping[str, xr.Dataset],
) -> list[Path]:
    """Draw one scene into ``folder/<scene_name>.svg`` and ``.pdf`` and return both paths.

    ``others`` are the datasets of the study's scenes by name, for ``figure: beside``. Raises
    KeyError if that names no scene, ValueError if scenes of this kind have no picture.
    """
    scene = study.scenes[scene_name]
    options = options_of(scene.figure, others)
    with house_style():
        figure = picture_of(scene.kind, dataset).draw(dataset, options)
        return save(figure, folder, scene_name)


def caption(scene: Scene, dataset: xr.Dataset, others: Mapping[str, xr.Dataset]) -> str:
    """Say what to see in the picture of a scene, from its data (not from ``scene.caption``)."""
    options = options_of(scene.figure, others)
    return picture_of(scene.kind, dataset).describe(dataset, options)


def draw_study(study: Study, results: Path) -> list[Path]:
    """Draw every scene of ``study`` from its datasets and return the files written.

    Reads ``results/<study>/<scene>.nc`` and writes ``results/<study>/figures/<scene>.svg`` and
    ``.pdf``. Raises StoreError, with nothing drawn, if a dataset is missing, damaged or of another
    study.
    """
    place = results / study.name
    datasets = read_scenes(place, study.scenes, study.fingerprints)
    folder = place / "figures"
    return [
        path
        for name, dataset in datasets.items()
        for path in draw_scene(study, name, dataset, folder, datasets)
    ]
