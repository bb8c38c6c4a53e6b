"""Shapes in maps: the outlines of regions, and the place of a label in a region."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
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
