"""What if a parameter that was not swept had another value: the motion at once, the map anew on request."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from threading import Lock
from typing import Any

import numpy as np
import xarray as xr
from bokeh.layouts import column
from bokeh.layouts import row as in_row
from bokeh.models import Button, Column, Slider, Spacer, Spinner, Toggle

from vibropipe.figures.text import format_number, in_brackets, parameter_names, with_units
from vibropipe.physics.exciter import Exciter
from vibropipe.physics.start import start_at, within_room
from vibropipe.scenes.sweep.sweep_rows import row_at
from vibropipe.solve.basins.attractors import attractors
from vibropipe.solve.basins.basins import basins
from vibropipe.solve.rebuild import (
    changed_row,
    exciter_of,
    in_units_of,
    mass_and_stiffness,
    section_of,
    tied_again,
    ties_of,
    unit_of_row,
    without_units,
)
from vibropipe.solve.rows.steady import steady_state
from vibropipe.solve.shown_units import shown_in
from vibropipe.solve.sweep.blocks import PATIENCE, assemble, solve_shard
from vibropipe.solve.sweep.sweep import grid_of
from vibropipe.solve.sweep.sweep_grid import DIRECTION
from vibropipe.solve.with_units import plain_name
from vibropipe.view.one_exciter import grid_of_starts
from vibropipe.view.plane import Plane
from vibropipe.view.words import script, symbol
from vibropipe.words.outputs import OF_STEADY_STATE, OUTPUTS
from vibropipe.words.parameters import DEFAULTS, FURTHER, PARAMETERS, PHYSICAL
from vibropipe.words.progress import Progress
from vibropipe.words.status import UnsolvedWarning
from vibropipe.words.vocabulary import (
    STEADY,
    attributes,
    drawn_by,
    held_name,
    physical_attributes,
    physical_name,
)

_START = re.compile(r"x0 = (\S+).*, v0 = (\S+)")
MAP_ANEW = "map anew"
STEPS = 50  # of a spinner over the size of its value
FINE_STEPS = 400  # of a slider from end to end
SPINNER_WIDTH = 84
# Kernels on all cores are called by one thread at a time.
ALL_CORES = Lock()


def unswept(plane: Plane) -> dict[str, xr.DataArray]:
    """Return the parameters that are the same in every row and not tied, those of absent effects included, by name."""
    names = [name for name in parameter_names(plane.dataset) if plane.dataset[name].ndim == 0]
    arrays = {name: plane.dataset[name] for name in names} | absent(plane)
    tied = {held_name(arrays, name) for name in ties_of(plane.dataset).parameters}
    return {name: array for name, array in arrays.items() if name not in tied}


def absent(plane: Plane) -> dict[str, xr.DataArray]:
    """Return the parameters of effects that no row has, absent, by the names that the dataset would have for them."""
    is_si = mass_and_stiffness(plane.dataset) is not None
    parameters = {}
    for name in FURTHER:
        held = physical_name(name) if is_si else name
        if held not in plane.dataset.variables:
            attrs = physical_attributes(name) if is_si else attributes(name)
            parameters[held] = xr.DataArray(DEFAULTS[name], name=held, attrs=attrs)
    return dict(shown_in(plane.dataset).dataset(xr.Dataset(parameters)).data_vars)  # type: ignore[arg-type]


def steady_row(row: xr.Dataset, changed: dict[str, float]) -> xr.Dataset:
    """Return the steady state that the motion of a row settles on when parameters change.

    row : a stored row, from whose section the motion goes on
    changed : new values of parameters, in the units of the row
    Raises ParameterError if a value is out of range.
    """
    exciter = tied_again(row, exciter_of(changed_row(row, changed)))
    x, v = section_of(row, exciter)
    if not np.isfinite([x, v]).all():
        x, v = float(start_at(exciter.l, exciter.delta, None, 0.0)), 0.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnsolvedWarning)
        steady = steady_state(exciter, x0=x, v0=v, outputs=OF_STEADY_STATE, patience=PATIENCE)
    return in_units_of(changed_row(row, changed), steady)


def row_of_start(plane: Plane, *start: float) -> xr.Dataset | None:
    """Return the steady state from a start of a plane that no attractor was found from; None at another phase."""
    shared = plane.dataset.isel(plane.further).drop_dims(["x0", "v0"]).coords
    row = xr.Dataset(coords={name: each for name, each in shared.items() if not each.dims})
    row = row.assign_attrs(plane.dataset.attrs)
    if float(row["start_phase"]) % 1.0:
        return None
    factors = (unit_of_row(row, name) for name in ("displacement", "velocity"))
    x0, v0 = (value / factor for value, factor in zip(start, factors, strict=True))
    exciter = exciter_of(row)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnsolvedWarning)
        x0 = float(within_room(exciter, x0))
        solved = steady_state(exciter, x0, v0, outputs=OF_STEADY_STATE, patience=PATIENCE)
    return in_units_of(row, solved)


def attractor_rows(row: xr.Dataset) -> list[xr.Dataset]:
    """Return the motions that scattered starts of the exciter of a row settle on, each a row in its units."""
    with ALL_CORES, warnings.catch_warnings():
        warnings.simplefilter("ignore", UnsolvedWarning)
        found = in_units_of(row, attractors(exciter_of(row)))
    return [row_at(found, number).load() for number in range(found.sizes["attractor_id"])]


def solve_anew(plane: Plane, changed: dict[str, float], on_rows: Progress) -> xr.Dataset:
    """Solve all rows of a plane again with changed parameters; `on_rows` is called as on_rows(done, total).

    Starts that would lie beyond a support are replaced by as many from support to support.
    """
    with ALL_CORES:
        return _solved_anew(plane, changed, on_rows)


def _solved_anew(plane: Plane, changed: dict[str, float], on_rows: Progress) -> xr.Dataset:
    dataset = changed_row(plane.dataset, changed)
    swept = [str(name) for name in plane.dims if name != DIRECTION]
    one = dataset.isel(dict.fromkeys(plane.dims, 0))
    exciter = exciter_of(one)
    over: dict[str, Any] = {
        plain_name(name): np.asarray(dataset[name].values, float)
        * without_units(one, plain_name(name), 1.0)
        for name in swept
    }
    if plane.of_starts:
        x0, v0 = (over.pop(name) for name in ("x0", "v0"))
        exciter = tied_again(one, exciter)
        if not over and (x0[0] < exciter.lower or x0[-1] > exciter.upper):
            x0, v0 = grid_of_starts(exciter, x0.size, v0.size)
        solved = basins(
            exciter, x0, v0, phase=float(dataset["start_phase"]), over=over or None,
            harmonics=dataset.sizes.get("harmonic", 1), progress=on_rows,
        )  # fmt: skip
        return in_units_of(dataset, solved)
    return in_units_of(dataset, _swept(exciter, over, dataset, on_rows))


def _swept(
    exciter: Exciter, over: dict[str, Any], dataset: xr.Dataset, on_rows: Progress
) -> xr.Dataset:
    """Solve a sweep that starts or follows as a stored one does."""
    follow: Any = tuple(str(dataset.attrs["follow"]).split()) if "follow" in dataset.attrs else None
    if follow is not None:
        follow = (plain_name(follow[0]), follow[1])
    start = _START.fullmatch(str(dataset.attrs.get("start", "")))
    options: dict[str, Any] = {}
    if start and follow is None and not {"x0", "v0"} & over.keys() and "m" not in dataset.coords:
        x0 = None if "support" in start[0] else float(start[1])
        options = {"start": (x0, float(start[2]))}
    shown = {STEADY[name].output for name in drawn_by("sweep") if name in dataset}
    outputs = [name for name in OUTPUTS if name in shown]
    ties = ties_of(dataset)
    grid = grid_of(ties.untied(exciter), over, follow, ties.texts)
    harmonics = dataset.sizes.get("harmonic", 1)
    rows = solve_shard(
        grid, 0, grid.rows, outputs=outputs, progress=on_rows, harmonics=harmonics, **options
    )
    return assemble([rows], grid)


def with_slider(spinner: Spinner) -> Column:
    """Return a spinner above a slider of the same parameter: over its range, else up to twice its value."""
    value = spinner.value
    reach = 2.0 * abs(value) or 1.0
    low = -reach if spinner.low is None else spinner.low
    high = reach if spinner.high is None else spinner.high
    step = 1.0 if spinner.step == 1.0 else (high - low) / FINE_STEPS
    slider = Slider(
        start=low, end=high, value=value, step=step, show_value=False, title=None,
        width=SPINNER_WIDTH, margin=(0, 5, 0, 5), name=f"slider_{spinner.name}",
    )  # fmt: skip
    moved = script("slide.js", slider=slider, field=spinner)
    slider.js_on_change("value", moved)
    spinner.js_on_change("value", moved)
    return column(spinner, slider)


class WhatIf:
    """Spinners with sliders of the parameters that were not swept, and the button that solves the map anew.

    on_change : called when a spinner changes
    on_solve : called when the map is requested
    """

    def __init__(self, on_change: Callable[[], None], on_solve: Callable[[], None]) -> None:
        self._on_change = on_change
        self.spinners: dict[str, Spinner] = {}
        self.button = Button(label=MAP_ANEW, width=110, name="map_anew", disabled=True)
        self.button.on_click(on_solve)
        self.reset = Button(label="as stored", width=80, name="as_stored", disabled=True)
        self.reset.on_click(self.as_stored)
        look = {"styles": {"flex-wrap": "wrap", "align-items": "end"}, "width": 1255}
        self._first, self._second = in_row(Spacer(width=0), **look), in_row(Spacer(width=0), **look)
        self._second.visible = False
        self.more = Toggle(label="further effects", width=110, name="further_effects")
        self.more.js_link("active", self._second, "visible")
        self.root = column(self._first, self._second)
        self._is_setting = False

    def open(self, plane: Plane) -> None:
        """Make the spinners of a plane."""
        arrays, further = unswept(plane), absent(plane)
        self._stored = {name: float(array) for name, array in arrays.items()}
        self.spinners = {name: self._spinner(array) for name, array in arrays.items()}
        present = [
            with_slider(spinner) for name, spinner in self.spinners.items() if name not in further
        ]
        self._first.children = [*present, self.reset, self.button, self.more]
        self._second.children = [with_slider(self.spinners[name]) for name in further] or [
            Spacer(width=0)
        ]
        self._set_buttons()

    def _spinner(self, array: xr.DataArray) -> Spinner:
        name, value = str(array.name), float(array)
        physical = PHYSICAL.get(name) if with_units(array, "") else None
        limits = (physical or PARAMETERS.get(name) or PHYSICAL[name]).range
        size = 10.0 ** np.floor(np.log10(abs(value))) if value else 1.0
        step = 0.01 if np.isfinite(limits.high) else float(size) / STEPS * 5
        step = 1.0 if limits.whole else step
        spinner = Spinner(
            title=in_brackets(symbol(array), array), value=value, step=step,
            low=limits.low if np.isfinite(limits.low) else None,
            high=limits.high if np.isfinite(limits.high) else None,
            width=SPINNER_WIDTH, name=name,
        )  # fmt: skip
        spinner.on_change("value", lambda attr, old, new: self._changed())
        return spinner

    @property
    def changed(self) -> dict[str, float]:
        """The parameters that differ from the stored ones."""
        values = {name: spinner.value for name, spinner in self.spinners.items()}
        return {
            name: float(value)
            for name, value in values.items()
            if value is not None and value != self._stored[name]
        }

    @property
    def text(self) -> str:
        """The changed parameters, for a name."""
        marks = [
            f"{self.spinners[name].title.split()[0]} = {format_number(value)}"
            for name, value in self.changed.items()
        ]
        return ", ".join(marks)

    def as_stored(self) -> None:
        """Set all parameters as they are stored."""
        self._is_setting = True
        for name, spinner in self.spinners.items():
            spinner.value = self._stored[name]
        self._is_setting = False
        self._changed()

    def _changed(self) -> None:
        if not self._is_setting:
            self._set_buttons()
            self._on_change()

    def tell(self, progress: str) -> None:
        """Show how far the map is; "" when none is solved."""
        self.button.label = f"solving {progress}" if progress else MAP_ANEW
        self.button.disabled = bool(progress) or not self.changed

    def _set_buttons(self) -> None:
        self.button.disabled = self.reset.disabled = not self.changed
