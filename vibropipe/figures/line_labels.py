"""Names of lines, each written on its line where it is far from the others."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from vibropipe.figures.canvas import CM_PER_INCH, label, size_of

Floats = NDArray[np.float64]
PLACES = 48  # that are tried along a line
ENOUGH = 0.8  # cm of clearance beyond which a place is no better
MARGIN = 0.12  # cm around a label
ON_LINE = {"boxstyle": "square,pad=0.08", "facecolor": "white", "edgecolor": "none"}


@dataclass(frozen=True)
class Named:
    """A line with its name; points that are not finite are gaps."""

    x: Floats
    y: Floats
    text: str
    colour: str


def label_lines(
    ax: Axes, lines: Sequence[Named], obstacles: Iterable[tuple[Floats, Floats]] = ()
) -> None:
    """Write the name of each line on it, with white below; lines without a place of their own have no name.

    Parameters
    ----------
    ax : Axes
        Where the lines are drawn, with their scales and limits.
    lines : sequence of Named
        The lines; the first ones choose first.
    obstacles : iterable of (x, y)
        Other curves, from which names keep away.
    """
    size = np.array(size_of(ax))
    points = [_in_cm(ax, line.x, line.y, size) for line in lines]
    others = [_in_cm(ax, x, y, size) for x, y in obstacles]
    boxes: list[Floats] = []
    for number, (line, own) in enumerate(zip(lines, points, strict=True)):
        half = _half_size(ax, line.text)
        inside = own[((own > half) & (own < size - half)).all(axis=1)]
        if not inside.size:
            continue
        tried = inside[np.unique(np.linspace(0, len(inside) - 1, PLACES).astype(int))]
        rest = [*(p for n, p in enumerate(points) if n != number), *others]
        clearance = np.minimum(_distance(tried, half, rest), ENOUGH)
        middle = 0.02 * np.abs(tried - size / 2).sum(axis=1) / size.sum()
        free = _is_free(tried, half, boxes)
        if not free.any():
            continue
        at = tried[int(np.argmax(np.where(free, clearance - middle, -np.inf)))]
        boxes.append(np.array([at - half, at + half]))
        x, y = at / size
        label(ax, x, y, line.text, line.colour, transform=ax.transAxes, ha="center",
              va="center_baseline", bbox=ON_LINE, zorder=6)  # fmt: skip


def _in_cm(ax: Axes, x: Floats, y: Floats, size: Floats) -> Floats:
    """Return the finite points of a line within its axes, in centimetres from their corner, (n, 2)."""
    kept = np.isfinite(x) & np.isfinite(y)
    points = np.stack([x[kept], y[kept]], axis=1)
    shown = ax.transAxes.inverted().transform(ax.transData.transform(points)) * size
    return shown[((shown >= 0) & (shown <= size)).all(axis=1)]


def _half_size(ax: Axes, text: str) -> Floats:
    """Return half the width and height of a label in centimetres."""
    drawn = label(ax, 0.5, 0.5, text, transform=ax.transAxes)
    box = drawn.get_window_extent()
    drawn.remove()
    return np.array([box.width, box.height]) / ax.figure.dpi * CM_PER_INCH / 2 + MARGIN


def _distance(at: Floats, half: Floats, others: Sequence[Floats]) -> Floats:
    """Return how far the box of a label is from all points of other lines."""
    found = np.full(len(at), ENOUGH)
    for points in others:
        if len(points):
            gap = np.maximum(np.abs(at[:, None] - points[None]) - half, 0.0)
            found = np.minimum(found, np.hypot(gap[..., 0], gap[..., 1]).min(axis=1))
    return found


def _is_free(at: Floats, half: Floats, boxes: Sequence[Floats]) -> NDArray[np.bool_]:
    """Return whether a label overlaps no other one."""
    free = np.ones(len(at), np.bool_)
    for low, high in boxes:
        free &= ((at + half < low) | (at - half > high)).any(axis=1)
    return free
