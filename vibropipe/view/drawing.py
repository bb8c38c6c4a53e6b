"""The exciter drawn: a mass on its spring between two supports, which a button sets in motion."""

from __future__ import annotations

import numpy as np
from bokeh.models import BoxAnnotation, ColumnDataSource, Range1d, Toggle
from bokeh.plotting import figure

from vibropipe.solve.rebuild import Motion
from vibropipe.view.motion_panel import WALL, MotionPanel
from vibropipe.view.scripts import script

# Share of the range of displacements that the mass takes.
MASS = 0.16
COILS = 9


class Drawing:
    """The drawing, which moves in the browser alone.

    Parameters
    ----------
    panel : MotionPanel
        Its motion is played, and its dot follows.
    """

    def __init__(self, panel: MotionPanel) -> None:
        self.x_range = Range1d(-1.0, 1.0)
        self.mass = ColumnDataSource({"x": [0.0], "width": [0.1]})
        self.spring = ColumnDataSource({"x": [-1.0, 0.0], "y": [0.0, 0.0]})
        self.walls = BoxAnnotation(**WALL), BoxAnnotation(**WALL)
        self.figure = figure(width=400, height=62, x_range=self.x_range, y_range=Range1d(-1, 1), tools="",
                             toolbar_location=None, name="drawing")  # fmt: skip
        self.figure.yaxis.visible = self.figure.xaxis.visible = False
        self.figure.grid.visible = False
        self.figure.line("x", "y", source=self.spring, color="#7F7F7F", line_width=1.5)
        self.figure.rect(
            "x", 0, "width", 1.0, source=self.mass, fill_color="#E69F00", line_color="black"
        )
        for wall in self.walls:
            self.figure.add_layout(wall)
        self.button = Toggle(label="▶ play", width=80, name="play")
        self.button.js_on_change(
            "active",
            script("play.js", motion=panel.sources["motion"], dot=panel.dot, mass=self.mass,
                   spring=self.spring),
        )  # fmt: skip

    def show(self, motion: Motion | None, low: float, high: float) -> None:
        """Place the supports and the mass at the start of a motion; low and high are the ends of the range."""
        if motion is None:
            return
        half = 0.5 * MASS * (high - low)
        x = float(motion.curves["displacement"].values[0])
        self.x_range.update(start=low - half, end=high + half)
        self.walls[0].left, self.walls[1].right = motion.walls[1] + half, motion.walls[2] - half
        self.mass.data = {"x": [x], "width": [2 * half]}
        self.spring.data = {
            "x": np.linspace(max(low, motion.walls[2]) - half, x, 2 * COILS + 2),
            "y": np.concatenate([[0.0], np.resize([0.3, -0.3], 2 * COILS), [0.0]]),
        }
