"""The figures of a study, drawn from its datasets."""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from vibropipe.compiler.sources import PACKAGE
from vibropipe.figures.units import display_units
from vibropipe.jobs.processes import reported, side_by_side
from vibropipe.scenes.keys.base import BaseScene, drawn_by_others
from vibropipe.scenes.registry import kind_of
from vibropipe.store import StoreError, fingerprint_of, read_scenes, seal_of
from vibropipe.study import Study, canonical_text

if TYPE_CHECKING:
    import xarray as xr

SUFFIXES = (".svg", ".pdf")
# Folders of the package that figures and reports depend on, beside the data.
DRAWN = (
    "figures",
    "report",
    "scenes",
    "words",
    "jobs/drawing.py",
    "jobs/report_data.py",
    "jobs/reporting.py",
)


def figure_names(scene: BaseScene) -> list[str]:
    """Return the names of a scene's figures: `<scene>`, and `<scene>-<picture>` for each further picture."""
    return [scene.name, *(f"{scene.name}-{picture}" for picture in scene.figure.chosen()[1:])]


def figures_of(study: Study) -> dict[str, BaseScene]:
    """Return the scene of each figure of a study by the figure's name.

    Scenes that others draw have none (`drawn_by_others`).
    """
    left_out = drawn_by_others(study.scenes)
    return {
        figure: scene
        for name, scene in study.scenes.items()
        if name not in left_out
        for figure in figure_names(scene)
    }


def figure_entries(study: Study, datasets: Mapping[str, xr.Dataset]) -> Iterator[dict[str, str]]:
    """Yield each figure: name, path, scene, picture, title, caption, heading, and the text for screen readers.

    The datasets are in units for display (`Study.shown`).
    """
    for scene_name in dict.fromkeys(scene.name for scene in figures_of(study).values()):
        scene: BaseScene = study.scenes[scene_name]
        dataset = datasets[scene_name]
        pictures = kind_of(scene).pictures_of(dataset, scene.figure.chosen())
        own_caption = " ".join(scene.caption.split())
        for name, picture in zip(figure_names(scene), pictures, strict=True):
            description = picture.describe(dataset, scene.figure, datasets)
            title = picture.title(dataset, scene.figure, datasets)
            yield {
                "type": "figure",
                "name": name,
                "path": f"figures/{name}.pdf",
                "scene": scene_name,
                "picture": picture.name,
                "title": title or scene.title or words_of(scene_name),
                "caption": own_caption or description,
                "heading": picture.heading,
                "alt": description,
            }
            own_caption = ""  # the caption of the study describes the first picture


def words_of(name: str) -> str:
    """Write the name of a scene as a title: Second scene."""
    return name.replace("_", " ").capitalize()


def scenes_drawn(study: Study, scene: BaseScene) -> list[str]:
    """Return the names of the scenes whose data the figures of a scene depend on.

    In a study with units these are all: their quantities are shown with the same prefixes.
    """
    if scene.mass_and_stiffness is not None:
        return list(study.scenes)
    return [name for name in study.scenes if name in (scene.name, *scene.figure.shown_scenes())]


def draw_scene(
    scene: BaseScene,
    dataset: xr.Dataset,
    folder: Path,
    others: Mapping[str, xr.Dataset],
    names: Collection[str] = (),
    fingerprints: Mapping[str, str] = MappingProxyType({}),
) -> list[Path]:
    """Draw the pictures of one scene, each as SVG and PDF.

    scene : its figure options choose the pictures
    folder : where `<name>.svg` and `<name>.pdf` are written
    others : the datasets of the scenes of the study, at least of `scenes_drawn`
    names : names of the figures that are drawn (default: all of the scene)
    fingerprints : fingerprints that the figures carry, by name
    Raises KeyError if a figure option names a scene that is not among `others`.
    """
    from vibropipe.figures.style import house_style, save

    shown = display_units({**others, scene.name: dataset})
    dataset, others = shown[scene.name], shown
    pictures = kind_of(scene).pictures_of(dataset, scene.figure.chosen())
    paths: list[Path] = []
    for name, picture in zip(figure_names(scene), pictures, strict=True):
        if names and name not in names:
            continue
        with house_style():
            figure = picture.draw(dataset, scene.figure, others)
            paths += save(figure, folder, name, fingerprints.get(name, ""))
    return paths


def remove_unchosen(scene: BaseScene, folder: Path) -> list[Path]:
    """Remove the files of pictures that a scene no longer chooses, and return their paths.

    Only files named `<scene>-<picture>` after a picture of the scene's kind are removed.
    """
    further = {f"{scene.name}-{picture.name}" for picture in kind_of(scene).pictures}
    removed = [
        folder / f"{name}{suffix}"
        for name in sorted(further - set(figure_names(scene)))
        for suffix in SUFFIXES
        if (folder / f"{name}{suffix}").is_file()
    ]
    for path in removed:
        path.unlink()
    return removed


def draw_study(
    study: Study, results: Path, names: Collection[str] = (), processes: int = 1
) -> list[Path]:
    """Draw figures of a study from its datasets.

    results : folder of all results. Reads `<study>/<scene>.nc` in it and writes into `<study>/figures`
    names : names of the figures, without suffix (default: all figures of the study)
    processes : number of processes that share them; the others print their errors
    Raises StoreError if a dataset is missing, damaged or of another study; nothing is drawn then.
    """
    folder = results / study.name
    figures = {n: scene for n, scene in figures_of(study).items() if not names or n in names}
    needed = dict.fromkeys(n for scene in figures.values() for n in scenes_drawn(study, scene))
    fingerprints = {
        name: figure_fingerprint(study, scene, name, folder) for name, scene in figures.items()
    }
    datasets = study.shown(read_scenes(folder, needed, study.fingerprints))

    def draw(name: str) -> list[Path]:
        scene, data = figures[name], datasets[figures[name].name]
        return draw_scene(scene, data, folder / "figures", datasets, (name,), fingerprints)

    if min(processes, len(figures)) < 2:
        return [path for name in figures for path in draw(name)]
    for scene in figures.values():  # imported once for all processes
        _ = kind_of(scene).pictures

    def draw_apart(number: int) -> None:
        with reported(None):
            draw([*figures][number])

    side_by_side(draw_apart, len(figures), processes)
    paths = {folder / "figures" / f"{name}{s}": name for name in figures for s in SUFFIXES}
    missing = dict.fromkeys(n for p, n in paths.items() if fingerprint_of(p) != fingerprints[n])
    if missing:
        raise StoreError(f"{study.name}: cannot be drawn: {', '.join(missing)}")
    return list(paths)


def figure_fingerprint(study: Study, scene: BaseScene, name: str, folder: Path) -> str:
    """Return the hash of all that a figure is made from: program, name, options, and the bytes of its datasets."""
    data = [seal_of(folder / f"{other}.nc") for other in sorted(scenes_drawn(study, scene))]
    return made_from(name, scene.figure.model_dump_json(), study.display_units, *data)


def report_fingerprint(study: Study, folder: Path, failed: Collection[str] = ()) -> str:
    """Return the hash of all that a report is made from: program, study with its texts, and the bytes of its datasets.

    folder : results of the study; failed : scenes that the report names as left out
    """
    data = [seal_of(folder / f"{name}.nc") for name in study.scenes]
    return made_from(study.name, canonical_text(study), *data, *failed)


def made_from(*parts: str) -> str:
    """Return the hash (64 hex digits) of the program that draws and typesets, and of further texts."""
    return hashlib.sha256("\0".join([drawing_hash(), *parts]).encode()).hexdigest()


@functools.cache
def drawing_hash() -> str:
    """Return the hash (16 hex digits) of the sources and templates that figures and reports depend on."""
    digest = hashlib.sha256()
    for entry in DRAWN:
        for source in _files(PACKAGE / entry):
            digest.update(source.relative_to(PACKAGE).as_posix().encode() + b"\0")
            digest.update(source.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def _files(path: Path) -> Iterable[Path]:
    if path.is_file():
        return [path]
    return sorted(
        item for item in path.rglob("*") if item.suffix in (".py", ".toml", ".typ", ".otf")
    )
