"""Which files of a study are stale: missing, or made from something else by their own words.

Datasets say it by their attributes, figures and reports by a fingerprint at their end. No record of an earlier run is
needed, so results may be copied, moved, and made from another folder.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path

from vibropipe.jobs.drawing import (
    SUFFIXES,
    figure_fingerprint,
    figures_of,
    report_fingerprint,
    scenes_drawn,
)
from vibropipe.jobs.solving import cut_text, identity, is_of
from vibropipe.store import fingerprint_of
from vibropipe.study import Study

# An input of each job whose outputs are stale. It is newer than they are, so that snakemake makes them again.
MARK = Path(".snakemake/outdated")


def stale_files(study: Study, results: str, shards: Mapping[str, int]) -> Iterator[str]:
    """Yield the files of a study that have to be made, in this order; date the others on, in the order of their making.

    results : folder of all results
    shards : number of shards of each scene
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
    made = _last_time(f"{folder}/{name}.nc" for name in study.scenes)
    drawn = made
    for name, scene in figures_of(study).items():
        of_stale = not scenes.isdisjoint(scenes_drawn(study, scene))
        wanted = figure_fingerprint(study, scene, name, Path(folder))
        for path in (f"{folder}/figures/{name}{suffix}" for suffix in SUFFIXES):
            if of_stale or fingerprint_of(path) != wanted:
                yield path
            else:
                drawn = max(drawn, _date_on(path, made))
    path = f"{folder}/report.pdf"
    if scenes or fingerprint_of(path) != report_fingerprint(study, Path(folder)):
        yield path
    else:
        _date_on(path, drawn)


def _last_time(paths: Iterable[str]) -> int:
    """Return the latest modification time (ns) of files, 0 without any."""
    return max((Path(path).stat().st_mtime_ns for path in paths if Path(path).exists()), default=0)


def _date_on(path: str, time_ns: int) -> int:
    """Give a file that is up to date at least the time (ns) of what it is made from; return its time.

    A copy may have other times, by which snakemake would make the file again.
    """
    own = _last_time([path])
    if own < time_ns:
        with suppress(OSError):  # a file of somebody else
            os.utime(path, ns=(time_ns, time_ns))
    return max(own, time_ns)


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
