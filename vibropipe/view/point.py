"""All that is shown of one point: its law, its numbers, its motion beside a ghost, a pinned one and coexisting ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from html import escape
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from bokeh.layouts import column, row
from bokeh.models import Button, ColumnDataSource, Div, InlineStyleSheet, Select, Toggle

from vibropipe.solve.rebuild import Motion, motion_of
from vibropipe.view.copies import as_python, as_yaml
from vibropipe.view.latest import Background, Later, Latest
from vibropipe.view.motion_panel import Drawing, MotionPanel
from vibropipe.view.plane import Plane
from vibropipe.view.row_numbers import (
    Line,
    is_same_motion,
    law_text,
    lines_of,
    momentum_lines,
    motion_name,
    table_html,
)
from vibropipe.view.what_if import WhatIf, attractor_rows, steady_row
from vibropipe.view.words import script
from vibropipe.words.wording import count

NUMBERS_CSS = """
.numbers {border-collapse: collapse; font-size: 11px; line-height: 1.25}
.numbers td {padding: 0 6px 1px 0; vertical-align: top; min-width: 24px}
.numbers td:nth-child(2) {width: 110px; overflow-wrap: anywhere}
.law {font-size: 13px; margin: 0}
"""
STORED, SEEK, SEEKING = "motion shown first", "coexisting", "seeking …"
NUMBERS_HEIGHT = 210
# Seconds of a change of parameters from which on the page says that the next one is being solved.
LONG = 0.3
NO_ATTRACTOR = "No attractor was found from this start."
SECTION_TEXT = "White points: its Poincaré section, once every forcing period."
COPIES = {"yaml": "copy as YAML", "python": "copy as Python", "link": "copy link"}


def lines_with_momentum(motion: Motion | None, stored: xr.Dataset) -> list[Line]:
    """Return the numbers of a row, with the momentum given to the supports if it has a motion."""
    return [*lines_of(stored), *(() if motion is None else momentum_lines(motion))]


class Shown(NamedTuple):
    """What a point shows unless a coexisting motion is chosen; `before` stands before its place."""

    motion: Motion | None
    row: xr.Dataset
    before: str


def settled(stored: xr.Dataset, changed: dict[str, float]) -> tuple[Motion | None, xr.Dataset]:
    """Return the motion that a row settles on when parameters change, and its row."""
    row = steady_row(stored, changed)
    return motion_of(row), row


class PointPanel:
    """The point under the crosshair.

    on_solve : called when the map is requested anew
    later : takes work to do once what was sent before is drawn
    background : takes work to do beside the page
    rest : seconds that a point is shown before others that coexist are sought
    """

    def __init__(
        self, on_solve: Callable[[], None], later: Later, background: Background, rest: float
    ) -> None:
        self._later, self._is_choosing = later, False
        self._settling, self._seeking = Latest(background, later), Latest(background, later, rest)
        self._base: Shown | None = None
        self._found = ""  # the sentence on what coexists
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
            options=[STORED], value=STORED, width=205, visible=False, name="coexisting"
        )
        self.seek = Toggle(label=SEEK, width=85, name="seek")
        self.seek.on_change("active", lambda attr, old, new: self._seek())
        self.coexisting.on_change("value", lambda attr, old, new: self._choose(new))
        self.copies = ColumnDataSource({name: [""] for name in COPIES})
        copies = [self._copy_button(name) for name in COPIES]
        self.buttons = row(*copies, align="end")
        self.root = column(
            self.law,
            self.panel.curves,
            row(self.drawing.figure, self.drawing.button, self.pin),
            row(self.panel.portrait, column(row(self.seek, self.coexisting), self.numbers)),
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

        stored : the row; None where a start has no attractor
        where, border, link : the point as text, its nearest border of regimes, and the query of a link to it
        others : coexisting motions by name, each as what returns its row
        """
        self._where, self._border, self._others = where, border, others
        self.stored, self.motion = stored, None if stored is None else motion_of(stored)
        # the motion is what was asked for: it goes first
        self.follow_what_if()
        self._later(partial(self._offer, stored, link))

    def _offer(self, stored: xr.Dataset | None, link: str) -> None:
        """Offer texts to be copied."""
        if self.stored is not stored:
            return
        self.copies.data = {
            "yaml": ["" if stored is None else as_yaml(stored, f"Point {self._where}")],
            "python": ["" if stored is None else as_python(stored)],
            "link": [link],
        }

    def _choose(self, name: str) -> None:
        """Show a coexisting motion in place of that of the point."""
        if self._is_choosing or self._base is None:
            return
        motion, row, before = self._base
        if name in self._offered:
            row = self._offered[name]()
            motion = motion_of(row)
        self._draw(motion, row, before)

    def _offer_motions(self, others: Mapping[str, Callable[[], xr.Dataset]]) -> None:
        self._is_choosing, self._offered = True, others
        self.coexisting.update(options=[STORED, *others], value=STORED, visible=bool(others))
        self._is_choosing = False

    def _show_base(self, motion: Motion | None, row: xr.Dataset, before: str = "") -> None:
        """Show the motion of the point, and tell what coexists with it."""
        self._base = Shown(motion, row, before)
        # those of a scene of the study are of its parameters
        others = {} if before else self._others
        known = "No other motion was found." if len(others) == 1 else ""
        if len(others) > 1:
            known = f"{count(len(others), 'motion')} coexist here: see the menu."
        self._found = known
        self._draw(motion, row, before)
        self._later(partial(self._seek, others))

    def _seek(self, others: Mapping[str, Callable[[], xr.Dataset]] | None = None) -> None:
        """Look for motions that coexist with that of the point, where the button says so and none are known.

        others : what is known
        """
        if others is not None:
            self._offer_motions(others)
        base, is_wanted = self._base, self.seek.active and not self._offered
        self.seek.label = SEEKING if is_wanted and base is not None else SEEK
        if not is_wanted or base is None:
            self._seeking.drop()
            return
        self._seeking.request(partial(attractor_rows, base.row), partial(self._tell_found, base))

    def _tell_found(self, base: Shown, result: Any) -> None:
        """Say which motions were found beside that of the point, or why they are not known."""
        self.seek.label = SEEK
        if isinstance(result, Exception):
            self._found = f"Others were not found: {result}"
        else:
            n_others = len(result) - any(is_same_motion(base.row, each) for each in result)
            self._found = (
                f"No {'other ' if result else ''}attractor was found from scattered starts."
            )
            if n_others:
                self._offer_motions({motion_name(each): partial(_itself, each) for each in result})
                self._found = f"Coexists with {count(n_others, 'other motion')}: see the menu."
        self._unwritten = base.row
        self._tell(base.motion, base.row, base.before)

    def tell_failure(self, what: str, reason: str) -> None:
        """Say why something is not shown; the motion stays."""
        self._unwritten = None
        self.law.text = f'<p class="law"><b>{escape(what)}:</b> {escape(reason)}</p>'

    def follow_what_if(self) -> None:
        """Show the stored motion; with changed parameters the one it settles on then, the stored one as a ghost."""
        self._unwritten, self._base = None, None
        self._settling.drop()
        self._seek({})
        if self.stored is None:
            self.law.text, self.numbers.text = f'<p class="law">{NO_ATTRACTOR}</p>', ""
            self._draw_motion(None)
            return
        changed = self.what_if.changed
        if not changed:
            self.panel.show(None, "ghost")
            self._show_base(self.motion, self.stored)
            return
        text = f"What if {self.what_if.text}"
        if self._settling.seconds > LONG:
            self.tell_failure(text, "being solved …")
        self._settling.request(partial(settled, self.stored, changed), partial(self._settled, text))

    def _settled(self, text: str, result: Any) -> None:
        """Show what the stored motion settles on, or why it does not."""
        if isinstance(result, Exception):
            self.tell_failure(text, str(result))
            return
        self.panel.show(self.motion, "ghost")
        motion, row = result
        self._show_base(motion, row, f"{text}: ")

    def _draw(self, motion: Motion | None, shown: xr.Dataset, before: str = "") -> None:
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
        parts += [self._found] if self._found else []
        if not before:
            parts.append(self._border)
        head, tail = escape(before + self._where), escape(" ".join(parts))
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


def _itself(row: xr.Dataset) -> xr.Dataset:
    return row


def values_at(plane: Plane, at: tuple[int, ...]) -> tuple[float, ...]:
    """Return the values of the axes at indices."""
    return tuple(float(np.asarray(v)[n]) for v, n in zip(plane.values, at, strict=True))
