"""What a scene's data depend on, as text and as a hash."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from vibropipe.scenes.keys.base import BaseScene, plain
from vibropipe.study.models import Study

# To be raised when the meaning of a key changes, so that older data are recomputed.
SEMANTICS_VERSION = 1
# what a scene says beside its data
_WORDS = ("title", "caption", "figure")


def _data_keys(scene: BaseScene) -> dict[str, Any]:
    return {"meaning": SEMANTICS_VERSION, **scene.data_keys()}


def canonical_text(study: Study, scene: BaseScene | str | None = None) -> str:
    """Return one line of JSON that is the same for studies that mean the same.

    Of a scene: what its data depend on. Of a whole study: everything, titles and captions too.
    Comments, order of keys, Greek spelling, ways of writing a number and defaults written out leave
    it unchanged.
    """
    if scene is not None:
        chosen = study.scene(scene) if isinstance(scene, str) else scene
        return _json(_data_keys(chosen))
    scenes = {
        name: {
            "data": _data_keys(entry),
            **{key: plain(getattr(entry, key)) for key in _WORDS},
        }
        for name, entry in study.scenes.items()
    }
    head = {"title": study.title, "description": study.description}
    return _json({**head, "scenes": list(scenes.items())})


def fingerprint(study: Study, scene: BaseScene | str) -> str:
    """Return the hash of what a scene's data depend on, 64 hexadecimal digits."""
    return hashlib.sha256(canonical_text(study, scene).encode()).hexdigest()


def _json(value: Any) -> str:
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)
