"""What a scene's data depend on, as text and as a hash."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from vibropipe.physics.start import largest_start
from vibropipe.study.accuracy import AccuracyScene
from vibropipe.study.base import BaseScene
from vibropipe.study.effect_costs import EffectsScene
from vibropipe.study.grids import Keys
from vibropipe.study.models import BackboneScene, Study, SweepScene

# To be raised when the meaning of a key changes, so that older data are recomputed.
MEANING = 1
_NO_DATA = ("title", "caption", "figure", "exciter")


def _plain(value: Any) -> Any:
    if isinstance(value, Keys):
        return {name: _plain(getattr(value, name)) for name in type(value).model_fields}
    if isinstance(value, dict):
        return {name: _plain(entry) for name, entry in value.items()}
    return [_plain(entry) for entry in value] if isinstance(value, (list, tuple)) else value


def data_keys(scene: BaseScene) -> dict[str, Any]:
    """Return what the data of a scene depend on and nothing else, with defaults filled in."""
    keys = {name: _plain(getattr(scene, name)) for name in type(scene).model_fields}
    keys = {name: value for name, value in keys.items() if name not in _NO_DATA}
    if "outputs" in keys:
        keys["outputs"] = sorted(keys["outputs"])
    if keys.get("effects") is not None:
        keys["effects"] = sorted(keys["effects"])
    exciter = scene.resolved_exciter()
    if isinstance(scene, SweepScene):
        exciter = {name: value for name, value in exciter.items() if name not in scene.over}
        keys["over"] = list(keys["over"].items())  # their order is the order of the dimensions
    if isinstance(scene, BackboneScene) and not scene.over_amplitude:
        exciter = {}
    if keys.get("start"):
        keys["start"] = _resolved(keys["start"], _ends(scene))
    if isinstance(scene, AccuracyScene | EffectsScene):
        for name, motion in keys["motions"].items():
            motion["start"] = _resolved(motion["start"], scene.exciter_of(name))
    return {"meaning": MEANING, "exciter": exciter, **keys}


def _resolved(start: dict[str, Any], values: dict[str, Any]) -> dict[str, Any]:
    """Return a start with its x0 written out, where one left out is the equilibrium in every row."""
    is_equilibrium = start["x0"] is None and largest_start(values, None) == 0.0
    return {**start, "x0": 0.0} if is_equilibrium else start


def _ends(scene: BaseScene) -> dict[str, Any]:
    """Return the parameters of a scene, the swept ones by the ends of their grids."""
    ends = {name: [grid.low, grid.high] for name, grid in scene.grids().items()}
    return {**scene.resolved_exciter(), **ends}


def canonical_text(study: Study, scene: BaseScene | str | None = None) -> str:
    """Return one line of JSON that is the same for studies that mean the same.

    Of a scene: what its data depend on. Of a whole study: everything, titles and captions too.
    Comments, order of keys, Greek spelling, ways of writing a number and defaults written out leave
    it unchanged.
    """
    if scene is not None:
        chosen = study.scene(scene) if isinstance(scene, str) else scene
        return _json(data_keys(chosen))
    scenes = {
        name: {
            "data": data_keys(entry),
            **{key: _plain(getattr(entry, key)) for key in _NO_DATA[:3]},
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
