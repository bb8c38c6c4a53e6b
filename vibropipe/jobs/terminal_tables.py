"""Plans and motions as tables for a terminal."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from vibropipe.jobs.plan import plan_scene
from vibropipe.scenes.costs import Estimate
from vibropipe.words.effects import EFFECT_NAMES
from vibropipe.words.parameters import PARAMETERS
from vibropipe.words.status import Status
from vibropipe.words.wording import aligned, count

if TYPE_CHECKING:
    import xarray as xr

    from vibropipe.study import Study

MAX_LINES = 60


def plan_text(study: Study, found: Mapping[str, Estimate] | None = None) -> str:
    """Return the plan of a study as a table for people.

    Parameters
    ----------
    study : Study
        What is planned.
    found : mapping of str to Estimate, optional
        What a calibration on this machine found, by scene. Without it, rough times and sizes that are the same
        everywhere.
    """
    plans = [plan_scene(scene) for scene in study.scenes.values()]
    expected = found or {
        plan.name: Estimate(plan.seconds, 0.0, plan.bytes, parallel=False, method=plan.method)
        for plan in plans
    }
    # kernels are loaded by each job
    work = {
        plan.name: expected[plan.name].core_seconds + plan.shards * expected[plan.name].load_seconds
        for plan in plans
    }
    heads = ("expected", "on disk") if found else ("work", "size of data")
    body = [
        (
            plan.name,
            plan.kind,
            plan.size,
            expected[plan.name].method,
            effects_text(plan.effects),
            " ".join(plan.outputs),
            str(plan.shards + (plan.shards > 1)),
            seconds_text(work[plan.name]),
            bytes_text(expected[plan.name].bytes),
        )
        for plan in plans
    ]
    head = ("scene", "kind", "size", "method", "effects", "outputs", "jobs", *heads)
    seconds = sum(work.values())
    stored = bytes_text(sum(expected[plan.name].bytes for plan in plans))
    total = f"{count(len(plans), 'scene')}, {count(sum(plan.rows for plan in plans), 'row')}, "
    if found:
        cores = os.cpu_count() or 1
        longest = max(work[plan.name] / plan.shards for plan in plans)
        total += (
            f"expected on this machine: {seconds_text(seconds)} of one core,"
            f" {seconds_text(max(longest, seconds / cores))} on its {cores}, {stored} on disk"
        )
    else:
        total += f"roughly {seconds_text(seconds)} of work on one core, {stored} before compression"
    return "\n".join([f"{study.name}: {study.title}", *aligned([head, *body]), total])


def effects_text(effects: Sequence[str]) -> str:
    """Return the effects of a scene by name; all of them, or none, in a word."""
    if set(effects) == set(EFFECT_NAMES):
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


def motion_text(motion: xr.Dataset, most: int = MAX_LINES) -> str:
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
    lines = [parameters, *_chosen(motion), *_shortened(aligned([head, *body]), most), end]
    return "\n".join(lines if status == Status.OK else [*lines, status.remedy])


def _chosen(motion: xr.Dataset) -> list[str]:
    """Return the method that was chosen to reach an accuracy, if one was asked."""
    attrs = motion.attrs
    if "accuracy_asked" not in attrs:
        return []
    steps = f", {attrs['steps_per_period']} steps per period" if "steps_per_period" in attrs else ""
    reached = f"error {attrs['accuracy_reached']:.1e}, asked {attrs['accuracy_asked']:.1e}"
    return [f"{attrs['method']}{steps}: {reached}"]


def events(motion: xr.Dataset) -> list[tuple[float, tuple[str, ...]]]:
    """Return (tau, row of the table) of each impact, grazing, rest and release, by kind."""

    def each(*names: str) -> Iterator[tuple[float, ...]]:
        return zip(*(motion[name].values.tolist() for name in names), strict=True)

    impacts = ("impact_tau", "impact_support", "impact_velocity", "impact_velocity_after")
    found: list[tuple[float, str, float, str, str]] = [
        (tau, "impact", support, f"{before:.9g}", f"{after:.9g}")
        for tau, support, before, after in each(*impacts)
    ]
    for tau, support in each("grazing_tau", "grazing_support"):
        found.append((tau, "grazing", support, "0", "0"))
    for start, end, support in each("rest_start", "rest_end", "rest_support"):
        found.append((start, "rest", support, "", ""))
        if end != float("inf"):
            found.append((end, "release", support, "", ""))
    return [
        (tau, (f"{tau:.12g}", event, str(support), *velocities))
        for tau, event, support, *velocities in found
    ]


def _shortened(lines: list[str], most: int) -> list[str]:
    """Leave out the middle of a long table; its first line is the head."""
    left_out = len(lines) - 1 - most
    if left_out <= 0:
        return lines
    half = most // 2
    return [*lines[: 1 + half], f"... {left_out} more ...", *lines[len(lines) - (most - half) :]]
