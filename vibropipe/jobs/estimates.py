"""What a scene is expected to take on this machine, kept beside the compiled kernels by fingerprint."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

from vibropipe.compiler.cache import cache_folder
from vibropipe.store import StoreError, whole_file

KEPT = "expected.json"


@dataclass(frozen=True)
class Expected:
    """What a scene will come to: seconds of one core, seconds to load the kernels once per job, bytes on
    disk, whether threads share the work, and the method chosen where an accuracy was asked."""

    core_seconds: float
    load_seconds: float
    bytes: float
    parallel: bool
    method: str

    def seconds(self, threads: int = 1, share: float = 1.0) -> float:
        """Seconds of one job with so many threads that does such a share of the scene."""
        return self.load_seconds + share * self.core_seconds / (threads if self.parallel else 1)


def keep(found: dict[str, Expected]) -> None:
    """Keep expectations by fingerprint, beside those of other scenes."""
    known = {**_kept(), **{name: asdict(value) for name, value in found.items()}}
    try:
        with whole_file(cache_folder() / KEPT) as temporary:
            temporary.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
    except (OSError, StoreError):
        return  # a machine that keeps nothing has no expectations later


def recall(scene_fingerprint: str) -> Expected | None:
    """The expectation kept for a scene on this machine, if there is one."""
    entry = _kept().get(scene_fingerprint)
    try:
        return None if entry is None else Expected(**entry)
    except TypeError:
        return None


def _kept() -> dict[str, Any]:
    try:
        known = json.loads((cache_folder() / KEPT).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return known if isinstance(known, dict) else {}
