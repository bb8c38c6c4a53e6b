"""The motions of basins beside or below their map: displacement between the supports over some periods."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibropipe.figures.canvas import (
    CM_PER_INCH,
    LETTER,
    SMALL,
    WIDE,
    axes,
    raised,
    size_of,
    support_bands,
)
from vibropipe.figures.palette import GREY, INK
from vibropipe.figures.text import format_number, in_brackets, is_forced
from vibropipe.scenes.basins.attractors import attractor_words, images_of, letters_of, ordered
from vibropipe.scenes.basins.text import percent
from vibropipe.solve.rebuild import Motion, motion_of
from vibropipe.words.parameters import PARAMETERS, PHYSICAL

MAX_MOTIONS = 4  # that stand beside the map
LEFT, TALL_CM = 1.25, 7.2  # cm: left of a row of motions, height of a column of them
# Left of the motions, their width, most height of one.
BESIDE, MOTION_CM, SLOT_CM = 11.95, 3.85, 3.1
ACROSS_CM, ACROSS_GAP = 1.9, 1.1  # motions in a row: height, and gap between them
FLAT_CM = 1.1  # height of a panel with two ticks
LINE_CM, LETTERS, LEAST_PERIODS, MOST_PERIODS = 0.34, 36, 2, 6
DISC = {"boxstyle": "circle,pad=0.2", "facecolor": "white", "edgecolor": INK, "linewidth": 0.5}
LETTER_STYLE: dict[str, Any] = {
    "ha": "center",
    "va": "center",
    "weight": "bold",
    "fontsize": LETTER,
    "bbox": DISC,
    "zorder": 7,
}


def draw_motions(figure: Figure, dataset: xr.Dataset, bottom: float, across: bool = False) -> None:
    """Draw the displacement of the motions of the largest basins: below each other, or in a row `across` a figure."""
    drawn = [(index, row_motion(dataset, index)) for index in ordered(dataset)[:MAX_MOTIONS]]
    if not drawn:
        return
    motions = [motion for _, motion in drawn if motion is not None]
    longest = max((int(motion.row["period_multiple"]) for motion in motions), default=1)
    periods, limits = min(max(longest, LEAST_PERIODS), MOST_PERIODS), limits_of(motions)
    words = [
        textwrap.wrap(text, LETTERS)[:2] for text in motion_texts(dataset, [n for n, _ in drawn])
    ]
    text_cm = 0.3 + LINE_CM * (1 + max(map(len, words)))
    slot = min(SLOT_CM, TALL_CM / len(drawn))
    pitch = (WIDE - LEFT) / max(2, len(drawn))
    for position, (index, motion) in enumerate(drawn):
        place = (BESIDE, bottom + TALL_CM - (position + 1) * slot, MOTION_CM, slot - text_cm)
        if across:
            place = (LEFT + position * pitch, bottom, pitch - ACROSS_GAP, ACROSS_CM)
        ax = axes(figure, *place)
        if motion is not None:
            draw_displacement(ax, motion, periods)
            ax.set(xlim=(0, periods), ylim=limits)
            support_bands(ax, motion.walls[2], motion.walls[1])
        write_heading(ax, dataset, index, words[position])
        is_last = across or position == len(drawn) - 1
        ax.tick_params(labelsize=SMALL, labelbottom=is_last)
        if place[3] > FLAT_CM or motion is None:
            ax.locator_params(axis="y", nbins=3)
        else:  # two numbers have room: the supports
            ends = [motion.walls[2], motion.walls[1]]
            ax.set_yticks(ends, [format_number(end, 2) for end in ends])
        ax.locator_params(axis="x", integer=True)
        if is_last:
            ax.set_xlabel(f"time, in {'forcing ' if is_forced(dataset) else ''}periods")
    high = ACROSS_CM if across else slot * len(drawn)
    middle = bottom + (0.0 if across else TALL_CM - slot * len(drawn)) + high / 2
    left = 0.15 if across else BESIDE - 1.28
    text = in_brackets("displacement", dataset["displacement_strobe"])
    at = (middle + raised(figure)) / (figure.get_figheight() * CM_PER_INCH)
    figure.text(left / WIDE, at, text, rotation=90,
                ha="center", va="center")  # fmt: skip


def write_heading(ax: Axes, dataset: xr.Dataset, index: int, words: Sequence[str]) -> None:
    """Write letter, share and words of a motion above its panel."""
    wide, high = size_of(ax)
    heading = f"{percent(float(dataset['basin_share'][index]))} of the starts"
    for line, text in enumerate(reversed([heading, *words])):
        weight = "bold" if text is heading else "normal"
        y = 1 + (0.2 + line * LINE_CM) / high
        ax.text(
            -0.2 / wide, y, text, transform=ax.transAxes, fontsize=SMALL, weight=weight, va="center"
        )
    top = 1 + (0.2 + LINE_CM * len(words)) / high
    ax.text(-0.65 / wide, top, letters_of(dataset)[index], transform=ax.transAxes, **LETTER_STYLE)


def motion_texts(dataset: xr.Dataset, indices: Sequence[int]) -> list[str]:
    """Return each motion in words: of the second of a pair of mirror images, of which it is one."""
    letters, texts = letters_of(dataset), []
    for n, index in enumerate(indices):
        images = [letters[each] for each in images_of(dataset, index) if each in indices[:n]]
        texts.append(f"mirror image of {images[0]}" if images else attractor_words(dataset, index))
    return texts


def draw_displacement(ax: Axes, motion: Motion, periods: int) -> None:
    """Draw the displacement of a motion over some periods; of one that does not repeat later ones too, in grey."""
    t, x = displacement_over(motion, periods)
    if motion.is_orbit:
        ax.plot(t, x, color=INK, linewidth=0.9)
        return
    for first in range(0, MOST_PERIODS, periods):
        own = (t >= first) & (t <= first + periods)
        style: dict[str, Any] = {"color": INK, "linewidth": 0.9, "zorder": 3}
        later: dict[str, Any] = {"color": GREY, "linewidth": 0.5}
        ax.plot(t[own] - first, x[own], **(later if first else style))


def row_motion(dataset: xr.Dataset, index: int) -> Motion | None:
    """Return the motion of an attractor, marched on from its section."""
    row = dataset.sel(attractor_id=index)
    needed = ("displacement_strobe", "velocity_strobe", "base_frequency", "period_multiple")
    names = [name for name in (*PARAMETERS, *PHYSICAL, *needed) if name in row.variables]
    return motion_of(row[names])


def limits_of(motions: Sequence[Motion]) -> tuple[float, float]:
    """Return the limits of the displacement: a little beyond the supports."""
    if not motions:
        return -1.0, 1.0
    ends = [motions[0].walls[support] for support in (2, 1)]
    seen = [motion.curves["displacement"].values for motion in motions]
    low, high = min(ends[0], *map(np.nanmin, seen)), max(ends[1], *map(np.nanmax, seen))
    return float(low - 0.15 * (high - low)), float(high + 0.15 * (high - low))


def displacement_over(motion: Motion, periods: int) -> tuple[np.ndarray, np.ndarray]:
    """Return time in forcing periods and displacement of a motion, with its impacts; an orbit is repeated."""
    plain, period = motion.plain, motion.exciter.period
    wall = np.where(plain["impact_support"].values == 1, motion.walls[1], motion.walls[2])
    hard = ~np.isin(plain["impact_support"].values, motion.soft)
    t = np.concatenate([plain["tau"].values, plain["impact_tau"].values[hard]])
    x = np.concatenate([motion.curves["displacement"].values, wall[hard]])
    order = np.argsort(t, kind="stable")
    t, x = t[order] / period, x[order]
    times = -(-periods * period // motion.length) if motion.is_orbit else 1
    shifts = np.arange(max(int(times), 1)) * motion.length / period
    return (t + shifts[:, None]).ravel(), np.tile(x, shifts.size)
