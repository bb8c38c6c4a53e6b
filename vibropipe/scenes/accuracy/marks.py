"""Names and marks of compared methods, and the axes of time and error that their pictures share."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from vibropipe.figures.canvas import hairlines, power_ticks, time_ticks
from vibropipe.figures.claims import at_most
from vibropipe.figures.palette import METHODS, MethodStyle
from vibropipe.figures.text import format_number

NS = 1e-9
STYLES: Mapping[str, MethodStyle] = {
    **METHODS,
    **{name: METHODS[name.lower()] for name in ("RK45", "DOP853", "Radau")},
    "solve_nivp": METHODS["nivp"],
}
# Names in sentences and tables.
NAMES = {
    "crude": "an impact at the end of a step",
    "newmark": "Newmark's method",
    "exact": "the exact method",
    "RK45": "scipy's RK45",
    "DOP853": "scipy's DOP853",
    "Radau": "scipy's Radau",
    "heyoka": "heyoka",
    "solve_nivp": "solve-nivp",
}
TIME_UNITS = ((1e9, "s"), (1e6, "ms"), (1e3, "µs"), (1.0, "ns"))
LEAST_ERROR = 1e-16


def capital(text: str) -> str:
    """Return a text with a capital letter, unless it begins with a name that has none."""
    return text if text.startswith(("scipy", "heyoka", "solve")) else text[:1].upper() + text[1:]


def time_text(nanoseconds: float, digits: int = 2) -> str:
    """Write a time in the unit that people use: 0.23 µs, 1.5 ms."""
    size, unit = next((s for s in TIME_UNITS if nanoseconds >= 0.1 * s[0]), TIME_UNITS[-1])
    return f"{format_number(float(f'{nanoseconds / size:.{digits}g}'), 4)} {unit}"


def error_text(error: float) -> str:
    """Write an error, rounded up to two digits, as a percentage from 1 % on."""
    if error >= 0.01:
        return f"{at_most(100 * error, 2)} %"
    return at_most(error, 2).removeprefix("1 × ")


def multiple_text(ratio: float) -> str:
    """Write a multiple to two digits, with commas: 1.1, 54, 4,400."""
    if ratio < 10:
        return f"{ratio:.2g}"
    digits = int(np.floor(np.log10(ratio))) - 1
    return f"{round(ratio, -digits):,.0f}"


def error_axis(ax: Axes, exponents: Iterable[int], worst: float, best: float = LEAST_ERROR) -> None:
    """Let an axis of errors grow more accurate to the right."""
    ax.set(xscale="log", xlim=(worst, best))
    power_ticks(ax, "x", exponents)


def time_axis(ax: Axes, low: float, high: float) -> None:
    """Let an axis show times in seconds, with hairlines."""
    ax.set(yscale="log", ylim=(low, high))
    inside = range(int(np.ceil(np.log10(low))), int(np.floor(np.log10(high))) + 1)
    time_ticks(ax, "y", inside)
    hairlines(ax, "y")


def time_span(dataset: xr.Dataset) -> tuple[float, float]:
    """Return limits of the times (s) of a dataset, with room."""
    times = dataset["time_per_period"].values * NS
    times = times[np.isfinite(times)]
    return (times.min() / 3, times.max() * 3) if times.size else (1e-8, 1e-3)


def motion_title(name: object) -> str:
    """Return the name of a motion in words: figure_6 is that of the paper."""
    text = str(name).replace("_", " ")
    number = text.removeprefix("figure ")
    return f"figure {number} of the paper" if number != text and number.isdigit() else text
