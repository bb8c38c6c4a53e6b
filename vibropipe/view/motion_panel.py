"""The motion at the crosshair: displacement over time between hatched supports, and the phase portrait."""

from __future__ import annotations

import numpy as np
from bokeh.models import BoxAnnotation, ColumnDataSource, Range1d, Toggle
from bokeh.plotting import figure
from numpy.typing import NDArray

from vibropipe.figures.palette import SUPPORT_COLOURS
from vibropipe.figures.phase_plane import near_walls, with_breaks
from vibropipe.figures.text import clock, times_of
from vibropipe.solve.rebuild import Motion
from vibropipe.view.words import label_of, script, short_ticks

# Share of the range of displacements that the mass takes.
MASS = 0.16
COILS = 9


class Drawing:
    """The drawing, which moves in the browser alone.

    panel : its motion is played, and its dot follows
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


CURVE, JUMPS = ("time", "x", "v"), ("time", "x", "before", "after", "colour")
SECTION = ("x", "v")
MARGIN = 0.12
WALL = {
    "fill_color": "#D8D8D8", "fill_alpha": 0.6, "hatch_pattern": "/", "hatch_color": "#808080",
    "hatch_alpha": 0.7, "line_color": "#7F7F7F", "level": "underlay",
}  # fmt: skip
# Stored motion, ghost, pinned motion: colour, dashes, width.
STYLES = {
    "ghost": ("#9A9A9A", "solid", 2.5),
    "pinned": ("#D55E00", "dashed", 1.3),
    "motion": ("#000000", "solid", 1.3),
}


def curve_of(motion: Motion) -> dict[str, NDArray]:
    """Return time, displacement and velocity of a motion, with breaks of the velocity at impacts."""
    data = motion.curves
    jumps = data.isel(impact=~np.isin(data["impact_support"].values, motion.soft))
    tau, at = data[clock(data)].values, times_of(jumps, "impact").values
    wall = np.where(jumps["impact_support"].values == 1, motion.walls[1], motion.walls[2])
    before, after = jumps["impact_velocity"].values, jumps["impact_velocity_after"].values
    time, x = with_breaks(tau, data["displacement"].values, at, wall, wall)
    _time, v = with_breaks(tau, data["velocity"].values, at, before, after)
    return {"time": time, "x": x, "v": v}


def jumps_of(motion: Motion) -> dict[str, NDArray]:
    """Return the impacts of a motion: time, place, velocities, colour of the support.

    On a soft support the velocity does not jump: both are that of touching it.
    """
    data = motion.curves
    support, before = data["impact_support"].values, data["impact_velocity"].values
    after = np.where(np.isin(support, motion.soft), before, data["impact_velocity_after"].values)
    colours = np.array(["", SUPPORT_COLOURS[1], SUPPORT_COLOURS[2]])
    return {
        "time": times_of(data, "impact").values,
        "x": np.where(support == 1, motion.walls[1], motion.walls[2]),
        "before": before,
        "after": after,
        "colour": colours[support],
    }


class MotionPanel:
    """Curves and portrait of a motion, beside a ghost and a pinned one."""

    def __init__(self) -> None:
        self.sources = {name: ColumnDataSource({c: [] for c in CURVE}) for name in STYLES}
        self.jumps = ColumnDataSource({name: [] for name in JUMPS})
        self.section = ColumnDataSource({name: [] for name in SECTION})
        self.dot = ColumnDataSource({"time": [], "x": [], "v": []})
        tools = {"tools": "wheel_zoom,pan,reset", "active_drag": None, "toolbar_location": None}
        self.x_range = Range1d(-1.0, 1.0)
        self.curves = figure(width=568, height=175, y_range=self.x_range, name="motion", **tools)
        self.portrait = figure(
            width=255, height=250, x_range=self.x_range, name="portrait", **tools
        )
        for panel in (self.curves, self.portrait):
            panel.xaxis.formatter = panel.yaxis.formatter = short_ticks()
        for axis in (self.portrait.xaxis[0], self.portrait.yaxis[0]):
            axis.ticker.desired_num_ticks = 4
        self.shown: dict[str, Motion] = {}
        for name, (colour, dash, width) in STYLES.items():
            look = {
                "color": colour,
                "line_dash": dash,
                "line_width": width,
                "source": self.sources[name],
            }
            self.curves.line("time", "x", **look)
            self.portrait.line("x", "v", **look)
        self.portrait.segment("x", "before", "x", "after", color="colour", line_dash="dotted",
                              line_width=2, source=self.jumps)  # fmt: skip
        self.curves.scatter("time", "x", color="colour", size=6, source=self.jumps)
        self.portrait.scatter("x", "before", color="colour", size=5, source=self.jumps)
        self.portrait.scatter(
            "x", "v", size=4, fill_color="white", line_color="black", source=self.section
        )
        for panel, x, y in ((self.curves, "time", "x"), (self.portrait, "x", "v")):
            panel.scatter(x, y, size=10, color="#E69F00", line_color="black", source=self.dot)
        self.walls = {n: (BoxAnnotation(**WALL), BoxAnnotation(**WALL)) for n in (1, 2)}
        for level, upright in self.walls.values():
            self.curves.add_layout(level)
            self.portrait.add_layout(upright)

    @property
    def boxes(self) -> list[BoxAnnotation]:
        """What is beyond the supports: of the curves, then of the portrait, support 1 first."""
        return [self.walls[support][n] for n in (0, 1) for support in (1, 2)]

    def show(self, motion: Motion | None, name: str = "motion") -> None:
        """Show a motion under one of the names of STYLES; None clears it."""
        if motion is None and name not in self.shown:
            return
        empty: dict[str, list[float]] = {column: [] for column in CURVE}
        self.sources[name].data = empty if motion is None else curve_of(motion)
        if motion is None:
            self.shown.pop(name, None)
        else:
            self.shown[name] = motion
        if "motion" in self.shown:
            self._place_walls(self.shown["motion"])
        if name != "motion":
            return
        if motion is None:
            self.jumps.data = {column: [] for column in JUMPS}
            self.section.data = {column: [] for column in SECTION}
            return
        self.jumps.data = jumps_of(motion)
        self.section.data = dict(zip(SECTION, motion.section.T, strict=True))
        data = motion.curves
        self.curves.xaxis.axis_label = label_of(data[clock(data)])
        self.curves.yaxis.axis_label = label_of(data["displacement"])
        self.portrait.xaxis.axis_label = label_of(data["displacement"])
        self.portrait.yaxis.axis_label = label_of(data["velocity"])

    def _place_walls(self, motion: Motion) -> None:
        """Hatch what is beyond the supports, and set the range of displacements; a far support is left out."""
        x = np.concatenate(
            [each.curves["displacement"].values for each in self.shown.values()]
            + [motion.section[:, 0]]
        )
        low, high = float(np.nanmin(x)), float(np.nanmax(x))
        near = near_walls(low, high, motion.walls).values()
        low, high = min([low, *near]), max([high, *near])
        margin = MARGIN * (high - low or 1.0)
        self.x_range.update(start=low - margin, end=high + margin)
        for support, (level, upright) in self.walls.items():
            at = motion.walls[support]
            if support == 1:
                level.bottom = upright.left = at
            else:
                level.top = upright.right = at
