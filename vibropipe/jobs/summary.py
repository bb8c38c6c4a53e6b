"""The summary of a run: files made, up to date and missing, study by study."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from vibropipe.jobs.run import Run
from vibropipe.jobs.up_to_date import stale_scenes
from vibropipe.store import StoreError, read_sidecar, selected_attributes
from vibropipe.words.wording import share

HOW_TO_RESUME = (
    "The run is incomplete; see its errors and logs/. Fix the cause and run the same command again: completed\n"
    "files are kept."
)
# Begins the error of a job, in its log.
ERROR = "vibropipe: "
# Limits of the lists: paths of missing files, and names of scenes (beyond it their number is printed).
MAX_LISTED, MAX_SCENES_LISTED = 20, 4


@dataclass(frozen=True)
class Summary:
    """Lines that are printed at the end of a run, and paths of missing files (none if all were made)."""

    lines: list[str]
    missing: list[str]


# Summaries that this process has printed: the workflow prints none where nothing is to be done.
PRINTED: list[Summary] = []


def summarise_all(run: Run) -> Summary:
    """Return the summary of a run whose studies were all up to date."""
    return summarise(run, [path for name in run.default for path in run.targets(name)], {})


def summarise(run: Run, requested: Collection[str], planned: Mapping[str, int]) -> Summary:
    """Return the summary of a finished run.

    Parameters
    ----------
    run : Run
        The studies.
    requested : collection of str
        All files that were requested, and the files that they are made of.
    planned : mapping of str to int
        The files that had to be made, each with its modification time (ns) before the run, 0 if it did not exist.

    Returns
    -------
    Summary
        A dataset that was made from another study or by other code counts as missing.
    """
    lines: list[str] = []
    missing = [path for path in sorted(requested) if not Path(path).is_file()]
    now = file_times(planned)
    missing += [path for path in planned if now[path] in (0, planned[path])]
    for name, study in run.studies.items():
        parts = _parts(run, name)
        wanted = {part: files for part, paths in parts.items() if (files := paths & set(requested))}
        if not wanted:
            continue
        scenes = [scene for scene in study.scenes if scene in wanted]
        unresolved, stale = [], stale_scenes(study, f"{run.results}/{name}")
        for scene in scenes:
            path = f"{run.results}/{name}/{scene}.nc"
            if scene in stale:
                missing.append(path)
            if rows := int(read_sidecar(path).get("unresolved", 0)):
                part = share(rows, run.plans[name][scene].rows, "row")
                unresolved.append(f"  {scene}: {part} unresolved; `status` gives the reason")
        failed = [part for part, paths in wanted.items() if paths & set(missing)]
        made = [
            part for part, paths in wanted.items() if paths & set(planned) and part not in failed
        ]
        kept = [part for part in wanted if part not in (*made, *failed)]
        texts = [f"made {_listed(made)}"] if made else []
        texts += [f"not made: {_listed(failed)}"] if failed else []
        texts += [f"up to date: {_listed(kept)}" if texts else "up to date"] if kept else []
        location = run.report(name) if "report" in wanted else f"{run.results}/{name}/"
        lines.append(f"{name}: {'; '.join(texts)} ({location})")
        lines += unresolved
        if gone := scenes_left_over(run, name):
            left = f"results of {_listed(gone)}"
            lines.append(
                f"  kept, though no longer in the study: {left}; delete them if not needed"
            )
    missing = list(dict.fromkeys(missing))
    if missing:
        lines.append(
            "some requested files are missing, or were made from another study or by other code:"
        )
        lines += [*(f"  {path}" for path in missing[:MAX_LISTED]), HOW_TO_RESUME]
    return Summary(lines, missing)


def scenes_left_over(run: Run, name: str) -> list[str]:
    """Return the scenes whose datasets are in the folder of a study that no longer has them."""
    files = sorted(Path(run.results, name).glob("[!.]*.nc"))
    left = [path for path in files if path.stem not in run.studies[name].scenes]
    return [path.stem for path in left if "fingerprint" in _said(path)]


def _said(path: Path) -> dict[str, str]:
    """Return the fingerprint of a dataset as a mapping; empty without one."""
    with suppress(StoreError):
        return selected_attributes(path, ["fingerprint"])
    return {}


def causes(logs: Iterable[str]) -> list[str]:
    """Return the errors that end the logs of failed jobs, each once."""
    found: dict[str, None] = {}
    for path in logs:
        with suppress(OSError):
            text = Path(path).read_text(encoding="utf-8", errors="replace")
            _, begin, error = f"\n{text}".rpartition(f"\n{ERROR}")
            found |= {f"{ERROR}{error.strip()}": None} if begin else {}
    return list(found)


def file_times(paths: Iterable[str]) -> dict[str, int]:
    """Return the modification times (ns) of files, 0 for a file that does not exist."""
    return {path: Path(path).stat().st_mtime_ns if Path(path).exists() else 0 for path in paths}


def _parts(run: Run, name: str) -> dict[str, set[str]]:
    """Return the files of a study by the names that the summary prints: each scene, figures, report."""
    scenes = {scene: {f"{run.results}/{name}/{scene}.nc"} for scene in run.studies[name].scenes}
    figures = {*run.figures(name, "svg"), *run.figures(name, "pdf")}
    return {**scenes, "figures": figures, "report": {run.report(name)}}


def _listed(parts: list[str]) -> str:
    """Return the names as a list; many scenes are given by their number."""
    scenes = [part for part in parts if part not in ("figures", "report")]
    others = [part for part in parts if part not in scenes]
    if len(scenes) > MAX_SCENES_LISTED:
        scenes = [f"{len(scenes)} scenes"]
    return ", ".join([*scenes, *others])
