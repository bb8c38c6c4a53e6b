"""Pictures of a motion, by itself or with others on common axes: over forcing periods, and the phase plane."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibropipe.figures.canvas import (
    BODY,
    CM_PER_INCH,
    SMALL,
    WIDE,
    axes,
    new_canvas,
    plain_ticks,
    ticks,
)
from vibropipe.figures.motion_words import number_word
from vibropipe.figures.palette import INK, SUPPORT_TEXT
from vibropipe.figures.phase_plane import Impacts, walls_of
from vibropipe.figures.style import ROUNDING
from vibropipe.figures.text import (
    axis_label,
    clock,
    format_number,
    is_forced,
    is_soft_without_restitution,
    scalar_parameters,
    value_text,
    width_in_digits,
    with_units,
)
from vibropipe.scenes.certificate_page import CERTIFICATE_PICTURE
from vibropipe.scenes.kind import MAX_TITLE, Picture
from vibropipe.scenes.motion.balance import ENERGY, SPECTRUM
from vibropipe.scenes.motion.captions import (
    describe_impacts,
    describe_motion,
    describe_together,
    seen_text,
)
from vibropipe.scenes.motion.curves import forcing_period
from vibropipe.scenes.motion.impacts import draw_impacts_only, is_sampled
from vibropipe.scenes.motion.keys import MotionFigure
from vibropipe.scenes.motion.panels import (
    draw_motion,
    draw_over_time,
    draw_plane,
    limits_of,
    window,
)
from vibropipe.scenes.motion.phase_plane import (
    SECTION,
    describe_portrait,
    draw_phase_portrait,
    portrait_title,
)
from vibropipe.scenes.motion.ramp_picture import RAMP_PICTURE
from vibropipe.words.parameters import or_default
from vibropipe.words.wording import capitalised, series

LEFT, RIGHT, GAP = 1.5, 0.1, 0.32  # cm
PLANE_BOTTOM, PLANE, VELOCITY_BOTTOM, PANEL = 1.1, 3.3, 5.5, 1.85  # cm
LINE = 0.4  # cm, of the texts above a column
DIGIT, BOLD_LETTER = 0.125, 0.155  # cm, of a letter of these texts
MAX_PERIODS = 4  # that are drawn of orbits


def draw_together(
    motions: Sequence[xr.Dataset], names: Sequence[str], periods: float | None = None
) -> Figure:
    """Draw motions in columns with common axes.

    motions : two to six motions with samples
    names : what stands above each
    periods : number of forcing periods to show, up to the end of the records (default: those after which all repeat,
        if there are few; else all)
    """
    width = (WIDE - LEFT - RIGHT - GAP * (len(motions) - 1)) / len(motions)
    titles = [textwrap.wrap(name, int(width / BOLD_LETTER)) for name in names]
    heads = [head_lines(data, motions, width) for data in motions]
    title_lines = max(map(len, titles))
    top = VELOCITY_BOTTOM + 2 * PANEL + GAP
    figure = new_canvas(top + LINE * (title_lines + max(map(len, heads))) + 0.2)
    limits = limits_of(motions)
    shown = periods or common_periods(motions)
    for column, dataset in enumerate(motions):
        left = LEFT + column * (width + GAP)
        view = aligned_window(dataset, shown)
        boxes = ((top - PANEL, PANEL), (VELOCITY_BOTTOM, PANEL), (PLANE_BOTTOM, PLANE))
        x, v, plane = (axes(figure, left, bottom, width, high) for bottom, high in boxes)
        for ax, name in ((x, "displacement"), (v, "velocity")):
            ax.set(xlim=view, ylim=limits[name])
            draw_over_time(ax, dataset, name, view, is_labelled=False)
            tick_periods(ax, dataset, view)
        fastest = 1.12 * limits["velocity"][1]  # with room for the numbers
        plane.set(xlim=limits["displacement"], ylim=(-fastest, fastest))
        name_velocities(plane, draw_plane(plane, dataset, view), dataset)
        if math.isfinite(mean_of(dataset)):
            x.axhline(mean_of(dataset), color=INK, linewidth=0.6, linestyle=(0, (5, 3)), zorder=1)
        for ax, name in ((x, "displacement"), (v, "velocity"), (plane, "velocity")):
            ax.set_ylabel("" if column else axis_label(dataset[name], width=16))
            plain_ticks(ax.yaxis, 4)
            ax.tick_params(labelleft=not column)
        x.tick_params(labelbottom=False)
        v.set_xlabel(
            "forcing periods" if is_forced(dataset) else axis_label(dataset[clock(dataset)])
        )
        plane.set_xlabel(axis_label(dataset["displacement"], width=int(width / DIGIT)))
        write_head(figure, left, titles[column], 0, weight="bold", fontsize=BODY)
        write_head(figure, left, heads[column], title_lines, fontsize=SMALL)
    figure.align_ylabels(figure.axes[:3])
    return figure


def head_lines(dataset: xr.Dataset, motions: Sequence[xr.Dataset], width: float) -> list[str]:
    """Return the texts below the name of a column: the parameters in which the motions differ, mean displacement."""
    own = scalar_parameters(dataset)
    every = [scalar_parameters(each) for each in motions]
    names = [
        n
        for n in own
        if any(own[n] != or_default(each, n) for each in every)
        and not is_soft_without_restitution(dataset, n)
    ]
    lines: list[str] = []
    before = ""
    for each in names:
        text = value_text(dataset[each])
        joined = ", ".join([*lines[-1:], text])
        # of both supports in one line
        if before and each[:-1] == before[:-1] and width_in_digits(joined) * DIGIT <= width:
            lines[-1] = joined
        else:
            lines.append(text)
        before = each
    if math.isfinite(mean_of(dataset)):
        mean = format_number(mean_of(dataset), 3)
        lines.append(f"mean {with_units(dataset['displacement_mean'], mean)}")
    return lines


def write_head(figure: Figure, left: float, lines: Sequence[str], first: int, **style: Any) -> None:
    """Write lines above a column, below the `first` ones."""
    high = float(figure.get_figheight()) * CM_PER_INCH
    for number, text in enumerate(lines, first):
        height = high - 0.35 - number * LINE
        figure.text(left / WIDE, height / high, text, va="baseline", **style)


def mean_of(dataset: xr.Dataset) -> float:
    """Return the mean displacement of a steady state, 0 where it is rounding; NaN if it is not known."""
    mean = float(dataset.get("displacement_mean", math.nan))
    size = float(np.abs(dataset["displacement"]).max())
    return 0.0 if abs(mean) <= ROUNDING * size else mean


def common_periods(motions: Sequence[xr.Dataset]) -> float | None:
    """Return the forcing periods after which all orbits of some motions repeat; None for whole records."""
    multiples = [int(d["period_multiple"]) if "period_multiple" in d else 0 for d in motions]
    if not all(multiples) or not all(map(is_forced, motions)):
        return None
    common = math.lcm(*multiples)
    return float(common) if common <= MAX_PERIODS else None


def aligned_window(dataset: xr.Dataset, periods: float | None) -> tuple[float, float]:
    """Return the first and last time to show, the first where the phase of the force is 0 if the record allows it."""
    first, last = window(dataset, periods)
    if periods is None or not is_forced(dataset):
        return first, last
    period = forcing_period(dataset)
    start = period * math.floor(first / period + 1e-6)
    begin = float(dataset[clock(dataset)][0])
    return (first, last) if start < begin - 1e-6 * period else (start, start + periods * period)


def tick_periods(ax: Axes, dataset: xr.Dataset, view: tuple[float, float]) -> None:
    """Count forcing periods on the axis of time from the first time shown; without a force it stays."""
    if not is_forced(dataset):
        return
    period = forcing_period(dataset)
    number = (view[1] - view[0]) / period
    step = max(1, round(number / 4))
    counts = range(0, int(number + 1e-9) + 1, step)
    ticks(ax, "x", [view[0] + n * period for n in counts], map(str, counts))


def name_velocities(ax: Axes, impacts: Impacts, dataset: xr.Dataset) -> None:
    """Write the speed of each impact in the phase plane, if there is at most one on each support."""
    for support, side in ((1, 1.0), (2, -1.0)):
        own = impacts.before[impacts.support == support]
        if own.size != 1 or (impacts.support == 3 - support).sum() > 1:
            continue
        ax.annotate(
            f"{abs(float(own[0])):#.3g}".rstrip("."), (walls_of(dataset)[support], float(own[0])),
            xytext=(-5 * side, 1.5 * side), textcoords="offset points", fontsize=BODY, weight="bold",
            color=SUPPORT_TEXT[support], ha="right" if side > 0 else "left", va="bottom" if side > 0 else "top",
        )  # fmt: skip


def keywords(options: MotionFigure | None, others: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Return the keywords of `draw_motion`."""
    options = options or MotionFigure()
    together = {name: others[name] for name in options.together}
    names = ("show", "periods", "heads")
    return {name: getattr(options, name) for name in names} | {"together": together}


def draw_panels(
    dataset: xr.Dataset,
    show: Collection[str],
    periods: float | None,
    heads: Sequence[str],
    together: Mapping[str, xr.Dataset],
) -> Figure:
    """Draw one motion, or several on common axes."""
    if not together:
        return draw_motion(dataset, show, periods)
    names = names_of(dataset, together)
    names[: len(heads)] = heads
    return draw_together([dataset, *together.values()], names, periods)


def names_of(dataset: xr.Dataset, together: Iterable[str]) -> list[str]:
    """Return the names of motions on common axes as words."""
    own = str(dataset.attrs.get("title", "motion")).rpartition(": ")[2]
    return [name.replace("_", " ") for name in (own, *together)]


def title_panels(
    dataset: xr.Dataset, heads: Sequence[str], together: Iterable[str], **others: Any
) -> str:
    """Write what is seen of a motion, or which ones are compared; where these have heads, the scene's title says it."""
    names = [*together] and names_of(dataset, together)
    if heads or not names:
        return "" if names else seen_text(dataset)
    text = f"Side by side: {series(names)}"
    return (
        text
        if len(text) <= MAX_TITLE
        else f"{capitalised(number_word(len(names)))} motions side by side"
    )


def describe_panels(
    dataset: xr.Dataset,
    show: Collection[str],
    periods: float | None,
    together: Mapping[str, xr.Dataset],
    **others: Any,
) -> str:
    """Return the caption of one motion, or of several on common axes."""
    if not together:
        return describe_motion(dataset, show, periods)
    return describe_together([dataset, *together.values()])


PICTURES = (
    RAMP_PICTURE,
    Picture("panels", draw_panels, describe_panels, is_sampled, keywords, title_panels),
    Picture("impacts", draw_impacts_only, describe_impacts, titled=seen_text),
    Picture(
        "portrait",
        lambda dataset, periods, **others: draw_phase_portrait(dataset, periods),
        lambda dataset, **others: describe_portrait(dataset),
        is_sampled,
        keywords,
        lambda dataset, **others: portrait_title(dataset),
    ),
    SECTION,
    SPECTRUM,
    ENERGY,
    CERTIFICATE_PICTURE,
)
