"""Which files of a study are stale: missing, or made from something else by their own words.

Datasets say it by their attributes, figures and reports by a fingerprint at their end. No record of an earlier run is
needed, so results may be copied, moved, and made from another folder.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from vibropipe.jobs.drawing import (
    SUFFIXES,
    figure_fingerprint,
    figure_names,
    report_fingerprint,
    scenes_drawn,
)
from vibropipe.jobs.solving import cut_text, identity, is_of
from vibropipe.store import fingerprint_of
from vibropipe.study import Study

# An input of each job whose outputs are stale. It is newer than they are, so that snakemake makes them again.
MARK = Path(".snakemake/outdated")


def stale_files(study: Study, results: str, shards: Mapping[str, int]) -> Iterator[str]:
    """Yield the files of a study that have to be made, in the order in which they are.

    Parameters
    ----------
    study : Study
        The study.
    results : str
        Folder of all results.
    shards : mapping of str to int
        Number of shards of each scene.
    """
    folder = f"{results}/{study.name}"
    scenes = stale_scenes(study, folder)
    for name in scenes:
        made_from = identity(study, study.scene(name))
        for number in range(1, shards[name] + 1) if shards[name] > 1 else ():
            path = shard_file(folder, name, number)
            if not is_of(path, made_from, cut_text(number, shards[name])):
                yield path
        yield f"{folder}/{name}.nc"
    for scene in study.scenes.values():
        of_stale = not scenes.isdisjoint(scenes_drawn(study, scene))
        for name in figure_names(scene):
            wanted = figure_fingerprint(study, scene, name, Path(folder))
            for path in (f"{folder}/figures/{name}{suffix}" for suffix in SUFFIXES):
                if of_stale or fingerprint_of(path) != wanted:
                    yield path
    path = f"{folder}/report.pdf"
    if scenes or fingerprint_of(path) != report_fingerprint(study, Path(folder)):
        yield path


def stale_scenes(study: Study, folder: str) -> set[str]:
    """Return the scenes of a study whose datasets are stale; `folder` has the results of the study."""
    return {
        name
        for name, scene in study.scenes.items()
        if not is_of(f"{folder}/{name}.nc", identity(study, scene))
    }


def shard_file(folder: str, scene: str, number: int) -> str:
    """Return the file of a shard, counted from 1; `folder` has the results of the study."""
    return f"{folder}/shards/{scene}/{number:04d}.nc"


def write_mark(stale: Iterable[str]) -> str:
    """Write MARK, newer than all stale files, even those of a clock that was ahead; return its path."""
    MARK.parent.mkdir(exist_ok=True)
    # different at each call: snakemake takes an input with the content of an earlier run for unchanged
    MARK.write_text(str(time.time_ns()), encoding="utf-8")
    now = MARK.stat().st_mtime
    for path in map(Path, stale):
        if path.is_file() and path.stat().st_mtime >= now:
            os.utime(path, (now - 1, now - 1))
    return str(MARK)
