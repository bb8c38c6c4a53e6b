"""All that is shown of one point: its law, its numbers, its motion beside a ghost, a pinned one and coexisting ones."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from bokeh.layouts import column, row
from bokeh.models import Button, ColumnDataSource, Div, InlineStyleSheet, Select

from vibropipe.physics.exciter import ParameterError
from vibropipe.solve.rebuild import Motion, motion_of
from vibropipe.view.drawing import Drawing
from vibropipe.view.motion_panel import MotionPanel
from vibropipe.view.plane import Plane
from vibropipe.view.recipe import as_python, as_yaml
from vibropipe.view.row_numbers import Line, law_text, lines_of, momentum_lines, table_html
from vibropipe.view.scripts import script
from vibropipe.view.what_if import WhatIf, steady_row
from vibropipe.view.words import html

NUMBERS_CSS = """
.numbers {border-collapse: collapse; font-size: 11px; line-height: 1.25}
.numbers td {padding: 0 6px 1px 0; vertical-align: top; min-width: 24px}
.numbers td:nth-child(2) {width: 110px; overflow-wrap: anywhere}
.law {font-size: 13px; margin: 0}
"""
STORED = "stored motion"
NUMBERS_HEIGHT, MENU_HEIGHT = 250, 40
NO_ATTRACTOR = "No attractor was found from this start."
SECTION_TEXT = "White points: its Poincaré section, once every forcing period."
Later = Callable[[Callable[[], None]], Any]
COPIES = {"yaml": "copy as YAML", "python": "copy as Python", "link": "copy link"}


def lines_with_momentum(motion: Motion | None, stored: xr.Dataset) -> list[Line]:
    """Return the numbers of a row, with the momentum given to the supports if it has a motion."""
    return [*lines_of(stored), *(() if motion is None else momentum_lines(motion))]


class PointPanel:
    """The point under the crosshair.

    Parameters
    ----------
    on_solve : callable
        Called when the map is requested anew.
    later : callable
        Takes work to do once what was sent before is drawn.
    """

    def __init__(self, on_solve: Callable[[], None], later: Later) -> None:
        self._later, self._is_choosing = later, False
        # the row whose law and numbers are still to be written
        self._unwritten: xr.Dataset | None = None
        sheet = InlineStyleSheet(css=NUMBERS_CSS)
        look = {"disable_math": True, "stylesheets": [sheet]}
        self.law = Div(width=568, height=74, name="law", styles={"overflow-y": "auto"}, **look)
        self.numbers = Div(
            width=300, height=NUMBERS_HEIGHT, name="numbers", styles={"overflow-y": "auto"}, **look
        )
        self.panel = MotionPanel()
        self.drawing = Drawing(self.panel)
        self.what_if = WhatIf(self.follow_what_if, on_solve)
        self.stored: xr.Dataset | None = None
        self.motion: Motion | None = None
        self.pinned: Motion | None = None
        self.pin = Button(label="pin", width=60, name="pin")
        self.pin.on_click(self.toggle_pin)
        self.coexisting = Select(
            options=[STORED], value=STORED, width=300, visible=False, name="coexisting"
        )
        self.coexisting.on_change("value", lambda attr, old, new: self._choose(new))
        self.copies = ColumnDataSource({name: [""] for name in COPIES})
        copies = [self._copy_button(name) for name in COPIES]
        self.buttons = row(*copies, align="end")
        self.root = column(
            self.law,
            self.panel.curves,
            row(self.drawing.figure, self.drawing.button, self.pin),
            row(self.panel.portrait, column(self.coexisting, self.numbers)),
        )

    def _copy_button(self, name: str) -> Button:
        button = Button(label=COPIES[name], width=110, name=f"copy_{name}")
        button.js_on_click(script("copy.js", copies=self.copies, what=name))
        return button

    def show(
        self,
        stored: xr.Dataset | None,
        where: str,
        border: str,
        link: str,
        others: dict[str, Callable[[], xr.Dataset]],
    ) -> None:
        """Show a row.

        Parameters
        ----------
        stored : xarray.Dataset or None
            The row; None where a start has no attractor.
        where, border, link : str
            The point as text, its nearest border of regimes, and the query of a link to it.
        others : dict of str to callable
            Coexisting motions by name, each as what returns its row.
        """
        self._where, self._border, self._others = where, border, others
        self.stored, self.motion = stored, None if stored is None else motion_of(stored)
        # the motion is what was asked for: it goes first
        self.follow_what_if()
        self._later(partial(self._offer, stored, link))

    def _offer(self, stored: xr.Dataset | None, link: str) -> None:
        """Offer coexisting motions in a menu, and texts to be copied."""
        if self.stored is not stored:
            return
        others = self._others
        self._is_choosing = True
        self.coexisting.update(options=[STORED, *others], value=STORED, visible=bool(others))
        self._is_choosing = False
        self.numbers.height = NUMBERS_HEIGHT - (MENU_HEIGHT if others else 0)
        self.copies.data = {
            "yaml": ["" if stored is None else as_yaml(stored, f"Point {self._where}")],
            "python": ["" if stored is None else as_python(stored)],
            "link": [link],
        }

    def _choose(self, name: str) -> None:
        """Show a coexisting motion in place of the stored one."""
        if self._is_choosing or self.stored is None:
            return
        chosen = self._others[name]() if name in self._others else None
        self._draw(
            self.motion if chosen is None else motion_of(chosen),
            self.stored if chosen is None else chosen,
        )

    def follow_what_if(self) -> None:
        """Show the stored motion; with changed parameters the one it settles on then, the stored one as a ghost."""
        self._unwritten = None
        if self.stored is None:
            self.law.text, self.numbers.text = f'<p class="law">{NO_ATTRACTOR}</p>', ""
            self._draw_motion(None)
            return
        changed = self.what_if.changed
        if not changed:
            self.panel.show(None, "ghost")
            self._draw(self.motion, self.stored)
            return
        try:
            row = steady_row(self.stored, changed)
        except ParameterError as error:
            self.law.text = (
                f'<p class="law"><b>What if {html(self.what_if.text)}:</b> {html(str(error))}</p>'
            )
            return
        self.panel.show(self.motion, "ghost")
        self._draw(motion_of(row), row, f"What if {self.what_if.text}: ")

    def _draw(self, motion: Motion | None, shown: xr.Dataset, before: str = "") -> None:
        """Draw a motion with its numbers."""
        self._draw_motion(motion)
        self._unwritten = shown
        self._later(partial(self._tell, motion, shown, before))

    def _tell(self, motion: Motion | None, shown: xr.Dataset, before: str) -> None:
        """Write the law and the numbers of a motion, unless another row or a message came after it."""
        if self._unwritten is not shown:
            return
        parts = [law_text(shown)]
        if motion is not None and not motion.is_orbit:
            parts.append(SECTION_TEXT)
        if not before:
            parts.append(self._border)
        head, tail = html(before + self._where), html(" ".join(parts))
        self.law.text = f'<p class="law"><b>{head}.</b> {tail}</p>'
        columns = [lines_with_momentum(motion, shown)]
        if self.pinned is not None:
            columns.append(lines_with_momentum(self.pinned, self.pinned.row))
        self.numbers.text = table_html(columns)

    def _draw_motion(self, motion: Motion | None) -> None:
        self.panel.show(motion)
        self.shown = motion
        ends = self.panel.x_range
        self.drawing.show(motion, ends.start, ends.end)
        # The script that plays the motion takes the forcing period from here.
        self.panel.sources["motion"].tags = [] if motion is None else [motion.period]

    def toggle_pin(self) -> None:
        """Pin the motion shown, to compare others with it; or release it."""
        self.pinned = self.shown if self.pinned is None else None
        self.pin.label = "pin" if self.pinned is None else "unpin"
        self.panel.show(self.pinned, "pinned")
        if self.stored is not None and self.shown is not None:
            self._draw(self.shown, self.shown.row)


def values_at(plane: Plane, at: tuple[int, ...]) -> tuple[float, ...]:
    """Return the values of the axes at indices."""
    return tuple(float(np.asarray(v)[n]) for v, n in zip(plane.values, at, strict=True))
