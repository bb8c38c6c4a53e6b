"""Datasets against themselves: a random sample of their rows is computed again from what they say of their origin.

A dataset tells the study it was made of, so that neither the study's file nor its folder is needed.
"""

from __future__ import annotations

import hashlib
import math
import secrets
from collections.abc import Iterator
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from vibropipe.jobs.sharding import chain_length
from vibropipe.scenes import solve
from vibropipe.scenes.sweep import solve_part
from vibropipe.store import (
    Difference,
    StoreError,
    attributes_of,
    compare,
    compare_rows,
    expected_changes,
    scene_files,
)
from vibropipe.store.grid import Grid
from vibropipe.study import (
    AccuracyScene,
    BackboneScene,
    EffectsScene,
    HardCasesScene,
    Scene,
    Study,
    StudyError,
    SweepScene,
    fingerprint,
    study_of_text,
)
from vibropipe.study.grids import ValueGrid
from vibropipe.words.wording import count

__all__ = ["ROWS", "Verdict", "new_seed", "verify"]

ROWS = 100
MOST_TOLD = 3
TIMES = ("time_", "kernel_time", "target_ratio", "target_met")
NO_STUDY = "it holds no study, so that nothing tells how it was made"
A_SHARD = "it is a shard of a sweep: join all of them first"


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
        lines += [f"  {fault}" for fault in self.faults[:MOST_TOLD]]
        if len(self.faults) > MOST_TOLD:
            lines.append(f"  and {len(self.faults) - MOST_TOLD} more")
        lines += [f"  not compared: {self.left_out}"] if self.left_out else []
        if self.reasons:
            word = "can differ here" if self.good else "a difference is expected here"
            lines.append(f"  {word}: {'; '.join(self.reasons)}")
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
    checked, found = _computed_again(path, scene, rows, generator)
    timed = isinstance(scene, AccuracyScene | EffectsScene)
    left_out = "times, which are of the run that took them" if timed else ""
    return Verdict(name, checked, [str(item) for item in found], reasons, left_out)


class _ForeignError(ValueError):
    """What a file says of its origin contradicts itself."""


def _asked(attrs: dict[str, Any]) -> tuple[Study, Scene]:
    """Return the study that a file holds, and its scene in it."""
    text, title = str(attrs["study"]), str(attrs.get("title", ""))
    if hashlib.sha256(text.encode()).hexdigest() != attrs.get("study_hash"):
        raise _ForeignError("the study in it is not the one it was made of (study_hash differs)")
    name, _, scene = title.partition(": ")
    study = study_of_text(text, name)
    if scene not in study.scenes:
        raise _ForeignError(f"its title {title!r} names no scene of the study in it")
    return study, study.scenes[scene]


def _computed_again(
    path: Path, scene: Scene, rows: int, generator: np.random.Generator
) -> tuple[str, list[Difference]]:
    """Compute a part of a scene again; return what it was in words, and how the file differs from it."""
    if isinstance(scene, SweepScene):
        return _rows_again(path, scene, rows, generator)
    if isinstance(scene, HardCasesScene):
        from vibropipe.lab.hard_cases import CASES

        names = scene.cases or [case.name for case in CASES]
        names = [name for name in (case.name for case in CASES) if name in names]
        places = _sample(len(names), rows, generator)
        part: Scene = scene.model_copy(update={"cases": [names[place] for place in places]})
        return _of(len(places), len(names), "case"), compare(path, solve(part), ("case", places))
    if isinstance(scene, AccuracyScene):
        each = scene.row_count // len(scene.motions)
        places = _sample(len(scene.motions), math.ceil(rows / each), generator)
        motions = list(scene.motions.items())
        chosen = {"motions": dict(motions[place] for place in places), "repeats": 1}
        again = solve(scene.model_copy(update=chosen))
        words = _of(len(places) * each, scene.row_count, "race")
        return words, compare(path, again, ("motion", places), _is_of_a_run)
    if isinstance(scene, EffectsScene):
        again = solve(scene.model_copy(update={"repeats": 1}))
        return _of(scene.row_count, scene.row_count, "motion"), compare(
            path, again, skip=_is_of_a_run
        )
    if isinstance(scene, BackboneScene) and scene.over_amplitude:
        values = scene.over_arrays()["amplitude"]
        places = _sample(values.size, rows, generator)
        part = scene.model_copy(update={"amplitude": ValueGrid(values=values[places].tolist())})
        words = _of(len(places), values.size, "amplitude")
        return words, compare(path, solve(part), ("amplitude", places))
    return "all of it", compare(path, solve(scene))


def _is_of_a_run(name: str) -> bool:
    """Whether a quantity is of the run that took it, such as a time."""
    return name.startswith(TIMES)


def _rows_again(
    path: Path, scene: SweepScene, rows: int, generator: np.random.Generator
) -> tuple[str, list[Difference]]:
    """Compute rows of a sweep again, each by itself; where a parameter is followed, whole chains."""
    followed, length = scene.follow_pair(), chain_length(scene)
    grid = Grid(scene.over_arrays(), followed[0] if followed else None)
    chains = _sample(grid.rows // length, math.ceil(rows / length), generator)
    found: list[Difference] = []
    for chain in chains:
        shard = solve_part(scene, chain * length, (chain + 1) * length)
        found += compare_rows(path, shard, grid)
        if any(item.where == "" for item in found):  # the same in every row
            break
    return _of(len(chains) * length, grid.rows, "row"), found


def _sample(there_are: int, wanted: int, generator: np.random.Generator) -> list[int]:
    """Return places chosen at random, in order; all of them if no more are there."""
    if wanted >= there_are:
        return list(range(there_are))
    return sorted(int(place) for place in generator.choice(there_are, wanted, replace=False))


def _of(part: int, whole: int, noun: str) -> str:
    nouns = noun if whole == 1 else f"{noun}s"
    if part == whole:
        return f"the only {noun}" if whole == 1 else f"all {whole:,} {nouns}"
    return f"{part:,} of {whole:,} {nouns}"
