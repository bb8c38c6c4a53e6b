"""What the colours, the marks and the lines of a plane mean, in words."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

import numpy as np

from vibropipe.scenes.sweep.quantities import Series
from vibropipe.view.plane import Plane, Region

# Marks of slices: what Bokeh calls them, and as letters.
MARKERS, LETTERS = ("circle", "triangle", "inverted_triangle", "square"), "●▲▼■"
# Strokes and gaps of the dashes that Bokeh names, in pixels.
STROKES = {"solid": "", "dashed": "6", "dotted": "2 4", "dashdot": "2 4 6 4"}
SIGNS = {
    "circle": "○", "square": "□", "diamond": "◇", "triangle": "△", "inverted_triangle": "▽",
    "x": "×", "star": "☆",
}  # fmt: skip
LEGEND_CSS = """
.legend {font-size: 11px; line-height: 1.3}
.legend div {padding-left: 28px; text-indent: -28px}
.legend i {display: inline-block; width: 22px; height: 9px; margin-right: 6px; text-indent: 0; font-style: normal;
           text-align: center; line-height: 9px}
.legend .area {border: 1px solid #333333; box-sizing: border-box}
"""


def legend_html(parts: Iterable[str]) -> str:
    """Return a legend as HTML; each part is a line of it."""
    return f'<div class="legend">{"".join(parts)}</div>'


def region_lines(regions: Iterable[Region]) -> list[str]:
    """Return a line for each region: its colour and its text."""
    return [
        f'<div><i class="area" style="background: {each.colour}"></i>{escape(each.text)}</div>'
        for each in regions
    ]


def regions_shown(plane: Plane) -> list[Region]:
    """Return the regions that a plane shows, the largest first."""
    others = [{"direction": n} if each else {} for n, each in enumerate(plane.directions)]
    codes = np.concatenate([plane.codes(**each).ravel() for each in others])
    sizes = np.bincount(codes, minlength=len(plane.regions))
    return [plane.regions[n] for n in np.argsort(-sizes, kind="stable") if sizes[n]]


def mark_lines(plane: Plane, chosen: list[Series]) -> list[str]:
    """Return a line for each mark of slices, where there are several."""
    names = [
        " ".join(filter(None, [f"{one.dim} {one.position + 1}" if one.position is not None else "", direction]))
        for one in chosen
        for direction in plane.directions
    ]  # fmt: skip
    if len(names) < 2:
        return []
    return [
        f"<div><i>{LETTERS[n % len(LETTERS)]}</i>{escape(name)}</div>"
        for n, name in enumerate(names)
    ]


def stroke_line(text: str, colour: str, dash: str, width: float) -> str:
    """Return the line of a curve."""
    look = f'stroke="{colour}" stroke-width="{width}" stroke-dasharray="{STROKES[dash]}"'
    drawn = f'<svg width="22" height="10"><path d="M0 5H22" {look}/></svg>'
    return f"<div><i>{drawn}</i>{escape(text)}</div>"


def sign_line(text: str, marker: str) -> str:
    """Return the line of a mark on a map."""
    return f"<div><i>{SIGNS[marker]}</i>{escape(text)}</div>"
