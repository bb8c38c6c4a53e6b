"""The studies of one run of the workflow: their plans, files, and the parameters of their jobs.

The rules of the workflow call the methods of `Run` and hold no logic of their own. Studies are read once, before any
job. What is made again is what is missing or says by its own fingerprint that it was made from something else, whatever
records snakemake keeps: an edit of one scene reruns the jobs of that scene only, and a touched file reruns none.
"""

from __future__ import annotations

import functools
import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vibropipe.compiler.cache import has_kernels
from vibropipe.jobs.drawing import SUFFIXES, figures_of
from vibropipe.jobs.plan import SHARD_VARIABLE, ScenePlan, plan_scene, shard_seconds
from vibropipe.jobs.solving import cut_text
from vibropipe.jobs.up_to_date import shard_file, stale_files, write_mark
from vibropipe.scenes.costs import PlanError
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.keys.values import NAME
from vibropipe.study import Config, Study, config_of_files, load_config, load_study

CONFIG = "config/config.yaml"
# Seconds of work, on one core, for each thread of a scene; and where its kernels have to be compiled first, which takes
# one core half a minute: for less work than that, others would wait for it.
SECONDS_PER_THREAD, SECONDS_PER_THREAD_UNCOMPILED = 4, 30
# The module whose kernels solve rows.
ROWS = "vibropipe.solve.rows.many"
# Priority of jobs that start before all others.
FIRST = 1000
# Cores that every node of a cluster has: a job that asks for more than a node has would wait for ever.
CORES_OF_NODES = 2


@dataclass(frozen=True)
class Run:
    """The studies of one run. Methods take a job of snakemake, which has the wildcards `study`, `scene` and `shard`.

    results : folder of all results
    files : YAML file of each study by name
    plans : plans by study and scene
    default : studies that are made if no target is named
    named : files of results that the command line names
    """

    results: str
    files: Mapping[str, Path]
    studies: Mapping[str, Study]
    plans: Mapping[str, Mapping[str, ScenePlan]]
    default: tuple[str, ...]
    named: tuple[str, ...] = ()

    def plan(self, job: Any) -> ScenePlan:
        """Return the plan of the scene of a job."""
        return self.plans[job.study][job.scene]

    def file(self, job: Any) -> str:
        """Return the YAML file of the study of a job."""
        return str(self.files[job.study])

    def batches(self) -> Iterator[tuple[str, list[str]]]:
        """Yield each study with the scenes of each job that solves whole scenes.

        All that are less work than a shard are one job. A longer one, and one that measures times, is a job of its own.
        """
        for study, plans in self.plans.items():
            whole = [plan for plan in plans.values() if plan.shards == 1]
            alone = [p.name for p in whole if p.is_timed or p.seconds > shard_seconds()]
            small = [plan.name for plan in whole if plan.name not in alone]
            yield from ((study, scenes) for scenes in (small, *([n] for n in alone)) if scenes)

    def threads(self, study: str, scenes: Sequence[str], cores: int | None) -> int:
        """Return the number of threads of a job that solves scenes.

        cores : of the machine; None on a cluster, where a job may have those of the smallest node. Else it has at most
            its share of the work of the run: jobs side by side leave fewer cores idle than one job on all of them,
            whose last scene runs alone
        """
        plans = [self.plans[study][scene] for scene in scenes]
        if any(plan.is_timed for plan in plans):
            return cores or 1
        stale = self.stale_of(study, "{}.nc", scenes)
        whole = sum(plan.seconds for plan in plans)
        most = math.ceil(whole / seconds_per_thread()) if has_kernels(ROWS) else len(stale)
        useful = max(1, min(len(stale), most), *map(useful_threads, plans))
        own = sum(self.plans[study][scene].seconds for scene in stale)
        return max(1, min(useful, share_of_cores(cores, own, self._seconds_to_solve)))

    @functools.cached_property
    def _seconds_to_solve(self) -> float:
        """Planned seconds of all scenes that have to be solved beside others, above 0."""
        own = (
            self.plans[study][scene]
            for study in self.at_work()
            for scene in self.stale_of(study, "{}.nc", self.plans[study])
        )
        return sum(plan.seconds for plan in own if not plan.is_timed) or math.inf

    def drawing_threads(self, study: str, cores: int | None) -> int:
        """Return the number of threads of a study's last job: its share of the figures that the run draws.

        cores : as of `threads`
        """
        own = len(self.figures_to_draw(study))
        whole = sum(len(self.figures_to_draw(each)) for each in self.at_work())
        return max(1, min(own, share_of_cores(cores, own, max(whole, 1))))

    def priority(self, study: str, scenes: Sequence[str]) -> int:
        """Return the priority of a job that solves scenes, shards included; a larger one starts earlier.

        Jobs that take all cores come first, since later they would wait until all other jobs are done, and before
        others those that may take several. The rest are ordered by the seconds left of their study: their own work,
        and about a second for each figure.
        """
        plans = [self.plans[study][scene] for scene in scenes]
        if any(plan.is_timed for plan in plans):
            return FIRST
        if plans[0].shards == 1 and any(useful_threads(plan) > 1 for plan in plans):
            return FIRST - 1
        seconds = sum(plan.seconds for plan in plans)
        return min(math.ceil(seconds) + len(self.plans[study]), FIRST - 2)

    def shards(self, job: Any) -> list[str]:
        """Return the files of all shards of a sweep."""
        folder = f"{self.results}/{job.study}"
        numbers = range(1, self.plan(job).shards + 1)
        return [shard_file(folder, job.scene, number) for number in numbers]

    def shard_sidecars(self, job: Any) -> list[str]:
        """Return the sidecars of all shards of a sweep."""
        return [path.removesuffix(".nc") + ".json" for path in self.shards(job)]

    def cut(self, job: Any) -> str:
        """Return the shard of a job as `I/N`, the option of `vibropipe solve`."""
        return cut_text(int(job.shard), self.plan(job).shards)

    def datasets(self, name: str) -> list[str]:
        """Return the datasets of a study."""
        return [f"{self.results}/{name}/{scene}.nc" for scene in self.studies[name].scenes]

    def figures(self, name: str, suffix: str) -> list[str]:
        """Return the figure files of a study with one suffix."""
        return [f"{self.results}/{name}/figures/{n}.{suffix}" for n in self.drawn_scenes(name)]

    def drawn_scenes(self, name: str) -> dict[str, BaseScene]:
        """Return the scene of each figure of a study by the figure's name."""
        return figures_of(self.studies[name])

    @functools.cached_property
    def stale(self) -> frozenset[str]:
        """Files that have to be made, as found at first use."""
        return frozenset(self.stale_now())

    def stale_now(self) -> Iterator[str]:
        """Yield the files that have to be made, as found now."""
        for name, study in self.studies.items():
            shards = {scene: plan.shards for scene, plan in self.plans[name].items()}
            yield from stale_files(study, self.results, shards)

    def stale_of(self, study: str, pattern: str, names: Iterable[str]) -> list[str]:
        """Return the names whose files, `pattern` with the name in it, have to be made in the folder of a study."""
        folder = f"{self.results}/{study}/"
        return [name for name in names if folder + pattern.format(name) in self.stale]

    def drawing(self, study: str) -> str:
        """Return what the last job of a study makes, as text."""
        figures = self.figures_to_draw(study)
        drawn = [f"drawing {', '.join(figures)}"] if figures else []
        return " and ".join([*drawn, "typesetting the report"])

    def figures_to_draw(self, study: str) -> list[str]:
        """Return the names of the figures of a study that have to be drawn."""
        names = self.drawn_scenes(study)
        stale = {n for s in SUFFIXES for n in self.stale_of(study, f"figures/{{}}{s}", names)}
        return [name for name in names if name in stale]

    def mark(self, *paths: str) -> list[str]:
        """Return an input that is newer than some files of results if one is stale; none if they are up to date."""
        return self._mark if not self.stale.isdisjoint(paths) else []

    @functools.cached_property
    def _mark(self) -> list[str]:
        return [write_mark(self.stale)]

    def report(self, name: str) -> str:
        """Return the report of a study."""
        return f"{self.results}/{name}/report.pdf"

    def drawn(self, name: str) -> list[str]:
        """Return the figures and the report of a study."""
        return [*self.figures(name, "svg"), *self.figures(name, "pdf"), self.report(name)]

    def targets(self, name: str) -> list[str]:
        """Return all files that a study results in: datasets, figures and report."""
        return [*self.datasets(name), *self.drawn(name)]

    @property
    def wanted(self) -> list[str]:
        """Files that the run is to make: those that the command line names, else all of the default studies."""
        return [*self.named] or [path for name in self.default for path in self.targets(name)]

    def at_work(self) -> list[str]:
        """Return the studies with files that are wanted and that have to be made."""
        folders = {path.removeprefix(f"{self.results}/").split("/")[0] for path in self.wanted}
        to_make = {path.removeprefix(f"{self.results}/").split("/")[0] for path in self.stale}
        return [name for name in self.studies if name in folders & to_make]

    def scenes_regex(self, folder: str = "") -> str:
        """Return a regular expression of the scenes that are cut into shards, each preceded by its study's folder.

        It matches nothing if there are none.
        """
        alternatives = [
            f"(?<=/{study}/{folder})(?:{'|'.join(names)})"
            for study, plans in self.plans.items()
            if (names := [name for name, plan in plans.items() if plan.shards > 1])
        ]
        return "|".join(alternatives) or "(?!)"


def share_of_cores(cores: int | None, own: float, whole: float) -> int:
    """Return the cores of a job that is a part of all work; None for those of a machine means a cluster."""
    return CORES_OF_NODES if cores is None else round(cores * own / whole)


def seconds_per_thread() -> float:
    """Return the seconds of work that justify a further thread."""
    return SECONDS_PER_THREAD if has_kernels(ROWS) else SECONDS_PER_THREAD_UNCOMPILED


def useful_threads(plan: ScenePlan) -> int:
    """Return the number of threads that the work of a scene justifies."""
    return max(1, round(plan.seconds / seconds_per_thread())) if plan.is_parallel else 1


def read_run(
    config_file: str | None, settings: Mapping[str, Any], arguments: Iterable[str] = ()
) -> Run:
    """Read the studies of a run.

    config_file : the list of studies; `config/config.yaml` if None
    settings : settings of the command line (`--config`): `studies` (files, or names in `config/`) and `results`
    arguments : the command line. A file in the folder of results names its study, listed or not
    Raises StudyError, PlanError with every fault of the list or of a study.
    """
    config = _config(config_file, settings)
    check_results_name(config.results)
    named = tuple(_named_files(config, arguments))
    files = {name: config.study_file(name) for name in config.studies}
    files |= {name: config.study_file(name) for name in _named_studies(config, named, arguments)}
    places = tuple(
        (name, str(file), file.resolve(), file.stat().st_mtime_ns if file.is_file() else 0)
        for name, file in files.items()
    )
    studies, plans = _read(places, os.environ.get(SHARD_VARIABLE))
    return Run(config.results, files, studies, plans, tuple(config.studies), named)


@functools.lru_cache(maxsize=1)
def _read(
    places: tuple[tuple[str, str, Path, int], ...], _shard_seconds: str | None
) -> tuple[dict[str, Study], dict[str, dict[str, ScenePlan]]]:
    """Read and plan studies, once in a process: name, file, and the place and time by which it is the same file."""
    studies = {name: load_study(file) for name, file, *_ in places}
    plans = {
        name: {scene.name: plan_scene(scene) for scene in study.scenes.values()}
        for name, study in studies.items()
    }
    return studies, plans


def _config(config_file: str | None, settings: Mapping[str, Any]) -> Config:
    """Return the list of studies: that of the command line, else that of the file.

    Settings may be those of the file and of the command line together, as snakemake has them.
    """
    listed = (
        load_config(config_file or CONFIG) if config_file or "studies" not in settings else None
    )
    unknown = sorted(set(settings) - {"studies", "results"})
    if unknown:
        raise PlanError(
            f"--config: must be studies or results, got {unknown[0]} (see also --configfile)"
        )
    results = settings.get("results", listed.results if listed else "results")
    if listed is None or settings.get("studies", listed.studies) != listed.studies:
        return config_of_files(settings["studies"], results)
    return listed.model_copy(update={"results": str(results)})


def check_results_name(results: str) -> None:
    """Raise PlanError unless the name is valid for the folder of results."""
    if set(results) & set("{}*"):
        raise PlanError(f"results: must be a folder's name without {{, }} and *, got {results!r}")
    if Path(results).exists() and not Path(results).is_dir():
        raise PlanError(f"results: must be a folder, got the file {results}")


def _named_files(config: Config, arguments: Iterable[str]) -> Iterator[str]:
    """Yield the files of results that a command line names."""
    results = config.results.rstrip("/")
    pattern = re.compile(rf"(?:\./)?{re.escape(results)}/+({NAME.pattern}/.*)")
    yield from (f"{results}/{match[1]}" for word in arguments if (match := pattern.match(word)))


def _named_studies(config: Config, named: Iterable[str], arguments: Iterable[str]) -> Iterator[str]:
    """Yield the studies that a command line names: by a result file, or by a job in its own call of snakemake."""
    for path in named:
        yield path.removeprefix(config.results.rstrip("/")).split("/")[1]
    for argument in arguments:
        match = re.match(rf".*\bstudy=({NAME.pattern})", argument)
        if match and config.study_file(match[1]).is_file():
            yield match[1]
