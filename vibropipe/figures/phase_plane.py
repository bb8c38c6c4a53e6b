"""Curves in the plane of displacement and velocity: portraits, jumps and sections; spectra of harmonics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from vibropipe.figures.palette import SUPPORT_COLOURS, SUPPORT_MARKERS
from vibropipe.figures.style import BLACK, BLUE, GREY, NEUTRAL, VERMILLION, rasterise_many
from vibropipe.figures.text import frequency
from vibropipe.physics.start import support_positions

Floats = NDArray[np.float64]

TIME_TOLERANCE = 1e-9  # relative: samples this close to an impact count as simultaneous


def with_breaks(
    tau: Floats, values: Floats, at: Floats, before: Floats, after: Floats
) -> tuple[Floats, Floats]:
    """Insert (at, before), a break, (at, after) into a sampled curve, so that jumps are not sloped.

    Samples at the time of an impact are dropped, since they are on one side of the jump or the other.
    """
    is_away = away_from(tau, at)
    tau, values = tau[is_away], values[is_away]
    indices = np.repeat(np.searchsorted(tau, at, side="left"), 3)
    new_tau = np.repeat(at, 3)
    new_values = np.stack([before, np.full_like(before, np.nan), after], axis=1).ravel()
    return np.insert(tau, indices, new_tau), np.insert(values, indices, new_values)


def away_from(tau: Floats, at: Floats) -> NDArray[np.bool_]:
    """Return which samples are at none of the ascending times `at`, within TIME_TOLERANCE."""
    if at.size == 0:
        return np.ones(tau.shape, dtype=np.bool_)
    right = np.searchsorted(at, tau)
    nearest = np.minimum(
        np.abs(tau - at[np.clip(right, 0, at.size - 1)]),
        np.abs(tau - at[np.clip(right - 1, 0, at.size - 1)]),
    )
    return nearest > TIME_TOLERANCE * (1.0 + np.abs(tau))


def certain_jumps(tau: Floats, velocity: Floats, acceleration: float) -> NDArray[np.intp]:
    """Return the indices of samples that follow a jump: a step larger than a bound of the acceleration allows."""
    steps = np.abs(np.diff(velocity))
    return np.flatnonzero(steps > 1.05 * acceleration * np.diff(tau)) + 1


FAR_SUPPORT = 3.0  # supports farther than this multiple of the largest displacement are not drawn
WALL_SHARE = 0.08  # of the width of the plane, on each side
MANY_IMPACTS = 80  # markers shrink beyond this
JUMP_LINE = (0, (1, 1.5))


@dataclass(frozen=True)
class Impacts:
    """Impacts of a motion: times (ascending), supports, velocities before and after."""

    time: Floats
    support: NDArray[np.int8]
    before: Floats
    after: Floats

    def within(self, first: float, last: float) -> Impacts:
        """Return the impacts from one time to another."""
        kept = (self.time >= first) & (self.time <= last)
        return Impacts(self.time[kept], self.support[kept], self.before[kept], self.after[kept])


def path(
    time: Floats, x: Floats, v: Floats, impacts: Impacts, walls: dict[int, float]
) -> tuple[Floats, Floats]:
    """Return a sampled motion in the plane, with each impact on its support and a break at its jump."""
    wall = np.where(impacts.support == 1, walls[1], walls[2])
    _, shown_x = with_breaks(time, x, impacts.time, wall, wall)
    _, shown_v = with_breaks(time, v, impacts.time, impacts.before, impacts.after)
    return shown_x, shown_v


def draw_portrait(
    ax: Axes, x: Floats, v: Floats, impacts: Impacts, walls: dict[int, float]
) -> None:
    """Draw a path, its supports as walls and its jumps as vertical dotted lines."""
    rasterise_many(ax.plot(x, v, color=BLACK, linewidth=0.9, zorder=2), x.size)
    draw_walls(ax, float(np.nanmin(x)), float(np.nanmax(x)), walls)
    draw_jumps(ax, impacts, walls)


def draw_jumps(ax: Axes, impacts: Impacts, walls: dict[int, float]) -> None:
    """Draw the jumps of a path as vertical dotted lines, with a mark where each begins."""
    for support in (1, 2):
        own = impacts.support == support
        amount = int(own.sum())
        if amount:
            wall = np.full(amount, walls[support])
            lines = ax.vlines(wall, impacts.before[own], impacts.after[own], color=SUPPORT_COLOURS[support],
                              linestyle=JUMP_LINE, linewidth=1.1, zorder=3)  # fmt: skip
            marks = ax.plot(wall, impacts.before[own], **impact_style(support, amount))
            rasterise_many([lines, *marks], amount)


def impact_style(support: int, amount: int) -> dict[str, Any]:
    """Return the mark of impacts on a support; many are small."""
    return {
        "linestyle": "none",
        "marker": SUPPORT_MARKERS[support],
        "markersize": 4.5 if amount <= MANY_IMPACTS else 2.5,
        "markerfacecolor": SUPPORT_COLOURS[support],
        "markeredgecolor": "white",
        "markeredgewidth": 0.4,
        "zorder": 4,
    }


def walls_of(dataset: xr.Dataset) -> dict[int, float]:
    """Return the displacements of both supports of a motion or of a row, eq. (1)."""
    return dict(enumerate(support_positions(float(dataset["l"]), float(dataset["delta"])), 1))


def near_walls(low: float, high: float, walls: dict[int, float]) -> dict[int, float]:
    """Return the supports that are near a range of displacements."""
    reach = max(abs(low), abs(high), 1e-300)
    return {support: x for support, x in walls.items() if abs(x) <= FAR_SUPPORT * reach}


def draw_walls(ax: Axes, low: float, high: float, walls: dict[int, float]) -> None:
    """Shade what is beyond the supports that are near a range of displacements, and set the limits."""
    near = near_walls(low, high, walls)
    ends = [low, high, *near.values()]
    margin = WALL_SHARE * (max(ends) - min(ends) or 1.0)
    limits = (min(ends) - margin, max(ends) + margin)
    for support, x in near.items():
        edge = limits[1] if support == 1 else limits[0]
        ax.axvspan(*sorted((x, edge)), facecolor=NEUTRAL, alpha=0.55, linewidth=0, zorder=0)
        ax.axvline(x, color=GREY, linewidth=0.8, zorder=1)
    ax.set_xlim(limits)


def portrait_handles(supports: set[int]) -> list[Line2D]:
    """Return legend entries of the jumps on the supports that are struck."""
    return [
        Line2D([], [], linestyle=JUMP_LINE, color=SUPPORT_COLOURS[support],
               marker=SUPPORT_MARKERS[support], label=f"impact on support {support}")
        for support in sorted(supports)
    ]  # fmt: skip


def _cells(values: Floats) -> NDArray[np.int64]:
    """Return in which of CELLS along their range values lie; 0 of those that are not finite."""
    finite = values[np.isfinite(values)]
    low, width = (finite.min(), np.ptp(finite) or 1.0) if finite.size else (0.0, 1.0)
    return np.nan_to_num(np.round(CELLS * (values - low) / width)).astype(np.int64)


def draw_points(ax: Axes, x: Floats, y: Floats, colour: str = BLACK, marker: str = ".") -> None:
    """Draw the points of a section or a diagram, smaller the more places they have: orbits come back to theirs."""
    places = np.unique((CELLS + 1) * _cells(x) + _cells(y)).size or 1
    size = float(np.clip(30.0 / places**0.4, 1.3, 5.0))
    drawn = ax.plot(
        x, y, linestyle="none", marker=marker, markersize=size, markeredgewidth=0.0,
        color=colour, zorder=2,
    )  # fmt: skip
    rasterise_many(drawn, 4 * x.size)


CELLS = 10_000  # of a side, in which points are counted as one
FLOOR = 1e-6  # lowest amplitude on the axis, relative to the largest
STEMS: tuple[dict[str, Any], ...] = (
    {"color": BLUE, "marker": "o"},
    {"color": VERMILLION, "marker": "D", "markerfacecolor": "white"},
)


def lines_of(row: xr.Dataset, name: str) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Return (multiples of nu, amplitudes) of the harmonics of one row, then of its subharmonics.

    name : `displacement` or `velocity`
    """
    values = row[f"{name}_amplitude"].values
    harmonics = (np.asarray(row["harmonic"].values, float), values)
    between = f"subharmonic_{name}_amplitude"
    if between not in row:
        return harmonics, (np.empty(0), np.empty(0))
    multiple = max(1, int(row.get("period_multiple", xr.DataArray(1))))
    at = np.asarray(row["subharmonic"].values, float) / multiple
    kept = np.isfinite(row[between].values)
    return harmonics, (at[kept], row[between].values[kept])


def draw_spectrum(ax: Axes, row: xr.Dataset, name: str) -> None:
    """Draw the amplitudes of one row on a log axis; what is rounding error is left out."""
    largest = float(np.nanmax(row[f"{name}_amplitude"].values, initial=0.0))
    shown = np.concatenate([values for _, values in lines_of(row, name)])
    shown = shown[shown > FLOOR * largest]
    # subharmonics may be larger than all harmonics
    top = 3.0 * float(shown.max(initial=0.0) or 1.0)
    floor = 0.3 * float(shown.min(initial=largest or 1.0))
    for (at, values), style in zip(lines_of(row, name), STEMS, strict=True):
        kept = (values > floor) & (at < row.sizes["harmonic"] + 0.5)
        ax.vlines(at[kept], floor, values[kept], color=style["color"], linewidth=1.2)
        ax.plot(at[kept], values[kept], linestyle="none", markersize=3.6, **style)
    ax.set(yscale="log", ylim=(floor, top), xlim=(0, row.sizes["harmonic"] + 0.5))
    ax.xaxis.set_major_locator(MaxNLocator(integer=True, nbins=8))


def spectrum_handles(dataset: xr.Dataset) -> list[Line2D]:
    """Return legend entries of harmonics and, if the data have any, of subharmonics."""
    symbol = rf"\{frequency(dataset)}"
    texts = [f"harmonics, multiples of ${symbol}$"]
    between = (f"subharmonic_{name}_amplitude" for name in ("displacement", "velocity"))
    if any(bool(dataset[name].notnull().any()) for name in between if name in dataset):
        texts.append(f"subharmonics, multiples of ${symbol}/m$")
    return [
        Line2D([], [], markersize=4, **style, label=text)
        for style, text in zip(STEMS, texts, strict=False)
    ]
