"""Names at the lines of branches: values of the further parameter on them, motions in words beside them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from vibropipe.figures.canvas import SMALL, size_of
from vibropipe.figures.motion_words import words_of
from vibropipe.figures.text import value_text
from vibropipe.scenes.branch.lines import Piece, swept

VALUE = "value of a line"
VALUE_STYLE: dict[str, Any] = {
    "fontsize": SMALL, "ha": "center", "va": "center", "zorder": 4, "gid": VALUE,
    "bbox": {"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.85},
}  # fmt: skip
BESIDE_STYLE: dict[str, Any] = {
    "textcoords": "offset points", "fontsize": SMALL, "ha": "center", "zorder": 4, "gid": VALUE,
}  # fmt: skip
LETTER_CM = 0.125  # of such a text
LINE_CM = 0.4  # of a line of it, with its distance from the curve
PLACES = 40  # along a text, at which lines above and below it are sought


def line_names(dataset: xr.Dataset, pieces: Sequence[Piece]) -> list[str]:
    """Return what is written at the line of each piece: the value of the further parameter, or the motion in words."""
    over = swept(dataset)
    if over:
        return [value_text(dataset[over], piece.value) for piece in pieces]
    return [words_of(dataset.isel(point=piece.points.start)) for piece in pieces]


def write_names(
    ax: Axes, x: np.ndarray, y: np.ndarray, pieces: Sequence[Piece], names: Sequence[str]
) -> None:
    """Write each name on the widest stable piece that has it, at places that differ from name to name.

    Words of motions, which are long, stand beside their line where there is room.
    """
    over = len({piece.value for piece in pieces}) > 1
    limits = ax.get_xlim()
    different = list(dict.fromkeys(names))
    for position, name in enumerate(different, 1):
        drawn = [
            piece.points
            for piece, own in zip(pieces, names, strict=True)
            if own == name and piece.is_stable and np.isfinite(y[piece.points]).any()
        ]
        if not drawn:
            continue
        seen = [np.clip([x[p].min(), x[p].max()], *limits) for p in drawn]
        widest = int(np.argmax(np.ptp(seen, axis=1)))
        piece, (low, high) = drawn[widest], seen[widest]
        if not over:
            write_beside(ax, x, y, [piece, *(each.points for each in pieces)], (low, high), name)
            continue
        at = low + position / (len(different) + 1) * (high - low)
        index = piece.start + int(np.abs(x[piece] - at).argmin())
        height = y[index][np.isfinite(y[index])]
        if height.size:
            ax.text(x[index], height[0], name, **VALUE_STYLE)


def write_beside(
    ax: Axes,
    x: np.ndarray,
    y: np.ndarray,
    lines: Sequence[slice],
    span: tuple[float, float],
    text: str,
) -> None:
    """Write a text above or below the first of some lines, where others and the frame are farthest.

    Without room, or beside a line that spans less than half of the text, it is not written.
    """
    (width, height), (left, right), (bottom, top) = size_of(ax), ax.get_xlim(), ax.get_ylim()
    half = 0.5 * LETTER_CM * len(text) * (right - left) / width
    if span[1] - span[0] < half:
        return
    middle = min(max(sum(span) / 2, left + half), right - half)
    at = np.linspace(middle - half, middle + half, PLACES)
    own, *others = (heights_at(at, x[line], y[line]) for line in lines)
    around, places = np.concatenate(others), []
    for line in own[np.isfinite(own).any(axis=1)]:
        for sign, end, frame in ((1.0, np.nanmax, top), (-1.0, np.nanmin, bottom)):
            gaps = sign * (around - end(line))
            gap = np.min(gaps[gaps > 1e-9 * np.nanmax(np.abs(y))], initial=np.inf)
            places.append((min(gap, sign * (frame - end(line))), sign, end(line)))
    gap, sign, level = max(places, default=(0.0, 1.0, 0.0))
    if gap > LINE_CM * (top - bottom) / height:
        va = "bottom" if sign > 0 else "top"
        ax.annotate(text, (middle, level), xytext=(0, 2.5 * sign), va=va, **BESIDE_STYLE)


def heights_at(at: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the heights of a line at some values of x, for each column of y; nan beyond its ends."""
    order = np.argsort(x)
    return np.array(
        [np.interp(at, x[order], y[order, n], np.nan, np.nan) for n in range(y.shape[1])]
    )
