"""Pictures of a design scene; among them the first design drawn to scale, and how far its parameters may be off."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from vibropipe.figures.canvas import SMALL, WIDE, arrow, axes, new_canvas
from vibropipe.figures.palette import BAND, FAILED, GREY, INK, SUPPORT_TEXT
from vibropipe.figures.text import (
    LINE_DIGITS,
    force_amplitude,
    format_number,
    in_lines,
    is_forced,
    parameter_names,
    plain_symbol_of,
    sentences,
    symbol_of,
    with_units,
)
from vibropipe.report.exciter import WORDS
from vibropipe.report.parts import DASH
from vibropipe.scenes.certificate_page import CERTIFICATE_PICTURE
from vibropipe.scenes.design.data import goals, has_tolerances, is_front, is_met, wanted_parts
from vibropipe.scenes.design.front import describe_front, draw_front, title_front
from vibropipe.scenes.design.nominal import (
    held_too_wide,
    hold_at_once,
    nominal_text,
    shown_tolerance,
    toleranced,
)
from vibropipe.scenes.design.ranking import (
    describe_designs,
    draw_designs,
    least_miss,
    title_designs,
)
from vibropipe.scenes.design.spread import SENSITIVITIES, TORNADO
from vibropipe.scenes.design.workshop import no_tolerance, no_tolerance_text
from vibropipe.scenes.kind import Picture
from vibropipe.words.vocabulary import held_name

# Centimetres: from the middle to a support, or to an equilibrium beyond it; the wall; lines of the table.
REACH, WALL, LINE = 3.2, 0.7, 0.4
MIDDLE, CENTRED, TABLE = 6.4, 8.2, 10.6
FEW_LINES = 5  # of the table, beside the mass
DIGITS_BESIDE = 62  # of a line of parameters beside the table
MASS = 1.1
TOP = 5.62  # of the frame of a housing that slides
FRAME: dict[str, Any] = {"color": GREY, "lw": 1.2, "zorder": 1}
NAMES_DRAWN = ("l", "delta", "R1", "R2", "k1", "k2", "C1", "C2", "h1", "h2", "H1", "H2")


def draw_sketch(dataset: xr.Dataset) -> Figure:
    """Draw supports, offset and equilibrium of design 1 to scale, with the tolerances beside the deviations."""
    names = limited(dataset)
    given = [name for name in parameter_names(dataset) if name not in NAMES_DRAWN]
    texts = [quantity_text(dataset, name) for name in given]
    line = in_lines(texts, DIGITS_BESIDE if names else LINE_DIGITS)
    below = max(0, len(names) - FEW_LINES, line.count("\n")) * LINE
    height = 5.7 + below
    figure = new_canvas(height)
    ax = axes(figure, 0, 0, WIDE, height)
    ax.set(xlim=(0, WIDE), ylim=(-below, 5.7))
    ax.set_axis_off()
    draw_exciter(ax, dataset, *((MIDDLE, TABLE) if names else (CENTRED, WIDE)))
    if names:
        draw_limits(ax, dataset, names)
    ax.text(WALL, 0.42, line, va="top", linespacing=1.3)
    return figure


def draw_exciter(ax: Axes, dataset: xr.Dataset, middle: float, right: float) -> None:
    """Draw the parts up to `right`: supports and equilibrium to scale, mass, spring and damper not."""
    half, offset = (float(np.ravel(dataset[name].values)[0]) for name in ("l", "delta"))
    scale = REACH / max(half, abs(offset))
    # displacements count from the equilibrium, supports lie at offset -+ l
    at = middle - scale * offset
    grey: dict[str, Any] = {"color": GREY, "lw": 0.5}
    ax.plot([middle] * 2, [2.0, 5.35], ls=(0, (4, 2)), **grey)
    ax.plot([at] * 2, [0.6, 4.5], ls=(0, (6, 1.5, 1, 1.5)), zorder=0, **grey)
    if slides(dataset):
        ends = [middle + sign * (scale * half + 0.5) for sign in (-1, 1)]
        wall = WALL - 0.125
        ax.plot([wall, wall, ends[1], ends[1]], [1.8, TOP, TOP, 3.55], **FRAME)
        ax.plot([ends[0]] * 2, [TOP, 3.55], **FRAME)
    for number, sign in ((1, 1), (2, -1)):
        edge = middle + sign * scale * half
        draw_support(ax, dataset, number, edge, sign)
        ax.plot([edge] * 2, [3.55, 5.35], color=GREY, lw=0.4)
        dimension(ax, min(middle, edge), max(middle, edge), 5.15, quantity_text(dataset, "l"))
    if offset:
        draw_offset(ax, dataset, middle, at)
    # the mass with its striker, a bar whose sides meet the supports
    inside = float(np.clip(at, middle - scale * half, middle + scale * half))
    ax.plot([inside] * 2, [1.75, 3.3], color=INK, lw=2.0, solid_capstyle="butt", zorder=4)
    ax.add_patch(
        Rectangle((inside - MASS / 2, 0.8), MASS, 0.95, facecolor="white", edgecolor=INK, lw=0.9)
    )
    ax.text(inside, 1.27, "$m$", ha="center", va="center", zorder=5)
    if is_forced(dataset):
        side, end = inside + MASS / 2, min(inside + MASS / 2 + 0.9, right - 0.1)
        arrow(ax, (side, 1.27), (end, 1.27), lw=1.0)
        symbol = symbol_of(dataset[force_amplitude(dataset)])
        ax.text((side + end) / 2, 1.36, symbol, ha="center", va="bottom")
    block(ax, dataset, WALL - 0.25, 0.75, 0.25, 1.05)
    ax.plot([WALL] * 2, [0.75, 1.8], color=INK, lw=1.4, solid_capstyle="butt")
    coil(ax, WALL, inside - MASS / 2, 1.5)
    damper(ax, WALL, inside - MASS / 2, 1.04)


def draw_offset(ax: Axes, dataset: xr.Dataset, middle: float, at: float) -> None:
    """Draw the dimension of the offset, with arrows from outside if it is short."""
    text, gap = quantity_text(dataset, "delta"), abs(at - middle)
    if gap > 1.8:
        dimension(ax, min(at, middle), max(at, middle), 4.3, text)
        return
    sign = 1 if at >= middle else -1
    arrow(ax, (at + 0.45 * sign, 4.3), (at, 4.3), lw=0.45, mutation_scale=4)
    arrow(ax, (middle - 0.45 * sign, 4.3), (middle, 4.3), lw=0.45, mutation_scale=4)
    ax.text(at + 0.52 * sign, 4.3, text, va="center", ha="left" if sign > 0 else "right")


def draw_support(ax: Axes, dataset: xr.Dataset, number: int, edge: float, sign: int) -> None:
    """Draw a support whose surface is at `edge`, and write what it gives back or how soft it is."""
    stiffness, damping = (held_name(dataset.coords, f"{name}{number}") for name in "kh")
    soft = stiffness in dataset.coords and bool(np.ravel(dataset[stiffness].values)[0])
    depth, near = (0.2, 0.35) if soft else (0.5, 0.0)
    block(ax, dataset, min(edge + sign * near, edge + sign * (near + depth)), 2.8, depth, 0.75)
    if soft:
        first, last = sorted((edge, edge + sign * near))
        coil(ax, first, last, 3.17, turns=3, half=0.1, lead=0.04)
    ax.plot([edge] * 2, [2.8, 3.55], color=INK, lw=1.4, solid_capstyle="butt")
    ax.text(
        edge + sign * (near + depth) / 2, 3.62, str(number), ha="center", va="bottom",
        weight="bold", color=SUPPORT_TEXT[number],
    )  # fmt: skip
    names = [stiffness, damping] if soft else [f"R{number}"]
    text = "\n".join(quantity_text(dataset, name) for name in names if name in dataset.coords)
    side = "left" if sign > 0 else "right"
    ax.text(edge + sign * 0.65, 3.17, text, ha=side, va="center", linespacing=1.3)


def draw_limits(ax: Axes, dataset: xr.Dataset, names: list[str]) -> None:
    """Write how far each parameter may be off beside what the workshop holds; red where that is too wide."""
    tight = held_too_wide(dataset, 0)
    given = dataset.attrs.get("scatter") == "given"
    columns = ((TABLE + 3.0, "may be off by"), (WIDE - 0.05, "workshop" if given else "assumed"))
    has_found = bool(toleranced(dataset))
    for x, head in columns[0 if has_found else 1 :]:
        ax.text(x, 2.35, head, ha="right", weight="bold", fontsize=SMALL)
    ax.plot([TABLE, WIDE - 0.05], [2.26, 2.26], color=INK, lw=0.5)
    for n, name in enumerate(names):
        y = 2.0 - LINE * n
        ax.text(TABLE, y, symbol_of(dataset[name]), va="center")
        colour = FAILED if name in tight else INK
        text = shown_tolerance(dataset, name, 0) if name in toleranced(dataset) else DASH
        weight = "bold" if name in tight else "normal"
        off = plus_minus(dataset, name, text)
        if has_found:
            ax.text(columns[0][0], y, off, ha="right", va="center", color=colour, weight=weight)
        std = float(dataset[f"{name}_std"]) if f"{name}_std" in dataset else np.nan
        held = plus_minus(dataset, name, format_number(std, 3))
        ax.text(columns[1][0], y, held, ha="right", va="center", color=GREY)


def limited(dataset: xr.Dataset) -> list[str]:
    """Return the parameters that have a tolerance or a deviation."""
    held = toleranced(dataset)
    return [n for n in map(str, dataset.coords) if n in held or f"{n}_std" in dataset]


def plus_minus(dataset: xr.Dataset, name: str, text: str) -> str:
    """Write a tolerance or a deviation of a parameter with its unit; a dash if there is none."""
    return DASH if text == DASH else f"± {with_units(dataset[name], text)}"


def quantity_text(dataset: xr.Dataset, name: str) -> str:
    """Write a parameter of design 1 with its symbol and unit."""
    return f"{symbol_of(dataset[name])} = {nominal_text(dataset, name)}"


def block(ax: Axes, dataset: xr.Dataset, x: float, y: float, width: float, height: float) -> None:
    """Draw a block of the frame: hatched as the ground is, or plain where it is a housing that slides."""
    hatch = "" if slides(dataset) else "//////"
    ax.add_patch(
        Rectangle((x, y), width, height, facecolor=BAND, edgecolor=GREY, hatch=hatch, lw=0)
    )


def forces_text(dataset: xr.Dataset) -> str:
    """Write what the letters of constant forces mean that are drawn nowhere; empty without one."""
    names = [held_name(dataset.coords, name) for name in ("load", "housing_load")]
    given = [name for name in names if name in dataset.coords and dataset[name].values.any()]
    return ", ".join(f"{plain_symbol_of(dataset[name])}: {WORDS[name]}" for name in given)


def slides(dataset: xr.Dataset) -> bool:
    """Return whether the supports are those of a housing that slides."""
    mass = held_name(dataset.coords, "mass_ratio")
    return mass in dataset.coords and bool(np.ravel(dataset[mass].values)[0])


def coil(
    ax: Axes,
    x1: float,
    x2: float,
    y: float,
    turns: int = 12,
    half: float = 0.14,
    lead: float = 0.16,
) -> None:
    """Draw a spring between two points."""
    x = np.linspace(x1 + lead, x2 - lead, 2 * turns + 1)
    up = half * np.array([0, *(1 if k % 2 else -1 for k in range(1, 2 * turns)), 0])
    ax.plot([x1, *x, x2], [y, *(y + up), y], color=INK, lw=0.7)


def damper(ax: Axes, x1: float, x2: float, y: float) -> None:
    """Draw a damper between two points."""
    a, b = x1 + 0.42 * (x2 - x1), x1 + 0.62 * (x2 - x1)
    for x, z in (
        ((x1, a), (y, y)),
        ((b, a, a, b), (y + 0.15, y + 0.15, y - 0.15, y - 0.15)),
        ((a + 0.17, x2), (y, y)),
    ):
        ax.plot(x, z, color=INK, lw=0.7)
    ax.plot([a + 0.17] * 2, [y - 0.11, y + 0.11], color=INK, lw=1.2)


def dimension(ax: Axes, x1: float, x2: float, y: float, text: str) -> None:
    """Draw a dimension with its text above."""
    arrow(ax, (x1, y), (x2, y), arrowstyle="<|-|>", lw=0.45, mutation_scale=4)
    ax.text((x1 + x2) / 2, y + 0.06, text, ha="center", va="bottom")


def title_sketch(dataset: xr.Dataset) -> str:
    """Return the title of the sketch."""
    if not is_met(dataset)[0] and least_miss(dataset) == 0:
        return "The design found that misses least, drawn to scale"
    return f"{'The design' if dataset.sizes['design'] == 1 else 'Design 1'}, drawn to scale"


def describe_sketch(dataset: xr.Dataset) -> str:
    """Return the caption of the sketch."""
    parts = [
        "Dash-dotted: static equilibrium without supports; dashed: middle between the supports",
        "Grey: the housing, which slides" if slides(dataset) else "",
        f"Reached, with what is wanted in brackets: {reached}"
        if (reached := reached_text(dataset))
        else "",
        forces_text(dataset),
    ]
    if has_tolerances(dataset):
        reason = no_tolerance(dataset, 0)
        how = ": all at once" if hold_at_once(dataset) else ""
        off = f"May be off{how}, rounded down"
        parts.append(no_tolerance_text([0], reason) if reason else off)
    if dataset.attrs.get("scatter") == "given":
        red = "; red: a tolerance below it" if held_too_wide(dataset, 0) else ""
        parts.append(f"Workshop: given standard deviation{red}")
    elif "scatter" in dataset.attrs:
        parts.append("Assumed: a standard deviation of 0.1 %, since none is given")
    return sentences(*parts)


def reached_text(dataset: xr.Dataset) -> str:
    """Write what design 1 reaches of each goal, with the goal in brackets; empty without goals."""
    values = {part.words(dataset): part.value_text(dataset, 0) for part in wanted_parts(dataset)}
    return "; ".join(
        f"{goal.words} = {values[goal.words]} ({goal.text})"
        if goal.words in values
        else f"{goal.words} ({goal.text})"
        for goal in goals(dataset)
    )


def has_designs(dataset: xr.Dataset) -> bool:
    """Return whether a dataset holds designs, and not the spread of one exciter."""
    return "vary" in dataset.attrs


def of_front(front: Callable[..., Any], sketch: Callable[..., Any]) -> Callable[..., Any]:
    """Return what is drawn or told of a front; of designs that are none, beside which they stand, of the sketch."""
    return lambda dataset: (front if is_front(dataset) else sketch)(dataset)


PICTURES = (
    Picture(
        "front",
        of_front(draw_front, draw_sketch),
        of_front(describe_front, describe_sketch),
        is_front,
        titled=of_front(title_front, title_sketch),
    ),
    Picture("sketch", draw_sketch, describe_sketch, has_designs, titled=title_sketch),
    Picture(
        "designs",
        draw_designs,
        describe_designs,
        has_designs,
        titled=title_designs,
        heading="What does each design reach?",
    ),
    TORNADO,
    SENSITIVITIES,
    CERTIFICATE_PICTURE,
)
