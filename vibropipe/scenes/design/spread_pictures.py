"""Pictures of the spread of a design: what each parameter alone does, and the share that each has."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from vibropipe.figures.style import BLACK, BLUE, NEUTRAL, ORANGE, legend, new_figure, write_centred
from vibropipe.figures.text import format_number, symbol_of, with_units
from vibropipe.scenes.design.data import Part, has_spread, spread_parts
from vibropipe.solve.tolerance import WORST

NO_SPREAD = "No deviations of parameters are given: add tolerance"
# Quantities of the map beside the wanted ones.
MAPPED = (
    Part("displacement_mean"),
    Part("displacement_amplitude", "harmonic", 1),
    Part("displacement_amplitude", "harmonic", 2),
    Part("impact_velocity_max", "support", 1),
    Part("impact_velocity_max", "support", 2),
    Part("support_force_max", "support", 1),
    Part("support_force_max", "support", 2),
    Part("energy_input"),
)
SIGNED = "RdBu_r"


def draw_tornado(dataset: xr.Dataset) -> Figure:
    """Draw, for the first design, the deviation of each wanted quantity if one parameter alone is off."""
    if not has_spread(dataset):
        return empty(NO_SPREAD)
    best = dataset.isel(design=0)
    parts = spread_parts(dataset)
    k = best.sizes["parameter"]
    figure = new_figure(len(parts) * (1.9 + 0.55 * k) + 1.6)
    axes = figure.subplots(len(parts), 1, squeeze=False)[:, 0]
    for ax, part in zip(axes, parts, strict=True):
        draw_bars(ax, best, part)
    entries = [
        Patch(
            facecolor=ORANGE,
            edgecolor=BLACK,
            hatch="////",
            label=f"parameter {WORST:g} deviations below",
        ),
        Patch(facecolor=BLUE, edgecolor=BLACK, label=f"parameter {WORST:g} deviations above"),
        Line2D(
            [], [], color=BLACK, marker="|", linestyle="none", markersize=8, label="first order"
        ),
    ]
    legend(figure, entries, "lower")
    return figure


def draw_bars(ax: Axes, best: xr.Dataset, part: Part) -> None:
    """Draw the bars of one quantity, the most important parameter on top."""
    moved = part.of(best, "_deviation").transpose("parameter", "side").values
    share = part.of(best, "_contribution").values
    first = (
        WORST
        * np.sqrt(np.nan_to_num(share))
        * float(part.of(best, "_std").sel(estimate="first_order"))
    )
    order = np.argsort(np.abs(moved).max(axis=1), kind="stable")
    place = np.arange(order.size)
    style: dict[str, Any] = {"edgecolor": BLACK, "linewidth": 0.5}
    ax.barh(place + 0.2, moved[order, 0], height=0.38, color=ORANGE, hatch="////", **style)
    ax.barh(place - 0.2, moved[order, 1], height=0.38, color=BLUE, **style)
    for sign in (-1, 1):
        ax.plot(sign * first[order], place, "|", color=BLACK, markersize=14, markeredgewidth=1.2)
    ax.axvline(0.0, color=BLACK, linewidth=0.6)
    names = [str(best["parameter"].values[n]) for n in order]
    ax.set_yticks(place, [deviation_text(best, name) for name in names])
    ax.set_xlabel("deviation of " + part.label_text(best))


def deviation_text(dataset: xr.Dataset, name: str) -> str:
    """Write a parameter with its standard deviation."""
    return f"{symbol_of(dataset[name])} ± {with_units(dataset[name], format_number(float(dataset[f'{name}_std']), 2))}"


def draw_sensitivities(dataset: xr.Dataset) -> Figure:
    """Draw, for the first design, the signed share that each parameter has in the spread of each quantity."""
    if not has_spread(dataset):
        return empty(NO_SPREAD)
    best = dataset.isel(design=0)
    held = [part for part in MAPPED if f"{part.variable}_contribution" in dataset]
    parts = list(dict.fromkeys([*spread_parts(dataset), *held]))
    signed = np.array([shares_of(best, part) for part in parts])
    names = [str(name) for name in best["parameter"].values]
    figure = new_figure(0.85 * len(parts) + 3.4)
    ax = figure.subplots()
    image = ax.imshow(signed, cmap=SIGNED, vmin=-1, vmax=1, aspect="auto")
    for row, column in np.ndindex(signed.shape):
        value = signed[row, column]
        text = "–" if np.isnan(value) else f"{100 * value:+.0f} %".replace("-", "−")
        ax.text(
            column,
            row,
            text,
            ha="center",
            va="center",
            color="white" if abs(value) > 0.6 else BLACK,
        )
    ax.set_xticks(range(len(names)), [deviation_text(best, name) for name in names])
    ax.set_yticks(range(len(parts)), [row_text(best, part) for part in parts])
    ax.set_xticks(np.arange(len(names) + 1) - 0.5, minor=True)
    ax.set_yticks(np.arange(len(parts) + 1) - 0.5, minor=True)
    ax.grid(which="minor", color=NEUTRAL, linewidth=0.8)
    ax.tick_params(which="both", length=0)
    label = "share of the variance, with the sign\nof the derivative"
    figure.colorbar(image, ax=ax, aspect=18, pad=0.02, label=label)
    return figure


def shares_of(best: xr.Dataset, part: Part) -> np.ndarray:
    """Return the share of the variance that each parameter has, with the sign of its effect."""
    moved = part.of(best, "_deviation").sel(side="above").values
    signed: np.ndarray = np.sign(moved) * part.of(best, "_contribution").values
    return signed


def row_text(best: xr.Dataset, part: Part) -> str:
    """Write a quantity with its symbol and standard deviation."""
    std = float(part.of(best, "_std").sel(estimate="first_order"))
    return f"{part.words(best)}\n± {with_units(best[part.variable], format_number(std, 2))}"


def empty(text: str) -> Figure:
    """Return a figure that says why there is nothing to show."""
    figure = new_figure(3.0)
    ax = figure.subplots()
    ax.set_axis_off()
    write_centred(ax, text)
    return figure
