"""The keys that the data of a scene depend on, as text and as a hash; the study that still makes a dataset."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibropipe.figures.units import display_units
from vibropipe.scenes.keys.base import BaseScene, canonical_json, plain
from vibropipe.scenes.keys.problems import StudyError
from vibropipe.solve.shown_units import DISPLAY_UNITS
from vibropipe.study.loading import load_study
from vibropipe.study.models import Study

if TYPE_CHECKING:
    import xarray as xr

# Keys that no data depend on.
_TEXT_KEYS = ("title", "caption", "figure")


def canonical_text(study: Study, scene: BaseScene | str | None = None) -> str:
    """Return one line of JSON that is equal for studies of the same meaning.

    Comments, order of keys, Greek spelling, notations of a number and explicit defaults do not change it.

    scene : a scene: the text holds the keys that its data depend on. Without it, the text holds the whole study,
        titles and captions included
    Raises StudyError if the study has no scene of that name.
    """
    if scene is not None:
        return _scene(study, scene).canonical_text()
    scenes = [
        [name, {"data": entry.data_keys(), **_texts(entry)}] for name, entry in study.scenes.items()
    ]
    head = {
        name: plain(getattr(study, name))
        for name in ("title", "question", "answers", "table", "description", "hero")
    }
    if study.display_units:
        head["units"] = study.display_units
    return canonical_json({**head, "scenes": scenes})


def fingerprint(study: Study, scene: BaseScene | str) -> str:
    """Return the SHA-256 hash (64 hex digits) of the keys that the data of a scene depend on."""
    return _scene(study, scene).fingerprint()


def study_at_hand(datasets: Iterable[xr.Dataset]) -> Study | None:
    """Return the study as its file is now, if one of the datasets is what the file still asks for.

    The file is sought in the current folder and beside the folder of all results, and in `config` of each.
    """
    studies: dict[Path, Study] = {}
    for dataset in datasets:
        name, _, scene = str(dataset.attrs.get("title", "")).partition(": ")
        beside = Path(dataset.encoding.get("source", "")).parents[2:3]
        folders = [each for folder in (Path(), *beside) for each in (folder, folder / "config")]
        for file in (folder / f"{name}.yaml" for folder in folders if scene):
            with suppress(StudyError, OSError):
                study = studies.get(file) or studies.setdefault(file, load_study(file))
                asked_for = study.scenes[scene].fingerprint() if scene in study.scenes else ""
                if asked_for == dataset.attrs.get("fingerprint"):
                    return study
    return None


def shown_now(datasets: Mapping[str, xr.Dataset]) -> dict[str, xr.Dataset]:
    """Return datasets of a study in the units of its file, if it is at hand, else in those they were made with."""
    study = study_at_hand(data for data in datasets.values() if DISPLAY_UNITS in data.attrs)
    return study.shown(datasets, False) if study else display_units(datasets, prefixes=False)


def _scene(study: Study, scene: BaseScene | str) -> BaseScene:
    resolved: BaseScene = study.scene(scene) if isinstance(scene, str) else scene
    return resolved


def _texts(scene: BaseScene) -> dict[str, Any]:
    return {key: plain(getattr(scene, key)) for key in _TEXT_KEYS}
