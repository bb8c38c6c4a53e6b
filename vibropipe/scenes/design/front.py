"""The picture of a front of two quantities: its designs, and the motions of the sweep behind it."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from vibropipe.figures.canvas import SMALL, axes, new_canvas
from vibropipe.figures.palette import EXACT, INK, shades
from vibropipe.figures.style import LINE_MARKERS
from vibropipe.figures.text import sentences
from vibropipe.scenes.design.data import ends_of, struck_texts, wanted_text
from vibropipe.solve.rows.named import OF_CONTACTS

HEIGHT = 8.8
CLOUD = "#9C9C9C"
MARKER = 5.0  # pt


def draw_front(dataset: xr.Dataset) -> Figure:
    """Draw the second quantity over the first: the front, and the motions of the sweep behind it."""
    (first, _), (second, _) = ends_of(dataset)
    figure = new_canvas(HEIGHT)
    ax = axes(figure, 1.5, 1.2, 11.6, HEIGHT - 1.6)
    cloud = swept(dataset)
    ax.plot(
        *cloud.T, ".", color=CLOUD, markersize=2.4, markeredgewidth=0, zorder=0, rasterized=True
    )
    x, y = first.of(dataset).values, second.of(dataset).values
    ax.plot(x, y, color=INK, linewidth=0.6, zorder=1)
    laws = struck_texts(dataset)
    kinds = list(dict.fromkeys(laws))
    for n, (law, colour) in enumerate(zip(kinds, shades(len(kinds)), strict=True)):
        chosen = np.array([each == law for each in laws])
        marker = LINE_MARKERS[n % len(LINE_MARKERS)]
        style: dict[str, Any] = {"color": colour, "markeredgecolor": EXACT, "markeredgewidth": 0.5}
        label = law.removesuffix(" periods")
        ax.plot(x[chosen], y[chosen], marker, markersize=MARKER, label=label, **style)
    number(ax, dataset, x, y)
    ax.set_xlabel(axis_text(dataset, 0))
    ax.set_ylabel(axis_text(dataset, 1))
    ax.margins(0.05)
    ax.legend(
        title="impacts, support 1 +\nsupport 2, in a period\nor in several", loc="upper left", fontsize=SMALL,
        bbox_to_anchor=(1.02, 1.0), borderaxespad=0.0, frameon=False, title_fontsize=SMALL, alignment="left",
    )  # fmt: skip
    return figure


def number(ax: Axes, dataset: xr.Dataset, x: np.ndarray, y: np.ndarray) -> None:
    """Write the numbers of designs on the side of the front where nothing else can lie, or else beside that.

    Those of the ends come first; one without room is left out, since the designs are numbered along the front.
    """
    signs = [sign for _, sign in ends_of(dataset)]
    ha, va = "right" if signs[0] > 0 else "left", "top" if signs[1] > 0 else "bottom"
    other = "left" if ha == "right" else "right"
    places = ((-3.0, -2.0, ha), (0.0, -4.0, "center"), (3.0, -2.0, other))
    ax.autoscale_view()  # matplotlib puts it off until the limits are asked for
    at, half = ax.transData.transform(np.column_stack([x, y])), 0.4 * MARKER / 72 * ax.figure.dpi
    boxes = [Bbox([point - half, point + half]) for point in at]
    last = x.size - 1
    for n in sorted(range(x.size), key=lambda n: (n not in (0, last), n)):
        for right, up, side in places:
            text = ax.annotate(
                str(n + 1), (x[n], y[n]), (right * signs[0], up * signs[1]), textcoords="offset points",
                fontsize=SMALL, ha=side, va=va,
            )  # fmt: skip
            box = text.get_window_extent()
            if not any(box.overlaps(each) for each in boxes):
                boxes.append(box)
                break
            text.remove()


def axis_text(dataset: xr.Dataset, which: int) -> str:
    """Write what an axis shows, and in which direction it is better."""
    part, sign = ends_of(dataset)[which]
    text = part.label_text(dataset)
    return f"← better   {text}" if sign > 0 else f"{text}   better →"


def title_front(dataset: xr.Dataset) -> str:
    """Return the title of the front: whether a motion of the sweep beats it."""
    amount = len(swept(dataset))
    if not amount:
        return "What is better in one quantity is worse in the other"
    motions = "swept motions with impacts" if has_contacts(dataset) else "swept motions"
    if better := beating(dataset):
        beat = "beats" if better == 1 else "beat"
        return f"{better:,} of {amount:,} {motions} {beat} a design of the front"
    return f"None of {amount:,} {motions} beats a design of the front"


def has_contacts(dataset: xr.Dataset) -> bool:
    """Return whether a quantity of the front is one of contacts: a motion without any has none."""
    return any(part.variable in OF_CONTACTS for part, _ in ends_of(dataset))


def describe_front(dataset: xr.Dataset) -> str:
    """Return the caption of the front."""
    others = wanted_text(dataset, [part.words(dataset) for part, _ in ends_of(dataset)])
    dots = "Grey: motions of a grid over the ranges"
    dots += " that keep to the bounds" * ("subject_to" in dataset.attrs)
    if has_contacts(dataset):
        dots += "; those that do not strike the support are left out"
    return sentences(
        f"Wanted: {others}" if others else "",
        dots if len(swept(dataset)) else "",
        "Markers: designs, in the order of the first quantity; between them the front is not followed",
    )


# Costs within this share of their spread are the same.
EQUAL = 1e-6


def swept(dataset: xr.Dataset) -> np.ndarray:
    """Return both quantities (n, 2) of the motions of the sweep; none where it is not stored."""
    parts = [part for part, _ in ends_of(dataset)]
    if any(f"{part.variable}_swept" not in dataset for part in parts):
        return np.empty((0, 2))
    return np.column_stack([part.of(dataset, "_swept").values for part in parts])


def beating(dataset: xr.Dataset) -> int:
    """Return how many motions of the sweep are better in both quantities than a design of the front."""
    signs = np.array([sign for _, sign in ends_of(dataset)])
    front = signs * np.column_stack([part.of(dataset).values for part, _ in ends_of(dataset)])
    cloud = signs * swept(dataset)
    room = EQUAL * np.ptp(front, axis=0)
    better = (cloud[:, None] < front[None] - room).all(axis=2)
    return int(better.any(axis=1).sum())
