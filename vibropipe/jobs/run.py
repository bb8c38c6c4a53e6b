"""The studies of one run of the workflow: their plans, files, and the parameters of their jobs.

The rules of the workflow call the methods of `Run` and hold no logic of their own. Studies are read once, before any
job. What is made again is what is missing or says by its own fingerprint that it was made from something else, whatever
records snakemake keeps: an edit of one scene reruns the jobs of that scene only, and a touched file reruns none.
"""

from __future__ import annotations

import functools
import math
import re
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vibropipe.compiler.cache import has_kernels
from vibropipe.jobs.drawing import figures_of, scenes_drawn
from vibropipe.jobs.plan import ScenePlan, plan_scene
from vibropipe.jobs.solving import cut_text
from vibropipe.jobs.up_to_date import shard_file, stale_files, write_mark
from vibropipe.scenes.costs import PlanError
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.keys.values import NAME
from vibropipe.store import NotWrittenError, check_intact, remove_leftovers
from vibropipe.store.files import ENDING
from vibropipe.study import (
    Config,
    Study,
    config_of_files,
    load_config,
    load_study,
)

CONFIG = "config/config.yaml"
# Folders in which a run writes, whatever the folder of results, if they exist.
WORKING_FOLDERS = (".", ".snakemake", "logs")
# Seconds of work, on one core, for each thread of a scene; and where its kernels have to be compiled first, which takes
# one core half a minute: for less work than that, others would wait for it.
SECONDS_PER_THREAD, SECONDS_PER_THREAD_UNCOMPILED = 4, 30
# The module whose kernels solve rows.
ROWS = "vibropipe.solve.rows.many"
# Priority of jobs that start before all others.
FIRST = 1000


@dataclass(frozen=True)
class Run:
    """The studies of one run. Methods take a job of snakemake, which has the wildcards `study`, `scene` and `shard`.

    Parameters
    ----------
    results : str
        Folder of all results.
    files : mapping of str to Path
        YAML file of each study by name.
    studies : mapping of str to Study
        Studies by name.
    plans : mapping
        Plans by study and scene.
    default : tuple of str
        Studies that are made if no target is named.
    """

    results: str
    files: Mapping[str, Path]
    studies: Mapping[str, Study]
    plans: Mapping[str, Mapping[str, ScenePlan]]
    default: tuple[str, ...]

    def plan(self, job: Any) -> ScenePlan:
        """Return the plan of the scene of a job."""
        return self.plans[job.study][job.scene]

    def file(self, job: Any) -> str:
        """Return the YAML file of the study of a job."""
        return str(self.files[job.study])

    def threads(self, job: Any, cores: int) -> int:
        """Return the number of threads of a scene on a machine with `cores` cores."""
        plan = self.plan(job)
        return cores if plan.is_timed else useful_threads(plan)

    def priority(self, job: Any) -> int:
        """Return the priority of a scene; a larger one starts earlier.

        Scenes that take several cores come first, since later they would wait until all other jobs are done. The
        others are ordered by the seconds left of their study: their own work, and about a second for each figure.
        """
        plan = self.plan(job)
        if plan.shards == 1 and (plan.is_timed or useful_threads(plan) > 1):
            return FIRST
        return min(math.ceil(plan.seconds) + len(self.plans[job.study]), FIRST - 1)

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

    def figure_regex(self) -> str:
        """Return a regular expression of the names of all figures, each preceded by the folder of its study."""
        alternatives = [
            f"(?<=/{study}/figures/)(?:{'|'.join(self.drawn_scenes(study))})"
            for study in self.studies
        ]
        return "|".join(alternatives) or "(?!)"

    def drawn_scenes(self, name: str) -> dict[str, BaseScene]:
        """Return the scene of each figure of a study by the figure's name."""
        return figures_of(self.studies[name])

    def figure_scene(self, job: Any) -> BaseScene:
        """Return the scene of a figure's job, which has the wildcards `study` and `figure`."""
        return self.drawn_scenes(job.study)[job.figure]

    def figure_data(self, job: Any) -> list[str]:
        """Return the datasets that a figure is drawn from."""
        names = scenes_drawn(self.studies[job.study], self.figure_scene(job))
        return [f"{self.results}/{job.study}/{scene}.nc" for scene in names]

    @functools.cached_property
    def stale(self) -> frozenset[str]:
        """Files that have to be made, as found at first use."""
        return frozenset(
            path
            for name, study in self.studies.items()
            for path in stale_files(
                study,
                self.results,
                {scene: plan.shards for scene, plan in self.plans[name].items()},
            )
        )

    def mark(self, *paths: str) -> list[str]:
        """Return an input that is newer than some files of results if one is stale; none if they are up to date."""
        return self._mark if not self.stale.isdisjoint(paths) else []

    @functools.cached_property
    def _mark(self) -> list[str]:
        return [write_mark(self.stale)]

    def report(self, name: str) -> str:
        """Return the report of a study."""
        return f"{self.results}/{name}/report.pdf"

    def targets(self, name: str) -> list[str]:
        """Return all files that a study results in: datasets, figures and report."""
        figures = [*self.figures(name, "svg"), *self.figures(name, "pdf")]
        return [*self.datasets(name), *figures, self.report(name)]

    def scenes_regex(self, chosen: Callable[[ScenePlan], bool], folder: str = "") -> str:
        """Return a regular expression of the scenes whose plan is chosen, each preceded by the folder of its study.

        It matches nothing if no plan is chosen.
        """
        alternatives = [
            f"(?<=/{study}/{folder})(?:{'|'.join(names)})"
            for study, plans in self.plans.items()
            if (names := [name for name, plan in plans.items() if chosen(plan)])
        ]
        return "|".join(alternatives) or "(?!)"


def useful_threads(plan: ScenePlan) -> int:
    """Return the number of threads that the work of a scene justifies."""
    if not plan.is_parallel:
        return 1
    per_thread = SECONDS_PER_THREAD if has_kernels(ROWS) else SECONDS_PER_THREAD_UNCOMPILED
    return max(1, round(plan.seconds / per_thread))


def read_run(
    config_file: str | None, settings: Mapping[str, Any], arguments: Iterable[str] = ()
) -> Run:
    """Read the studies of a run.

    Parameters
    ----------
    config_file : str or None
        The list of studies; `config/config.yaml` if None.
    settings : mapping
        Settings of the command line (`--config`): `studies` (files, or names in `config/`) and `results`.
    arguments : iterable of str
        The command line. A file in the folder of results names its study, listed or not.

    Returns
    -------
    Run
        The studies with their plans.

    Raises
    ------
    StudyError, PlanError
        With every fault of the list or of a study.
    """
    config = _config(config_file, settings)
    check_results_name(config.results)
    files = {name: config.study_file(name) for name in config.studies}
    files |= {name: config.study_file(name) for name in _named_studies(config, arguments)}
    studies = {name: load_study(file) for name, file in files.items()}
    plans = {
        name: {scene.name: plan_scene(scene) for scene in study.scenes.values()}
        for name, study in studies.items()
    }
    return Run(config.results, files, studies, plans, tuple(config.studies))


def _config(config_file: str | None, settings: Mapping[str, Any]) -> Config:
    """Return the list of studies: that of the command line, else that of the file."""
    unknown = sorted(set(settings) - {"studies", "results"})
    if unknown:
        raise PlanError(
            f"--config: must be studies or results, got {unknown[0]} (see also --configfile)"
        )
    if "studies" in settings:
        return config_of_files(settings["studies"], settings.get("results", "results"))
    config = load_config(config_file or CONFIG)
    if "results" in settings:
        config = config.model_copy(update={"results": str(settings["results"])})
    return config


def check_results_name(results: str) -> None:
    """Raise PlanError unless the name is valid for the folder of results."""
    if set(results) & set("{}*"):
        raise PlanError(f"results: must be a folder's name without {{, }} and *, got {results!r}")
    if Path(results).exists() and not Path(results).is_dir():
        raise PlanError(f"results: must be a folder, got the file {results}")


def check_working_folder() -> None:
    """Raise NotWrittenError unless the working folder, where snakemake keeps records and logs, can be written."""
    for folder in filter(Path.is_dir, map(Path, WORKING_FOLDERS)):
        try:
            with tempfile.TemporaryFile(dir=folder):
                pass
        except OSError as error:
            raise NotWrittenError(
                f"{folder.absolute()}: cannot be written ({error.strerror}), but the records and logs of a run are kept"
                " there: call it in another folder, or change the permissions of this one"
            ) from None


def check_writable(results: str) -> None:
    """Create the folder of results, and raise NotWrittenError unless files can be written there."""
    try:
        Path(results).mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=results):
            pass
    except OSError as error:
        raise NotWrittenError(
            f"{results}: cannot be written ({error.strerror}): change its permissions, free disk space, or name"
            f" another folder under `results` in {CONFIG}"
        ) from None


def check_whole(paths: Iterable[str]) -> None:
    """Raise StoreError if a dataset is truncated. Snakemake deletes what a job makes before the job can find it out."""
    for path in dict.fromkeys(paths):
        if Path(path).suffix == ENDING and Path(path).is_file():
            check_intact(path, every_byte=False)


def clear_leftovers(paths: Iterable[str]) -> None:
    """Remove the hidden files that killed writers of these files left; the caller holds the locks of the files."""
    by_folder: dict[Path, set[str]] = {}
    for path in map(Path, paths):
        by_folder.setdefault(path.parent, set()).add(path.name)
    for folder, names in by_folder.items():
        # all files here belong to one sweep, which may have been cut into another number of shards
        remove_leftovers(folder, None if folder.parent.name == "shards" else names)


def _named_studies(config: Config, arguments: Iterable[str]) -> Iterator[str]:
    """Yield the studies that a command line names: by a result file, or by a job in its own call of snakemake."""
    results = re.escape(config.results.rstrip("/"))
    by_file = re.compile(rf"(?:\./)?{results}/+({NAME.pattern})/")
    by_job = re.compile(rf".*\bstudy=({NAME.pattern})")
    for argument in arguments:
        if match := by_file.match(argument):
            yield match[1]
            continue
        match = by_job.match(argument)
        if match and config.study_file(match[1]).is_file():
            yield match[1]
