"""The page of a study: which scene, quantity and point are shown, and how its panels follow them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from html import escape
from typing import Any
from urllib.parse import urlencode

import xarray as xr
from bokeh.events import Pan, Tap
from bokeh.layouts import column, row
from bokeh.models import (
    ColumnDataSource,
    CustomJS,
    Div,
    InlineStyleSheet,
    LayoutDOM,
    Select,
    Spacer,
)
from bokeh.plotting import figure

from vibropipe.scenes.sweep.quantities import Series
from vibropipe.view.border import Borders
from vibropipe.view.latest import Background, Later, in_thread
from vibropipe.view.map_panel import MapPanel, flag_colours
from vibropipe.view.overlays import Overlays, starts_on
from vibropipe.view.plane import (
    LEGEND_CSS,
    Plane,
    Region,
    legend_html,
    mark_lines,
    region_lines,
    regions_shown,
)
from vibropipe.view.point import NO_ATTRACTOR, PointPanel, values_at
from vibropipe.view.results import Results
from vibropipe.view.slices import CURVES_WIDTH, LEVEL_HEIGHT, UPRIGHT_WIDTH, Slice, shown_series
from vibropipe.view.what_if import row_of_start, solve_anew
from vibropipe.view.words import script, symbol, value_of

REGIONS, ATTRACTORS = "regimes and laws of motion", "attractors"


def at_once(work: Callable[[], None]) -> None:
    """Do work now; a server does it after the events that wait."""
    work()


def _note_div(note: str) -> list[Div]:
    if not note:
        return []
    styles = {"overflow-y": "auto", "font-size": "11px"}
    return [Div(text=escape(note), width=300, height=45, styles=styles, disable_math=True)]


class Page:
    """One page, of one session.

    later : takes work to do after the events that wait, so that a fast mouse costs one answer
    chosen : scene and point to begin with: `scene`, and a number by the name of each dimension
    background : takes work to do beside the page: a map that is solved anew, a change of parameters, other motions
    rest : seconds that a point is shown before others that coexist are sought
    """

    def __init__(
        self,
        results: Results,
        later: Later = at_once,
        chosen: Mapping[str, str] | None = None,
        background: Background = in_thread,
        rest: float = 0.0,
    ) -> None:
        self.datasets, self._later, self._background = dict(results.datasets), later, background
        self._is_waiting = self._is_opening = False
        # both numbers in one: a click is one message and costs one answer
        self.crosshair = ColumnDataSource({"x": [0.0], "y": [0.0]}, name="crosshair")
        self.x_axis, self.y_axis = ColumnDataSource({"at": []}), ColumnDataSource({"at": []})
        self.point = PointPanel(self.solve_map, later, background, rest)
        names = results.explorable
        self.scene = Select(
            title="scene", options=names, value=results.first or names[0], width=190, name="scene"
        )
        self.quantity = Select(title="map", width=330, name="quantity")
        self.legend = Div(
            name="legend", disable_math=True, styles={"overflow-y": "auto"},
            stylesheets=[InlineStyleSheet(css=LEGEND_CSS)],
        )  # fmt: skip
        self.others = row(Spacer(width=0))
        self.left = column(Spacer(width=0))
        head = row(
            self.scene, self.quantity, self.others, self.point.buttons, *_note_div(results.note)
        )
        self.root = column(
            head, row(self.left, self.point.root), self.point.what_if.root, name="page"
        )
        self.crosshair.on_change("data", lambda attr, old, new: self._moved())
        self.scene.on_change("value", lambda attr, old, new: self.open_scene({}))
        self.quantity.on_change("value", lambda attr, old, new: self._show_quantity())
        self.open_scene(dict(chosen or {}))

    @property
    def scripts(self) -> list[CustomJS]:
        """Scripts that run once the page is there."""
        texts = [self.point.law, self.point.numbers]
        return [script("keys.js", **self._handles()), script("texts.js", texts=texts)]

    @property
    def series(self) -> Series | None:
        """The quantity of the map; None for regions."""
        return self.plane.series.get(self.quantity.value)

    @property
    def pointed(self) -> tuple[float, ...]:
        """Place of the crosshair, a number for each axis of the plane."""
        place = self.crosshair.data["x"][0], self.crosshair.data["y"][0]
        return place[: len(self.plane.axes)]

    def point_at(self, x: float, y: float = 0.0) -> None:
        """Place the crosshair."""
        self.crosshair.data = {"x": [x], "y": [y]}

    def open_scene(self, chosen: dict[str, str]) -> None:
        """Show a scene, at a point if its numbers are chosen."""
        name = chosen.get("scene", self.scene.value)
        if self._is_opening:
            return
        self._is_opening = True
        if name in self.scene.options:
            self.scene.value = name
        self.plane = Plane(self.datasets[self.scene.value])
        self._take(chosen)
        self.x_axis.data = {"at": self.plane.values[0]}
        is_map = len(self.plane.axes) > 1
        self.y_axis.data = {"at": self.plane.values[1] if is_map else []}
        panels = self._panels(is_map)
        self.point.what_if.open(self.plane)
        self.at: tuple[int, ...] | None = None
        regions = ATTRACTORS if self.plane.of_starts else REGIONS
        self.quantity.update(options=[regions, *self.plane.series], value=regions)
        self._is_opening = False
        self._show_quantity()
        # with their data: a browser finds no ranges of empty panels
        self.left.children = panels

    def _take(self, chosen: Mapping[str, str]) -> None:
        """Place the crosshair at chosen numbers, else in the middle, and choose the other dimensions."""
        middle = [float(values[values.size // 2]) for values in self.plane.values]
        for n, name in enumerate(self.plane.axes):
            try:
                middle[n] = float(chosen[name])
            except (KeyError, ValueError):
                continue
        point = values_at(self.plane, self.plane.nearest(*middle))
        self.point_at(*point)
        for name in self.plane.further_dims:
            texts = [str(value) for value in self.plane.dataset[name].values]
            if chosen.get(name) in texts:
                self.plane.further[name] = texts.index(chosen[name])

    def _panels(self, is_map: bool) -> list[LayoutDOM]:
        """Make and return the panels of the plane: a map with two slices, or curves."""
        self.borders = Borders(self.plane)
        self.map = MapPanel(self.plane, self.crosshair) if is_map else None
        beside = None if self.map is None else self.map.figure
        self.slices = [Slice(self.plane, 0, self.crosshair, beside)]
        level = self.slices[0].figure
        self._listen(level, "x")
        self.overlays = Overlays(beside or level)
        self.menus = [self._select(name) for name in self.plane.further_dims]
        self.others.children = self.menus or [Spacer(width=0)]
        if self.map is None:
            self.legend.update(width=CURVES_WIDTH, height=130)
            return [level, self.legend]
        self.legend.update(width=UPRIGHT_WIDTH + 50, height=LEVEL_HEIGHT + 40)
        self.slices.append(Slice(self.plane, 1, self.crosshair, beside))
        self._listen(self.slices[1].figure, "y")
        self._listen(self.map.figure, "both")
        return [row(self.map.figure, self.slices[1].figure), row(level, self.legend)]

    def _select(self, name: str) -> Select:
        """Return the menu of a dimension that is no axis."""
        texts = [str(value) for value in self.plane.dataset[name].values]
        title = symbol(self.plane.dataset[name])
        select = Select(
            title=title, options=texts, value=texts[self.plane.further[name]], width=110, name=name
        )

        def choose(attr: str, old: str, new: str) -> None:
            self.plane.further[name] = texts.index(new)
            self.borders = Borders(self.plane)
            self.at = None
            self._show_quantity()

        select.on_change("value", choose)
        return select

    def _handles(self) -> dict[str, Any]:
        """Return what scripts move."""
        return {"crosshair": self.crosshair, "x_axis": self.x_axis, "y_axis": self.y_axis}

    def _listen(self, plot: figure, moves: str) -> None:
        """Let clicks and drags move the crosshair, in the browser itself."""
        for event in (Tap, Pan):
            plot.js_on_event(event, script("drag.js", plot=plot, moves=moves, **self._handles()))

    def _show_quantity(self) -> None:
        if self._is_opening:
            return
        if self.map is not None:
            self.map.show(self.series)
        shown = shown_series(self.plane, self.series)
        self.overlays.show(self.datasets, self.plane, shown[0] if shown else None)
        self.legend.text = self.legend_of(self.series)
        self._follow(is_new=True)

    def legend_of(self, series: Series | None) -> str:
        """Return what marks, lines and colours mean when a quantity is shown."""
        flags = self.plane.flags(series) if series and self.map else {}
        names = zip(flags, flag_colours(flags), strict=False)
        regions = [Region("", flags[n], colour) for n, colour in names]
        areas = region_lines([*regions, *regions_shown(self.plane)])
        marks = mark_lines(self.plane, shown_series(self.plane, series))
        return legend_html([*marks, *self.overlays.lines, *areas])

    def _moved(self) -> None:
        if not (self._is_waiting or self._is_opening):
            self._is_waiting = True
            self._later(self._follow)

    def _follow(self, is_new: bool = False) -> None:
        self._is_waiting = False
        at = self.plane.nearest(*self.pointed)
        if at == self.at and not is_new:
            return
        is_moved, self.at = at != self.at, at
        if is_new:
            self._show_slices()
        if is_moved:
            self._show_row(at)
        if not is_new:
            self._later(self._show_slices)

    def _show_slices(self) -> None:
        if self.at is None:
            return
        for each in self.slices:
            each.show(self.series, self.at)

    def _show_row(self, at: tuple[int, ...]) -> None:
        """Show the motion and the numbers of the row at indices of the axes."""
        number_of_row, point = self.plane.row_number(at), values_at(self.plane, at)
        values = dict(zip(self.plane.axes, point, strict=True))
        for name in self.plane.further_dims:
            values[name] = self.plane.dataset[name].values[self.plane.further[name]]
        marks = [
            f"{symbol(self.plane.dataset[name])} = {value_of(self.plane.dataset[name], value)}"
            for name, value in values.items()
        ]
        link = urlencode(
            {"scene": self.scene.value, **{name: str(v) for name, v in values.items()}}
        )
        stored = self.plane.row(number_of_row) if number_of_row >= 0 else None
        border = self.borders.sentence(at, point)
        if stored is None:
            stored, border = row_of_start(self.plane, *point), NO_ATTRACTOR
        self.point.show(stored, ", ".join(marks), border, link, self._coexisting(at))

    def _coexisting(self, at: tuple[int, ...]) -> dict[str, Callable[[], xr.Dataset]]:
        """Return the attractors of basins at a point by name, each as what returns its row."""
        planes = {self.scene.value: self.plane} if self.plane.of_starts else {}
        for each in starts_on(self.datasets, self.plane):
            if self.plane.nearest(*each.point) == at:
                planes[each.scene] = Plane(self.datasets[each.scene], dict(each.at))
        rows: dict[str, Callable[[], xr.Dataset]] = {}
        for scene, plane in planes.items():
            for number in plane.attractors:
                rows[f"{scene}: {plane.regions[number + 1].text}"] = partial(plane.row, number)
        return rows

    def solve_map(self) -> None:
        """Solve the plane anew with the changed parameters, beside the page, and show it as a scene of its own."""
        what_if, plane, name = self.point.what_if, self.plane, self.scene.value
        changed, title = what_if.changed, f"{name}, {what_if.text}"

        def on_rows(done: int, total: int) -> None:
            self._later(partial(what_if.tell, f"{done / total:.0%}"))

        def work() -> None:
            try:
                solved = solve_anew(plane, changed, on_rows)
            except Exception as error:  # told on the page: nobody else waits for this thread
                self._later(partial(self._tell_failure, title, str(error)))
            else:
                self._later(partial(self._add_scene, title, solved))

        what_if.tell("0%")
        self._background(work)

    def _tell_failure(self, title: str, reason: str) -> None:
        self.point.what_if.tell("")
        self.point.tell_failure(title, reason)

    def _add_scene(self, name: str, dataset: xr.Dataset) -> None:
        """Add a dataset to the menu of scenes, and show it."""
        self.point.what_if.tell("")
        self.datasets[name] = dataset
        point = values_at(self.plane, self.at) if self.at else ()
        chosen = dict(zip(self.plane.axes, map(str, point), strict=False))
        self.scene.options = [*dict.fromkeys([*self.scene.options, name])]
        self.open_scene({"scene": name, **chosen})
