"""The summary of a run: files made, up to date and missing, study by study."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from vibropipe.jobs.earlier import NOT_TAKEN, TAKEN, taken_text
from vibropipe.jobs.run import Run
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


def summarise(run: Run) -> Summary:
    """Return the summary of a run: what was stale when it began (`Run.stale`) and is not now was made.

    A dataset that was made from another study or by other code counts as missing.
    """
    lines: list[str] = []
    stale, wanted = set(run.stale_now()), set(run.wanted)
    for name in run.studies:
        parts = _parts(run, name)
        failed = [part for part, paths in parts.items() if paths & wanted & stale]
        made = [p for p, paths in parts.items() if paths & run.stale and not paths & stale]
        kept = [
            part for part, paths in parts.items() if paths & wanted and part not in (*made, *failed)
        ]
        if not (made or failed or kept):
            continue
        notes = []
        for scene in [each for each in run.studies[name].scenes if each in (*made, *kept)]:
            sidecar = read_sidecar(f"{run.results}/{name}/{scene}.nc")
            all_rows = run.plans[name][scene].rows
            if scene in made and TAKEN in sidecar:
                notes.append(f"  {scene}: {taken_text(int(sidecar[TAKEN]), all_rows)}")
            elif scene in made and NOT_TAKEN in sidecar:
                notes.append(f"  {scene}: {sidecar[NOT_TAKEN]}")
            if rows := int(sidecar.get("unresolved", 0)):
                part = share(rows, all_rows, "row")
                notes.append(f"  {scene}: {part} unresolved")
        texts = [f"made {_listed(made)}"] if made else []
        texts += [f"not made: {_listed(failed)}"] if failed else []
        texts += [f"up to date: {_listed(kept)}" if texts else "up to date"] if kept else []
        has_report = "report" in (*made, *failed, *kept)
        location = run.report(name) if has_report else f"{run.results}/{name}/"
        lines.append(f"{name}: {'; '.join(texts)} ({location})")
        lines += notes
        if gone := scenes_left_over(run, name):
            left = f"results of {_listed(gone)}"
            lines.append(
                f"  kept, though no longer in the study: {left}; delete them if not needed"
            )
    missing = [path for path in run.wanted if path in stale]
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


def changed_since(time: float, pattern: str) -> list[str]:
    """Return the files of a pattern that were written since a time (s)."""
    return sorted(str(p) for p in Path().glob(pattern) if p.stat().st_mtime >= time)


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
