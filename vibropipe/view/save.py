"""A page in one file: map, slices, values, and motions rebuilt in the browser from their stored impacts."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from bokeh.document import Document
from bokeh.embed import file_html
from bokeh.events import DocumentReady
from bokeh.layouts import column, row
from bokeh.models import ColumnDataSource, CustomJS, Div
from bokeh.resources import INLINE

from vibropipe.orbits.window import LISTED_PERIODS
from vibropipe.scenes.sweep.quantities import DEFAULT_SHOW, Series
from vibropipe.scenes.sweep.sweep_rows import rows_of_impacts
from vibropipe.solve.rebuild import SHOWN_PERIODS, mass_and_stiffness, motion_of, without_units
from vibropipe.store import StoreError, atomic_file
from vibropipe.view.page import REGIONS, Page
from vibropipe.view.plane import Plane
from vibropipe.view.results import Results, is_sweep
from vibropipe.view.saved_plan import plan_text
from vibropipe.view.words import source_of
from vibropipe.words.parameters import FURTHER, PARAMETERS
from vibropipe.words.regimes import Regime

# Points along an axis, impacts and rests, and bytes of the quantities, beyond which a page would grow above some 10 MB.
MAX_POINTS, MAX_EVENTS, MAX_FIELD_BYTES = 330, 600_000, 4_000_000
# Axes of no more points are never thinned.
MIN_POINTS = 20
# The parameters of motions that the script rebuilds; others must have their default, which means "effect absent".
REBUILT = tuple(name for name in PARAMETERS if name not in FURTHER)


def save_page(results: Results, path: Path) -> None:
    """Write a page of a sweep that needs neither server nor network.

    results : the first scene is saved, which must be a sweep; of more than MAX_POINTS points along an axis, every
        n-th
    Raises StoreError if the scene is no sweep.
    """
    scene = results.first
    dataset = results.datasets[scene]
    if not is_sweep(dataset):
        sweeps = ", ".join(name for name, data in results.datasets.items() if is_sweep(data))
        remedy = f"name one with --scene: {sweeps}" if sweeps else "it needs the server"
        raise StoreError(f"{scene}: is no sweep, and only sweeps can be saved as a page: {remedy}")
    others = {name: data for name, data in results.datasets.items() if name != scene}
    page = Page(Results(results.title, {scene: thinned(dataset), **others}, scene))
    document = saved_document(page, f"{results.title}: {scene}")
    text = file_html(
        document, INLINE, suppress_callback_warning=True, title=f"{results.title} – vibropipe"
    )
    with atomic_file(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def thinned(dataset: xr.Dataset) -> xr.Dataset:
    """Return every n-th row along each axis, with their impacts: MAX_POINTS of an axis and MAX_EVENTS at most."""
    loaded, dims = dataset.load(), [str(dim) for dim in dataset["regime"].dims]
    has_impacts = "row_size" in loaded
    for least in range(1, max(loaded["regime"].shape) + 1):
        kept = {dim: slice(None, None, _step(loaded.sizes[dim], least)) for dim in dims}
        part = loaded.isel(kept)
        if not has_impacts or _n_events(part) <= MAX_EVENTS:
            break
    if has_impacts:
        is_kept = xr.zeros_like(loaded["regime"], dtype=bool)
        is_kept[kept] = True
        part = part.isel(impact=is_kept.values.ravel()[rows_of_impacts(loaded)])
    return part


def _step(size: int, least: int) -> int:
    """Return of how many values of an axis one is kept; a short axis, such as of directions, is kept whole."""
    return max(least, -(-size // MAX_POINTS)) if size > MIN_POINTS else 1


def _n_events(dataset: xr.Dataset) -> float:
    """Return the number of impacts that are drawn, about."""
    is_listed = dataset["regime"] == Regime.APERIODIC
    drawn = xr.where(is_listed, SHOWN_PERIODS / LISTED_PERIODS, 1.0)
    return float((dataset["row_size"] * drawn).sum())


def saved_document(page: Page, title: str) -> Document:
    """Return the document of a page whose panels follow scripts in place of a server."""
    plane, point = page.plane, page.point
    drawn = saved_series(plane)
    fields = {
        f"f{n}": plane.in_order(one.of(plane.dataset)).astype(np.float32)
        for n, one in enumerate(drawn.values())
    }
    rows, events = stored_events(plane)
    callback = CustomJS(
        args={"plan_text": plan_text(page, drawn, list(fields)), **_models(page),
              "fields": ColumnDataSource(fields), "rows": ColumnDataSource(rows),
              "events_source": ColumnDataSource(events)},
        code=source_of("motion.js") + source_of("saved.js"),
    )  # fmt: skip
    page.quantity.options = [REGIONS, *drawn]
    page.crosshair.js_on_change("data", callback)
    for menu in (page.quantity, *page.menus):
        menu.js_on_change("value", callback)
    document = Document()
    right = column(
        point.law,
        point.panel.curves,
        row(point.drawing.figure, point.drawing.button),
        row(point.panel.portrait, point.numbers),
    )
    heading = Div(text=f"<b>{escape(title)}</b>", align="end", width=600, disable_math=True)
    head = row(page.quantity, *page.menus, heading)
    document.add_root(column(head, row(page.left, right)))
    document.js_on_event(DocumentReady, *page.scripts)
    return document


def _models(page: Page) -> dict[str, Any]:
    """Return what the script of a saved page changes, by the names that it has there."""
    panel, drawing = page.point.panel, page.point.drawing
    of_map: dict[str, Any] = dict.fromkeys(
        ("mapper", "bar", "regions", "words", "outlines", "image")
    )
    if page.map is not None:
        of_map = {name: getattr(page.map, name) for name in of_map}
    return of_map | {
        "crosshair": page.crosshair, "x_axis": page.x_axis, "y_axis": page.y_axis,
        "quantity": page.quantity, "menus": list(page.menus), "legend": page.legend,
        "slices": [[each.points, each.lines, each.ruler, each.range] for each in page.slices],
        "motion": panel.sources["motion"], "jumps": panel.jumps, "section": panel.section,
        "x_range": panel.x_range, "drawing_range": drawing.x_range, "mass": drawing.mass,
        "spring": drawing.spring,
        "walls": [*panel.boxes, *drawing.walls], "law": page.point.law, "numbers": page.point.numbers,
    }  # fmt: skip


def saved_series(plane: Plane) -> dict[str, Series]:
    """Return the quantities that a page holds, by label: the main ones, and others as far as there is room."""
    room = max(len(DEFAULT_SHOW), MAX_FIELD_BYTES // (4 * plane.dataset["regime"].size))
    ordered = sorted(plane.series.items(), key=lambda pair: pair[1].name not in DEFAULT_SHOW)
    chosen = {label for label, _series in ordered[:room]}
    return {label: one for label, one in plane.series.items() if label in chosen}


def stored_events(plane: Plane) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return per row its code, periods, first event and number of events, and the events of all rows.

    An event is an impact: time in forcing periods, velocity before it, support; or a rest: its start, its end, minus
    its support. Rests are not stored; the few rows that have some are marched to find them.
    """
    data = plane.dataset
    codes, regime = plane.in_order(plane.row_codes), plane.in_order(data["regime"])
    multiple = plane.in_order(data["period_multiple"]).astype(np.int32)
    has_impacts = "impact_phase" in data
    owner, impacts = (
        _shown_impacts(data, regime) if has_impacts else (np.empty(0, int), np.empty((3, 0)))
    )
    parts, owners = [impacts], [owner]
    for number in np.flatnonzero(regime == Regime.WITH_REST):
        rests = _rests(plane, int(number))
        parts.append(rests)
        owners.append(np.full(rests.shape[1], number))
    owner, events = np.concatenate(owners), np.concatenate(parts, axis=1)
    order = np.lexsort((events[0], owner))
    count = np.bincount(owner, minlength=codes.size)
    is_known = (
        (multiple > 0)
        & (has_impacts & is_rebuilt(data))
        & ((count > 0) | (regime == Regime.NO_IMPACT))
    )
    is_known &= ~((regime == Regime.NO_IMPACT) & (_row_damping(plane) == 0.0))
    is_known |= (regime == Regime.APERIODIC) & has_impacts & is_rebuilt(data) & (count > 1)
    rows = {
        "code": codes.astype(np.uint8), "multiple": multiple,
        "first": (np.cumsum(count) - count).astype(np.int32), "count": count.astype(np.int32),
        "known": is_known.astype(np.uint8),
    }  # fmt: skip
    time, velocity, support = events[:, order]
    return rows, {"time": time, "velocity": velocity, "support": support.astype(np.int8)}


def _shown_impacts(data: xr.Dataset, regime: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the row of each impact that is drawn, and the impacts as events (3, n).

    Of a motion without an orbit these are the impacts of the last SHOWN_PERIODS forcing periods.
    """
    owner, period = rows_of_impacts(data), data["impact_period"].values
    last = np.zeros(regime.size, np.int64)
    np.maximum.at(last, owner, period)
    first = np.where(regime == Regime.APERIODIC, np.maximum(0, last + 1 - SHOWN_PERIODS), 0)[owner]
    velocity = data["impact_velocity"].values * without_units(data, "velocity", 1.0)
    time = period - first + data["impact_phase"].values
    kept = period >= first
    return owner[kept], np.stack([time, velocity, data["impact_support"].values])[:, kept]


def _rests(plane: Plane, number: int) -> np.ndarray:
    """Return the rests of a row as events (3, n)."""
    motion = motion_of(plane.row(number))
    if motion is None:
        return np.empty((3, 0))
    rests, period = motion.plain, motion.exciter.period
    ends = np.minimum(rests["rest_end"].values, motion.length)
    return np.stack(
        [rests["rest_start"].values / period, ends / period, -rests["rest_support"].values]
    )


def _row_damping(plane: Plane) -> np.ndarray:
    name = "H" if mass_and_stiffness(plane.dataset) else "h"
    regime = plane.dataset["regime"]
    damping, _ = xr.broadcast(plane.dataset[name], regime)
    return plane.in_order(damping)


def is_rebuilt(data: xr.Dataset) -> bool:
    """Return whether the script knows all effects of a dataset."""
    others = [name for name in PARAMETERS if name not in REBUILT and name in data.variables]
    return all(bool(np.all(data[name].values == PARAMETERS[name].default)) for name in others)
