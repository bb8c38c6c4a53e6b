"""Price list of effects and outputs: bars from 1, in words, with impacts and bytes beside."""

from __future__ import annotations

import math
from typing import Any

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibropipe.figures.canvas import BODY, SMALL, WHITE_GROUND, axes, new_canvas, ticks
from vibropipe.figures.palette import BAND, GREY, HAIRLINE, INK, METHODS, SUPPORT_COLOURS
from vibropipe.figures.text import format_number, sentences
from vibropipe.scenes.effects.report import LEAST, Price, base_times, groups, prices, title_of
from vibropipe.scenes.kind import Picture

ROW_CM = 0.29
MARGIN_CM = 0.65
LEFT_CM, WIDTH_CM = 6.2, 7.7  # of the axes; words stand left of them, columns right
DEARER, CHEAPER = SUPPORT_COLOURS[1], METHODS["newmark"].colour
COLUMNS = (("impacts", 8.5), ("bytes", 9.65))  # right edges, in cm of the axes
ROW = (0.1 - LEFT_CM) / WIDTH_CM, 9.7 / WIDTH_CM  # ends of a row, in widths of the axes
STRIPE = "#F4F4F4"  # of every second row, to be followed from its words to its numbers


def draw_effects(dataset: xr.Dataset) -> Figure:
    """Draw the price list: a bar for each entry on a logarithmic scale, by groups."""
    found = prices(dataset)
    by_group = groups(found)
    rows = sum(len(entries) + 1.4 for entries in by_group.values()) + 0.4
    figure = new_canvas(rows * ROW_CM + MARGIN_CM)
    ax = axes(figure, LEFT_CM, 0.1, WIDTH_CM, rows * ROW_CM)
    drawn = [price for entries in by_group.values() for price in entries]
    scale(ax, drawn, rows)
    times, y, written = base_times(dataset), 0.45, ""
    for group, entries in by_group.items():
        unit = unit_text(*times[group])
        write_group(ax, y, group, unit if unit != written else "")
        written = unit
        y += 1.0
        for number, price in enumerate(entries):
            draw_price(ax, y, price, has_stripe=number % 2 == 0)
            y += 1.0
        y += 0.4
    for title, right in COLUMNS:
        at: dict[str, Any] = {"transform": ax.transAxes, "ha": "right", "va": "baseline"}
        ax.text(
            right / WIDTH_CM, 1.0 + 0.12 / (rows * ROW_CM), title, fontsize=SMALL, color=GREY, **at
        )
    return figure


def scale(ax: Axes, drawn: list[Price], rows: float) -> None:
    """Set the logarithmic scale of the ratios, with room for the words beside the longest bars."""
    low = min([p.ratio for p in drawn] + [0.5])
    high = max([p.ratio for p in drawn] + [2.0])
    room = (high / low) ** 0.28
    ax.set(xscale="log", xlim=(low / room, high * room), ylim=(rows, 0.0))
    ax.spines[["left", "bottom"]].set_visible(False)
    ax.xaxis.tick_top()
    first, last = math.ceil(math.log10(low / room)), math.floor(math.log10(high * room))
    powers = range(first, last + 1)
    words = ["1" if n == 0 else f"{10**n:,}" if n > 0 else f"1/{10**-n:,}" for n in powers]
    ticks(ax, "x", [10.0**n for n in powers], words)
    ax.set_yticks([])
    ax.tick_params(axis="x", which="both", length=0, labeltop=True)
    ax.tick_params(axis="x", which="minor", labeltop=False)
    for n in powers:
        ax.axvline(10.0**n, color=BAND if n else INK, lw=0.5 if n else 0.6, zorder=0 if n else 5)


def unit_text(time: float, unit: str) -> str:
    """Write the time (ns) that a ratio of 1 stands for."""
    size = f"{format_number(float(f'{time / 1e3:.2g}'))} µs" if time >= 100 else f"{time:.2g} ns"
    return f"1 = {size} a {unit}"


def write_group(ax: Axes, y: float, group: str, unit: str) -> None:
    """Write the title of a group over a line, and what a ratio of 1 stands for where the group before has another."""
    beside: dict[str, Any] = {"transform": ax.get_yaxis_transform(), "va": "center"}
    ax.text(ROW[0], y, group, weight="bold", fontsize=BODY, zorder=7,
            bbox={**WHITE_GROUND, "boxstyle": "square,pad=0.1"}, **beside)  # fmt: skip
    if unit:
        ax.text(1.15, y, unit, va="center", fontsize=SMALL, color=GREY, zorder=6,
                bbox={**WHITE_GROUND, "boxstyle": "square,pad=0.15"})  # fmt: skip
    ax.plot(ROW, [y + 0.5] * 2, color=HAIRLINE, lw=0.5, transform=ax.get_yaxis_transform(),
            clip_on=False, zorder=1)  # fmt: skip


def draw_price(ax: Axes, y: float, price: Price, has_stripe: bool) -> None:
    """Draw the bar of an entry with its quartiles, what it costs in words, and its impacts and bytes."""
    beside: dict[str, Any] = {"transform": ax.get_yaxis_transform(), "va": "center"}
    if has_stripe:
        ax.fill_between(ROW, y - 0.5, y + 0.5, color=STRIPE, lw=0, zorder=-1, clip_on=False,
                        transform=ax.get_yaxis_transform())  # fmt: skip
    ax.text(-0.02, y, price.label, ha="right", fontsize=BODY, **beside)
    for (_title, right), value in zip(COLUMNS, (price.impacts, price.bytes), strict=True):
        text = f"{value:,.0f}" if value >= 100 else format_number(value, 2)
        ax.text(right / WIDTH_CM, y, text, ha="right", color=GREY, fontsize=BODY, **beside)
    wide = ax.get_xlim()[1] / ax.get_xlim()[0]
    gap = wide**0.012
    if price.is_nothing:
        ax.plot([1, 1], [y - 0.31, y + 0.31], color=GREY, lw=2.4, solid_capstyle="butt", zorder=6)
        ax.text(gap, y, price.text, va="center", color=GREY, fontsize=BODY)
        return
    colour = DEARER if price.ratio > 1.0 else CHEAPER
    ax.barh(y, price.ratio - 1.0, left=1.0, height=0.62, color=colour, lw=0, zorder=2)
    ax.plot([price.low, price.high], [y, y], color=INK, lw=0.6, zorder=4)
    is_dear = price.ratio > 1.0
    at = max(price.ratio, price.high) * gap if is_dear else min(price.ratio, price.low) / gap
    ha = "left" if is_dear else "right"
    ax.text(at, y, price.text, ha=ha, va="center", weight="bold", fontsize=BODY)


def describe_effects(dataset: xr.Dataset) -> str:
    """Return the caption: what the bars are relative to, and what counts as nothing."""
    found = prices(dataset)
    references = [price.label for price in found if price.is_reference]
    limit = math.ceil(100 * max([LEAST, *(price.limit for price in found)]) - 1e-9)
    return sentences(
        f"Time of each entry over that of {' and of '.join(references)}: medians, and quartiles as lines"
        if references
        else "Time of each entry",
        f"“nothing”: within {100 * LEAST:.0f} % and the scatter of repeated timings, together at most {limit} %"
        if any(price.is_nothing and not price.is_reference for price in found)
        else "",
        ""
        if all(price.is_same_motion for price in found)
        else "Where the number of impacts differs, the motion is another one",
        "Impacts: per forcing period; bytes: stored for a period, or for a row, before compression",
    )


PICTURES = (Picture("costs", draw_effects, describe_effects, titled=title_of),)
