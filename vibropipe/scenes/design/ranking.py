"""All designs beside each other: parameters, quantities within bounds, yields, and what keeps one from being made."""

from __future__ import annotations

import re
import textwrap
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from vibropipe.figures.canvas import SMALL, WIDE, EvenTicks, axes, new_canvas, size_of
from vibropipe.figures.claims import at_least, percent
from vibropipe.figures.palette import BAND, EXACT, FAILED, GREY, INK
from vibropipe.figures.text import in_brackets, sentences, symbol_of
from vibropipe.scenes.design.data import (
    Part,
    goals,
    has_tolerances,
    has_yield,
    is_met,
    objectives,
    off_allowed,
    struck_texts,
    varied,
    wanted_parts,
    wanted_text,
)
from vibropipe.scenes.design.nominal import held_too_wide, nominal_numbers
from vibropipe.scenes.design.workshop import (
    MADE,
    SAMPLED,
    is_lost,
    kept_words,
    lost_text,
    scatter_words,
    yield_words,
    yields_differ,
)
from vibropipe.solve.rows.named import OF_LAW
from vibropipe.words.designs import DesignResult, ToleranceResult

# Centimetres: a line; what stands over it and below; columns of the number, a parameter, the yield and the verdict.
LINE, LOW_LINE, FOOT = 0.5, 0.42, 0.8
FEW = 8  # designs that stand in lines of full height
HEAD_LINE, NOTE = 0.34, 0.4
NUMBER, COLUMN, STRUCK, YIELD, VERDICT, GAP = 0.8, 1.25, 1.5, 1.7, 2.2, 0.45
ALIKE = 1e-6  # relative difference of values that no number in a report tells apart
NEAREST = 1e-4  # of the ranges: nearer changes of the law are not told apart
NONE_FOUND = 1.0  # of the ranges: the margin where no change of the law is found
LONG = 1.2  # more for impacts in several periods
MOST_PARAMETERS, MOST_PANELS, NARROWEST = 5, 3, 1.7
MOST_TIGHT = 4  # symbols that have room in a verdict
KEPT = "\u00a0"
LETTERS = 6.6  # of a head in a centimetre
MISSED = {
    DesignResult.AT_RANGE: "at its range",
    DesignResult.LAW_CHANGES: "law changes",
    DesignResult.CONFLICTING: "goals conflict",
    DesignResult.NOT_REACHED: "not reached",
}


def draw_designs(dataset: xr.Dataset) -> Figure:
    """Draw a line for each design: parameters, wanted quantities with their bounds, yield and verdict."""
    n, names = dataset.sizes["design"], varied(dataset)[:MOST_PARAMETERS]
    height = line_of(n) * n
    struck, end, right = columns(dataset)
    shown = places(dataset, struck + GAP, end)
    lines = max([len(in_width(part.label_text(dataset), width)) for part, _, width in shown] or [1])
    figure = new_canvas(HEAD_LINE * lines + NOTE + 0.15 + height + FOOT)
    text = axes(figure, 0, FOOT, WIDE, height)
    text.set(xlim=(0, WIDE), ylim=(n, 0))
    text.set_axis_off()
    for row in range(1, n):
        text.plot([0, WIDE], [row, row], color=BAND, lw=0.5, zorder=0)
    head(text, 0.0, "design", "left")
    for row in range(n):
        text.text(0.35, row + 0.5, str(row + 1), weight="bold", ha="center", va="center")
    for column, name in enumerate(names):
        x = NUMBER + COLUMN * (column + 1) - 0.1
        unit = in_brackets("", dataset[name])
        head(text, x, symbol_of(dataset[name]) + (f"\n{unit.strip()}" if unit else ""), "right")
        for row, value in enumerate(nominal_numbers(dataset, name)):
            text.text(x, row + 0.5, value, ha="right", va="center")
    head(text, struck, "impacts\nat 1 + 2", "right")
    for row, words in enumerate(struck_texts(dataset)):
        text.text(struck, row + 0.5, words, ha="right", va="center")
    if verdicts_differ(dataset):
        draw_verdicts(text, dataset, right + 0.1)
    if yields_differ(dataset):
        draw_yields(axes(figure, end + 0.25, FOOT, YIELD, height), dataset)
    for part, x, width in shown:
        draw_part(axes(figure, x, FOOT, width, height), dataset, part)
    return figure


def columns(dataset: xr.Dataset) -> tuple[float, float, float]:
    """Return where the columns of impacts and of quantities end, and where the verdicts begin."""
    texts = struck_texts(dataset)
    names = varied(dataset)[:MOST_PARAMETERS]
    struck = NUMBER + COLUMN * len(names) + STRUCK + LONG * any(" in " in text for text in texts)
    right = WIDE - VERDICT * verdicts_differ(dataset)
    return struck, right - (YIELD + GAP) * yields_differ(dataset), right


def line_of(designs: int) -> float:
    """Return the height of a line in centimetres."""
    return LINE if designs <= FEW else LOW_LINE


def places(dataset: xr.Dataset, left: float, right: float) -> list[tuple[Part, float, float]]:
    """Return the quantities that have room, what is bounded first, each with the place and width of its axes."""
    room = int((right - left) / (NARROWEST + GAP))
    parts = shown_parts(dataset)[: max(1, min(MOST_PANELS, room))]
    width = (right - left + GAP) / max(1, len(parts))
    return [(part, left + n * width, width - GAP) for n, part in enumerate(parts)]


def shown_parts(dataset: xr.Dataset) -> list[Part]:
    """Return the wanted quantities, what is bounded or least before targets, which all designs meet."""
    parts = [part for part in wanted_parts(dataset) if part.variable not in ("yield", *OF_LAW)]
    return sorted(parts, key=lambda part: np.isfinite(part.end(dataset, "target")))


def head(ax: Axes, x: float, text: str, side: str) -> None:
    """Write the head of a column of text axes."""
    y = 1 + 0.2 / size_of(ax)[1]
    ax.text(x / WIDE, y, text, transform=ax.transAxes, ha=side, va="bottom", weight="bold")


def over(ax: Axes, title: str, note: str) -> None:
    """Write the title of a panel in as many lines as it needs, and a grey note under it."""
    width, height = size_of(ax)
    style: dict[str, Any] = {"transform": ax.transAxes, "va": "bottom"}
    ax.text(0, 1 + 0.12 / height, note, fontsize=SMALL, color=GREY, **style)
    top = 1 + (0.45 if note else 0.12) / height
    ax.text(0, top, "\n".join(in_width(title, width)), weight="bold", linespacing=1.15, **style)


def in_width(title: str, width: float) -> list[str]:
    """Return the lines of a title in a width in centimetres; numbers stay with what they count."""
    kept = re.sub(r" (?=\d)", KEPT, title)
    lines = textwrap.wrap(kept, max(8, int(width * LETTERS))) or [""]
    return [line.replace(KEPT, " ") for line in lines]


def bare(ax: Axes, n: int) -> None:
    """Leave the horizontal axis only."""
    ax.set_ylim(n, 0)
    ax.set_yticks([])
    ax.patch.set_visible(False)
    ax.spines["left"].set_visible(False)


def draw_part(ax: Axes, dataset: xr.Dataset, part: Part) -> None:
    """Draw one quantity of all designs: its spread, or its value, and grey what is outside its goal."""
    values = part.of(dataset).values
    n = values.size
    bare(ax, n)
    ends, spread = limits_of(dataset, part), spread_of(dataset, part)
    known = [*values, *spread.ravel(), *ends]
    known = [value for value in known if np.isfinite(value)] or [0.0]
    low, high = min(known), max(known)
    is_met_by_all = ends[0] == ends[1] and bool(is_met(dataset).all())
    if is_met_by_all or high - low <= ALIKE * max(abs(low), abs(high)):
        low = high = 0.5 * (low + high)  # what differs is rounding
    room = 0.12 * (high - low) or 0.1 * abs(high) or 1.0
    ax.set_xlim(low - room, high + room)
    for end, beyond in zip(ends, ax.get_xlim(), strict=True):
        if np.isfinite(end):
            if ends[0] != ends[1]:
                ax.axvspan(*sorted((end, beyond)), color=BAND, lw=0, zorder=0)
            ax.axvline(end, color=INK, lw=0.8, zorder=1)
    kept = within_share(dataset, part)
    for row in range(n):
        colour = FAILED if kept[row] < MADE else EXACT
        y = row + 0.5
        if np.isfinite(spread[row]).all():
            ax.plot(spread[row], [y, y], color=colour, lw=3.2, solid_capstyle="butt")
        ax.plot(values[row], y, "D", color=colour, markersize=3.2)
    ax.xaxis.set_major_locator(MaxNLocator(3 if size_of(ax)[0] < 2.6 else 4, steps=[1, 2, 5, 10]))
    ax.xaxis.set_major_formatter(EvenTicks())
    over(ax, part.label_text(dataset), goal_text(dataset, part))


def goal_text(dataset: xr.Dataset, part: Part) -> str:
    """Write the goal of a quantity."""
    texts = [goal.text for goal in goals(dataset) if goal.words == part.words(dataset)]
    return ", ".join(f"wanted {t}" if t[0] not in "<>" else t for t in texts)


def limits_of(dataset: xr.Dataset, part: Part) -> tuple[float, float]:
    """Return the ends between which a quantity keeps its goal; both the target if it may not be off, NaN for none."""
    target = part.end(dataset, "target")
    if not np.isfinite(target):
        return part.end(dataset, "lower"), part.end(dataset, "upper")
    off = off_allowed(dataset, part)
    return target - off, target + off


def spread_of(dataset: xr.Dataset, part: Part) -> np.ndarray:
    """Return between which values (design, 2) 95 % of the sampled exciters lie; NaN if that is not known."""
    if f"{part.variable}_quantile" not in dataset:
        return np.full((dataset.sizes["design"], 2), np.nan)
    ends: np.ndarray = part.of(dataset, "_quantile").transpose("design", "quantile").values
    return ends[:, [0, -1]]


def within_share(dataset: xr.Dataset, part: Part) -> np.ndarray:
    """Return the share of sampled exciters that keep the goal of a quantity, NaN if that is not known."""
    if f"{part.variable}_yield" not in dataset:
        return np.full(dataset.sizes["design"], np.nan)
    return part.of(dataset, "_yield").values


def draw_yields(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the yields as bars with their numbers."""
    shares, lost = dataset["yield"].values, is_lost(dataset)
    bare(ax, shares.size)
    ax.set_xlim(0, 100)
    for row, share in enumerate(shares):
        ax.barh(row + 0.5, 100 * share, height=0.5, color=FAILED if lost[row] else EXACT, lw=0)
        inside = share > 0.5
        ax.text(
            100 * share - 4 if inside else 100 * share + 4, row + 0.5, percent(float(share)), va="center",
            ha="right" if inside else "left", color="white" if inside else INK, fontsize=SMALL, weight="bold",
        )  # fmt: skip
    ax.set_xticks([0, 50, 100], ["0", "50 %", "100"])  # as wide as the room at the end
    over(ax, "yield", "of those sampled")


def verdicts_differ(dataset: xr.Dataset) -> bool:
    """Return whether verdicts are written: not if all are good."""
    return not set(verdicts(dataset)) <= {"can be made", ""}


def draw_verdicts(ax: Axes, dataset: xr.Dataset, x: float) -> None:
    """Write of each design whether it can be made, or what keeps it from that."""
    head(ax, x, "workshop" if has_yield(dataset) else "goals", "left")
    for row, text in enumerate(verdicts(dataset)):
        good = text in ("can be made", "not known", "")
        ax.text(x, row + 0.5, text, va="center", fontsize=SMALL, color=GREY if good else FAILED)


def verdicts(dataset: xr.Dataset) -> list[str]:
    """Return of each design whether it can be made; empty texts if all goals are met and no yield is known."""
    return [verdict(dataset, row) for row in range(dataset.sizes["design"])]


def verdict(dataset: xr.Dataset, row: int) -> str:
    """Return whether a design can be made, or what keeps it from that."""
    if not is_met(dataset)[row]:
        return MISSED[DesignResult(int(dataset["design_result"].values[row]))]
    if not has_yield(dataset):
        return ""
    if len(tight := held_too_wide(dataset, row)) > MOST_TIGHT:
        return f"{len(tight)} are tight"
    if tight:
        return "tight: " + ", ".join(symbol_of(dataset[name]) for name in tight)
    if is_lost(dataset)[row]:
        return "too many fail"
    if has_tolerances(dataset):
        result = ToleranceResult(int(dataset["tolerance_result"].values[row]))
        if result != ToleranceResult.FOUND:
            return "no tolerance"
    return "can be made" if dataset["yield_low"].values[row] >= MADE else "not known"


def least_miss(dataset: xr.Dataset) -> int:
    """Return the design whose largest miss is the least."""
    return int(dataset["design_miss"].values.argmin())


def title_designs(dataset: xr.Dataset) -> str:
    """Return the title: which designs lose exciters, how many keep all that is wanted, or how many there are."""
    n, met = dataset.sizes["design"], is_met(dataset)
    if not met.any():
        least = f"; design {least_miss(dataset) + 1} misses least" * (n > 1)
        return f"No design was found that keeps all that is wanted{least}"
    if has_yield(dataset):
        if lost := lost_text(dataset):
            return lost.rstrip(".")
        share = float(dataset["yield"].values.min())
        some = f"{'At least ' * (n > 1)}{percent(share)} of" if share < 1.0 else "All"
        whose = "each design keep" if n > 1 else "the design keep"
        told, *left_out = kept_words(dataset).split(" (")
        return f"{some} {SAMPLED} sampled exciters of {whose} {told if left_out else 'all that is wanted'}"
    if len(objectives(dataset)) == 2:
        return "The designs of the front, in its order"
    if n == 1:
        return "The design beside what is wanted of it"
    return f"{n} designs keep all that is wanted"


def describe_designs(dataset: xr.Dataset) -> str:
    """Return the caption of the designs beside each other."""
    margins = dataset["law_margin"].values
    struck, end, _ = columns(dataset)
    shown = [part for part, _, _ in places(dataset, struck + GAP, end)]
    limits = [limits_of(dataset, part) for part in shown]
    has_grey = any(np.isfinite(ends).any() and ends[0] != ends[1] for ends in limits)
    is_red = [(within_share(dataset, part) < MADE).any() for part in shown]
    if yields_differ(dataset):
        is_red.append(is_lost(dataset).any())
    others = wanted_text(dataset, [part.words(dataset) for part in shown])
    parts = [
        f"Wanted: {others}" if others else "",
        f"Diamonds: values{'; grey: outside the goal' * has_grey}{f'; red: below {percent(MADE)}' * any(is_red)}",
        "Impacts: at supports 1 + 2 in a forcing period",
    ]
    if any(np.isfinite(spread_of(dataset, part)).any() for part in shown):
        parts.append("Bars of quantities: 95 % of the sampled exciters that keep the law of motion")
    if has_yield(dataset):
        sampled = f"Sampled {scatter_words(dataset)}"
        parts.append(f"Yield: {yield_words(dataset)}" if yields_differ(dataset) else sampled)
    if any("tight" in text for text in verdicts(dataset)):
        parts.append("Tight: a tolerance below the given standard deviation")
    if (margins < NONE_FOUND).any():
        away = away_text(float(np.nanmin(margins)))
        of = f" from design {int(np.nanargmin(margins)) + 1}" if margins.size > 1 else ""
        parts.append(f"The nearest change of the law of motion that was found is {away} away{of}")
    return sentences(*parts)


def away_text(margin: float) -> str:
    """Write the distance of a change of the law of motion, rounded down: `2.1 % of the ranges`."""
    far = f"less than {100 * NEAREST:g}" if margin < NEAREST else at_least(100 * margin, 2)
    return f"{far} % of the ranges"
