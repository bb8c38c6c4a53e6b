"""What the script of a saved page has to know: how rows are numbered, what is drawn how, which parameters they have."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from html import escape
from typing import Any

import numpy as np
import xarray as xr
from bokeh.palettes import cividis

from vibropipe.figures.palette import SUPPORT_COLOURS
from vibropipe.figures.phase_plane import FAR_SUPPORT
from vibropipe.figures.text import parameter_names, with_units
from vibropipe.scenes.sweep.quantities import Series
from vibropipe.solve.rebuild import exciter_of, unit_of_row, without_units
from vibropipe.solve.sweep.sweep_grid import DIRECTION
from vibropipe.solve.with_units import plain_name
from vibropipe.view.map_panel import even_cells, flag_colours, limits_of
from vibropipe.view.motion_panel import MARGIN, MASS
from vibropipe.view.page import Page
from vibropipe.view.plane import MARKERS, Plane
from vibropipe.view.slices import least_length, shown_series, slice_label
from vibropipe.view.words import symbol, value_of
from vibropipe.words.parameters import PARAMETERS

UNKNOWN = "Its motion is not in this file."


def plan_text(page: Page, drawn: Mapping[str, Series], keys: list[str]) -> str:
    """Return the plan of a page as JSON; `keys` name the columns of the quantities."""
    plane = page.plane
    sizes = [plane.dataset.sizes[name] for name in plane.dims]
    strides = {name: int(np.prod(sizes[n + 1 :])) for n, name in enumerate(plane.dims)}
    menus, labels = page.plane.further_dims, list(drawn)
    is_curved = plane.directions != [""]
    plan = {
        "strides": [strides[name] for name in plane.axes],
        "menus": [strides[name] for name in menus],
        "directions": [n * strides[DIRECTION] for n in range(len(plane.directions))] if is_curved else [0],
        "drawn": sum(strides[name] * at for name, at in plane.further.items()),
        "columns": even_cells(plane.values[0]).tolist(),
        "rows": even_cells(plane.values[1]).tolist() if len(plane.axes) > 1 else [],
        "series": [_series_plan(page, label, one, key) for (label, one), key in zip(drawn.items(), keys, strict=True)],
        "short": slice_label(plane, shown_series(plane, None)),
        "legend": page.legend_of(None),
        "least": least_length(plane, shown_series(plane, None)[0]),
        "of_regions": [labels.index(plane.label(one)) for one in shown_series(plane, None)],
        "regions": [
            {"text": each.text, "colour": each.colour, "html": escape(each.text).capitalize()}
            for each in plane.regions
        ],
        "palette": list(cividis(256)),
        "words": {} if page.map is None else {k: list(v) for k, v in page.map.words.data.items()},
        "markers": MARKERS,
        "axis_marks": [escape(symbol(plane.dataset[name])) for name in plane.axes],
        "menu_marks": [escape(symbol(plane.dataset[name])) for name in menus],
        "way": menus.index(DIRECTION) if is_curved else -1,
        "parameters": list(_parameters(plane, menus)),
        "support_colours": [SUPPORT_COLOURS[1], SUPPORT_COLOURS[2]],
        "far": FAR_SUPPORT, "margin": MARGIN, "mass": MASS, "unknown": UNKNOWN,
    }  # fmt: skip
    return json.dumps(plan | _physics(plane, menus), ensure_ascii=False, allow_nan=False)


def _series_plan(page: Page, label: str, series: Series, key: str) -> dict[str, Any]:
    plane, flags = page.plane, page.plane.flags(series)
    values = np.asarray(series.of(plane.dataset).values, float)
    index = None if series.position is None else series.position + 1
    tail = f", support {index}" if series.dim == "support" else ""
    return {
        "label": label,
        "key": key,
        "limits": (-0.5, max(flags) + 0.5) if flags else limits_of(series.name, values),
        "palette": flag_colours(flags) or None,
        "texts": [flags.get(n, "") for n in range(max(flags, default=-1) + 1)],
        "legend": page.legend_of(series),
        "mark": escape(symbol(plane.dataset[series.name], index)),
        "name": escape(str(plane.dataset[series.name].attrs.get("long_name", series.name)) + tail),
        "unit": escape(_unit(plane.dataset[series.name])),
        "short": slice_label(plane, [series]),
        "least": least_length(plane, series),
    }


def _unit(array: xr.DataArray) -> str:
    unit = with_units(array, "")
    return f" {unit}" if unit else ""


def _parameters(plane: Plane, menus: list[str]) -> Iterator[dict[str, Any]]:
    """Yield symbol, name and unit of each parameter, with its value as text or where the page finds it."""
    for name in parameter_names(plane.dataset):
        array = plane.dataset[name]
        is_fixed = array.ndim == 0
        if not (is_fixed or name in plane.axes or name in menus):
            continue
        yield {
            "mark": escape(symbol(array)),
            "name": escape(str(array.attrs.get("long_name", name))),
            "text": escape(value_of(array, float(array))) if is_fixed else None,
            "axis": plane.axes.index(name) if name in plane.axes else -1,
            "menu": menus.index(name) if name in menus else -1,
            "unit": escape(_unit(array)),
        }


def _physics(plane: Plane, menus: list[str]) -> dict[str, Any]:
    """Return the parameters that are the same in every row, the names of the others, and their factors from SI."""
    one = plane.dataset.isel(dict.fromkeys(plane.dims, 0))

    def plain(name: str) -> str:
        own = plain_name(name)
        return own if own in PARAMETERS else ""

    def factor(name: str) -> float:
        return without_units(one, plain(name), 1.0) if plain(name) else 1.0

    exciter = exciter_of(one).parameters()._asdict()
    return {
        "exciter": exciter,
        "axes": [plain(name) for name in plane.axes],
        "factors": [factor(name) for name in plane.axes],
        "menu_names": [plain(name) for name in menus],
        "menu_factors": [factor(name) for name in menus],
        "scale": {
            "time": unit_of_row(one, "tau"),
            "length": unit_of_row(one, "displacement"),
            "velocity": unit_of_row(one, "velocity"),
        },
    }
