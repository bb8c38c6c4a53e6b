"""The keys that the data of a scene depend on, as text and as a hash."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING, Any

from vibropipe.scenes.keys.base import BaseScene, plain

if TYPE_CHECKING:
    from vibropipe.study.models import Study

# Version of the meaning of the keys. Increase it when a meaning changes, so that older data are recomputed.
SEMANTICS_VERSION = 1
# Keys that no data depend on.
_TEXT_KEYS = ("title", "caption", "figure")


def _data_keys(scene: BaseScene) -> dict[str, Any]:
    return {"meaning": SEMANTICS_VERSION, **scene.data_keys()}


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
        return _json(_data_keys(study.scene(scene) if isinstance(scene, str) else scene))
    scenes = {
        name: {
            "data": _data_keys(entry),
            **{key: plain(getattr(entry, key)) for key in _TEXT_KEYS},
        }
        for name, entry in study.scenes.items()
    }
    head = {"title": study.title, "description": study.description}
    return _json({**head, "scenes": list(scenes.items())})


def fingerprint(study: Study, scene: BaseScene | str) -> str:
    """Return the SHA-256 hash (64 hex digits) of the keys that the data of a scene depend on."""
    return hashlib.sha256(canonical_text(study, scene).encode()).hexdigest()


def _json(value: Any) -> str:
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)
