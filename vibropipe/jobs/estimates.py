"""How long a study will take on this machine and how much it will write, found by solving samples of it.

Findings are kept beside the compiled kernels by fingerprint, so that a later job can set them against the time it
took.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

from vibropipe.compiler.cache import cache_folder
from vibropipe.scenes.costs import Estimate, sampling
from vibropipe.scenes.registry import kind_of
from vibropipe.store import StoreError, atomic_file
from vibropipe.study import Study, fingerprint

KEPT = "expected.json"
# Seconds of one core that the samples of a whole study may take, and those of one scene at least.
BUDGET, MIN_BUDGET = 1.0, 0.05


def estimate_study(study: Study) -> dict[str, Estimate]:
    """Return estimates by scene; they are kept for the jobs that solve the scenes."""
    with sampling() as sampler:
        sampler.budget = max(MIN_BUDGET, BUDGET / len(study.scenes))
        found = {
            name: kind_of(scene).estimate(scene, sampler) for name, scene in study.scenes.items()
        }
    save_estimates({fingerprint(study, name): value for name, value in found.items()})
    return found


def save_estimates(estimates: dict[str, Estimate]) -> None:
    """Keep estimates by fingerprint, beside those of other scenes."""
    cached = {**_kept(), **{name: asdict(value) for name, value in estimates.items()}}
    try:
        with atomic_file(cache_folder() / KEPT) as temporary:
            temporary.write_text(json.dumps(cached, indent=1) + "\n", encoding="utf-8")
    except (OSError, StoreError):
        return  # a machine that keeps nothing has no estimates later


def load_estimate(scene_fingerprint: str) -> Estimate | None:
    """Return the estimate kept for a scene on this machine, if there is one."""
    entry = _kept().get(scene_fingerprint)
    try:
        return None if entry is None else Estimate(**entry)
    except TypeError:
        return None


def _kept() -> dict[str, Any]:
    try:
        cached = json.loads((cache_folder() / KEPT).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return cached if isinstance(cached, dict) else {}
