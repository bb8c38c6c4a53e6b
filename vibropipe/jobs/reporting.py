"""The report of a study: one PDF typeset from its datasets and figures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import xarray as xr

from vibropipe.figures.units import display_units
from vibropipe.jobs.drawing import figure_names, remove_unchosen
from vibropipe.report import typeset
from vibropipe.report.accuracy import Sidecars, accuracy_table, accuracy_text, provenance_table
from vibropipe.report.data import (
    asked_text,
    effects_table,
    further_effects,
    is_physical,
    parameter_table,
    subtitle,
)
from vibropipe.report.table import Datasets, breakable
from vibropipe.report.unsolved import unsolved_section
from vibropipe.scenes.registry import kind_of
from vibropipe.store import StoreError, atomic_file, read_scenes, read_sidecar
from vibropipe.study import Study
from vibropipe.words.wording import paragraphs


def build_report(study: Study, results: Path, output: Path) -> Path:
    """Typeset the report of a study from its datasets and figures, and remove pictures that it no longer chooses.

    Parameters
    ----------
    study : Study
        The study.
    results : Path
        Folder of all results. Reads `<study>/<scene>.nc`, its sidecar and `<study>/figures/<name>.pdf` in it.
    output : Path
        The PDF that is written.

    Returns
    -------
    Path
        `output`.

    Raises
    ------
    StoreError
        If a dataset or a figure is missing, damaged or of another study.
    """
    folder = results / study.name
    for scene in study.scenes.values():
        remove_unchosen(scene, folder / "figures")
    datasets = read_scenes(folder, study.scenes, study.fingerprints)
    sidecars = {name: read_sidecar(folder / f"{name}.nc") for name in study.scenes}
    names = [name for scene in study.scenes.values() for name in figure_names(scene)]
    pictures = {name: folder / "figures" / f"{name}.pdf" for name in names}
    for path in pictures.values():
        _check_figure(path)
    pdf = typeset(report_data(study, datasets, sidecars), pictures)
    with atomic_file(output) as temporary:
        temporary.write_bytes(pdf)
    return output


def _check_figure(path: Path) -> None:
    """Raise StoreError unless a file is a complete PDF."""
    if not path.is_file():
        raise StoreError(f"{path}: does not exist: draw the figures of the study first")
    content = path.read_bytes()
    if not (content.startswith(b"%PDF-") and content.rstrip().endswith(b"%%EOF")):
        raise StoreError(f"{path}: is damaged: draw the figures of the study again")


def report_data(study: Study, datasets: Datasets, sidecars: Sidecars) -> dict[str, Any]:
    """Return the data of the template: strings, lists and mappings only, so that JSON holds it without loss.

    Parameters
    ----------
    study : Study
        The study.
    datasets, sidecars : mapping
        Dataset and sidecar of each scene by name.
    """
    datasets = display_units(datasets)
    parts = [
        (
            kind,
            {name: datasets[name] for name in datasets if kind_of(study.scenes[name]) is kind},
        )
        for kind in dict.fromkeys(kind_of(study.scenes[name]) for name in datasets)
    ]
    notes = [note for kind, own in parts for note in kind.report.accuracy_notes(own)]
    outputs = {name: getattr(scene, "outputs", None) for name, scene in study.scenes.items()}
    figures = list(figure_entries(study, datasets))
    sections = [section for kind, own in parts for section in kind.report.sections(own)]
    return {
        "title": study.title,
        "subtitle": subtitle(study.name, datasets),
        "description": paragraphs(study.description or ""),
        "asked": asked_text({name: scene.kind for name, scene in study.scenes.items()}, datasets),
        "main": main_figure(study),
        "findings": [
            {"name": scene_title(study, finding.scene), "texts": finding.texts}
            for kind, own in sorted(parts, key=lambda part: part[0].report.rank)
            for finding in kind.report.findings(own)
            if finding.texts
        ],
        "is_physical": is_physical(datasets),
        "has_backbone": any("velocity_over_l" in dataset for dataset in datasets.values()),
        "further": further_effects(datasets),
        "parameters": parameter_table(
            {name: scene.kind for name, scene in study.scenes.items()}, datasets
        ).as_data(),
        "effects": effects_table(outputs, datasets).as_data(),
        "figures": figures,
        "sections": [section.as_data() for section in (*sections, *unsolved_section(datasets))],
        "accuracy": {
            "table": accuracy_table(datasets, sidecars).as_data(),
            "text": accuracy_text(datasets, notes),
        },
        "provenance": provenance_table(datasets).as_data(),
    }


def main_figure(study: Study) -> str:
    """Return the name of the main picture: the first one of the first scene of the kind with the lowest rank."""
    scene = min(study.scenes.values(), key=lambda scene: kind_of(scene).report.rank)
    return figure_names(scene)[0]


def scene_title(study: Study, name: str) -> str:
    """Return the title of a scene, or its name; empty for no scene."""
    return (study.scenes[name].title or breakable(name)) if name else ""


def figure_entries(study: Study, datasets: Mapping[str, xr.Dataset]) -> Iterator[dict[str, str]]:
    """Yield each figure: name, path, title, caption, and the alternative text for screen readers.

    The datasets are in units for display (`display_units`).
    """
    for scene_name, dataset in datasets.items():
        scene = study.scenes[scene_name]
        pictures = kind_of(scene).pictures_of(dataset, scene.figure.chosen())
        own_caption = " ".join(scene.caption.split())
        for name, picture in zip(figure_names(scene), pictures, strict=True):
            further = "" if name == scene_name else f" ({picture.name.replace('_', ' ')})"
            description = picture.describe(dataset, scene.figure, datasets)
            yield {
                "name": name,
                "path": f"figures/{name}.pdf",
                "title": scene_title(study, scene_name) + further,
                "caption": own_caption or description,
                "alt": description,
            }
            own_caption = ""  # the caption of the study describes the first picture
