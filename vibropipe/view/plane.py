"""The rows of a dataset as a plane to point at: axes, regions, values, and the row at a point; its legend."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.figures.palette import FAILED
from vibropipe.figures.regime_words import regime_text
from vibropipe.scenes.basins.attractors import colours_of
from vibropipe.scenes.sweep.laws import laws_of
from vibropipe.scenes.sweep.map_layout import map_axes
from vibropipe.scenes.sweep.quantities import Series, series_of
from vibropipe.scenes.sweep.sweep_rows import (
    axis_and_others,
    is_map,
    row_at,
    with_impacts_per_period,
)
from vibropipe.solve.sweep.sweep_grid import DIRECTION
from vibropipe.view.results import is_basins
from vibropipe.view.words import label_of
from vibropipe.words.regimes import Regime

Floats = NDArray[np.float64]
# Dimensions of a quantity, beside those of the rows, of which each element can be drawn.
ELEMENTS = ("support", "harmonic", "multiplier", "subharmonic", "parameter")
MAX_ELEMENTS = 8
MAX_KEPT = 8  # arrays of a plane that are kept


class Region(NamedTuple):
    """What equal codes of a map mean: a text within the map, one of the legend, and a colour."""

    short: str
    text: str
    colour: str


@dataclass
class Plane:
    """The rows of a sweep or of basins over two axes, or over one, at chosen values of the others.

    dataset : a sweep, or basins
    further : index along each dimension that is no axis
    """

    dataset: xr.Dataset
    further: dict[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._arrays: dict[tuple, NDArray] = {}
        self.dataset = with_impacts_per_period(self.dataset)
        for name in self.further_dims:
            self.further.setdefault(name, 0)

    @cached_property
    def of_starts(self) -> bool:
        """Whether the axes are those of starts, and rows are attractors."""
        return is_basins(self.dataset)

    @cached_property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes, abscissa first: two of a map, one of curves."""
        if self.of_starts:
            return ("x0", "v0")
        if is_map(self.dataset):
            return map_axes(self.dataset)[:2]
        return (axis_and_others(self.dataset)[0],)

    @cached_property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of what is drawn."""
        return tuple(map(str, self.dataset["attractor" if self.of_starts else "regime"].dims))

    @cached_property
    def further_dims(self) -> list[str]:
        """Dimensions that are no axis."""
        return [name for name in self.dims if name not in self.axes]

    @cached_property
    def values(self) -> list[Floats]:
        """Values along each axis."""
        return [np.asarray(self.dataset[name].values, float) for name in self.axes]

    @cached_property
    def labels(self) -> list[str]:
        """Labels of the axes."""
        return [label_of(self.dataset[name]) for name in self.axes]

    @cached_property
    def _laws(self) -> tuple[xr.DataArray, list[Region]]:
        """Return the code of each row of a sweep, and its laws by code."""
        codes, laws = laws_of(self.dataset)
        return codes, [Region(law.short, law.text, law.colour) for law in laws]

    @property
    def row_codes(self) -> xr.DataArray:
        """Codes of the rows."""
        return self.dataset["attractor"] + 1 if self.of_starts else self._laws[0]

    @property
    def regions(self) -> list[Region]:
        """What the codes mean: laws of motion, or the attractors at the chosen values of the other dimensions."""
        if not self.of_starts:
            return self._laws[1]
        regions = [Region("none found", "no attractor was found", FAILED)]
        regimes = self.dataset["regime"].isel(self.further).values
        own = colours_of(self.dataset)
        for index, regime in enumerate(regimes):
            words, colour = regime_text(int(regime)), own.get(index, FAILED)
            regions.append(Region(f"{index}", f"attractor {index}: {words}", colour))
        return regions

    @property
    def attractors(self) -> list[int]:
        """Numbers of the attractors of starts at the chosen values of the other dimensions."""
        regimes = self.dataset["regime"].isel(self.further).values
        return [int(n) for n in np.flatnonzero(regimes != Regime.UNRESOLVED)]

    def flags(self, series: Series) -> dict[int, str]:
        """Return what the values of a quantity mean in words; nothing of one that is a number."""
        attrs = self.dataset[series.name].attrs
        words = [each.replace("_", " ") for each in str(attrs.get("flag_meanings", "")).split()]
        return dict(zip(map(int, attrs.get("flag_values", ())), words, strict=False))

    def at_further(self, array: xr.DataArray, **others: int) -> NDArray:
        """Return an array (y, x), or (x,) of curves, at the chosen values of the other dimensions."""
        chosen = {**self.further, **others}
        part = array.isel({name: at for name, at in chosen.items() if name in array.dims})
        return np.asarray(part.transpose(*reversed(self.axes)).values)

    def _kept(self, key: object, others: dict[str, int], make: Callable[[], NDArray]) -> NDArray:
        """Return an array that was made before for the same values of the other dimensions, or make it."""
        whole = (key, *{**self.further, **others}.items())
        if whole not in self._arrays:
            if len(self._arrays) >= MAX_KEPT:
                del self._arrays[next(iter(self._arrays))]
            self._arrays[whole] = make()
        return self._arrays[whole]

    def in_order(self, array: xr.DataArray) -> NDArray:
        """Return the values of all rows, in the order of their numbers."""
        return np.asarray(array.transpose(*self.dims).values).ravel()

    def codes(self, **others: int) -> NDArray[np.int64]:
        """Return the codes (y, x) of the regions."""
        return self._kept(
            "codes", others, lambda: self.at_further(self.row_codes, **others).astype(np.int64)
        )

    @cached_property
    def series(self) -> Mapping[str, Series]:
        """The quantities that can be drawn, by label."""
        by_label: dict[str, Series] = {}
        for key, array in self.dataset.data_vars.items():
            own = [str(dim) for dim in array.dims if dim not in self.dims]
            is_drawn = set(self.dims) <= set(array.dims) and array.dtype.kind in "iufbc"
            if not is_drawn or len(own) > 1 or (own and own[0] not in ELEMENTS):
                continue
            if own and own[0] not in ("support", "multiplier", "harmonic"):
                each = [
                    Series(str(key), own[0], n, str(n + 1))
                    for n in range(min(array.sizes[own[0]], MAX_ELEMENTS))
                ]
            elif own:
                each = series_of(self.dataset, str(key))
            else:
                each = [Series(str(key))]
            for one in each:
                by_label[self.label(one)] = one
        return by_label

    def label(self, series: Series) -> str:
        """Return the label of an element of a quantity."""
        array = self.dataset[series.name]
        if series.dim is None or series.position is None:
            return label_of(array)
        numbers = self.dataset.coords.get(series.dim, range(1, series.position + 2))
        text = str(np.asarray(numbers)[series.position])
        index = int(text) if text.isdigit() else None
        # A symbol with an index says which one, but for supports.
        tail = f", {series.dim} {text}" if series.dim in ("support", "parameter") else ""
        return label_of(array, index) + tail

    def field(self, series: Series, **others: int) -> Floats:
        """Return the values (y, x) of a quantity; of complex ones the modulus."""
        return self._kept(
            series, others, lambda: self.at_further(series.of(self.dataset), **others).astype(float)
        )

    def nearest(self, *point: float) -> tuple[int, ...]:
        """Return the index along each axis of the row nearest to a point."""
        return tuple(
            int(np.argmin(np.abs(values - at)))
            for values, at in zip(self.values, point, strict=True)
        )

    def row_number(self, at: tuple[int, ...], **others: int) -> int:
        """Return the flat number of the row at indices of the axes; -1 where a start has no attractor."""
        index = {**self.further, **others, **dict(zip(self.axes, at, strict=True))}
        if self.of_starts:
            return int(self.dataset["attractor"].isel(index))
        shape = [self.dataset.sizes[name] for name in self.dims]
        return int(np.ravel_multi_index([index[name] for name in self.dims], shape))

    def row(self, number: int) -> xr.Dataset:
        """Return one row by its flat number (of starts, by its attractor), with its own impacts alone, in memory."""
        if not self.of_starts:
            return row_at(self.dataset, number).load()
        rows = self.dataset.drop_dims(["x0", "v0"])
        at = [self.further.get(str(name), number) for name in rows["regime"].dims]
        return row_at(rows, int(np.ravel_multi_index(at, rows["regime"].shape))).load()

    @property
    def directions(self) -> list[str]:
        """The directions in which curves were followed; one empty text without them."""
        is_curved = len(self.axes) == 1 and DIRECTION in self.dims
        return [str(each) for each in self.dataset[DIRECTION].values] if is_curved else [""]


# Marks of slices: what Bokeh calls them, and as letters.
MARKERS, LETTERS = ("circle", "triangle", "inverted_triangle", "square"), "●▲▼■"
# Strokes and gaps of the dashes that Bokeh names, in pixels.
STROKES = {"solid": "", "dashed": "6", "dotted": "2 4", "dashdot": "2 4 6 4"}
SIGNS = {
    "circle": "○", "square": "□", "diamond": "◇", "triangle": "△", "inverted_triangle": "▽",
    "x": "×", "star": "☆",
}  # fmt: skip
LEGEND_CSS = """
.legend {font-size: 11px; line-height: 1.3}
.legend div {padding-left: 28px; text-indent: -28px}
.legend i {display: inline-block; width: 22px; height: 9px; margin-right: 6px; text-indent: 0; font-style: normal;
           text-align: center; line-height: 9px}
.legend .area {border: 1px solid #333333; box-sizing: border-box}
"""


def legend_html(parts: Iterable[str]) -> str:
    """Return a legend as HTML; each part is a line of it."""
    return f'<div class="legend">{"".join(parts)}</div>'


def region_lines(regions: Iterable[Region]) -> list[str]:
    """Return a line for each region: its colour and its text."""
    return [
        f'<div><i class="area" style="background: {each.colour}"></i>{escape(each.text)}</div>'
        for each in regions
    ]


def regions_shown(plane: Plane) -> list[Region]:
    """Return the regions that a plane shows, the largest first."""
    others = [{"direction": n} if each else {} for n, each in enumerate(plane.directions)]
    codes = np.concatenate([plane.codes(**each).ravel() for each in others])
    sizes = np.bincount(codes, minlength=len(plane.regions))
    return [plane.regions[n] for n in np.argsort(-sizes, kind="stable") if sizes[n]]


def mark_lines(plane: Plane, chosen: list[Series]) -> list[str]:
    """Return a line for each mark of slices, where there are several."""
    names = [
        " ".join(filter(None, [f"{one.dim} {one.position + 1}" if one.position is not None else "", direction]))
        for one in chosen
        for direction in plane.directions
    ]  # fmt: skip
    if len(names) < 2:
        return []
    return [
        f"<div><i>{LETTERS[n % len(LETTERS)]}</i>{escape(name)}</div>"
        for n, name in enumerate(names)
    ]


def stroke_line(text: str, colour: str, dash: str, width: float) -> str:
    """Return the line of a curve."""
    look = f'stroke="{colour}" stroke-width="{width}" stroke-dasharray="{STROKES[dash]}"'
    drawn = f'<svg width="22" height="10"><path d="M0 5H22" {look}/></svg>'
    return f"<div><i>{drawn}</i>{escape(text)}</div>"


def sign_line(text: str, marker: str) -> str:
    """Return the line of a mark on a map."""
    return f"<div><i>{SIGNS[marker]}</i>{escape(text)}</div>"
