"""The studies of one run of the workflow: what each comes to, and what its jobs are told.

The workflow's rules ask here and hold no knowledge of their own. Studies are read once, before any job. A rule
depends on its own part of a study through `params` and never on the YAML file: an edit of one scene is seen by
the jobs of that scene alone, a touched file by none.
"""

from __future__ import annotations

import hashlib
import math
import re
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vibropipe.jobs.drawing import figure_names
from vibropipe.jobs.plan import ScenePlan, plan_scene
from vibropipe.jobs.solving import code_hash
from vibropipe.scenes.costs import PlanError
from vibropipe.scenes.keys.base import BaseScene
from vibropipe.scenes.keys.values import NAME
from vibropipe.scenes.registry import kind_of
from vibropipe.store import NotWrittenError
from vibropipe.store.atomic import remove_leftovers
from vibropipe.study import (
    Config,
    Study,
    canonical_text,
    config_of_files,
    fingerprint,
    load_config,
    load_study,
)

CONFIG = "config/config.yaml"
# A sweep is worth a thread for each four seconds of its work.
SECONDS_PER_THREAD = 4
# Priority of a job that nothing is to be started before.
FIRST = 1000


@dataclass(frozen=True)
class Run:
    """Studies by name, with their files and plans (by scene), and the folder of results.

    default: the studies that are made where nothing else is asked for.
    """

    results: str
    files: Mapping[str, Path]
    studies: Mapping[str, Study]
    plans: Mapping[str, Mapping[str, ScenePlan]]
    default: tuple[str, ...]

    def plan(self, job: Any) -> ScenePlan:
        """Return the plan of the scene of a job, which has `study` and `scene`."""
        return self.plans[job.study][job.scene]

    def file(self, job: Any) -> str:
        """Return the file of the study of a job, as the command line takes it."""
        return str(self.files[job.study])

    def fingerprint(self, job: Any) -> str:
        """Return the hash of all that the data of a scene depend on."""
        return fingerprint(self.studies[job.study], job.scene)

    def code(self, job: Any) -> str:
        """Return the hash of the code that the data of a scene depend on."""
        return code_hash(kind_of(self.studies[job.study].scenes[job.scene]))

    def wording(self, name: str) -> str:
        """Return the hash of all that a study says, titles and captions too."""
        return hashlib.sha256(canonical_text(self.studies[name]).encode()).hexdigest()

    def threads(self, job: Any, cores: int) -> int:
        """Return how many threads a scene gets."""
        plan = self.plan(job)
        return cores if plan.is_timed else useful_threads(plan)

    def priority(self, job: Any) -> int:
        """Return how early a scene is solved.

        First what takes several cores: later it would wait for them until all others are done. Then by the
        seconds that are left of its study: its own work, and about one for each figure, which one job draws when
        all scenes of a study are there.
        """
        plan = self.plan(job)
        if plan.shards == 1 and (plan.is_timed or useful_threads(plan) > 1):
            return FIRST
        return min(math.ceil(plan.seconds) + len(self.plans[job.study]), FIRST - 1)

    def shards(self, job: Any) -> list[str]:
        """Return the files of all shards of a sweep."""
        folder = f"{self.results}/{job.study}/shards/{job.scene}"
        return [f"{folder}/{shard:04d}.nc" for shard in range(1, self.plan(job).shards + 1)]

    def shard_sidecars(self, job: Any) -> list[str]:
        """Return what the shards of a sweep tell of their times."""
        return [path.removesuffix(".nc") + ".json" for path in self.shards(job)]

    def cut(self, job: Any) -> str:
        """Return which shard of how many, as the command line takes it."""
        return f"{int(job.shard)}/{self.plan(job).shards}"

    def datasets(self, name: str) -> list[str]:
        """Return the datasets of a study."""
        return [f"{self.results}/{name}/{scene}.nc" for scene in self.studies[name].scenes]

    def figures(self, name: str, suffix: str) -> list[str]:
        """Return the figures of a study."""
        return [path for path, _ in self.drawn(name, suffix)]

    def drawn(self, name: str, suffix: str) -> list[tuple[str, BaseScene]]:
        """Return the figures of a study, each with its scene."""
        folder = f"{self.results}/{name}/figures"
        scenes = self.studies[name].scenes.values()
        return [(f"{folder}/{n}.{suffix}", scene) for scene in scenes for n in figure_names(scene)]

    def report(self, name: str) -> str:
        """Return the report of a study."""
        return f"{self.results}/{name}/report.pdf"

    def targets(self, name: str) -> list[str]:
        """Return what is made of a study."""
        figures = [*self.figures(name, "svg"), *self.figures(name, "pdf")]
        return [*self.datasets(name), *figures, self.report(name)]

    def scenes_regex(self, chosen: Callable[[ScenePlan], bool], folder: str = "") -> str:
        """Return the names of the scenes whose plan is chosen, each behind the folder of its study."""
        found = [
            f"(?<=/{study}/{folder})(?:{'|'.join(names)})"
            for study, plans in self.plans.items()
            if (names := [name for name, plan in plans.items() if chosen(plan)])
        ]
        return "|".join(found) or "(?!)"


def useful_threads(plan: ScenePlan) -> int:
    """Return how many threads a scene is worth for its work."""
    return max(1, round(plan.seconds / SECONDS_PER_THREAD)) if plan.is_parallel else 1


def read_run(
    config_file: str | None, given: Mapping[str, Any], arguments: Iterable[str] = ()
) -> Run:
    """Read the studies of a run.

    Parameters
    ----------
    config_file : str or None
        The list of studies; `config/config.yaml` if None.
    given : mapping
        What the command line sets: `studies` (files, or names in `config/`) and `results`.
    arguments : iterable of str
        The command line. A file in the folder of results names its study, listed or not.

    Raises
    ------
    StudyError, PlanError
        With every fault of the list or of a study.
    """
    config = _config(config_file, given)
    check_results_name(config.results)
    files = {name: config.study_file(name) for name in config.studies}
    files |= {name: config.study_file(name) for name in _named(config, arguments)}
    studies = {name: load_study(file) for name, file in files.items()}
    plans = {
        name: {scene.name: plan_scene(scene) for scene in study.scenes.values()}
        for name, study in studies.items()
    }
    return Run(config.results, files, studies, plans, tuple(config.studies))


def _config(config_file: str | None, given: Mapping[str, Any]) -> Config:
    """Return the list of studies: the command line's, else the file's."""
    unknown = sorted(set(given) - {"studies", "results"})
    if unknown:
        raise PlanError(
            f"--config: must be studies or results, got {unknown[0]} (see also --configfile)"
        )
    if "studies" in given:
        return config_of_files(given["studies"], given.get("results", "results"))
    config = load_config(config_file or CONFIG)
    if "results" in given:
        config = config.model_copy(update={"results": str(given["results"])})
    return config


def check_results_name(results: str) -> None:
    """Raise PlanError unless a name can be that of the folder of results."""
    if set(results) & set("{}*"):
        raise PlanError(f"results: must be a folder's name without {{, }} and *, got {results!r}")
    if Path(results).exists() and not Path(results).is_dir():
        raise PlanError(f"results: must be a folder, got the file {results}")


def check_writable(results: str) -> None:
    """Make the folder of results, and raise NotWrittenError unless it takes files."""
    try:
        Path(results).mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=results):
            pass
    except OSError as error:
        raise NotWrittenError(
            f"{results}: cannot be written ({error.strerror}): change its permissions, free disk space, or name"
            f" another folder under `results` in {CONFIG}"
        ) from None


def clear_leftovers(paths: Iterable[str]) -> None:
    """Remove the hidden files that killed writers of some files left, for one who has locked these files."""
    made: dict[Path, set[str]] = {}
    for path in map(Path, paths):
        made.setdefault(path.parent, set()).add(path.name)
    for folder, names in made.items():
        # shards belong to one sweep, however it was cut before
        remove_leftovers(folder, None if folder.parent.name == "shards" else names)


def write_caption(study: str, scene: BaseScene) -> str:
    """Write the caption of a scene for `snakemake --report`, which reads it as reStructuredText; return the file."""
    words = " ".join((scene.caption or scene.title or scene.name).split())
    path = Path(".snakemake", "captions", study, f"{scene.name}.rst").absolute()
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(re.sub(r"([^\w\s])", r"\\\1", words) + "\n", encoding="utf-8")
    return str(path)


def _named(config: Config, arguments: Iterable[str]) -> Iterator[str]:
    """Yield the studies beside those of the list that a command line names: by a file of their results or, where a
    job is a call of its own, by the job."""
    results = re.escape(config.results.rstrip("/"))
    by_file = re.compile(rf"(?:\./)?{results}/+({NAME.pattern})/")
    by_job = re.compile(rf"(?:figures_|.*\bstudy=)({NAME.pattern})")
    for argument in arguments:
        if found := by_file.match(argument):
            yield found[1]
            continue
        found = by_job.match(argument)
        if found and config.study_file(found[1]).is_file():
            yield found[1]
