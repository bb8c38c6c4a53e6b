"""The keys that the data of a scene depend on, as text and as a hash."""

from __future__ import annotations

from typing import Any

from vibropipe.scenes.keys.base import BaseScene, canonical_json, plain
from vibropipe.study.models import Study

# Keys that no data depend on.
_TEXT_KEYS = ("title", "caption", "figure")


def canonical_text(study: Study, scene: BaseScene | str | None = None) -> str:
    """Return one line of JSON that is equal for studies of the same meaning.

    Comments, order of keys, Greek spelling, notations of a number and explicit defaults do not change it.

    Parameters
    ----------
    study : Study
        The study.
    scene : BaseScene or str, optional
        A scene: the text holds the keys that its data depend on. Without it, the text holds the whole study, titles
        and captions included.

    Raises
    ------
    StudyError
        If the study has no scene of that name.
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


def _scene(study: Study, scene: BaseScene | str) -> BaseScene:
    resolved: BaseScene = study.scene(scene) if isinstance(scene, str) else scene
    return resolved


def _texts(scene: BaseScene) -> dict[str, Any]:
    return {key: plain(getattr(scene, key)) for key in _TEXT_KEYS}
