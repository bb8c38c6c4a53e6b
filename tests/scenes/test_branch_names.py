"""Names of motions stand beside their lines, above or below where nothing else lies, or are left out."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from vibropipe.figures.canvas import axes, new_canvas
from vibropipe.figures.style import house_style
from vibropipe.scenes.branch.lines import Piece
from vibropipe.scenes.branch.names import write_names

X = np.array([0.0, 10.0])


def written(levels: list[tuple[float, float]], limits=(0.0, 10.0)) -> tuple[Figure, list]:
    """Draw straight lines from one height to another, the first of them named, and return what is written."""
    x, y = np.tile(X, len(levels)), np.ravel(levels)[:, None]
    pieces = [Piece(slice(2 * n, 2 * n + 2), f"law {n}", n == 0, 0.0) for n in range(len(levels))]
    with house_style():
        figure = new_canvas(5.0)
        ax = axes(figure, 1.5, 1.0, 14.0, 3.5)
        for n in range(len(levels)):
            ax.plot(X, y[2 * n : 2 * n + 2, 0])
        ax.set(xlim=limits, ylim=(0.0, 1.0))
        names = ["both supports, once a period", *["other"] * (len(levels) - 1)]
        write_names(ax, x, y, pieces, names, {piece.law: "k" for piece in pieces})
    return figure, list(ax.texts)


@pytest.mark.parametrize("limits", [(0.0, 10.0), (4.0, 6.0)])
@pytest.mark.parametrize(
    ("levels", "side"),
    [([(0.5, 0.5)], 1), ([(0.5, 0.5), (0.6, 0.6)], -1), ([(0.5, 0.5), (0.4, 0.4)], 1), ([(0.95, 0.95)], -1)],
)  # fmt: skip
def test_a_name_stands_where_no_line_and_no_frame_is(levels, side, limits):
    # the points of the lines lie outside the range that is drawn
    figure, (text,) = written(levels, limits)
    box = text.get_window_extent(figure.canvas.get_renderer())
    (ax,) = figure.axes
    low, high = ax.transData.inverted().transform(box.get_points())[:, 1]
    assert (low > levels[0][0]) if side > 0 else (high < levels[0][0])
    assert not any(low < level < high for level, _ in levels)
    assert low >= 0.0
    assert high <= 1.0


def test_without_room_there_is_no_name():
    assert written([(0.5, 0.5), (0.52, 0.52), (0.48, 0.48)])[1] == []
    assert written([(0.5, 0.5)], limits=(9.0, 19.0))[1] == []  # a line too short for it


def test_a_value_that_another_panel_names_covers_no_line():
    heights = [0.45, 0.5, 0.55]
    x, y = np.tile(X, 3), np.repeat(heights, 2)[:, None]
    pieces = [Piece(slice(2 * n, 2 * n + 2), "law", True, value) for n, value in enumerate(heights)]
    values = [f"R1 = {value}" for value in heights]
    with house_style():
        figure = new_canvas(5.0)
        upper, lower = (axes(figure, 1.5, 1.0, 14.0, 3.5, label=name) for name in ("a", "b"))
        for ax in (upper, lower):
            ax.set(xlim=(0.0, 10.0), ylim=(0.0, 1.0))
        colours = dict.fromkeys([*heights, "law"], "k")
        told = write_names(upper, x, y, pieces, values, colours)
        again = write_names(lower, x, y, pieces, values, colours, told=told)
    assert told == set(values)  # the middle one on its line
    assert again == {values[0], values[2]}
