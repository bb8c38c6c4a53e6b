"""Plans and motions as tables for a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from vibropipe.plan import plan_scene
from vibropipe.status import Status
from vibropipe.vocabulary import PARAMETERS

if TYPE_CHECKING:
    import xarray as xr

    from vibropipe.study import Study

MOST_LINES = 60


def plan_text(study: Study) -> str:
    """Return the plan of a study as a table for people."""
    plans = [plan_scene(scene) for scene in study.scenes.values()]
    head = ("scene", "kind", "size", "method", "outputs", "jobs", "work", "size of data")
    body = [
        (
            plan.name,
            plan.kind,
            plan.size,
            plan.method,
            " ".join(plan.outputs),
            str(plan.shards + (plan.shards > 1)),
            seconds_text(plan.seconds),
            bytes_text(plan.bytes),
        )
        for plan in plans
    ]
    total = (
        f"{len(plans)} scenes, {sum(plan.rows for plan in plans)} rows,"
        f" roughly {seconds_text(sum(plan.seconds for plan in plans))} of work on one core,"
        f" {bytes_text(sum(plan.bytes for plan in plans))} before compression"
    )
    return "\n".join([f"{study.name}: {study.title}", *columns([head, *body]), total])


def columns(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return rows of text as lines with aligned columns."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


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
