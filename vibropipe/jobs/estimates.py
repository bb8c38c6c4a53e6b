"""Run time and disk space of a study on this machine, estimated by solving samples of its scenes.

Estimates are stored by fingerprint beside the compiled kernels. The job that later solves a scene records its estimate
beside the time that it took.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from vibropipe.compiler.cache import cache_folder
from vibropipe.scenes.costs import Estimate, sampling
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.registry import kind_of
from vibropipe.store import StoreError, atomic_file, write
from vibropipe.study import Study, fingerprint

FILE_NAME = "expected.json"
# Seconds of one core for the samples of a whole study, shared evenly by its scenes; and the least share of a scene.
BUDGET, MIN_BUDGET = 1.0, 0.05


def estimate_study(study: Study) -> dict[str, Estimate]:
    """Return the estimate of each scene by name, and store them for the jobs that solve the scenes."""
    with sampling(_solve_to_file) as sampler:
        sampler.budget = max(MIN_BUDGET, BUDGET / len(study.scenes))
        estimates = {
            name: kind_of(scene).estimate(scene, sampler) for name, scene in study.scenes.items()
        }
    save_estimates({fingerprint(study, name): value for name, value in estimates.items()})
    return estimates


def _solve_to_file(scene: BaseScene, path: Path) -> None:
    write(kind_of(scene).solve(scene), path)


def save_estimates(estimates: dict[str, Estimate]) -> None:
    """Add estimates by fingerprint to those stored on this machine; do nothing if the cache cannot be written."""
    cached = {**_load_all(), **{name: asdict(value) for name, value in estimates.items()}}
    try:
        with atomic_file(cache_folder() / FILE_NAME) as temporary:
            temporary.write_text(json.dumps(cached, indent=1) + "\n", encoding="utf-8")
    except (OSError, StoreError):
        return


def load_estimate(scene_fingerprint: str) -> Estimate | None:
    """Return the estimate of a scene that is stored on this machine, None if there is none."""
    entry = _load_all().get(scene_fingerprint)
    try:
        return None if entry is None else Estimate(**entry)
    except TypeError:
        return None


def _load_all() -> dict[str, Any]:
    """Return the entries of the file by fingerprint; none if it is missing or unreadable."""
    try:
        cached = json.loads((cache_folder() / FILE_NAME).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return cached if isinstance(cached, dict) else {}
