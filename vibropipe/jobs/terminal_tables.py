"""Plans and motions as tables for a terminal."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from vibropipe.jobs.drawing import figures_of
from vibropipe.jobs.plan import ScenePlan, plan_scene
from vibropipe.scenes.costs import OF_PIECES
from vibropipe.words.parameters import COMMON_EFFECTS, PARAMETERS
from vibropipe.words.status import Status
from vibropipe.words.wording import aligned, count, method_text, series

if TYPE_CHECKING:
    import xarray as xr

    from vibropipe.jobs.plan import Estimate, Estimates
    from vibropipe.study import Study

# Events of a motion that are printed; longer tables are shortened in the middle.
MAX_EVENTS = 60
# Rough seconds of a run beside the work of its scenes: to begin, for each figure and for the report; and once to
# compile the kernels of a kind of scene, and those of each further kind, without effects of pieces and with them.
START_SECONDS, FIGURE_SECONDS, REPORT_SECONDS = 4.0, 1.0, 1.5
COMPILE_SECONDS, COMPILE_SECONDS_FURTHER = {False: 30.0, True: 37.0}, {False: 8.0, True: 14.0}
# The most that kernels of rests take beside these, where none of pieces is compiled yet.
REST_SECONDS = 26.0


def plan_text(study: Study, estimates: Estimates | None = None) -> str:
    """Return the plan of a study as a table.

    estimates : estimates for this machine. Without them, the table holds approximate times and sizes that are the same
        on every machine
    """
    plans = [plan_scene(scene) for scene in study.scenes.values()]
    found: Mapping[str, Estimate | ScenePlan]
    found = estimates.by_scene if estimates else {plan.name: plan for plan in plans}
    work = {name: each.seconds for name, each in found.items()}
    heads = ("time", "on disk") if estimates else ("work", "size of data")
    body = [
        (
            plan.name,
            plan.kind,
            plan.size,
            plan.method,
            effects_text(plan.effects),
            " ".join(plan.outputs),
            str(plan.shards + (plan.shards > 1)),
            seconds_text(work[plan.name]),
            bytes_text(found[plan.name].bytes),
        )
        for plan in plans
    ]
    head = ("scene", "kind", "size", "method", "effects", "outputs", "jobs", *heads)
    seconds = sum(work.values())
    stored = bytes_text(sum(each.bytes for each in found.values()))
    total = f"{count(len(plans), 'scene')}, {count(sum(plan.rows for plan in plans), 'row')}, "
    if estimates:
        cores = os.cpu_count() or 1
        figures = len(figures_of(study))
        alone, shared = (
            seconds_text(run_seconds(plans, work, figures, estimates.uncompiled, n))
            for n in (1, cores)
        )
        total += (
            f"estimated on this machine, with figures and report: {alone} on one core,"
            f" {shared} on {count(cores, 'core')}, {stored} on disk"
        )
        total += unsure_text(estimates)
    else:
        total += f"roughly {seconds_text(seconds)} of work on one core, {stored} before compression"
    odd = {name: scene.warning() for name, scene in study.scenes.items()}
    warned = [f"warning: {name}: {text}" for name, text in odd.items() if text]
    return "\n".join([f"{study.name}: {study.title}", *aligned([head, *body]), total, *warned])


def unsure_text(estimates: Estimates) -> str:
    """Write what estimates include or leave open, a line for each."""
    lines = {
        "This includes compiling kernels for {}, once for this version.": estimates.uncompiled,
        "The time of {} is rough: no such scene was solved on this machine yet.": estimates.rough,
        "The time of {} is that of a usual scene: it depends on what is found.": estimates.searched,
        "If a motion of {} rests on a support, compiling kernels for that takes up to "
        f"{seconds_text(REST_SECONDS)} more, once.": estimates.at_rests,
    }
    return "".join("\n" + line.format(series(names)) for line, names in lines.items() if names)


def run_seconds(
    plans: Sequence[ScenePlan],
    work: Mapping[str, float],
    figures: int,
    uncompiled: Sequence[str],
    cores: int,
) -> float:
    """Return the estimated seconds from the command to the report of a study.

    work : seconds on one core by scene
    uncompiled : scenes whose kernels have to be compiled first, kind by kind
    """
    longest = max(
        work[plan.name] / (min(cores, plan.shards) if not plan.is_parallel else cores)
        for plan in plans
    )
    solving = max(longest, sum(work.values()) / cores)
    compiling = compile_seconds([plan for plan in plans if plan.name in uncompiled], cores)
    return START_SECONDS + compiling + solving + FIGURE_SECONDS * figures / cores + REPORT_SECONDS


def compile_seconds(plans: Sequence[ScenePlan], cores: int) -> float:
    """Return the estimated seconds in which the kernels of some scenes are compiled, several kinds at a time."""
    kernels = {(plan.kind, bool({*OF_PIECES} & {*plan.effects})) for plan in plans}
    if not kernels:
        return 0.0
    first, *further = sorted((of_pieces for _kind, of_pieces in kernels), reverse=True)
    return COMPILE_SECONDS[first] + sum(COMPILE_SECONDS_FURTHER[each] for each in further[::cores])


def effects_text(effects: Sequence[str]) -> str:
    """Return the names of the effects of a scene; `all` or `none` for all or none of them."""
    if set(effects) == set(COMMON_EFFECTS):
        return "all"
    return " ".join(effects) if effects else "none"


def seconds_text(seconds: float) -> str:
    """Return a duration with a suitable unit."""
    if seconds < 1:
        return "< 1 s"
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{seconds:.0f} s"


def bytes_text(size: float) -> str:
    """Return a number of bytes with a suitable unit."""
    for unit, n_bytes in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if size >= n_bytes:
            return f"{size / n_bytes:.1f} {unit}"
    return f"{size:.0f} B"


def motion_text(motion: xr.Dataset) -> str:
    """Return a motion as a table: parameters, impacts, grazings and rests in order of time, end state.

    Of more than MAX_EVENTS events, only the first and the last ones are shown.
    """
    head = ("tau", "event", "support", "velocity before", "after")
    body = [event for _, event in sorted(events(motion), key=lambda item: item[0])]
    parameters = "  ".join(
        f"{name} = {entry.range.words[int(motion[name])] if entry.range.words else f'{float(motion[name]):g}'}"
        for name, entry in PARAMETERS.items()
        if name in motion
    )
    # -0.0 + 0.0 is 0.0
    x, v = (float(motion[f"{name}_end"]) + 0.0 for name in ("displacement", "velocity"))
    end = f"end: displacement {x:.12g}, velocity {v:.12g}"
    status = Status(int(motion["status"]))
    lines = [parameters, *_accuracy_text(motion), *_shortened(aligned([head, *body])), end]
    return "\n".join(lines if status == Status.OK else [*lines, status.remedy])


def _accuracy_text(motion: xr.Dataset) -> list[str]:
    """Return a line with the method chosen and the error reached, if an accuracy was requested."""
    attrs = motion.attrs
    if "accuracy_asked" not in attrs:
        return []
    error = f"error {attrs['accuracy_reached']:.1e} (requested {attrs['accuracy_asked']:.1e})"
    return [f"{method_text(attrs['method'], attrs.get('steps_per_period'))}: {error}"]


def events(motion: xr.Dataset) -> list[tuple[float, tuple[str, ...]]]:
    """Return tau and the row of the table of each impact, grazing, rest and release, ordered by these kinds."""

    def each(*names: str) -> Iterator[tuple[float, ...]]:
        return zip(*(motion[name].values.tolist() for name in names), strict=True)

    impacts = ("impact_tau", "impact_support", "impact_velocity", "impact_velocity_after")
    rows: list[tuple[float, str, float, str, str]] = [
        (tau, "impact", support, f"{before:.9g}", f"{after:.9g}")
        for tau, support, before, after in each(*impacts)
    ]
    for tau, support in each("grazing_tau", "grazing_support"):
        rows.append((tau, "grazing", support, "0", "0"))
    for start, end, support in each("rest_start", "rest_end", "rest_support"):
        rows.append((start, "rest", support, "", ""))
        if end != float("inf"):
            rows.append((end, "release", support, "", ""))
    return [
        (tau, (f"{tau:.12g}", event, str(support), *velocities))
        for tau, event, support, *velocities in rows
    ]


def _shortened(lines: list[str]) -> list[str]:
    """Return a table without its middle rows if it has more than MAX_EVENTS; its first line is the head."""
    left_out = len(lines) - 1 - MAX_EVENTS
    if left_out <= 0:
        return lines
    half = MAX_EVENTS // 2
    return [*lines[: 1 + half], f"... {left_out} more ...", *lines[-half:]]
