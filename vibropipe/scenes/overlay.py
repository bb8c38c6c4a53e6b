"""Several datasets of one kind over one another: motions over time, or sweeps and branches along one parameter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from vibropipe.figures.canvas import BODY, axes, hairlines, new_canvas, panel, plain_ticks
from vibropipe.figures.map_shapes import scale_of
from vibropipe.figures.style import DOTTED, LINES
from vibropipe.figures.text import axis_label, clock, parameter_names, value_text
from vibropipe.physics.exciter import ParameterError
from vibropipe.scenes.motion.curves import curve
from vibropipe.words.wording import series

LEFT, WIDTH, HEIGHT, BOTTOM, ABOVE, ENTRY_CM = 1.7, 13.9, 3.7, 1.1, 0.7, 0.45
MOTION, SWEEP, BRANCH = "motion", "sweep", "branch"
# Quantities of panels where none are chosen: the first two that all datasets hold.
OF_ROWS = ("displacement_amplitude", "impact_velocity_max", "displacement_mean")
OF_MOTIONS = ("displacement", "velocity")
# What is drawn of a quantity that has several values in a row.
PARTS = {"harmonic": "first harmonic", "support": "larger of both supports"}
WHAT = "motions, or sweeps of one parameter and branches along it"

Line = tuple[np.ndarray, np.ndarray, bool]  # x, y, whether it is stable


def draw_overlay(
    datasets: Mapping[str, xr.Dataset], kinds: Sequence[str], show: Sequence[str] = ()
) -> Figure:
    """Draw datasets over one another, a panel for each quantity.

    datasets : the datasets by the text that names them; by an empty text, a number or what differs names them
    show : quantities (default: displacement and velocity of motions; first harmonic and impact velocity of rows)
    Raises ParameterError if they cannot be drawn over one another; the message names what can.
    """
    shown = list(datasets.values())
    x = _abscissa(datasets, kinds)
    held = [n for n in show or (OF_MOTIONS if kinds[0] == MOTION else OF_ROWS) if _held(n, shown)]
    names = held if show else held[:2]
    if not names or set(show) - {*names}:
        wanted = next(iter(set(show) - {*names}), "")
        common = [n for n in (*OF_MOTIONS, *OF_ROWS) if _held(n, shown)]
        must = f"must be quantities that all datasets hold ({series(common) or 'there is none'})"
        raise ParameterError("show", show, must=must, got=repr(wanted))
    rows = -(-len(shown) // 3)
    top = 0.15 + ENTRY_CM * rows
    figure = new_canvas(BOTTOM + len(names) * (HEIGHT + ABOVE) + top)
    texts = _texts(datasets)
    for number, name in enumerate(names):
        bottom = BOTTOM + (len(names) - 1 - number) * (HEIGHT + ABOVE)
        ax = axes(figure, LEFT, bottom, WIDTH, HEIGHT)
        for style, dataset in zip(LINES, shown, strict=False):
            for at, values, is_stable in _lines(dataset, x, name):
                unstable = {"color": style["color"], "linestyle": DOTTED}
                mark = "o" if len(at) == 1 else ""  # no line shows one point
                ax.plot(at, values, **(style if is_stable else unstable), marker=mark)
        _finish(ax, shown[0], x, name, "abcdefg"[number] if len(names) > 1 else "")
        ax.tick_params(labelbottom=number == len(names) - 1)
    ax.set_xlabel(axis_label(shown[0][x]))
    handles = [
        Line2D([], [], label=text, **dict(style)) for style, text in zip(LINES, texts, strict=False)
    ]
    high = figure.get_figheight() * 2.54
    figure.legend(handles=handles, loc="upper left", bbox_to_anchor=(LEFT / 16.0, 1 - 0.05 / high),
                  ncols=min(3, len(shown)), borderaxespad=0, fontsize=BODY)  # fmt: skip
    return figure


def _abscissa(datasets: Mapping[str, xr.Dataset], kinds: Sequence[str]) -> str:
    """Return what the datasets run over, or raise a ParameterError if they do not run over the same."""
    odd = next((kind for kind in kinds if kind not in (MOTION, SWEEP, BRANCH)), None)
    if odd is not None or (MOTION in kinds and {*kinds} != {MOTION}):
        got = series(dict.fromkeys(kind.replace("_", " ") for kind in kinds))
        must = f"must be {WHAT} to be drawn over one another"
        raise ParameterError("dataset", datasets, must=must, got=f"{got} scenes")
    if len(datasets) > len(LINES):
        must = f"must be at most {len(LINES)} datasets over one another"
        raise ParameterError("dataset", datasets, must=must, got=str(len(datasets)))
    first = ""
    for number, (dataset, kind) in enumerate(zip(datasets.values(), kinds, strict=True), 1):
        name = _axis(dataset, kind, number)
        first = first or name
        if name != first:
            must = f"must run over {first} as the first dataset does"
            raise ParameterError(f"dataset {number}", dataset, must=must, got=name)
    return first


def _axis(dataset: xr.Dataset, kind: str, number: int) -> str:
    """Return what one dataset runs over."""
    if kind == MOTION:
        name = clock(dataset)
        if name not in dataset.dims:
            must = "must have samples: simulate with samples_per_period above 0"
            raise ParameterError(f"dataset {number}", dataset, must=must, got="")
        return name
    if kind == BRANCH:
        if "follow" not in dataset.attrs:
            must = "must be branches, and not the speeds of a motor, to be drawn over one another"
            raise ParameterError(f"dataset {number}", dataset, must=must, got="")
        return str(dataset.attrs["follow"]).split()[0]
    dims = [str(dim) for dim in dataset["regime"].dims if dim != "direction"]
    if len(dims) != 1:
        must = "must have one swept parameter: choose one value of the others, as dataset.sel(f=1)"
        raise ParameterError(f"dataset {number}", dataset, must=must, got=series(dims) or "none")
    return dims[0]


def _held(name: str, datasets: Sequence[xr.Dataset]) -> bool:
    return all(name in dataset for dataset in datasets)


def _lines(dataset: xr.Dataset, x: str, name: str) -> Iterator[Line]:
    """Yield the lines of a quantity: of a motion one with its jumps, of rows a new one where the law changes."""
    if x == clock(dataset):
        yield (*curve(dataset, name), True)
        return
    values = dataset[name]
    for dim in PARTS.keys() & {*values.dims}:
        values = values.sel({dim: 1}) if dim == "harmonic" else values.max(dim)
    ways = dataset.sizes.get("direction", 1)
    for way in range(ways):
        at = {"direction": way} if "direction" in dataset.dims else {}
        own, line = dataset.isel(at), values.isel(at) if "direction" in values.dims else values
        laws = np.stack([np.asarray(own[each].values, float) for each in _laws(own)], axis=-1)
        cuts = np.flatnonzero((laws[1:] != laws[:-1]).any(axis=-1)) + 1
        stable = own["stable"].values if "branch_id" in own else np.ones(own[x].size, bool)
        places, numbers = own[x].values, np.asarray(line.values, float)
        for part in np.split(np.arange(places.size), cuts):
            # the stretches of a branch meet
            last = part[-1] + 1
            meets = last < places.size and "branch_id" in own and laws[last][0] == laws[part[-1]][0]
            part = np.append(part, last) if meets else part
            yield places[part], numbers[part], bool(stable[part[0]])


def _laws(dataset: xr.Dataset) -> list[str]:
    """Return the variables whose change ends a line."""
    names = ("branch_id", "stable") if "branch_id" in dataset else ("regime", "period_multiple")
    return [name for name in names if name in dataset]


def _finish(ax: Axes, dataset: xr.Dataset, x: str, name: str, letter: str) -> None:
    values = dataset[name]
    part = next((PARTS[str(dim)] for dim in values.dims if dim in PARTS), "")
    index = 1 if "harmonic" in values.dims else None
    unit = axis_label(values, index)
    ax.set_ylabel(axis_label(values, index, 26))
    ax.set_xscale(scale_of(dataset[x].values) if x not in ("tau", "time", "point") else "linear")
    panel(ax, letter, "" if part in unit or "harmonic" in part else part)
    hairlines(ax)
    plain_ticks(ax.yaxis, 5)


def _texts(datasets: Mapping[str, xr.Dataset]) -> list[str]:
    """Return the name of each dataset: its own, else the parameters that differ, else its number."""
    shown = list(datasets.values())
    names = [
        name
        for name in dict.fromkeys(name for data in shown for name in parameter_names(data))
        if all(name in data and data[name].ndim == 0 for data in shown)
        and len({float(data[name]) for data in shown}) > 1
    ]
    texts = [",  ".join(value_text(data[name]) for name in names) for data in shown]
    found = len(set(texts)) == len(texts)
    return [
        str(key) if isinstance(key, str) else text if found else str(key)
        for key, text in zip(datasets, texts, strict=True)
    ]
