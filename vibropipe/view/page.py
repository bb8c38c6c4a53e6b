"""The page of a study: which scene, quantity and point are shown, and how its panels follow them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from bokeh.events import DocumentReady, Pan, Tap
from bokeh.layouts import column, row
from bokeh.models import ColumnDataSource, CustomJS, Div, InlineStyleSheet, Select, Span
from bokeh.plotting import figure

from vibropipe.scenes.sweep.quantities import DIRECTION, Series
from vibropipe.view.border import Borders
from vibropipe.view.map_panel import MapPanel
from vibropipe.view.motion_panel import MotionPanel
from vibropipe.view.numbers import law_text, lines_of, momentum_lines, table_html
from vibropipe.view.plane import Plane
from vibropipe.view.rebuild import Motion, motion_of
from vibropipe.view.results import Results
from vibropipe.view.slices import Slice
from vibropipe.view.words import html, number, symbol

REGIONS = "regimes and laws of motion"
NUMBERS_CSS = """
.numbers {border-collapse: collapse; font-size: 11px} .numbers td {padding: 0 6px 0 0; vertical-align: top}
.law {font-size: 13px; margin: 0 0 4px 0}
"""
Later = Callable[[Callable[[], None]], Any]


def script(name: str, **arguments: Any) -> CustomJS:
    """Return a script of this folder as a callback."""
    return CustomJS(args=arguments, code=Path(__file__).with_name(name).read_text(encoding="utf-8"))


def at_once(work: Callable[[], None]) -> None:
    """Do work now; a server does it after the events that wait."""
    work()


class Page:
    """One page, of one session.

    Parameters
    ----------
    results : Results
    later : callable
        Takes work to do after the events that wait, so that a fast mouse costs one answer.
    chosen : mapping of str to str
        Scene and point to begin with: `scene`, and a number by the name of each dimension.
    """

    def __init__(
        self, results: Results, later: Later = at_once, chosen: Mapping[str, str] | None = None
    ) -> None:
        self.results, self._later = results, later
        self._is_waiting = self._is_opening = False
        self.upright = Span(dimension="height", line_color="#CC0000", line_width=1.5)
        self.across = Span(dimension="width", line_color="#CC0000", line_width=1.5)
        self.x_axis, self.y_axis = ColumnDataSource({"at": []}), ColumnDataSource({"at": []})
        self.motion_panel = MotionPanel()
        self.motion: Motion | None = None
        sheet = InlineStyleSheet(css=NUMBERS_CSS)
        self.numbers = Div(width=280, height=255, disable_math=True, stylesheets=[sheet], name="numbers",
                           styles={"overflow-y": "auto"})  # fmt: skip
        self.law = Div(width=560, height=52, disable_math=True, stylesheets=[sheet], name="law")
        names = results.explorable
        self.scene = Select(title="scene", options=names, value=names[0], width=180, name="scene")
        self.quantity = Select(title="map", width=330, name="quantity")
        self.others = row()
        self.left = column()
        right = column(
            self.law, self.motion_panel.curves, row(self.motion_panel.portrait, self.numbers)
        )
        self.root = column(row(self.scene, self.quantity, self.others), row(self.left, right))
        for span in (self.upright, self.across):
            span.on_change("location", lambda attr, old, new: self._moved())
        self.scene.on_change("value", lambda attr, old, new: self.open_scene({}))
        self.quantity.on_change("value", lambda attr, old, new: self._show_quantity())
        self.open_scene(dict(chosen or {}))

    @property
    def scripts(self) -> dict[str, CustomJS]:
        """Callbacks of the document by event."""
        return {DocumentReady.event_name: script("keys.js", **self._handles())}

    @property
    def series(self) -> Series | None:
        """The quantity of the map; None for regions."""
        return self.plane.series.get(self.quantity.value)

    def open_scene(self, chosen: dict[str, str]) -> None:
        """Show a scene, at a point if its numbers are chosen."""
        name = chosen.get("scene", self.scene.value)
        if name in self.results.explorable and name != self.scene.value:
            self.scene.value = name  # comes back here
            return
        self._is_opening = True
        self.plane = Plane(self.results.datasets[self.scene.value])
        self._take(chosen)
        self.x_axis.data = {"at": self.plane.values[0]}
        is_map = len(self.plane.axes) > 1
        self.y_axis.data = {"at": self.plane.values[1] if is_map else []}
        self.across.visible = is_map
        self._build(is_map)
        self.at: tuple[int, ...] | None = None
        options = [REGIONS, *self.plane.series]
        self.quantity.update(options=options, value=REGIONS)
        self._is_opening = False
        self._show_quantity()

    def _take(self, chosen: Mapping[str, str]) -> None:
        """Place the crosshair at chosen numbers, else in the middle, and choose the other dimensions."""
        middle = [float(values[values.size // 2]) for values in self.plane.values]
        for n, name in enumerate(self.plane.axes):
            try:
                middle[n] = float(chosen[name])
            except (KeyError, ValueError):
                continue
        at = self.plane.nearest(*middle)
        point = [float(values[n]) for values, n in zip(self.plane.values, at, strict=True)]
        self.upright.location = point[0]
        self.across.location = point[1] if len(point) > 1 else 0.0
        for name in self.plane.further_dims:
            texts = [str(value) for value in self.plane.dataset[name].values]
            if chosen.get(name) in texts:
                self.plane.further[name] = texts.index(chosen[name])

    def _build(self, is_map: bool) -> None:
        """Make the panels of the plane: a map with two slices, or curves."""
        self.borders = Borders(self.plane)
        self.map = MapPanel(self.plane, self.across, self.upright) if is_map else None
        beside = None if self.map is None else self.map.figure
        self.slices = [Slice(self.plane, 0, self.upright, beside)]
        self._listen(self.slices[0].figure, "x")
        if self.map is None:
            self.left.children = [self.slices[0].figure]
        else:
            self.slices.append(Slice(self.plane, 1, self.across, beside))
            self._listen(self.slices[1].figure, "y")
            self._listen(self.map.figure, "both")
            self.left.children = [
                row(self.map.figure, self.slices[1].figure), self.slices[0].figure
            ]  # fmt: skip
        self.others.children = [
            self._select(name) for name in self.plane.further_dims if name != DIRECTION or is_map
        ]

    def _select(self, name: str) -> Select:
        """Return the menu of a dimension that is no axis."""
        values = self.plane.dataset[name].values
        texts = [str(value) for value in values]
        title = symbol(self.plane.dataset[name])
        select = Select(
            title=title, options=texts, value=texts[self.plane.further[name]], width=110
        )

        def choose(_attr: str, _old: str, new: str) -> None:
            self.plane.further[name] = texts.index(new)
            self.borders = Borders(self.plane)
            self.at = None
            self._show_quantity()

        select.on_change("value", choose)
        return select

    def _handles(self) -> dict[str, Any]:
        """Return what scripts move."""
        return {"upright": self.upright, "across": self.across,
                "x_axis": self.x_axis, "y_axis": self.y_axis}  # fmt: skip

    def _listen(self, plot: figure, moves: str) -> None:
        """Let clicks and drags move the crosshair, in the browser itself."""
        for event in (Tap, Pan):
            plot.js_on_event(event, script("drag.js", plot=plot, moves=moves, **self._handles()))

    def _show_quantity(self) -> None:
        if self._is_opening:
            return
        if self.map is not None:
            self.map.show(self.series)
        self._follow(is_new=True)

    def _moved(self) -> None:
        if not (self._is_waiting or self._is_opening):
            self._is_waiting = True
            self._later(self._follow)

    def _follow(self, is_new: bool = False) -> None:
        """Bring all panels to the row under the crosshair."""
        self._is_waiting = False
        point = (self.upright.location, self.across.location)[: len(self.plane.axes)]
        at = self.plane.nearest(*point)
        if at == self.at and not is_new:
            return
        is_moved, self.at = at != self.at, at
        for each in self.slices:
            each.show(self.series, at)
        if is_moved:
            self._show_row(self.plane.row_number(at))

    def _show_row(self, row_number: int) -> None:
        """Show the motion and the numbers of a row; -1 is none."""
        self.motion = None
        if row_number < 0:
            self.law.text, self.numbers.text = "No attractor was found from this start.", ""
            self.motion_panel.show(None)
            return
        stored = self.plane.row(row_number)
        self.motion = motion_of(stored)
        self.motion_panel.show(self.motion)
        point = tuple(float(v[n]) for v, n in zip(self.plane.values, self.at or (), strict=True))
        where = ", ".join(
            f"{symbol(self.plane.dataset[name])} = {number(value)}"
            for name, value in zip(self.plane.axes, point, strict=True)
        )
        text = f"{law_text(stored)} {self.borders.sentence(self.at or (), point)}"
        self.law.text = f'<p class="law"><b>{html(where)}.</b> {html(text)}</p>'
        lines = [*lines_of(stored)]
        if self.motion is not None:
            lines += momentum_lines(self.motion)
        self.numbers.text = table_html([lines])
