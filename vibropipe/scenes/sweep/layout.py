"""Where the panels of curves stand: one large and small ones beside it, a stack, or small multiples; bars below."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibropipe.figures.canvas import BODY, SMALL, WIDE, axes, new_canvas
from vibropipe.figures.canvas import panel as write_title
from vibropipe.figures.map_shapes import scale_of
from vibropipe.scenes.sweep.map_layout import combination_text
from vibropipe.scenes.sweep.quantities import Panel, wrapped
from vibropipe.scenes.sweep.sweep_rows import combinations, evenly

LEFT, RIGHT, BETWEEN = 1.55, 0.25, 1.0  # cm left of the panels, right of them, between columns
TITLE, LABELS = 0.62, 1.0  # cm above a panel, below the lowest axes
HEAD = 0.45  # cm of the combination above several panels
MAIN_CM, SIDE_CM = 8.6, 4.6  # widths of the large panel and of those beside it
BAR_CM, BARS_GAP = 0.36, 0.25  # height of a bar of regimes, gap above the bars
MAX_SIDE, MAX_PANELS, MAX_COLUMNS, MAX_MULTIPLES = 4, 12, 3, 12
# Height of a stack of panels, of one in columns, of small multiples, and from which these fill more than page 1 has.
STACK_CM, GRID_CM, SMALL_CM, LEAST_CM = 8.4, 2.5, 3.0, 1.7
HERO_CM, PAGE_CM = 15.0, 20.0  # height of a picture that fits on page 1, and on another page
LETTERS_PER_CM = 7.5  # of SMALL type
LABEL_LINES = 2.5  # of a label along an axis: three, broken between words
MARGIN = 0.18  # cm between a line and the end of its axis, which would hide it


@dataclass(frozen=True)
class Spot:
    """A panel with its rows: place in cm from the lower left corner of the figure, and titles."""

    panel: Panel
    part: xr.Dataset
    left: float
    bottom: float
    width: float
    height: float
    title: str = ""
    is_inner: bool = False  # right of another one that has the same ordinate
    head: str = ""  # above the title

    @property
    def words_cm(self) -> float:
        """Room for what is drawn: a line above the panel or, beside a title of its own, LABEL_LINES along the axis."""
        return LABEL_LINES * self.height if self.title else self.width - 0.2


@dataclass(frozen=True)
class Bars:
    """The bars of regimes below a column: rows, place in cm, and whether they have names."""

    part: xr.Dataset
    left: float
    bottom: float
    width: float
    is_first: bool


@dataclass(frozen=True)
class Layout:
    """A figure with its panels and bars; the first panel is the largest."""

    figure: Figure
    spots: list[Spot]
    bars: list[Bars]


def combinations_drawn(dataset: xr.Dataset, dims: Sequence[str]) -> list[dict[str, int]]:
    """Return the combinations of further parameters that are drawn."""
    return evenly(combinations(dataset, list(dims)), MAX_MULTIPLES)


def fitting_panels(
    dataset: xr.Dataset, dims: Sequence[str], panels: Sequence[Panel]
) -> list[Panel]:
    """Return the panels that are drawn: all, or of several combinations as many as fit on a page.

    Higher harmonics are left out before other quantities.
    """
    amount = len(combinations_drawn(dataset, dims))
    most = MAX_PANELS if amount == 1 else 4 if amount <= MAX_COLUMNS else 1
    kept = sorted(panels, key=lambda panel: panel.is_higher_harmonic)[:most]
    return [panel for panel in panels if panel in kept]


def lay_out(
    dataset: xr.Dataset,
    dims: Sequence[str],
    panels: Sequence[Panel],
    lines: int,
    stacked: bool,
    below: float,
) -> Layout:
    """Return the figure and the places of its panels.

    dims : parameters beyond those of abscissa and lines: each combination of their values has its panels
    panels : those of `fitting_panels`
    lines : number of bars below each column
    stacked : whether panels stand one above the other in full width
    below : room for a legend at the bottom (cm)
    """
    found = combinations_drawn(dataset, dims)
    foot = below + LABELS + lines * BAR_CM
    if len(found) > 1:
        return _multiples(dataset, found, panels, foot, lines)
    part = dataset.isel(found[0])
    if stacked or len(panels) <= 1:
        return _stack(part, panels, foot)
    if len(panels) <= 1 + MAX_SIDE:
        return _beside(part, panels, foot, lines)
    return _columns(part, panels, foot)


def _stack(part: xr.Dataset, panels: Sequence[Panel], foot: float) -> Layout:
    width, amount = WIDE - LEFT - RIGHT, len(panels)
    height = max(1.7, STACK_CM / amount - TITLE) if amount else 0.0
    rise = height + TITLE
    figure = new_canvas(foot + BARS_GAP + amount * rise)
    spots = [
        Spot(panel, part, LEFT, foot + BARS_GAP + (amount - 1 - n) * rise, width, height)
        for n, panel in enumerate(panels)
    ]  # fmt: skip
    return Layout(figure, spots, [Bars(part, LEFT, foot, width, True)])


def _beside(part: xr.Dataset, panels: Sequence[Panel], foot: float, lines: int) -> Layout:
    """Place the first panel at the left above the bars, the others in a column at the right."""
    first, *others = panels
    high = max(9.2, foot + BARS_GAP + 5.0 + TITLE)
    figure = new_canvas(high)
    bottom = foot + BARS_GAP
    spots = [Spot(first, part, LEFT, bottom, MAIN_CM, high - bottom - TITLE)]
    low = foot - lines * BAR_CM
    rise = (high - low) / len(others)
    for n, panel in enumerate(others):
        at = low + (len(others) - 1 - n) * rise
        spots.append(Spot(panel, part, WIDE - RIGHT - SIDE_CM, at, SIDE_CM, rise - TITLE - 0.1))
    return Layout(figure, spots, [Bars(part, LEFT, foot, MAIN_CM, True)])


def _columns(part: xr.Dataset, panels: Sequence[Panel], foot: float) -> Layout:
    """Place many panels in two columns, each above its bars."""
    down = -(-len(panels) // 2)
    width = (WIDE - LEFT - RIGHT - BETWEEN) / 2
    rise = GRID_CM + TITLE - (0.4 if down > 4 else 0.0)
    figure = new_canvas(foot + BARS_GAP + down * rise)
    spots, bars = [], []
    for n, panel in enumerate(panels):
        column, row = divmod(n, down)
        left = LEFT + column * (width + BETWEEN)
        bottom = foot + BARS_GAP + (down - 1 - row) * rise
        spots.append(Spot(panel, part, left, bottom, width, rise - TITLE))
    for column in range(2):
        bars.append(Bars(part, LEFT + column * (width + BETWEEN), foot, width, column == 0))
    return Layout(figure, spots, bars)


def _multiples(
    dataset: xr.Dataset,
    found: list[dict[str, int]],
    panels: Sequence[Panel],
    foot: float,
    lines: int,
) -> Layout:
    """Place a column of panels above its bars for each combination, at most MAX_COLUMNS beside each other."""
    across = 2 if len(found) in (2, 4) else MAX_COLUMNS
    down = -(-len(found) // across)
    gap = 0.55
    width = (WIDE - LEFT - RIGHT - (across - 1) * gap) / across
    own = LABELS + lines * BAR_CM + BARS_GAP  # beside the panels of a row
    own += HEAD * (len(panels) > 1)
    heights = [
        (high - foot - down * (own + 0.4)) / (down * max(1, len(panels))) - TITLE
        for high in (HERO_CM, PAGE_CM)
    ]
    height = min(SMALL_CM, max(heights[0], min(LEAST_CM, heights[1])))
    rise = max(1, len(panels)) * (height + TITLE) + own + 0.3
    figure = new_canvas(foot - LABELS - lines * BAR_CM + down * rise)
    spots, bars = [], []
    for n, one in enumerate(found):
        row, column = divmod(n, across)
        left = LEFT + column * (width + gap)
        bottom = foot + (down - 1 - row) * rise
        part = dataset.isel(one)
        bars.append(Bars(part, left, bottom, width, column == 0))
        for k, each in enumerate(panels):
            at = bottom + BARS_GAP + (len(panels) - 1 - k) * (height + TITLE)
            text = combination_text(dataset, one)
            title, head = (text, "") if len(panels) == 1 else ("", text * (k == 0))
            spots.append(Spot(each, part, left, at, width, height, title, column > 0, head))
    return Layout(figure, spots, bars)


def write_spot_titles(ax: Axes, spot: Spot, letter: str, words: str) -> None:
    """Write a letter and the title of a panel, its own or `words`, and its head above.

    Beside panels with titles of their own stand the words.
    """
    write_title(ax, letter, spot.title or words, indent=-0.5)
    if spot.title and not spot.is_inner:
        ax.set_ylabel("\n".join(wrapped(words, int(LETTERS_PER_CM * spot.height))), fontsize=SMALL)
    if spot.head:
        y = 1 + (0.2 + HEAD) / spot.height
        ax.text(0, y, spot.head, fontsize=BODY, weight="bold", transform=ax.transAxes)


def spot_axes(layout: Layout, along: str) -> list[tuple[Spot, Axes]]:
    """Add the axes of each panel; those of the same quantities share the ordinate of the first."""
    first: dict[Panel, Axes] = {}
    found = []
    for spot in layout.spots:
        shared = first.get(spot.panel)
        ax = axes(layout.figure, spot.left, spot.bottom, spot.width, spot.height, sharey=shared)
        ax.set_xscale(scale_of(spot.part[along].values))
        ax.tick_params(which="both", labelleft=not spot.is_inner)
        ax.margins(y=max(0.05, MARGIN / spot.height))
        first.setdefault(spot.panel, ax)
        found.append((spot, ax))
    return found
