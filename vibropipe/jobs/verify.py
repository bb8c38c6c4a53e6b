"""Verification of datasets: whole scenes, or sampled rows of sweeps, are recomputed and compared bit for bit.

A dataset holds the text of its study, so neither the file of the study nor its folder is needed.
"""

from __future__ import annotations

import hashlib
import secrets
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.registry import kind_of
from vibropipe.store import StoreError, attributes_of, expected_changes, read_sidecar, scene_files
from vibropipe.study import Study, StudyError, fingerprint, study_of_text
from vibropipe.words.wording import count

# Default number of rows of a sample, and limit of the faults of one file that are printed.
ROWS, MAX_REPORTED = 100, 3
NO_STUDY = "contains no study text, so it cannot be recomputed"
A_SHARD = "is a shard of a sweep: join all its shards first"


@dataclass(frozen=True)
class Verdict:
    """The result for one file.

    checked : what was recomputed, as text
    faults : what differs or is damaged
    reasons : why differences are expected on this system
    left_out : what was not compared, as text
    newest : name of the newest dataset if the study that made it has no such scene, which may be left over
    """

    name: str
    checked: str = ""
    faults: list[str] = field(default_factory=list)
    reasons: list[str] = field(default_factory=list)
    left_out: str = ""
    newest: str = ""

    @property
    def good(self) -> bool:
        """Whether there are no faults."""
        return not self.faults

    def __str__(self) -> str:
        faults = "" if self.good else count(len(self.faults), "fault")
        head = f"{self.checked}: same, bit for bit" if self.checked and self.good else self.checked
        parts = [part for part in (head, faults) if part]
        lines = [f"{self.name}: {', '.join(parts) or 'not verified'}"]
        lines += [f"  {fault}" for fault in self.faults[:MAX_REPORTED]]
        if len(self.faults) > MAX_REPORTED:
            lines.append(f"  and {len(self.faults) - MAX_REPORTED} more")
        lines += [f"  not compared: {self.left_out}"] if self.left_out else []
        if self.newest:
            made = f"the study that made {self.newest}, the newest dataset"
            lines.append(f"  not in {made}: delete it if the study no longer has it")
        if self.reasons:
            word = "possible" if self.good else "expected"
            lines.append(f"  differences are {word} on this system: {'; '.join(self.reasons)}")
        return "\n".join(lines)


def new_seed() -> int:
    """Return a random seed for a sample."""
    return secrets.randbelow(10**6)


def verify(
    results: str | PathLike[str], rows: int = ROWS, seed: int | None = None
) -> Iterator[Verdict]:
    """Recompute a random sample of each dataset and compare it bit for bit.

    results : the folder of a study, or one dataset in it
    rows : least number of rows of a sweep in a sample, whole chains if a parameter is followed. Scenes of other kinds
        are recomputed completely
    seed : seed of the sample (default: a random one)
    Returns the result for each dataset, computed as the iterator advances.
    Raises StoreError at once, if there is no dataset.
    """
    files = scene_files(results)
    sample_seed = new_seed() if seed is None else seed
    gone = left_over(files)
    return (replace(_verdict(path, rows, sample_seed), newest=gone.get(path, "")) for path in files)


def left_over(files: Sequence[Path]) -> dict[Path, str]:
    """Return the datasets of scenes that are not in the study whose text the newest dataset has, each with its name."""
    made = {}
    for path in files:
        with suppress(StoreError):
            made[path] = str(read_sidecar(path).get("finished", ""))
    last = max(made, key=made.__getitem__, default=None)
    if last is None or not made[last]:
        return {}
    try:
        study, _ = study_and_scene(attributes_of(last))
    except (StoreError, StudyError, ForeignError, KeyError):
        return {}  # the verdict on this file says why
    return {path: last.stem for path in made if made[path] and path.stem not in study.scenes}


def _verdict(path: Path, rows: int, seed: int) -> Verdict:
    """Recompute a sample of one file."""
    name = path.stem
    try:
        attrs = attributes_of(path)
        if "study" not in attrs:
            return Verdict(name, left_out=NO_STUDY)
        if "row_start" in attrs:
            return Verdict(name, left_out=A_SHARD)
        study, scene = study_and_scene(attrs)
    except (StoreError, StudyError, ForeignError) as error:
        return Verdict(name, faults=str(error).splitlines())
    reasons = expected_changes(attrs)
    if fingerprint(study, scene) != attrs.get("fingerprint"):
        reasons.append("the study means something else to this version (its fingerprint differs)")
    generator = np.random.default_rng([seed, *name.encode()])
    sample = kind_of(scene).recompute(path, scene, rows, generator)
    faults = [str(difference) for difference in sample.differences]
    return Verdict(name, sample.checked, faults, reasons, sample.not_compared)


class ForeignError(ValueError):
    """The attributes of a file contradict each other."""


def study_and_scene(attrs: dict[str, Any]) -> tuple[Study, BaseScene]:
    """Return the study that a file contains, and the scene that the file belongs to."""
    text, title = str(attrs["study"]), str(attrs.get("title", ""))
    if hashlib.sha256(text.encode()).hexdigest() != attrs.get("study_hash"):
        raise ForeignError(
            "study: must be the one the file was made from, but its study_hash differs"
        )
    name, _, scene = title.partition(": ")
    study = study_of_text(text, name)
    if scene not in study.scenes:
        raise ForeignError(f"title: must name a scene of the study in the file, got {title!r}")
    return study, study.scenes[scene]
