"""Level curves in pictures and texts of boundaries: their quantities in words, and their values on the lines."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.text import Text

from vibropipe.figures.canvas import label_region
from vibropipe.figures.text import symbol_of
from vibropipe.scenes.design.data import in_words, shown_goals
from vibropipe.solve.rows.named import named
from vibropipe.words.quantities import QUANTITIES

# Shares of a curve at which its label is tried, and at which it stands without room.
PLACES, MIDDLE = (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8), 0.5
# Curves of a level that have a label: the longest.
LABELLED_CURVES = 3


# Distance of the ends of two pieces of one curve, as a share of what is drawn.
TOUCHING = 1e-5


class ShownLevel(NamedTuple):
    """A level: its quantity in words and as mathtext, and its value with the unit shown."""

    words: str
    symbol: str
    value: str

    @property
    def text(self) -> str:
        """The level in words."""
        return f"{self.words} = {self.value}"


def shown_levels(dataset: xr.Dataset) -> list[ShownLevel]:
    """Return the levels that were sought, by their number."""
    levels = []
    for name, text in shown_goals(dataset, "levels"):
        quantity = named(name, "levels")
        record, dims = QUANTITIES[quantity.variable], QUANTITIES[quantity.variable].dims
        words = in_words(
            quantity.variable, record.long_name, dims[0] if dims else "", quantity.number or 0
        )
        array = xr.DataArray(0.0, name=quantity.variable)
        symbol = symbol_of(array, quantity.number)
        if quantity.number and symbol == symbol_of(array):
            symbol += f" at {dims[0]} {quantity.number}"
        levels.append(ShownLevel(words, symbol, text.removeprefix("= ")))
    return levels


def level_numbers(dataset: xr.Dataset) -> Iterator[tuple[int, ShownLevel]]:
    """Yield the number and the words of each level that has curves."""
    present = set(np.unique(dataset["level_of"].values)) if "level_of" in dataset else set()
    for number, level in enumerate(shown_levels(dataset)):
        if number in present:
            yield number, level


def joined_curves(dataset: xr.Dataset, number: int, x: str, y: str) -> list[list[int]]:
    """Return the curves of a level as lists of their pieces: where the law of motion changes, a next piece begins."""
    ids = dataset["curve_id"].values
    groups: list[tuple[list[int], np.ndarray]] = []
    size = np.array([float(np.ptp(dataset[name].values)) or 1.0 for name in (x, y)])
    for curve in np.unique(ids[dataset["level_of"].values == number]).tolist():
        points = np.flatnonzero(ids == curve)[[0, -1]]
        ends = np.column_stack([dataset[name].values[points] for name in (x, y)]) / size
        near = [
            bool(np.abs(ends[:, None] - known).max(axis=-1).min() <= TOUCHING)
            for _, known in groups
        ]
        joined = [group for group, is_near in zip(groups, near, strict=True) if is_near]
        groups = [group for group, is_near in zip(groups, near, strict=True) if not is_near]
        pieces = [piece for other, _ in joined for piece in other]
        groups.append(([*pieces, curve], np.concatenate([*(known for _, known in joined), ends])))
    return [pieces for pieces, _ends in groups]


def label_levels(ax: Axes, dataset: xr.Dataset, x: str, y: str) -> list[Text]:
    """Write the value of each level on the longest of its curves; return the labels."""
    labels: list[Text] = []
    ids = dataset["curve_id"].values
    for number, level in level_numbers(dataset):
        curves = []
        for pieces in joined_curves(dataset, number, x, y):
            longest = max(pieces, key=lambda piece: int((ids == piece).sum()))
            points = np.flatnonzero(ids == longest)
            data = np.column_stack([dataset[x].values[points], dataset[y].values[points]])
            drawn = ax.transData.transform(data)
            steps = np.hypot(*np.diff(drawn, axis=0).T)
            curves.append((float(steps.sum()), drawn, np.concatenate([[0.0], steps.cumsum()])))
        curves.sort(key=lambda each: -each[0])
        for n, (_length, drawn, passed) in enumerate(curves[:LABELLED_CURVES]):
            text = f"{level.symbol} = {level.value}"
            label = _label(ax, drawn, passed, text, labels, is_needed=n == 0)
            labels += [] if label is None else [label]
    return labels


def _label(
    ax: Axes, drawn: np.ndarray, passed: np.ndarray, text: str, labels: list[Text], is_needed: bool
) -> Text | None:
    """Write a label on a curve where it covers no other one and stays inside the axes; None if it has no room.

    drawn, passed : (n, 2) points of the curve on the canvas, and (n,) its length up to each
    is_needed : whether it is written in the middle of the curve without room
    """
    frame = ax.get_window_extent()
    for share in (*PLACES, MIDDLE):
        at = [np.interp(share * passed[-1], passed, drawn[:, k]) for k in (0, 1)]
        x, y = ax.transAxes.inverted().transform(at)
        label = label_region(ax, x, y, text, transform=ax.transAxes)
        label.set_zorder(7)
        box = label.get_window_extent()
        inside = frame.x0 < box.x0 and box.x1 < frame.x1 and frame.y0 < box.y0 and box.y1 < frame.y1
        is_free = not any(box.overlaps(other.get_window_extent()) for other in labels)
        if inside and is_free and box.width < passed[-1]:
            return label
        label.remove()
    if not is_needed:
        return None
    return label_region(ax, x, y, text, transform=ax.transAxes, zorder=7)
