"""Plans and motions as tables for a terminal."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from vibropipe.jobs.plan import ScenePlan, plan_scene
from vibropipe.physics.effects import NAMES
from vibropipe.words.status import Status
from vibropipe.words.vocabulary import PARAMETERS
from vibropipe.words.wording import count

if TYPE_CHECKING:
    import xarray as xr

    from vibropipe.scenes.costs import Estimate
    from vibropipe.study import Study

MOST_LINES = 60


def plan_text(study: Study, found: Mapping[str, Estimate] | None = None) -> str:
    """Return the plan of a study as a table for people.

    With what a calibration has `found` by scene: the method chosen, the time expected on this machine
    and the size on disk; without it, rough ones that are the same everywhere.
    """
    plans = [plan_scene(scene) for scene in study.scenes.values()]
    known = found or {}
    work, size = ("expected", "on disk") if found else ("work", "size of data")
    head = ("scene", "kind", "size", "method", "effects", "outputs", "jobs", work, size)
    body = [
        (
            plan.name,
            plan.kind,
            plan.size,
            known[plan.name].method if found else plan.method,
            effects_text(plan.effects),
            " ".join(plan.outputs),
            str(plan.shards + (plan.shards > 1)),
            seconds_text(work_of(plan, found)),
            bytes_text(known[plan.name].bytes if found else plan.bytes),
        )
        for plan in plans
    ]
    seconds = sum(work_of(plan, found) for plan in plans)
    stored = sum(known[plan.name].bytes if found else plan.bytes for plan in plans)
    rows = f"{count(len(plans), 'scene')}, {count(sum(plan.rows for plan in plans), 'row')},"
    if found:
        cores = os.cpu_count() or 1
        longest = max(work_of(plan, found) / plan.shards for plan in plans)
        total = (
            f"{rows} expected on this machine: {seconds_text(seconds)} of one core,"
            f" {seconds_text(max(longest, seconds / cores))} on its {cores}, {bytes_text(stored)} on disk"
        )
    else:
        total = (
            f"{rows} roughly {seconds_text(seconds)} of work on one core,"
            f" {bytes_text(stored)} before compression"
        )
    return "\n".join([f"{study.name}: {study.title}", *columns([head, *body]), total])


def work_of(plan: ScenePlan, found: Mapping[str, Estimate] | None) -> float:
    """Return the seconds of one core that a scene takes, kernels loaded by each of its jobs."""
    if not found:
        return plan.seconds
    return found[plan.name].core_seconds + plan.shards * found[plan.name].load_seconds


def columns(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return rows of text as lines with aligned columns."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def effects_text(effects: Sequence[str]) -> str:
    """Return the effects of a scene by name; all of them, or none, in a word."""
    if set(effects) == set(NAMES):
        return "all"
    return " ".join(effects) if effects else "none"


def seconds_text(seconds: float) -> str:
    """Return a duration with a unit that suits it."""
    if seconds < 1:
        return "< 1 s"
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{seconds:.0f} s"


def bytes_text(count: float) -> str:
    """Return a number of bytes with a unit that suits it."""
    for unit, size in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if count >= size:
            return f"{count / size:.1f} {unit}"
    return f"{count:.0f} B"


def motion_text(motion: xr.Dataset, most: int = MOST_LINES) -> str:
    """Return the impacts, grazings and rests of `vp.simulate` in order of time, and the end.

    Of more than `most` events the first and the last ones are shown.
    """
    head = ("tau", "event", "support", "velocity before", "after")
    body = [event for _, event in sorted(events(motion), key=lambda item: item[0])]
    parameters = "  ".join(f"{name} = {float(motion[name]):g}" for name in PARAMETERS)
    end = (
        f"end: displacement {float(motion['displacement_end']):.12g},"
        f" velocity {float(motion['velocity_end']):.12g}"
    )
    status = Status(int(motion["status"]))
    lines = [parameters, *_chosen(motion), *_shortened(columns([head, *body]), most), end]
    return "\n".join(lines if status == Status.OK else [*lines, status.remedy])


def _chosen(motion: xr.Dataset) -> list[str]:
    """Return the method that was chosen to reach an accuracy, if one was asked."""
    told = motion.attrs
    if "accuracy_asked" not in told:
        return []
    steps = f", {told['steps_per_period']} steps per period" if "steps_per_period" in told else ""
    reached = f"error {told['accuracy_reached']:.1e}, asked {told['accuracy_asked']:.1e}"
    return [f"{told['method']}{steps}: {reached}"]


def events(motion: xr.Dataset) -> list[tuple[float, tuple[str, ...]]]:
    """Return (tau, row of the table) of each impact, grazing, rest and release, by kind."""
    found: list[tuple[float, tuple[str, ...]]] = [
        (tau, (f"{tau:.12g}", "impact", str(support), f"{before:.9g}", f"{after:.9g}"))
        for tau, support, before, after in _together(
            motion, "impact_tau", "impact_support", "impact_velocity", "impact_velocity_after"
        )
    ]
    for tau, support in _together(motion, "grazing_tau", "grazing_support"):
        found.append((tau, (f"{tau:.12g}", "grazing", str(support), "0", "0")))
    for start, end, support in _together(motion, "rest_start", "rest_end", "rest_support"):
        found.append((start, (f"{start:.12g}", "rest", str(support), "", "")))
        if end != float("inf"):
            found.append((end, (f"{end:.12g}", "release", str(support), "", "")))
    return found


def _together(motion: xr.Dataset, *names: str) -> zip[tuple[float, ...]]:
    return zip(*(motion[name].values.tolist() for name in names), strict=True)


def _shortened(lines: list[str], most: int) -> list[str]:
    """Leave out the middle of a long table; its first line is the head."""
    left_out = len(lines) - 1 - most
    if left_out <= 0:
        return lines
    half = most // 2
    return [*lines[: 1 + half], f"... {left_out} more ...", *lines[len(lines) - (most - half) :]]
