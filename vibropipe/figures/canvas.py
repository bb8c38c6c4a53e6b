"""Figures whose axes are placed in centimetres, and the marks and texts that are drawn directly on them.

A figure is WIDE or HALF centimetres wide and is printed at that width, so that sizes of type are those of the page::

    fig = new_canvas(9.0)
    ax = axes(fig, 1.6, 1.2, 12.8, 7.2)
    ax.plot(x, y, color=EXACT)
    label(ax, x[-1], y[-1], "exact", EXACT, ha="right", va="bottom")
    panel(ax, "a", "energy of a free motion")

Draw inside `style.house_style`. Lines and regions are labelled where they are. Positions below are in centimetres,
unless they are data of the axes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Literal

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import Formatter, FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from vibropipe.figures.palette import BAND, FAILED, GREY, HAIRLINE, INK, readable
from vibropipe.figures.text import format_number
from vibropipe.figures.units import RAISED

CM_PER_INCH = 2.54
LEGEND_LINE = 0.45  # cm of a line of a legend below a figure
WIDE, HALF, GAP = 16.0, 7.75, 0.5  # a figure, one of two beside each other, between the two
BODY, SMALL, LETTER = 8.0, 7.0, 9.0  # pt: labels and titles; ticks and notes; letters of panels
NOTE_CM = 0.38  # of a line of SMALL type
MIN_TYPE = 6.5  # pt, of anything in a figure
WHITE_GROUND = {"boxstyle": "round,pad=0.25", "facecolor": "white", "edgecolor": "none"}
TIGHT_GROUND = {**WHITE_GROUND, "boxstyle": "square,pad=0.08"}
MICRO = "\u00b5"
DECADES = 2.5  # from which on ticks of a logarithmic axis are powers of ten
MOST_DECIMALS, MOST_PLAIN = 6, 1e5  # of ticks that are written without powers of ten
TINY = 1e-3  # largest tick of an axis with powers of ten rather than more decimals


def new_canvas(height: float, width: float = WIDE) -> Figure:
    """Return an empty figure without automatic layout."""
    figure = Figure(figsize=(width / CM_PER_INCH, height / CM_PER_INCH))
    FigureCanvasAgg(figure)
    return figure


def axes(
    figure: Figure, left: float, bottom: float, width: float, height: float, **options: Any
) -> Axes:
    """Add axes whose lower left corner and size are given; `options` are those of `Figure.add_axes`."""
    wide, high = (size * CM_PER_INCH for size in figure.get_size_inches())
    place = (left / wide, (bottom + raised(figure)) / high, width / wide, height / high)
    return figure.add_axes(place, **options)


def raised(figure: Figure) -> float:
    """Return how far all of a figure stands above its edge in centimetres, for a note."""
    return float(getattr(figure, "raised", 0.0))


def size_of(ax: Axes) -> tuple[float, float]:
    """Return width and height of axes in centimetres."""
    box = ax.get_window_extent()
    inch = ax.figure.dpi / CM_PER_INCH
    return float(box.width / inch), float(box.height / inch)


def width_of(figure: Figure, text: str, fontsize: float) -> float:
    """Return the printed width of a text in centimetres."""
    drawn = figure.text(0.5, 0.5, text, fontsize=fontsize)
    width: float = drawn.get_window_extent().width / figure.dpi * CM_PER_INCH
    drawn.remove()
    return width


def panel(
    ax: Axes, letter: str = "", title: str = "", note: str = "", indent: float = -0.62
) -> None:
    """Write a bold letter, a title and a grey note in a line above axes; the letter `indent` from their left edge."""
    wide, high = size_of(ax)
    options: dict[str, Any] = {"transform": ax.transAxes, "va": "baseline"}
    y = 1 + 0.2 / high
    if letter:
        ax.text(indent / wide, y, letter, weight="bold", fontsize=LETTER, **options)
    if title:
        ax.text(0, y, title, fontsize=BODY, **options)
    if note:
        ax.text(1, y, note, fontsize=SMALL, color=GREY, ha="right", **options)


def label(ax: Axes, x: float, y: float, text: str, colour: str = INK, **options: Any) -> Text:
    """Write the name of a line at a point of its axes, in its colour, darkened until it is legible on white."""
    return ax.text(x, y, text, **{"color": readable(colour), "fontsize": BODY, **options})


def label_region(ax: Axes, x: float, y: float, text: str, **options: Any) -> Text:
    """Write the name of a region of a map at a point, on white."""
    centred = {"ha": "center", "va": "center", "multialignment": "center", "fontsize": SMALL}
    return ax.text(x, y, text, **{**centred, "bbox": WHITE_GROUND, "zorder": 5, **options})


def note(ax: Axes, x: float, y: float, text: str, **options: Any) -> Text:
    """Write a grey note at a point of the unit square of axes."""
    style = {"color": GREY, "fontsize": SMALL, "transform": ax.transAxes, "ha": "left", "va": "top"}
    return ax.text(x, y, text, **{**style, **options})


def note_height(text: str) -> float:
    """Return the height of a note of one or more lines below a figure."""
    return NOTE_CM * (1 + text.count("\n")) if text else 0.0


def noted_canvas(height: float, text: str, left: float) -> Figure:
    """Return an empty figure and, below its height, a grey note, such as the parameters, `left` from its edge."""
    below = note_height(text)
    figure = new_canvas(height + below)
    figure.raised = below  # type: ignore[attr-defined]
    wide, high = (size * CM_PER_INCH for size in figure.get_size_inches())
    figure.text(left / wide, 0.05 / high, text, color=GREY, fontsize=SMALL, va="bottom")
    return figure


def legend_above(figure: Figure, handles: Sequence[Artist], left: float) -> None:
    """Write a legend in a line above axes."""
    wide = figure.get_figwidth() * CM_PER_INCH
    figure.legend(
        handles=handles, loc="upper left", ncols=10, borderaxespad=0.1, handletextpad=0.5,
        bbox_to_anchor=(left / wide - 0.01, 1.0), columnspacing=1.2, fontsize=SMALL,
    )  # fmt: skip


def arrow(
    ax: Axes, start: tuple[float, float], end: tuple[float, float], colour: str = INK, **line: Any
) -> None:
    """Draw an arrow between two points of axes; `style` is `-|>` by default, `<|-|>` for a dimension."""
    options = {"arrowstyle": "-|>", "lw": 0.6, "mutation_scale": 6.0, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", end, start, arrowprops={**options, "color": colour, **line})


def jump(ax: Axes, x: float, start: float, end: float, colour: str) -> None:
    """Draw the jump from one branch to another as a dashed arrow."""
    arrow(ax, (x, start), (x, end), colour, linestyle=(0, (2, 1.2)), lw=0.8)


def hairlines(ax: Axes, axis: Literal["x", "y", "both"] = "y") -> None:
    """Draw a grid of hairlines behind the data."""
    ax.grid(axis=axis, color=BAND, linewidth=0.4)
    ax.set_axisbelow(True)


def zero_line(ax: Axes, axis: Literal["x", "y"] = "y") -> None:
    """Draw the line on which bars or differences begin, at zero of `axis`."""
    draw = ax.axhline if axis == "y" else ax.axvline
    draw(0.0, color=HAIRLINE, linewidth=0.5, zorder=0)


def support_bands(ax: Axes, lower: float, upper: float, axis: Literal["x", "y"] = "y") -> None:
    """Hatch what lies beyond the supports, the surfaces at two values of `axis`; keeps the limits of the axes."""
    low, high = sorted(ax.get_ylim() if axis == "y" else ax.get_xlim())
    span = ax.axhspan if axis == "y" else ax.axvspan
    style: dict[str, Any] = {"facecolor": BAND, "edgecolor": HAIRLINE, "hatch": "//////"}
    for first, last in ((low, lower), (upper, high)):
        if last > first:
            span(first, last, linewidth=0, zorder=0, **style)
    (ax.set_ylim if axis == "y" else ax.set_xlim)(low, high)


def missed_band(
    ax: Axes, first: float, last: float, text: str = "missed", axis: Literal["x", "y"] = "y"
) -> None:
    """Draw the grey band in which runs that failed stand as crosses, between two values of `axis`."""
    (ax.axhspan if axis == "y" else ax.axvspan)(first, last, color=BAND, linewidth=0, zorder=0)
    if text and axis == "y":
        middle = np.sqrt(first * last) if ax.get_yscale() == "log" else (first + last) / 2
        ax.text(0.01, middle, text, transform=ax.get_yaxis_transform(), fontsize=SMALL, va="center")


def crosses(ax: Axes, x: Any, y: Any, colour: str = FAILED) -> None:
    """Draw what failed as crosses."""
    ax.plot(x, y, linestyle="none", marker="x", color=colour, markersize=3.4, markeredgewidth=0.9)


def open_mark(marker: str, size: float, edge: float = 0.7, **options: Any) -> dict[str, Any]:
    """Return the style of a mark that is white inside."""
    return {
        "linestyle": "none", "marker": marker, "markersize": size, "markerfacecolor": "white",
        "markeredgecolor": INK, "markeredgewidth": edge, **options,
    }  # fmt: skip


def power_ticks(ax: Axes, axis: Literal["x", "y"], exponents: Iterable[int]) -> None:
    """Label powers of ten on an axis; 10^0 is written as 1, 10^1 as 10."""
    powers = list(exponents)
    words = {0: "1", 1: "10"}
    ticks(ax, axis, [10.0**n for n in powers], [words.get(n) or power(n) for n in powers])


def power(exponent: int) -> str:
    """Write a power of ten; raised digits are letters of the font, not smaller ones as in mathtext."""
    return "10" + str(exponent).translate(RAISED)


def time_ticks(ax: Axes, axis: Literal["x", "y"], exponents: Iterable[int]) -> None:
    """Label powers of ten of a time in seconds in units of people: 100 ns, 1 µs, 10 ms, 1 s."""
    units = {0: "s", -3: "ms", -6: f"{MICRO}s", -9: "ns"}
    powers = list(exponents)
    texts = [f"{10 ** (n % 3)} {units[n - n % 3]}" if n <= 2 else f"{10**n} s" for n in powers]
    ticks(ax, axis, [10.0**n for n in powers], texts)


def ticks(ax: Axes, axis: Literal["x", "y"], values: Iterable[float], texts: Iterable[str]) -> None:
    """Put labelled ticks on an axis, and no others."""
    (ax.set_yticks if axis == "y" else ax.set_xticks)(list(values), list(texts))
    (ax.yaxis if axis == "y" else ax.xaxis).set_minor_formatter(NullFormatter())
    ax.tick_params(axis=axis, which="minor", length=0)


class EvenTicks(Formatter):
    """Ticks of a linear axis, with equal decimals and commas at thousands; powers of ten if they are tiny or vast."""

    decimals: int | None = None

    def format_ticks(self, values: Any) -> list[str]:
        """Return the labels of the ticks of an axis."""
        most = max((abs(float(value)) for value in values), default=0.0)
        most_decimals = MOST_DECIMALS if most < TINY else 2 * MOST_DECIMALS  # of a narrow range
        exact = (
            n
            for n in range(most_decimals + 1)
            if all(abs(round(float(value), n) - value) <= 1e-9 * most for value in values)
        )
        self.decimals = next(exact, None) if most < MOST_PLAIN else None
        return [self(value) for value in values]

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return the label of a tick."""
        if self.decimals is None:
            return format_number(x, 6)
        return f"{round(float(x), self.decimals) + 0.0:,.{self.decimals}f}".replace("-", "−")


def plain_ticks(axis: Axis, most: int) -> None:
    """Put at most about `most` ticks on round numbers of a linear axis, and few on a logarithmic one."""
    low, high = axis.get_view_interval()
    if axis.get_scale() == "linear":
        axis.set_major_locator(MaxNLocator(most, steps=[1, 2, 5, 10]))
        axis.set_major_formatter(EvenTicks())
    elif high < low * 10**DECADES:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: format_number(value, 6)))
        axis.set_minor_formatter(NullFormatter())


def colour_bar(
    figure: Figure,
    drawn: Any,
    left: float,
    bottom: float,
    width: float,
    height: float,
    title: str = "",
) -> Colorbar:
    """Add the scale of a coloured map, in axes whose corner and size are given."""
    own = axes(figure, left, bottom, width, height)
    bar = figure.colorbar(drawn, cax=own)
    bar.outline.set_linewidth(0.5)
    own.tick_params(length=2, width=0.5, labelsize=SMALL)
    if title:
        bar.set_label(title, fontsize=BODY)
    return bar


def legend_below(figure: Figure, handles: Sequence[Artist], columns: int, left: float) -> None:
    """Put a legend at the lower edge of a figure, in lines of `columns` entries, `left` cm from the left edge."""
    if handles:
        columns = min(columns, len(handles))
        # in an order that reads along rows, since a legend fills its columns first
        ordered = [handle for column in range(columns) for handle in handles[column::columns]]
        at = (left / CM_PER_INCH / figure.get_figwidth(), 0.0)
        figure.legend(
            handles=ordered, ncols=columns, loc="lower left", bbox_to_anchor=at, borderpad=0.2,
            borderaxespad=0.0,
        )  # fmt: skip
