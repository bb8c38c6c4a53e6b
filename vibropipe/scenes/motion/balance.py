"""The energy of a motion as bars, and its harmonics as a spectrum."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibropipe.figures.spectrum import draw_spectrum, spectrum_handles
from vibropipe.figures.style import BLACK, GREY, SKY, SMALL_FONT_SIZE, YELLOW, legend, new_figure
from vibropipe.figures.text import (
    axis_label,
    format_number,
    in_brackets,
    parameter_line,
    sentences,
    with_units,
)
from vibropipe.words.vocabulary import label

HEIGHT_CM = 6.5
MAX_BARS = 5  # of a panel beside another, whose texts fit below it
FORMS = {
    "energy": "from start to end of the motion",
    "orbit_energy": "per forcing period of the steady state",
}
# Terms of a balance, in the order of the bars; what is fed in or stored counts positive.
SIGNS = {"input": 1, "damping": -1, "impact": -1, "friction": -1, "change": 1}
TEXTS = {
    "input": "work of\nthe force",
    "damping": "damping",
    "friction": "friction",
    "change": "stored",
}


def energy_terms(dataset: xr.Dataset, form: str) -> list[tuple[str, xr.DataArray, float]]:
    """Return (text, variable, value) of the energies of a motion or of its orbit; losses count negative."""
    terms = []
    for name, sign in SIGNS.items():
        full = f"{form}_{name}"
        if full not in dataset:
            continue
        array = dataset[full]
        # Soft supports have a friction of 0, and an orbit stores nothing.
        is_needless = name == "friction" or full == "orbit_energy_change"
        if is_needless and not np.nan_to_num(array).any():
            continue
        if array.ndim == 0:
            terms.append((TEXTS[name], array, sign * float(array)))
            continue
        for support, value in zip(dataset["support"].values, array.values, strict=True):
            terms.append((f"impacts on\nsupport {support}", array, sign * float(value)))
    return terms


def fits_energy(dataset: xr.Dataset) -> bool:
    """Return whether a motion has energies."""
    return any(energy_terms(dataset, form) for form in FORMS)


def draw_energy(dataset: xr.Dataset) -> Figure:
    """Draw the energy fed in, lost and stored as bars, of the motion and of its orbit."""
    forms = [form for form in FORMS if energy_terms(dataset, form)]
    terms = [energy_terms(dataset, form) for form in forms]
    rows, columns = (len(forms), 1) if max(map(len, terms)) > MAX_BARS else (1, len(forms))
    figure = new_figure(HEIGHT_CM * rows)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax, form, bars in zip(axes, forms, terms, strict=True):
        draw_bars(ax, bars)
        ax.set_title(FORMS[form])
    for ax in axes[::columns]:
        ax.set_ylabel(in_brackets("energy", terms[0][0][1]))
    figure.suptitle(parameter_line(dataset))
    return figure


def draw_bars(ax: Axes, terms: list[tuple[str, xr.DataArray, float]]) -> None:
    """Draw a bar with its value for each term."""
    values = [value for _, _, value in terms]
    colours = [SKY if value >= 0 else YELLOW for value in values]
    hatches = ["" if value >= 0 else "///" for value in values]
    ax.bar(
        range(len(terms)),
        values,
        color=colours,
        hatch=hatches,
        edgecolor=BLACK,
        linewidth=0.5,
        width=0.6,
    )
    span = max(map(abs, values), default=1.0) or 1.0
    for position, value in enumerate(values):
        ax.annotate(
            format_number(value, 3), (position, value), (0, 2 if value >= 0 else -2),
            textcoords="offset points", ha="center", va="bottom" if value >= 0 else "top",
            fontsize=SMALL_FONT_SIZE,
        )  # fmt: skip
    ax.axhline(0.0, color=GREY, linewidth=0.6)
    ax.set_xticks(range(len(terms)), [text for text, _, _ in terms])
    low = min([0.0, *values])
    ax.set_ylim(low - 0.18 * span * (low < 0), max([0.0, *values]) + 0.18 * span)


def describe_energy(dataset: xr.Dataset) -> str:
    """Return the caption of the energies: the residual of each balance."""
    texts = [
        f"Residual of the balance {text}: {format_number(float(dataset[f'{form}_residual']), 2)}"
        for form, text in FORMS.items()
        if f"{form}_residual" in dataset
    ]
    return sentences("Energy fed in (positive) and lost (negative)", *texts)


def draw_spectra(dataset: xr.Dataset) -> Figure:
    """Draw the harmonic amplitudes of the steady state of a motion over multiples of the forcing frequency."""
    names = [name for name in ("displacement", "velocity") if f"{name}_amplitude" in dataset]
    figure = new_figure(HEIGHT_CM + 1.0)
    for ax, name in zip(figure.subplots(1, len(names), squeeze=False)[0], names, strict=True):
        draw_spectrum(ax, dataset, name)
        ax.set(xlabel=label("harmonic"), ylabel=axis_label(dataset[f"{name}_amplitude"]))
    figure.suptitle(parameter_line(dataset))
    legend(figure, spectrum_handles(dataset), "lower")
    return figure


def fits_spectrum(dataset: xr.Dataset) -> bool:
    """Return whether a motion has harmonics of its steady state."""
    return "displacement_amplitude" in dataset and "harmonic" in dataset.dims


def describe_spectra(dataset: xr.Dataset) -> str:
    """Return the caption of a spectrum: the constant part and the largest harmonic."""
    amplitude = dataset["displacement_amplitude"]
    if not np.isfinite(amplitude).any():
        return sentences("No steady state was found, so there is no spectrum")
    number = int(dataset["harmonic"][int(np.nanargmax(amplitude.values))])
    mean = with_units(
        dataset["displacement_mean"], format_number(float(dataset["displacement_mean"]))
    )
    largest = with_units(amplitude, format_number(float(np.nanmax(amplitude.values))))
    return sentences(
        "Amplitudes of the harmonics of the steady state",
        f"The constant part of the displacement is {mean}; its largest harmonic is number {number}, {largest}",
    )
