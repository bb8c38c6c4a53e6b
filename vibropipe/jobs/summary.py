"""What a run made, study by study, and whether that is all it should have made."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

from vibropipe.jobs.run import Run
from vibropipe.store import read_sidecar
from vibropipe.words.wording import share

HOW_TO_RESUME = (
    "The run is incomplete; see the error above and logs/. Fix the cause and run the same command again: completed\n"
    "files are kept. If snakemake was killed and reports a locked folder, run `snakemake --unlock` first."
)
MOST_LISTED = 20


@dataclass(frozen=True)
class Summary:
    """What is printed at the end of a run, and what is missing (nothing if all was made)."""

    lines: list[str]
    missing: list[str]


def summarise(run: Run, wanted: Collection[str], planned: Mapping[str, int]) -> Summary:
    """Return what became of the files of a run.

    Parameters
    ----------
    run : Run
        The studies.
    wanted : collection of str
        All files that were asked for, with what they are made of.
    planned : mapping of str to int
        The files that had to be made, each with the time (ns) of the one that was there before, 0 if there was none.
    """
    lines: list[str] = []
    missing = [path for path in sorted(wanted) if not Path(path).is_file()]
    now = file_times(planned)
    missing += [path for path in planned if now[path] in (0, planned[path])]
    for name, study in run.studies.items():
        parts = _parts(run, name)
        asked = {part: paths & set(wanted) for part, paths in parts.items() if paths & set(wanted)}
        if not asked:
            continue
        scenes = [scene for scene in study.scenes if scene in asked]
        unresolved = []
        for scene in scenes:
            path = f"{run.results}/{name}/{scene}.nc"
            told, job = read_sidecar(path), SimpleNamespace(study=name, scene=scene)
            if any(told.get(key) != getattr(run, key)(job) for key in ("fingerprint", "code")):
                missing.append(path)  # made of another text of the study, or by other code
            if rows := int(told.get("unresolved", 0)):
                part = share(rows, run.plans[name][scene].rows, "row")
                unresolved.append(f"  {scene}: {part} unresolved; `status` says why")
        failed = [part for part, paths in asked.items() if paths & set(missing)]
        made = [
            part for part, paths in asked.items() if paths & set(planned) and part not in failed
        ]
        kept = [part for part in asked if part not in (*made, *failed)]
        texts = [f"made {_listed(made)}"] if made else []
        texts += [f"not made: {_listed(failed)}"] if failed else []
        texts += [f"up to date: {_listed(kept)}" if texts else "up to date"] if kept else []
        shown = run.report(name) if "report" in asked else f"{run.results}/{name}/"
        lines.append(f"{name}: {'; '.join(texts)} ({shown})")
        lines += unresolved
    missing = list(dict.fromkeys(missing))
    if missing:
        lines.append("less was made than was asked for: missing or made of something else:")
        lines += [*(f"  {path}" for path in missing[:MOST_LISTED]), HOW_TO_RESUME]
    return Summary(lines, missing)


def file_times(paths: Iterable[str]) -> dict[str, int]:
    """Return when files were last changed (ns), 0 where there is none."""
    return {path: Path(path).stat().st_mtime_ns if Path(path).exists() else 0 for path in paths}


def _parts(run: Run, name: str) -> dict[str, set[str]]:
    """Return the files of a study by what a reader calls them: each scene, the figures, the report."""
    scenes = {scene: {f"{run.results}/{name}/{scene}.nc"} for scene in run.studies[name].scenes}
    figures = {*run.figures(name, "svg"), *run.figures(name, "pdf")}
    return {**scenes, "figures": figures, "report": {run.report(name)}}


def _listed(parts: list[str]) -> str:
    """Return names in a row; of many scenes their number."""
    scenes = [part for part in parts if part not in ("figures", "report")]
    rest = [part for part in parts if part not in scenes]
    if len(scenes) > 4:
        scenes = [f"{len(scenes)} scenes"]
    return ", ".join([*scenes, *rest])
