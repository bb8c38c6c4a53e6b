"""Picture of an identification: what was measured, what the parameters found give, and the difference."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from vibropipe.figures.style import BLACK, BLUE, GREY, legend, line_style, new_figure
from vibropipe.figures.text import (
    axis_label,
    format_number,
    parameter_line,
    plain_symbol,
    plain_symbol_of,
    sentences,
    with_units,
)
from vibropipe.scenes.kind import Picture
from vibropipe.words.designs import FitResult, FoundResult
from vibropipe.words.wording import series

PANEL_CM, FRAME_CM = 4.2, 2.6


class Column(NamedTuple):
    """A measured quantity: its name with index, and what was measured, fitted and assumed of its noise."""

    name: str
    label: int | None
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
                found.append(Column(text, label, *parts))
    return found


def along(dataset: xr.Dataset) -> xr.DataArray:
    """Return what the measurements run over: the phase, or the first swept parameter."""
    return next(each for each in dataset.coords.values() if each.dims == ("measurement",))


def found_text(dataset: xr.Dataset, with_deviation: bool = True) -> list[str]:
    """Write each parameter that was found, with its standard deviation, or that it is not determined."""
    texts = []
    for name, result in zip(map(str, dataset["parameter"].values), results(dataset), strict=True):
        number, std = float(dataset[name]), float(dataset[f"{name}_std"])
        value = format_number(number, digits_for(number, std))
        if result == FoundResult.UNDETERMINED:
            texts.append(f"{plain_symbol(name)} not determined")
        elif result == FoundResult.AT_RANGE:
            texts.append(
                f"{plain_symbol_of(dataset[name])} = {with_units(dataset[name], value)}, at an end of its range"
            )
        else:
            sigma = (
                f" ± {format_number(float(dataset[f'{name}_std']), 2)}" if with_deviation else ""
            )
            texts.append(
                f"{plain_symbol_of(dataset[name])} = {with_units(dataset[name], value + sigma)}"
            )
    return texts


def digits_for(value: float, std: float) -> int:
    """Return the significant digits of a value up to the second one of its standard deviation, from 3 to 9."""
    if not (value and 0 < std < np.inf):
        return 5
    digits = int(np.floor(np.log10(abs(value))) - np.floor(np.log10(std))) + 2
    return min(max(digits, 3), 9)


def results(dataset: xr.Dataset) -> list[FoundResult]:
    """Return what the measurements say of each parameter."""
    return [FoundResult(int(code)) for code in dataset["parameter_result"].values]


def draw_fit(dataset: xr.Dataset) -> Figure:
    """Draw each measured quantity with the fit, and below what is left in standard deviations of the noise."""
    parts, x = columns(dataset), along(dataset)
    order = np.argsort(x.values, kind="stable")
    figure = new_figure((len(parts) + 1) * PANEL_CM + FRAME_CM)
    axes = figure.subplots(len(parts) + 1, 1, sharex=True)
    for n, (ax, part) in enumerate(zip(axes, parts, strict=False)):
        style = line_style(n)
        ax.plot(x[order], part.fitted[order], color=BLUE, linewidth=1.2, label="fitted")
        ax.plot(
            x, part.measured, "o", color=BLACK, markersize=3.5, fillstyle="none", label="measured"
        )
        ax.set_ylabel(axis_label(part.fitted, part.label, width=26).removeprefix("fitted "))
        left = (part.measured - part.fitted) / part.noise
        axes[-1].plot(
            x, left, "osD^vPX"[n % 7], color=style["color"], markersize=3.5, label=part.name
        )
    for level in (-2, 0, 2):
        axes[-1].axhline(
            level, color=GREY, linewidth=0.8, linestyle="-" if level == 0 else "--", zorder=0
        )
    axes[-1].set_ylabel("misfit in\nstandard deviations")
    axes[-1].set_xlabel("phase in forcing periods" if x.name == "phase" else axis_label(x))
    axes[0].set_title(parameter_line(dataset, leave_out=map(str, dataset["parameter"].values)))
    figure.align_ylabels(axes)
    entries = axes[0].get_legend_handles_labels()[0]
    entries += axes[-1].get_legend_handles_labels()[0] if len(parts) > 1 else []
    legend(figure, entries, "lower")
    return figure


def describe_fit(dataset: xr.Dataset) -> str:
    """Return the caption of the fit."""
    noise = series(
        f"{part.name}: {with_units(part.measured, format_number(float(part.noise), 2))}"
        for part in columns(dataset)
    )
    explained = int(dataset["fit_result"]) == FitResult.EXPLAINED
    return sentences(
        "Measured values and those of the parameters found, and below their difference over the standard deviation "
        "of the noise; dashed: two of them",
        f"{'Found' if explained else 'Nearest'}: {'; '.join(found_text(dataset, explained))}",
        f"Noise of {noise}",
    )


PICTURES = (Picture("fit", draw_fit, describe_fit),)
