"""Names at the lines of branches: values of the further parameter, or motions in words."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from vibropipe.figures.line_names import Named, label_lines, with_places
from vibropipe.figures.motion_words import words_of
from vibropipe.figures.text import value_text
from vibropipe.scenes.branch.lines import Piece, colour_of, swept

Curve = tuple[np.ndarray, np.ndarray]


def line_names(dataset: xr.Dataset, pieces: Sequence[Piece]) -> list[str]:
    """Return what is written at the line of each piece: the value of the further parameter, or the motion in words."""
    over = swept(dataset)
    if over:
        return [value_text(dataset[over], piece.value) for piece in pieces]
    return [words_of(dataset.isel(point=piece.points.start)) for piece in pieces]


def write_names(
    ax: Axes,
    x: np.ndarray,
    y: np.ndarray,
    pieces: Sequence[Piece],
    names: Sequence[str],
    colours: Mapping[Any, str],
    obstacles: Iterable[Curve] = (),
    *more: Named,
    told: Collection[str] = (),
) -> set[str]:
    """Write each name at the widest stable piece that has it, and return those that are written.

    Words of motions, which are long, stand only beside it, and so do values that another panel names.

    obstacles, more : other curves, from which names keep away, and further lines with theirs
    told : names that stand in another panel
    """
    are_values = len({piece.value for piece in pieces}) > 1
    limits, lines = ax.get_xlim(), [*more]
    curves = [
        (piece, name, with_places(x[piece.points]), with_places(values))
        for piece, name in zip(pieces, names, strict=True)
        for values in y[piece.points].T
        if np.isfinite(values).any()
    ]
    for name in dict.fromkeys(names):
        own = [n for n, (piece, its, *_) in enumerate(curves) if its == name and piece.is_stable]
        if own:
            widest = max(own, key=lambda n: np.ptp(np.clip(curves[n][2], *limits)))
            piece, _, at, values = curves.pop(widest)
            colour = colour_of(colours, piece.law, piece.value)
            lines.append(Named(at, values, name, colour, are_values and name not in told))
    written = label_lines(ax, lines, [*obstacles, *((at, y) for _, _, at, y in curves)])
    return {text.get_text() for text in written}
