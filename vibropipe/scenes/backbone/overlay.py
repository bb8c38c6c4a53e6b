"""Free motions over their frequency, and forced ones over that of the force, on common axes.

Figures 5 and 8 of the paper, with the steady states that lie along them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from vibropipe.figures.canvas import (
    CM_PER_INCH,
    SMALL,
    TIGHT_GROUND,
    WIDE,
    axes,
    jump,
    label,
    new_canvas,
    panel,
)
from vibropipe.figures.palette import BLUES, GREY, INK, ORANGES, readable, shades
from vibropipe.figures.style import ROUNDING
from vibropipe.figures.text import (
    ORDINALS,
    axis_label,
    frequency,
    in_brackets,
    scalar_parameters,
    symbol_of,
    value_text,
)
from vibropipe.words.parameters import or_default
from vibropipe.words.vocabulary import VOCABULARY
from vibropipe.words.wording import series

Floats = NDArray[np.float64]
HEIGHT, LOW, BOTTOM, TOP = 9.4, 8.0, 1.05, 0.75  # cm; LOW: without forced motions
LEFT, WIDTH, SMALL_LEFT, SMALL_WIDTH, GAP = 1.3, 8.95, 11.9, 3.95, 0.45  # cm
# Colour and width of the first free motion, and of others.
FREE = (("#BDBDBD", 4.0), ("#4A4A4A", 0.9))
FAMILIES = (BLUES, ORANGES)
# A step of a line that may be a jump: of the height of the axes, and, of one law of motion, of the steps beside it; a
# line that begins as a square root, as at a pitchfork, has 2.41 times the next step.
BREAK, STEEP = 0.05, 2.5
LAW = ("period_multiple", "impacts_per_orbit")
MAX_ORDER = 3
LARGE_ROOM = 1.08  # height of the large axes over the largest value
SMALL_ROOM = 1.25  # of others
LABEL_AT = 0.36  # of the largest value
RAISED = (1.0, 1.3, 1.6)  # of that height, where the name of a line may stand
LABEL_ROOM = 0.05  # of the range, from the middle of a name to a jump


class Line(NamedTuple):
    """A line of a sweep over the frequency: its colour, other coordinate, direction, values, and whether each has the
    law of motion of the next.
    """

    colour: str
    coordinate: xr.DataArray | None
    is_down: bool
    x: Floats
    y: Floats
    is_alike: NDArray[np.bool_]


def draw_overlay(
    free: Sequence[xr.Dataset], forced: Sequence[xr.Dataset], name: str = "displacement"
) -> Figure:
    """Draw one harmonic of free and forced motions large, and beside it the mean and the other harmonics.

    The large one is the first; of free motions alone, the one in which they differ most.

    free : backbones over amplitude
    forced : sweeps over the frequency, at most one more parameter and the direction
    name : `displacement` or `velocity`
    """
    height = HEIGHT if forced else LOW
    figure = new_canvas(height)
    high = height - BOTTOM - TOP
    orders = shown_orders([*free, *forced], name)
    large = 1 if forced else most_different(free, name, (1, *(order for order in orders if order)))
    orders = [order for order in sorted({1, *orders}) if order != large]
    main = axes(figure, LEFT, BOTTOM, WIDTH if orders else WIDE - LEFT - 0.3, high)
    small_high = (high - GAP * (len(orders) - 1)) / max(len(orders), 1)
    bottoms = [BOTTOM + n * (small_high + GAP) for n in reversed(range(len(orders)))]
    small = [axes(figure, SMALL_LEFT, bottom, SMALL_WIDTH, small_high) for bottom in bottoms]
    limits = x_limits(free, forced)
    for ax, order in zip((main, *small), (large, *orders), strict=True):
        room = LARGE_ROOM if ax is main else SMALL_ROOM
        draw_order(ax, free, forced, name, order, limits, room)
        if ax is not main:
            ax.tick_params(labelbottom=ax is small[-1])
            array = free[0][f"{name}_mean" if order == 0 else f"{name}_amplitude"]
            symbol = symbol_of(array, order or None)
            words = f"mean {name}" if order == 0 else f"{ORDINALS[order - 1]} harmonic"
            text = in_brackets(f"{words} {f'|{symbol}|' if order == 0 else symbol}", array)
            label(ax, 0.99, 0.99, text, transform=ax.transAxes, ha="right", va="top", zorder=6,
                  bbox=TIGHT_GROUND)  # fmt: skip
    amplitude = free[0][f"{name}_amplitude"]
    words = f"{ORDINALS[large - 1]} harmonic of the {name}, {symbol_of(amplitude, large)}"
    main.set(xlabel=x_label(free, forced), ylabel=in_brackets(words, amplitude))
    panel(main, "a", indent=-0.95)
    if small:
        panel(small[0], "b", indent=-0.95)
        axis = forced[0][frequency(forced[0])] if forced else free[0]["eigenfrequency"]
        small[-1].set_xlabel(axis_label(axis))
    if name == "displacement" and large == 1:
        draw_distance(main, free[0])
    write_key(figure, forced)
    return figure


def shown_orders(datasets: Sequence[xr.Dataset], name: str) -> list[int]:
    """Return what stands beside the first harmonic: 0 for the mean, 2 and 3, without what is only rounding."""
    number = min(MAX_ORDER, *(dataset.sizes["harmonic"] for dataset in datasets))
    tops = {k: max(largest_of(d, name, k) for d in datasets) for k in range(number + 1)}
    return [order for order in tops if order != 1 and tops[order] > ROUNDING * max(tops.values())]


def most_different(free: Sequence[xr.Dataset], name: str, orders: Sequence[int]) -> int:
    """Return the harmonic whose largest values differ most between free motions, relative to the larger one."""
    tops = {k: [largest_of(d, name, k) for d in free] for k in orders}
    return max(orders, key=lambda k: 1.0 - min(tops[k]) / (max(tops[k]) or 1.0))


def draw_distance(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the half distance of the supports, if it lies within the axes."""
    distance, (low, high) = dataset.get("l"), ax.get_ylim()
    if distance is None or distance.ndim or not low < float(distance) < high:
        return
    ax.axhline(float(distance), color=INK, linewidth=0.5, linestyle=(0, (4, 2)), zorder=0)
    text = f"half the distance between the supports, {value_text(distance)}"
    at_right: dict[str, Any] = {"transform": ax.get_yaxis_transform(), "ha": "right"}
    ax.text(0.995, float(distance), text, va="bottom", fontsize=SMALL, **at_right)


def draw_order(
    ax: Axes, free: Sequence[xr.Dataset], forced: Sequence[xr.Dataset], name: str, order: int,
    limits: tuple[float, float], room: float,
) -> None:  # fmt: skip
    """Draw one harmonic (0: the mean) of all motions within limits of the frequency; `room` is over the largest."""
    top = 0.0
    families = [list(lines_of(data, name, order, FAMILIES[n % 2])) for n, data in enumerate(forced)]
    for number, dataset in enumerate(free):
        x, y = dataset["eigenfrequency"].values, np.abs(of_order(dataset, name, order).values)
        kept = (x >= limits[0]) & (x <= limits[1])
        colour, width = FREE[min(number, 1)]
        ax.plot(x[kept], y[kept], color=colour, linewidth=width, zorder=1, solid_capstyle="butt")
        top = max(top, float(np.nanmax(y[kept], initial=0.0)))
    top = max(
        [top, *(float(np.nanmax(line.y, initial=0.0)) for lines in families for line in lines)]
    )
    for number, lines in enumerate(families):
        for line in lines:
            at = jumps_of(line, BREAK * top) + 1
            # the second family lies below the first, and is seen where it differs
            width, zorder, style = (1.1, 4, "-") if number == 0 else (1.0, 3, (0, (3, 1)))
            ax.plot(np.insert(line.x, at, np.nan), np.insert(line.y, at, np.nan), color=line.colour,
                    linewidth=width, zorder=zorder, linestyle=style)  # fmt: skip
            if order == 1 and number == 0:
                draw_jumps(ax, line, BREAK * top)
    if order == 1 and families:
        label_lines(ax, families[0], top)
    ax.set(xlim=limits, ylim=(0.0, room * top or 1.0))


def of_order(dataset: xr.Dataset, name: str, order: int) -> xr.DataArray:
    """Return a harmonic, or the mean for order 0."""
    if order == 0:
        return dataset[f"{name}_mean"]
    return dataset[f"{name}_amplitude"].sel(harmonic=order)


def largest_of(dataset: xr.Dataset, name: str, order: int) -> float:
    """Return the largest magnitude of a harmonic, or of the mean."""
    return float(np.nanmax(np.abs(of_order(dataset, name, order).values), initial=0.0))


def lines_of(dataset: xr.Dataset, name: str, order: int, family: tuple[str, str]) -> Iterator[Line]:
    """Yield the lines of a sweep; rows without an orbit are gaps."""
    axis = frequency(dataset)
    values = abs(of_order(dataset, name, order)).where(dataset["period_multiple"] > 0)
    other = next((str(dim) for dim in values.dims if dim not in (axis, "direction")), "")
    colours = shades(dataset.sizes[other] if other else 1, family)
    for number, colour in enumerate(colours):
        of_value = values.isel({other: number}) if other else values
        directions = dataset["direction"].values if "direction" in of_value.dims else [""]
        for way in directions:
            row = (of_value.sel(direction=way) if way else of_value).sortby(axis)
            coordinate = dataset[other][number] if other else None
            chosen = {each: row[each].values for each in (other, "direction") if each in row.coords}
            laws = dataset[list(LAW)].sel(chosen).sortby(axis)
            is_alike = laws_alike(laws, axis)
            yield Line(colour, coordinate, way == "down", row[axis].values, row.values, is_alike)


def laws_alike(rows: xr.Dataset, axis: str) -> NDArray[np.bool_]:
    """Return whether each row along an axis has the law of motion of the next one."""
    columns = [rows[name].transpose(axis, ...).values.reshape(rows.sizes[axis], -1) for name in LAW]
    law = np.concatenate(columns, axis=1)
    return (law[1:] == law[:-1]).all(axis=1)


def jumps_of(line: Line, least: float) -> NDArray[np.intp]:
    """Return the points after which a line jumps: to another law of motion, or by far more than beside it."""
    steps = np.abs(np.diff(line.y))
    around = np.nan_to_num(np.pad(steps, 1))
    is_steep = steps > STEEP * np.maximum(around[:-2], around[2:])
    return np.flatnonzero((steps > least) & (is_steep | ~line.is_alike))


def draw_jumps(ax: Axes, line: Line, least: float) -> None:
    """Draw the steps of a line from one branch to another as arrows in the direction in which it is followed."""
    for index in jumps_of(line, least):
        ends = line.y[index], line.y[index + 1]
        start, end = reversed(ends) if line.is_down else ends
        jump(ax, float(line.x[index : index + 2].mean()), float(start), float(end), line.colour)


def label_lines(ax: Axes, lines: Sequence[Line], top: float) -> None:
    """Write the other coordinate of each line where the lowest of its values last passes a height, else at its end.

    The height is raised where a jump would run through the text.
    """
    jumped = np.concatenate([line.x[jumps_of(line, BREAK * top)] for line in lines])
    by_value: dict[float, list[Line]] = {}
    for line in lines:
        if line.coordinate is not None:
            by_value.setdefault(line.coordinate.item(), []).append(line)
    for own in by_value.values():
        x, coordinate = own[0].x, own[0].coordinate
        assert coordinate is not None
        low = np.fmin.reduce([line.y for line in own])
        # after the last point that is as high; at the end where none is, or the last one
        above = [np.flatnonzero(low >= share * LABEL_AT * top) for share in RAISED]
        places = [min(int(each[-1]) + 1 if each.size else x.size, x.size - 1) for each in above]
        room = LABEL_ROOM * np.ptp(x)
        clear = [each for each in places if (np.abs(jumped - x[each]) > room).all()]
        at = (clear or places)[0]
        if not np.isfinite(low[at]):
            continue
        label(ax, float(x[at]), float(low[at]), value_text(coordinate), own[0].colour, ha="center", va="center",
              zorder=6, bbox=TIGHT_GROUND)  # fmt: skip


def x_limits(free: Sequence[xr.Dataset], forced: Sequence[xr.Dataset]) -> tuple[float, float]:
    """Return the range of the frequencies of the force, else of the free motions."""
    arrays = [d[frequency(d)] for d in forced] or [d["eigenfrequency"] for d in free]
    return min(float(a.min()) for a in arrays), max(float(a.max()) for a in arrays)


def x_label(free: Sequence[xr.Dataset], forced: Sequence[xr.Dataset]) -> str:
    """Return the label of the axis of frequencies."""
    if not forced:
        return axis_label(free[0]["eigenfrequency"])
    axis = forced[0][frequency(forced[0])]
    text = f"frequency {symbol_of(axis)} of excitation, or eigenfrequency of the free motion"
    return in_brackets(text, axis)


def write_key(figure: Figure, forced: Sequence[xr.Dataset]) -> None:
    """Write above the first panel which colour is which motion, by the parameters in which they differ."""
    entries = [("grey: free motion", GREY)]
    names = ("blue", "orange, dashed")
    for number, text in enumerate(difference_texts(forced)):
        tail = ", seen where it differs" if number else ""
        entries.append((f"{names[number % 2]}: {text}{tail}", FAMILIES[number % 2][1]))
    left, y = LEFT, 1 - 0.42 / (float(figure.get_figheight()) * CM_PER_INCH)
    for text, colour in entries:
        drawn = figure.text(left / WIDE, y, text, color=readable(colour), va="baseline")
        left += drawn.get_window_extent().width / figure.dpi * CM_PER_INCH + 0.45


def difference_texts(datasets: Sequence[xr.Dataset]) -> list[str]:
    """Write the parameters in which datasets differ, of each; of a single one that it is forced."""
    values = [scalar_parameters(dataset) for dataset in datasets]
    if len(values) < 2:
        return ["forced motion"] * len(values)
    names = [n for n in values[0] if len({or_default(each, n) for each in values}) > 1]
    return [
        series(
            value_text(d[n])
            if n in d.variables
            else f"{VOCABULARY[n].symbol} = {or_default({}, n):g}"
            for n in names
        )
        or "forced"
        for d in datasets
    ]
