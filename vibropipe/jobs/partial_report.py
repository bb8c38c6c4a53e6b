"""The report of a study in which scenes failed: of the others, with a line on each that is left out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from vibropipe.jobs.drawing import SUFFIXES, draw_study, figure_names, figures_of
from vibropipe.jobs.reporting import build_report
from vibropipe.jobs.summary import ERROR, causes
from vibropipe.jobs.up_to_date import stale_files, stale_scenes
from vibropipe.store import StoreError
from vibropipe.study import Study


def build_partial_report(study: Study, results: Path, output: Path) -> dict[str, str]:
    """Draw and typeset what there is of a study, with a line on each scene that could not be solved or drawn.

    Parameters
    ----------
    study, results, output
        As for `build_report`.

    Returns
    -------
    dict of str to str
        The scenes that are left out, each with the reason.

    Raises
    ------
    StoreError
        If no scene is left.
    """
    failed = {
        name: cause_of(study.name, name) for name in stale_scenes(study, f"{results}/{study.name}")
    }
    rest = without(study, failed)
    stale = set(stale_files(rest, str(results), dict.fromkeys(rest.scenes, 1)))
    for name, scene in {scene.name: scene for scene in figures_of(rest).values()}.items():
        names = figure_names(scene)
        files = (
            f"{results}/{study.name}/figures/{figure}{s}" for figure in names for s in SUFFIXES
        )
        try:
            if not stale.isdisjoint(files):
                draw_study(rest, results, names)
        except Exception as error:  # whatever it is, the others have their report
            failed[name] = f"cannot be drawn ({error})"
    build_report(without(study, failed), results, output, failed)
    return failed


def without(study: Study, failed: Mapping[str, str]) -> Study:
    """Return a study without some scenes, and without those whose figures show them."""
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
    return found[0] if found else f"is not solved (see logs/{study}/{scene}.log)"
