"""Picture of an identification: what was measured, what the parameters found give, and the difference."""

from __future__ import annotations

import textwrap
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibropipe.figures.canvas import axes, hairlines, new_canvas, note, zero_line
from vibropipe.figures.claims import at_most
from vibropipe.figures.palette import EXACT, GREY, INK, METHODS
from vibropipe.figures.text import (
    axis_label,
    format_number,
    in_brackets,
    measured,
    plain_symbol_of,
    sentences,
    with_units,
)
from vibropipe.scenes.design.data import in_words
from vibropipe.scenes.kind import Picture
from vibropipe.words.designs import FitResult, FoundResult, Twin
from vibropipe.words.parameters import MIRRORED
from vibropipe.words.wording import capitalised, count, series

# Centimetres: a panel of a quantity and of what is left, what stands below them, between two, at the left.
PANEL, REST, FOOT, GAP, LEFT = 3.4, 2.6, 1.15, 0.45, 1.8
WIDTH, NAMED = 13.9, 0.85
# Size of a circle, and of one of many.
SIZE, MANY_SIZE, MANY = 3.4, 1.2, 300
MARKERS = "osD^vPX"
TITLES = {
    FitResult.EXPLAINED: "The fit of the {} leaves no more than noise",
    FitResult.BEYOND_NOISE: "The nearest fit of the {} leaves more than noise",
    FitResult.CONSTANT: "The {} that was measured tells nothing",
    FitResult.ABSENT: "The nearest motion lacks some of the {}",
    FitResult.NOT_JUDGED: "The nearest fit of the {}, whose noise is not known",
}
TWINS = {
    Twin.OTHER: "Other parameters fit",
    Twin.MIRROR_IMAGE: "With the sensors reversed, the mirror image fits",
    Twin.REVERSED: "With the sensors reversed, other parameters fit",
}


class Column(NamedTuple):
    """A measured quantity: its name with index, and what was measured, fitted and assumed of its noise."""

    name: str
    words: str
    measured: xr.DataArray
    fitted: xr.DataArray
    noise: xr.DataArray


def columns(dataset: xr.Dataset) -> list[Column]:
    """Return the measured quantities of a dataset."""
    found: list[Column] = []
    for name in map(str, dataset.data_vars):
        stem = name.removesuffix("_measured")
        if stem == name:
            continue
        own = [dataset[stem + suffix] for suffix in ("_measured", "_fitted", "_noise")]
        inner = [str(dim) for dim in own[0].dims if dim != "measurement"]
        for label in dataset[inner[0]].values.tolist() if inner else [None]:
            parts = [each.sel({inner[0]: label}) if inner else each for each in own]
            if np.isfinite(parts[0].values).any():
                text = f"{stem}_{label}" if inner else stem
                long_name = str(own[0].attrs.get("long_name", "")).removeprefix("measured ")
                words = in_words(stem, long_name, *(inner[0], label) if inner else ())
                found.append(Column(text, words, *parts))
    return found


def along(dataset: xr.Dataset) -> xr.DataArray:
    """Return what the measurements run over: the phase, or the first swept parameter."""
    return next(each for each in dataset.coords.values() if each.dims == ("measurement",))


def is_of_one_motion(x: xr.DataArray) -> bool:
    """Return whether measurements are instants of one motion, not motions at several parameters."""
    return x.name == "phase"


def found_text(dataset: xr.Dataset, is_explained: bool) -> list[str]:
    """Write each parameter that was found, with its standard deviation, or that it is not determined."""
    texts = []
    for name, result in results(dataset).items():
        symbol = plain_symbol_of(dataset[name])
        if result == FoundResult.UNDETERMINED:
            texts.append(f"{symbol} not determined")
        elif result == FoundResult.AT_RANGE:
            texts.append(f"{symbol} = {value_text(dataset, name)}, at an end of its range")
        else:
            texts.append(
                f"{symbol} = {(with_deviation if is_explained else value_text)(dataset, name)}"
            )
    return texts


def value_text(dataset: xr.Dataset, name: str, number: float | None = None) -> str:
    """Write a parameter that was found, or another number of it, with the digits that it has."""
    value = float(dataset[name]) if number is None else number
    text = format_number(value, digits_for(value, float(dataset[f"{name}_std"])))
    return with_units(dataset[name], text)


def with_deviation(dataset: xr.Dataset, name: str) -> str:
    """Write a parameter that was found with its standard deviation and unit, with its last zeros: 0.6000 ± 0.0019."""
    value, std = float(dataset[name]), float(dataset[f"{name}_std"])
    return with_units(
        dataset[name], f"{measured(value, digits_for(value, std))} ± {at_most(std, 2)}"
    )


def digits_for(value: float, std: float) -> int:
    """Return the significant digits of a value up to the second one of its standard deviation, from 3 to 9."""
    if not (value and 0 < std < np.inf):
        return 5
    digits = int(np.floor(np.log10(abs(value))) - np.floor(np.log10(std))) + 2
    return min(max(digits, 3), 9)


def results(dataset: xr.Dataset) -> dict[str, FoundResult]:
    """Return what the measurements say of each parameter, by its name."""
    found = [FoundResult(int(code)) for code in dataset["parameter_result"].values]
    return dict(zip(map(str, dataset["parameter"].values), found, strict=True))


def draw_fit(dataset: xr.Dataset) -> Figure:
    """Draw each measured quantity with the fit, and below what is left in standard deviations of the noise."""
    parts, x = columns(dataset), along(dataset)
    order = np.argsort(x.values, kind="stable")
    height = FOOT + REST + len(parts) * (PANEL + GAP) + 0.3
    figure = new_canvas(height)
    rest = axes(figure, LEFT, FOOT, WIDTH, REST)
    draw_rest(rest, parts, x)
    rest.set_xlabel(axis_label(x))
    for n, part in enumerate(parts):
        bottom = FOOT + REST + GAP + (len(parts) - 1 - n) * (PANEL + GAP)
        ax = axes(figure, LEFT, bottom, WIDTH, PANEL, sharex=rest)
        if is_of_one_motion(x):
            ax.plot(x[order], part.fitted[order], color=EXACT, linewidth=1.0)
        else:  # between two frequencies the motion may be another one
            ax.plot(x, part.fitted, "+", color=EXACT, markersize=marker_size(x) + 2.6)
        ax.plot(
            x, part.measured, "o", color=INK, markersize=marker_size(x), fillstyle="none",
            markeredgewidth=0.7 if x.size <= MANY else 0.3,
        )  # fmt: skip
        ax.tick_params(labelbottom=False)
        text = in_brackets(part.words, part.measured)
        ax.set_ylabel("\n".join(textwrap.wrap(text, 28)))
        ax.yaxis.set_label_coords(-NAMED / WIDTH, 0.5)
        hairlines(ax)
    rest.yaxis.set_label_coords(-NAMED / WIDTH, 0.5)
    return figure


def marker_size(x: xr.DataArray) -> float:
    """Return the size of the markers of measurements."""
    return SIZE if x.size <= MANY else MANY_SIZE


def draw_rest(ax: Axes, parts: list[Column], x: xr.DataArray) -> None:
    """Draw what the fit leaves of each quantity in standard deviations of its noise, with a marker each."""
    colours = [EXACT, METHODS["rk45"].colour, GREY]
    for n, part in enumerate(parts):
        left = (part.measured - part.fitted) / part.noise
        style: dict[str, Any] = {"color": colours[n % 3], "markersize": marker_size(x)}
        ax.plot(x, left, MARKERS[n % len(MARKERS)], linestyle="none", label=part.words, **style)
    for level in (-2, 2):
        ax.axhline(level, color=GREY, linewidth=0.5, linestyle=(0, (4, 2)), zorder=0)
    zero_line(ax)
    low, high = ax.get_ylim()
    ax.set_ylim(min(low, -2.5), max(high, 2.5))
    ax.set_ylabel("misfit in\nstandard deviations")
    if len(parts) > 1:
        ax.legend(
            loc="lower right", bbox_to_anchor=(1.0, 0.97), ncols=min(len(parts), 3), frameon=False,
            borderaxespad=0.0, handletextpad=0.2, columnspacing=1.2,
        )  # fmt: skip
    elif not np.isfinite(parts[0].fitted.values).any():
        note(ax, 0.01, 0.95, "the nearest motion has none")


def title_fit(dataset: xr.Dataset) -> str:
    """Return the title of the fit: whether it leaves more than noise."""
    first = columns(dataset)[0].words
    return TITLES[FitResult(int(dataset["fit_result"]))].format(first)


def noise_text(dataset: xr.Dataset) -> str:
    """Write the noise of each quantity, and whether it was given."""
    noise = series(
        f"{with_units(part.measured, format_number(float(part.noise), 2))} of {part.words}"
        for part in columns(dataset)
    )
    how = "given" if dataset.attrs.get("noise") == "given" else "estimated"
    if int(dataset["fit_result"]) == FitResult.NOT_JUDGED:
        how = "roughly estimated"
    return f"{how} noise: {noise}"


def describe_fit(dataset: xr.Dataset) -> str:
    """Return the caption of the fit."""
    explained = int(dataset["fit_result"]) == FitResult.EXPLAINED
    text, whose = noise_text(dataset), "found" if explained else "nearest"
    mark = "line" if is_of_one_motion(along(dataset)) else "crosses"
    return sentences(
        f"Circles: measured; {mark}: with the parameters that are {whose}; below: measured "
        "less fitted over the standard deviation of the noise, dashed: two of them",
        f"{whose.capitalize()}: {'; '.join(found_text(dataset, explained))}",
        capitalised(text),
        *sensor_texts(dataset),
        *twin_texts(dataset),
    )


def twin_texts(dataset: xr.Dataset) -> list[str]:
    """Write other parameters that fit as well: the mirror image and others."""
    if "twin" not in dataset.dims:
        return []
    result = results(dataset)
    explained = int(dataset["fit_result"]) == FitResult.EXPLAINED
    texts, excess = [], dataset["twin_excess"].values
    for n, kind in enumerate(dataset["twin_kind"].values.tolist()):
        values = []
        for name in result:
            # With the sensors reversed each support has what is known of the other one.
            of = name if kind == Twin.OTHER else MIRRORED.get(name, (name, 1))[0]
            of, symbol = of if of in result else name, plain_symbol_of(dataset[name])
            if result[of] == FoundResult.UNDETERMINED:
                values.append(f"{symbol} not determined")
                continue
            number, std = float(dataset[f"{name}_twin"][n]), float(dataset[f"{of}_std"])
            value = with_units(dataset[name], format_number(number, digits_for(number, std)))
            values.append(f"{symbol} = {value}")
        worse = "no worse" if excess[n] <= 0.0 else "worse by no more than noise"
        how = "as well" if explained else worse
        texts.append(f"{TWINS[Twin(kind)]} {how}: {', '.join(values)}")
    return texts


def sensor_texts(dataset: xr.Dataset) -> list[str]:
    """Write which samples of a record do not count, and which sensors are reversed; nothing of other measurements."""
    if "transient_samples" not in dataset:
        return []
    texts, n = [], dataset.sizes["measurement"]
    if before := int(dataset["transient_samples"]):
        texts.append(f"{count(before, 'sample')} before the steady motion left out")
    for part in columns(dataset):
        if left_out := int(dataset[f"{part.name}_left_out"]):
            where = "at a limit of the sensor or next to an impact"
            texts.append(f"{left_out} of {n} samples of {part.words} {where} do not count")
        if float(dataset[f"{part.name}_sign"]) < 0:
            texts.append(f"The sensor of {part.words} is reversed: it counts towards support 2")
    return texts


PICTURES = (Picture("fit", draw_fit, describe_fit, titled=title_fit),)
