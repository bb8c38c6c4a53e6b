"""Datasets against themselves: a random sample of their rows is computed again from what they say of their origin.

A dataset tells the study it was made of, so that neither the study's file nor its folder is needed.
"""

from __future__ import annotations

import hashlib
import secrets
from collections.abc import Iterator
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.registry import kind_of
from vibropipe.store import StoreError, attributes_of, expected_changes, scene_files
from vibropipe.study import Study, StudyError, fingerprint, study_of_text
from vibropipe.words.wording import count

__all__ = ["ROWS", "Verdict", "new_seed", "verify"]

ROWS = 100
MAX_REPORTED = 3
NO_STUDY = "contains no study text, so it cannot be recomputed"
A_SHARD = "is a shard of a sweep: join all its shards first"


@dataclass(frozen=True)
class Verdict:
    """What was found of one file.

    checked: what was computed again, in words; faults: what differs or is damaged; reasons: why a difference
    can be no surprise here; left_out: what was not compared. `good` unless there are faults.
    """

    name: str
    checked: str = ""
    faults: list[str] = field(default_factory=list)
    reasons: list[str] = field(default_factory=list)
    left_out: str = ""

    @property
    def good(self) -> bool:
        """Whether nothing was found to differ."""
        return not self.faults

    def __str__(self) -> str:
        found = count(len(self.faults), "fault")
        head = f"{self.checked}: same, bit for bit" if self.checked and self.good else self.checked
        parts = [part for part in (head, "" if self.good else found) if part]
        lines = [f"{self.name}: {', '.join(parts) or 'not verified'}"]
        lines += [f"  {fault}" for fault in self.faults[:MAX_REPORTED]]
        if len(self.faults) > MAX_REPORTED:
            lines.append(f"  and {len(self.faults) - MAX_REPORTED} more")
        lines += [f"  not compared: {self.left_out}"] if self.left_out else []
        if self.reasons:
            word = "possible" if self.good else "expected"
            lines.append(f"  differences are {word} on this system: {'; '.join(self.reasons)}")
        return "\n".join(lines)


def new_seed() -> int:
    """Return a seed for one more sample."""
    return secrets.randbelow(10**6)


def verify(
    place: str | PathLike[str], rows: int = ROWS, seed: int | None = None
) -> Iterator[Verdict]:
    """Compute a random sample of each dataset again and compare it bit for bit, one verdict for each.

    place: the results of a study, or one file of them. rows: how many rows of a sweep (whole chains where a
    parameter is followed), amplitudes, hard cases or races at least, where there are as many; a motion and
    the curves of eq. (10) are computed whole. seed: of the sample, a new one if left out.
    Raises StoreError at once when there is no dataset.
    """
    files = scene_files(place)
    chosen = new_seed() if seed is None else seed
    return (_verdict(path, rows, chosen) for path in files)


def _verdict(path: Path, rows: int, seed: int) -> Verdict:
    """Return what is found of one file."""
    name = path.stem
    try:
        attrs = attributes_of(path)
        if "study" not in attrs:
            return Verdict(name, left_out=NO_STUDY)
        if "row_start" in attrs:
            return Verdict(name, left_out=A_SHARD)
        study, scene = _asked(attrs)
    except (StoreError, StudyError, _ForeignError) as error:
        return Verdict(name, faults=str(error).splitlines())
    reasons = expected_changes(attrs)
    if fingerprint(study, scene) != attrs.get("fingerprint"):
        reasons.append("the study means something else to this version (its fingerprint differs)")
    generator = np.random.default_rng([seed, *name.encode()])
    found = kind_of(scene).recompute(path, scene, rows, generator)
    faults = [str(item) for item in found.differences]
    return Verdict(name, found.checked, faults, reasons, found.not_compared)


class _ForeignError(ValueError):
    """What a file says of its origin contradicts itself."""


def _asked(attrs: dict[str, Any]) -> tuple[Study, BaseScene]:
    """Return the study that a file holds, and its scene in it."""
    text, title = str(attrs["study"]), str(attrs.get("title", ""))
    if hashlib.sha256(text.encode()).hexdigest() != attrs.get("study_hash"):
        raise _ForeignError(
            "study: must be the one the file was made from, but its study_hash differs"
        )
    name, _, scene = title.partition(": ")
    study = study_of_text(text, name)
    if scene not in study.scenes:
        raise _ForeignError(f"title: must name a scene of the study in the file, got {title!r}")
    return study, study.scenes[scene]
