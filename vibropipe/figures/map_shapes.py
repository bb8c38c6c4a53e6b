"""Grids and shapes of maps: cells and scales of axes, outlines of regions, the place of a label in a region."""

from __future__ import annotations

from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

Floats = NDArray[np.float64]
MIN_LOG_POINTS = 4
MIN_EVEN, OUTER_SHARE = 5, 0.05  # cells of a smaller grid reach out of it by at most this share
LONE_SHARE = 0.05  # of a single value, by which its cell reaches to either side
LABEL_MARGIN = 0.03  # of the grid that a labelled region must extend around its label


def borders(
    codes: NDArray[np.int64], x_edges: Floats, y_edges: Floats
) -> tuple[Floats, Floats] | None:
    """Return the outlines of regions of equal code as one curve with breaks; None if there is no outline.

    Speckles of one cell have no outline.

    Parameters
    ----------
    codes : (ny, nx) array of int
    x_edges, y_edges : (nx + 1,) and (ny + 1,) arrays
        Borders of the cells.
    """
    upright = _between(codes)
    level = _between(codes.T).T
    row, column = np.nonzero(upright)
    x = [x_edges[column + 1], x_edges[column + 1]]
    y = [y_edges[row], y_edges[row + 1]]
    row, column = np.nonzero(level)
    x = [np.concatenate([x[0], x_edges[column]]), np.concatenate([x[1], x_edges[column + 1]])]
    y = [np.concatenate([y[0], y_edges[row + 1]]), np.concatenate([y[1], y_edges[row + 1]])]
    if not x[0].size:
        return None
    breaks = np.full(x[0].size, np.nan)
    return np.stack([*x, breaks], axis=1).ravel(), np.stack([*y, breaks], axis=1).ravel()


def _between(codes: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return where neighbours along a row differ, while each is in a region wider than one cell."""
    differ = codes[:, 1:] != codes[:, :-1]
    wide = np.ones_like(differ)
    wide[:, 1:] &= ~differ[:, :-1]
    wide[:, :-1] &= ~differ[:, 1:]
    return differ & wide


def widest_spot(mask: NDArray[np.bool_]) -> tuple[int, int] | None:
    """Return the cell deepest inside a mask, if deep enough; the border of the map is outside.

    The mask is eroded layer by layer until nothing would remain.
    """
    remaining = mask
    for depth in range(max(mask.shape)):
        eroded = np.zeros_like(remaining)
        eroded[1:-1, 1:-1] = remaining[1:-1, 1:-1]
        eroded[1:-1, 1:-1] &= remaining[:-2, 1:-1] & remaining[2:, 1:-1]
        eroded[1:-1, 1:-1] &= remaining[1:-1, :-2] & remaining[1:-1, 2:]
        if not eroded.any():
            if depth < LABEL_MARGIN * min(mask.shape):
                return None
            rows, columns = np.nonzero(remaining)
            middle = rows.size // 2
            return int(rows[middle]), int(columns[middle])
        remaining = eroded
    return None


def cell_edges(values: np.ndarray) -> np.ndarray:
    """Return the borders half-way between ascending grid values, on the scale of their axis.

    The outer cells reach out of the grid as far as to the neighbour's cell; of fewer than MIN_EVEN values, which are
    far apart, by OUTER_SHARE of the grid at most, since nothing is known there. A single value gets a narrow cell.
    """
    if values.size == 1:
        reach = LONE_SHARE * (abs(values[0]) or 1.0)
        return np.array([values[0] - reach, values[0] + reach])
    if scale_of(values) == "log":
        return np.exp(cell_edges(np.log(values)))
    middle = 0.5 * (values[1:] + values[:-1])
    reach = OUTER_SHARE * (values[-1] - values[0]) if values.size < MIN_EVEN else np.inf
    first = values[0] - min(middle[0] - values[0], reach)
    last = values[-1] + min(values[-1] - middle[-1], reach)
    return np.concatenate([[first], middle, [last]])


def scale_of(values: np.ndarray) -> Literal["linear", "log"]:
    """Return the scale of an axis: log if its values grow by a constant factor."""
    if values.size < MIN_LOG_POINTS or values.min() <= 0.0 or values.max() < 5.0 * values.min():
        return "linear"
    steps = np.diff(np.log(np.sort(values)))
    return "log" if np.ptp(steps) <= 1e-6 * steps.mean() else "linear"


def frame(ax: Axes) -> None:
    """Draw all four sides of the frame."""
    for side in ("top", "right"):
        ax.spines[side].set_visible(True)
