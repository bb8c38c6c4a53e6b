"""The report of a study, of all its scenes or without those that failed: one PDF of its datasets and figures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from types import MappingProxyType

from vibropipe.jobs.drawing import (
    SUFFIXES,
    draw_study,
    figures_of,
    remove_unchosen,
    report_fingerprint,
)
from vibropipe.jobs.report_data import report_data
from vibropipe.jobs.summary import ERROR, causes
from vibropipe.jobs.up_to_date import stale_files, stale_scenes
from vibropipe.report import typeset
from vibropipe.report.parts import Answer
from vibropipe.store import StoreError, atomic_file, read_scenes, read_sidecar, with_fingerprint
from vibropipe.study import Study


def build_report(
    study: Study, results: Path, output: Path, failed: Mapping[str, str] = MappingProxyType({})
) -> Path:
    """Typeset the report of a study from its datasets and figures, and remove pictures that it no longer chooses.

    results : folder of all results. Reads `<study>/<scene>.nc`, its sidecar and `<study>/figures/<name>.pdf` in it
    failed : scenes that are left out, each with the reason
    Raises StoreError if a dataset or a figure is missing, damaged or of another study.
    """
    folder = results / study.name
    for scene in study.scenes.values():
        remove_unchosen(scene, folder / "figures")
    fingerprint = report_fingerprint(study, folder, failed)
    datasets = read_scenes(folder, study.scenes, study.fingerprints)
    sidecars = {name: read_sidecar(folder / f"{name}.nc") for name in study.scenes}
    names = [*figures_of(study)]
    pictures = {name: folder / "figures" / f"{name}.pdf" for name in names}
    for path in pictures.values():
        _check_figure(path)
    data = report_data(study, datasets, sidecars, results)
    data["answers"] = [*map(asdict, failures(failed)), *data["answers"]]
    pdf = typeset(data, pictures)
    with atomic_file(output) as temporary:
        scenes = [*study.scenes, *failed]
        content = with_fingerprint(pdf, fingerprint, scenes, study.display_units)
        temporary.write_bytes(content)
    return output


def failures(failed: Mapping[str, str]) -> list[Answer]:
    """Return what page 1 says of scenes that are left out: names, and the reason of each."""
    return [
        Answer(f"The scene {name} failed and is left out.", f"The reason: {reason.rstrip('.')}.")
        for name, reason in failed.items()
    ]


def _check_figure(path: Path) -> None:
    """Raise StoreError unless a file is a complete PDF."""
    if not path.is_file():
        raise StoreError(f"{path}: does not exist: draw the figures of the study first")
    content = path.read_bytes()
    if not (content.startswith(b"%PDF-") and content.rstrip().endswith(b"%%EOF")):
        raise StoreError(f"{path}: is damaged: draw the figures of the study again")


def make_report(
    study: Study, results: Path, output: Path, partial: bool = False, processes: int | None = None
) -> dict[str, str]:
    """Draw the figures of a study that are not up to date, and typeset its report.

    partial : whether scenes that could not be solved or drawn are left out, with a line on each
    processes : number of processes that draw (default: 1)
    Returns the scenes that are left out, each with the reason.
    Raises StoreError if a dataset is missing, damaged or of another study; of a partial report, if no scene is left.
    """
    folder, failed = results / study.name, {}
    if partial:
        failed = {name: cause_of(study.name, name) for name in stale_scenes(study, str(folder))}
    rest = without(study, failed)
    # as paths: those in the current folder may begin with ./ or not
    stale = set(map(Path, stale_files(rest, str(results), dict.fromkeys(rest.scenes, 1))))
    figures = {
        name: scene.name
        for name, scene in figures_of(rest).items()
        if not stale.isdisjoint(folder / "figures" / f"{name}{suffix}" for suffix in SUFFIXES)
    }
    if not partial and figures:
        draw_study(rest, results, figures, processes or 1)
    for scene in dict.fromkeys(figures.values()) if partial else ():
        try:
            draw_study(rest, results, [name for name in figures if figures[name] == scene])
        except Exception as error:  # whatever it is, the others have their report
            failed[scene] = f"cannot be drawn ({error})"
    build_report(without(study, failed), results, output, failed)
    return failed


def without(study: Study, failed: Mapping[str, str]) -> Study:
    """Return a study without some scenes, and without those whose figures show them."""
    if not failed:
        return study
    scenes = {
        name: scene
        for name, scene in study.scenes.items()
        if not {name, *scene.figure.shown_scenes()} & set(failed)
    }
    if not scenes:
        raise StoreError(f"{study.name}: no scene could be solved: {'; '.join(failed.values())}")
    hero = study.hero if study.hero is not None and study.hero.scene in scenes else None
    return study.model_copy(update={"scenes": scenes, "hero": hero})


def cause_of(study: str, scene: str) -> str:
    """Return why a scene of a study could not be solved, by the logs of its jobs in the working folder."""
    logs = [Path("logs", study, f"{scene}.log"), *sorted(Path("logs", study, scene).glob("*.log"))]
    found = [cause.removeprefix(ERROR) for cause in causes(map(str, logs))]
    return found[0] if found else f"it is not solved (see logs/{study}/{scene}.log)"
