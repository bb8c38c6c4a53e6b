"""Grids and shapes of maps: cells and scales of axes, outlines of regions, the place of a label in a region."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.text import Text
from numpy.typing import NDArray

from vibropipe.figures.canvas import CM_PER_INCH, label_region, size_of
from vibropipe.figures.palette import INK

STEP = 0.1  # cm between the points at which a map is looked at
WIDE_ENOUGH = 0.97  # share of a label within its region at which no narrower text is tried
IN_PLACE = 0.85  # share from which a label stands in its region: a region of speckles is never full
CENTRED = 1e-3  # of the score, for a label that is off the middle of its region by a whole map
AROUND = 6  # steps around a label that count for its place
GAP = 3  # steps between labels

# From a dot in a region to a label beside it, seen on light and dark.
LEADER: Mapping[str, Any] = {
    "color": INK,
    "linewidth": 0.6,
    "marker": "o",
    "markersize": 2.4,
    "markevery": [0],
    "zorder": 4,
    "path_effects": [withStroke(linewidth=2.0, foreground="white")],
}
Integers = NDArray[np.integer]
Spot = tuple[float, int, int]  # score, lowest row, first column


def label_regions(
    ax: Axes,
    codes: Integers,
    edges: tuple[NDArray[np.float64], NDArray[np.float64]],
    texts: Mapping[int, Sequence[str]],
) -> None:
    """Write the name of each region on white, the largest region first; labels do not overlap.

    ax : where the map is drawn, with its scales and limits
    codes, edges : (ny, nx) region of each cell, (nx + 1,) and (ny + 1,) borders of the cells
    texts : texts of a region, the preferred one first; the last one stands beside regions without room
    """
    seen = _seen(ax, codes, edges)
    taken = np.zeros(seen.shape, np.bool_)
    sizes = {code: int((seen == code).sum()) for code in texts}
    beside = []
    for code in sorted(sizes, key=lambda code: -sizes[code]):
        own = seen == code
        found = [(text, *_best(own, taken, _cells(ax, text))) for text in texts[code]]
        enough = [each for each in found if each[1] >= WIDE_ENOUGH]
        text, share, spot = enough[0] if enough else max(found, key=lambda each: each[1])
        if share >= IN_PLACE:
            _write(ax, seen.shape, spot, text, taken)
        elif own.any():
            beside.append(code)
    for code in beside:
        _write_beside(ax, seen, seen == code, texts[code][-1], taken)


def _seen(
    ax: Axes, codes: Integers, edges: tuple[NDArray[np.float64], NDArray[np.float64]]
) -> Integers:
    """Return the codes at points of the axes STEP apart, in the order of the cells."""
    indices = []
    for axis, (size, border) in enumerate(zip(size_of(ax), edges, strict=True)):
        amount = max(1, int(size / STEP))
        points = np.full((amount, 2), 0.5)
        points[:, axis] = (np.arange(amount) + 0.5) / amount
        data = ax.transData.inverted().transform(ax.transAxes.transform(points))[:, axis]
        indices.append(np.clip(np.searchsorted(border, data) - 1, 0, border.size - 2))
    return codes[np.ix_(indices[1], indices[0])]


def _cells(ax: Axes, text: str) -> tuple[int, int]:
    """Return how many steps a label is high and wide."""
    drawn = label_region(ax, 0.5, 0.5, text, transform=ax.transAxes)
    box = drawn.get_window_extent()
    drawn.remove()
    step = STEP / CM_PER_INCH * ax.figure.dpi
    return int(np.ceil(box.height / step)) + 3, int(np.ceil(box.width / step)) + 3


def _window_sums(mask: NDArray[np.bool_], size: tuple[int, int]) -> NDArray[np.int64]:
    """Return the number of true cells of each window of a size."""
    sums = np.pad(mask.astype(np.int64).cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    high, wide = size
    return sums[high:, wide:] - sums[:-high, wide:] - sums[high:, :-wide] + sums[:-high, :-wide]


def _best(
    own: NDArray[np.bool_], taken: NDArray[np.bool_], size: tuple[int, int]
) -> tuple[float, tuple[int, int, int, int]]:
    """Return the share of a label within its region at its best place, and the place: row, column, size."""
    if size[0] > own.shape[0] or size[1] > own.shape[1]:
        return 0.0, (0, 0, *size)
    share = _window_sums(own, size) / (size[0] * size[1])
    grown = (size[0] + 2 * AROUND, size[1] + 2 * AROUND)
    around = _window_sums(np.pad(own, AROUND), grown) / (grown[0] * grown[1])
    score = np.where(_window_sums(taken, size) > 0, -1.0, share + 0.5 * around)
    score -= CENTRED * _distance_from_middle(own, size)  # of places that are as good
    row, column = np.unravel_index(int(np.argmax(score)), score.shape)
    is_free = score[row, column] >= 0.0
    return float(share[row, column]) if is_free else 0.0, (int(row), int(column), *size)


def _distance_from_middle(own: NDArray[np.bool_], size: tuple[int, int]) -> NDArray[np.float64]:
    """Return how far each window of a size is from the middle of a region, as a share of the map."""
    rows, columns = np.indices([n - wide + 1 for n, wide in zip(own.shape, size, strict=True)])
    row, column = (axis.mean() for axis in np.nonzero(own)) if own.any() else (0.0, 0.0)
    away = rows + size[0] / 2 - row, columns + size[1] / 2 - column
    return np.hypot(*away) / sum(own.shape)


def _write(
    ax: Axes,
    shape: tuple[int, ...],
    spot: tuple[int, int, int, int],
    text: str,
    taken: NDArray[np.bool_],
) -> Text:
    """Write a label at its place, which is taken from then on."""
    row, column, high, wide = spot
    taken[max(0, row - GAP) : row + high + GAP, max(0, column - GAP) : column + wide + GAP] = True
    x, y = (column + wide / 2) / shape[1], (row + high / 2) / shape[0]
    return label_region(ax, x, y, text, transform=ax.transAxes)


def _write_beside(
    ax: Axes, seen: Integers, own: NDArray[np.bool_], text: str, taken: NDArray[np.bool_]
) -> None:
    """Write a label in another region near its own, with a line from the label to the own region."""
    from scipy.ndimage import distance_transform_edt  # slow to import; few maps have a use for it

    depth = distance_transform_edt(np.pad(own, 1))[1:-1, 1:-1]
    at = np.unravel_index(int(np.argmax(depth)), own.shape)
    size = _cells(ax, text)
    if size[0] > own.shape[0] or size[1] > own.shape[1]:
        return
    area = size[0] * size[1]
    even = np.max([_window_sums(seen == code, size) for code in np.unique(seen)], axis=0) / area
    rows, columns = np.indices(even.shape)
    row_gap = np.maximum(0, np.maximum(rows - at[0], at[0] - rows - size[0]))
    column_gap = np.maximum(0, np.maximum(columns - at[1], at[1] - columns - size[1]))
    distance = np.hypot(row_gap, column_gap)
    # speckles and borders under a label cost as much as a longer line, the own region and labels more than any
    cost = distance + 60.0 * (1.0 - even) + 400.0 * _window_sums(own, size) / area
    cost[(_window_sums(taken, size) > 0) | (distance < GAP)] = np.inf
    row, column = (int(n) for n in np.unravel_index(int(np.argmin(cost)), cost.shape))
    if not np.isfinite(cost[row, column]):
        return
    middle = (column + size[1] / 2, row + size[0] / 2)  # the line passes under the label
    points = np.array([[at[1] + 0.5, at[0] + 0.5], middle]) / [own.shape[1], own.shape[0]]
    ax.plot(*points.T, **LEADER, transform=ax.transAxes)
    _write(ax, own.shape, (row, column, *size), text, taken)


Floats = NDArray[np.float64]
MIN_LOG_POINTS = 4
MIN_EVEN, OUTER_SHARE = 5, 0.05  # cells of a smaller grid reach out of it by at most this share
LONE_SHARE = 0.05  # of a single value, by which its cell reaches to either side
LONE_MARGIN = 4.5  # widths of a lone cell that are left free on either side
LABEL_MARGIN = 0.03  # of the grid that a labelled region must extend around its label


def borders(
    codes: NDArray[np.int64], x_edges: Floats, y_edges: Floats
) -> tuple[Floats, Floats] | None:
    """Return the outlines of regions of equal code as one curve with breaks; None if there is no outline.

    codes : (ny, nx); edges : (nx + 1,) and (ny + 1,). Speckles of one cell have no outline.
    """
    rows, columns = np.diff(codes, axis=0) == 0, np.diff(codes, axis=1) == 0
    together = np.zeros(codes.shape, bool)
    together[1:] |= rows
    together[:-1] |= rows
    together[:, 1:] |= columns
    together[:, :-1] |= columns
    upright = ~columns & together[:, 1:] & together[:, :-1]
    level = ~rows & together[1:] & together[:-1]
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


def widest_spot(mask: NDArray[np.bool_]) -> tuple[int, int] | None:
    """Return the cell deepest inside a mask, if deep enough; the border of the map is outside."""
    from scipy.ndimage import distance_transform_cdt  # slow to import

    depth = distance_transform_cdt(np.pad(mask, 1), "taxicab")[1:-1, 1:-1]
    if depth.max() - 1 < LABEL_MARGIN * min(mask.shape):
        return None
    rows, columns = np.nonzero(depth == depth.max())
    middle = rows.size // 2
    return int(rows[middle]), int(columns[middle])


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


def with_margin(edges: np.ndarray) -> tuple[float, float]:
    """Return the limits of an axis with the borders of cells: a lone one that filled it would claim a range."""
    margin = LONE_MARGIN * (edges[-1] - edges[0]) if edges.size == 2 else 0.0
    return float(edges[0] - margin), float(edges[-1] + margin)


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
