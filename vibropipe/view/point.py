"""All that is shown of one point: its law, its numbers, its motion beside a ghost, a pinned one and coexisting ones."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from functools import partial
from html import escape
from typing import Any

import numpy as np
import xarray as xr
from bokeh.layouts import column, row
from bokeh.models import Button, ColumnDataSource, Div, InlineStyleSheet, Select

from vibropipe.physics.exciter import ParameterError
from vibropipe.physics.si import eigenfrequency
from vibropipe.solve.physical import is_physical
from vibropipe.solve.rebuild import Motion, exciter_of, mass_and_stiffness, motion_of, section_of
from vibropipe.solve.shown_units import in_si
from vibropipe.view.motion_panel import Drawing, MotionPanel
from vibropipe.view.plane import Plane
from vibropipe.view.row_numbers import Line, law_text, lines_of, momentum_lines, table_html
from vibropipe.view.what_if import WhatIf, steady_row
from vibropipe.view.words import script
from vibropipe.words.parameters import PARAMETERS, PHYSICAL
from vibropipe.words.units import plain_units

PERIODS = 4


def _parameters(row: xr.Dataset) -> dict[str, float]:
    """Return the parameters of a row that differ from the defaults, in its units."""
    return {name: float(row[name]) for name in _stated(row)}


def _stated(row: xr.Dataset) -> list[str]:
    """Return the names of the parameters of a row that differ from the defaults."""
    names = [name for name in (*PHYSICAL, *PARAMETERS) if name in row.variables]
    values = {name: float(row[name]) for name in dict.fromkeys(names)}
    is_si = is_physical(row)
    return [
        name
        for name, value in values.items()
        if (is_si and name in PHYSICAL) or PARAMETERS[name].default != value
    ]


def _start(row: xr.Dataset) -> tuple[float, float]:
    """Return the stored section in the units of the row, 0 where there is none."""
    x, v = (float(row[f"{name}_strobe"]) for name in ("displacement", "velocity"))
    return (x, v) if math.isfinite(x) and math.isfinite(v) else (0.0, 0.0)


def as_python(row: xr.Dataset) -> str:
    """Return code that finds the steady state of a row again, from its section."""
    given = ", ".join(f"{name}={float(in_si(row[name]))!r}" for name in _stated(row))
    call = "Exciter.from_physical" if is_physical(row) else "Exciter"
    exciter = exciter_of(row)
    x, v = section_of(row, exciter)
    if not math.isfinite(x + v):
        x, v = exciter.check_start(None, 0.0)
    si = mass_and_stiffness(row)
    lines = [
        "import vibropipe as vp",
        "",
        f"exciter = vp.{call}({given})",
        f"row = vp.steady_state(exciter, x0={x!r}, v0={v!r})",
        f"motion = vp.simulate(exciter, tau_end={PERIODS} * exciter.period, x0={x!r}, v0={v!r})",
    ]
    if si is not None:
        lines.append(
            f"row, motion = (vp.to_physical(each, m={si['m']!r}, C={si['C']!r}) for each in (row, motion))"
        )
    return "\n".join(lines) + "\n"


def as_yaml(row: xr.Dataset, title: str) -> str:
    """Return a study of the motion of a row, from its section on."""
    is_si, (x, v) = is_physical(row), _start(row)

    def written(name: str, value: float, of: str = "") -> str:
        units = str(row[of or name].attrs.get("units", "1"))
        unit = f" {plain_units(units)}" if is_si and units != "1" else ""
        return f"{name}: {value!r}{unit}"

    values = _parameters(row)
    own = [written(name, value) for name, value in values.items() if is_si and name in PHYSICAL]
    others = [
        written(name, value) for name, value in values.items() if not (is_si and name in PHYSICAL)
    ]
    start = f"{{{written('x0', x, 'displacement_strobe')}, {written('v0', v, 'velocity_strobe')}}}"
    length = PERIODS * exciter_of(row).period
    lines = [f"title: {json.dumps(title, ensure_ascii=False)}"]
    lines += [f"physical: {{{', '.join(own)}}}"] if own else []
    lines += [f"exciter: {{{', '.join(others)}}}"] if others else []
    lines += ["scenes:", "  point:", "    kind: motion", f"    start: {start}"]
    lines += [
        f"    tau_end: {_end(length, row)}",
        "    outputs: [motion, impacts, harmonics, stability]",
    ]
    return "\n".join(lines) + "\n"


def _end(length: float, row: xr.Dataset) -> str:
    """Write the end of a motion of a length in tau, in the units of a row."""
    si = mass_and_stiffness(row)
    if si is None:
        return repr(length)
    return f"{length / eigenfrequency(**si)!r} s"


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

    on_solve : called when the map is requested anew
    later : takes work to do once what was sent before is drawn
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
            self.law.text = f'<p class="law"><b>What if {escape(self.what_if.text)}:</b> {escape(str(error))}</p>'
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


def values_at(plane: Plane, at: tuple[int, ...]) -> tuple[float, ...]:
    """Return the values of the axes at indices."""
    return tuple(float(np.asarray(v)[n]) for v, n in zip(plane.values, at, strict=True))
