"""The energy of a motion as bars, and its harmonics as a spectrum."""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibropipe.figures.canvas import SMALL, WIDE, axes, new_canvas, panel, plain_ticks, zero_line
from vibropipe.figures.palette import METHODS
from vibropipe.figures.phase_plane import draw_spectrum, spectrum_handles
from vibropipe.figures.style import ROUNDING
from vibropipe.figures.text import (
    ORDINALS,
    axis_label,
    in_brackets,
    measured,
    parameters_text,
    sentences,
)
from vibropipe.report.findings import value_text
from vibropipe.scenes.kind import Picture
from vibropipe.words.vocabulary import ENERGIES, STEADY, label
from vibropipe.words.wording import capitalised

LEFT, BELOW, BETWEEN, SPECTRUM_CM = 1.75, 1.0, 0.5, 6.6  # cm
FED, LOST = METHODS["crude"].colour, METHODS["exact"].colour
LETTERS = 10  # of a line below a bar
MAX_BARS = 5  # of a panel beside another, whose texts fit below it
FORMS = {
    "energy": "from start to end of the motion",
    "orbit_energy": "per forcing period of the steady state",
}


def energy_terms(dataset: xr.Dataset, form: str) -> list[tuple[str, xr.DataArray, float]]:
    """Return (text, variable, value) of the energies of a motion or of its orbit; losses count negative."""
    terms = []
    for name in ENERGIES:
        entry, full = STEADY[name], name.replace("energy", form, 1)
        if full not in dataset or not entry.short:
            continue
        array, sign = dataset[full], -1 if entry.is_loss else 1
        # Soft supports have a friction of 0, and an orbit stores nothing.
        is_needless = entry.effect or full == "orbit_energy_change"
        if is_needless and not np.nan_to_num(array).any():
            continue
        words = entry.short.removeprefix("loss by ").removeprefix("loss at ")
        if array.ndim == 0:
            terms.append((fill(words, LETTERS), array, sign * float(array)))
            continue
        for support, value in zip(dataset["support"].values, array.values, strict=True):
            terms.append((f"{words} on\nsupport {support}", array, sign * float(value)))
    # What is no larger than the gap in the balance is its rounding.
    gap = abs(float(dataset.get(f"{form}_residual", 0.0)))
    return [(text, array, value if abs(value) > gap else 0.0) for text, array, value in terms]


def fits_energy(dataset: xr.Dataset) -> bool:
    """Return whether a motion has energies."""
    return any(energy_terms(dataset, form) for form in FORMS)


def draw_energy(dataset: xr.Dataset) -> Figure:
    """Draw the energy fed in, lost and stored as bars, of the motion and of its orbit."""
    forms = [form for form in FORMS if energy_terms(dataset, form)]
    terms = [energy_terms(dataset, form) for form in forms]
    is_wide = max(map(len, terms)) > MAX_BARS or len(forms) == 1
    width = WIDE - LEFT - 0.3 if is_wide else (WIDE - 2 * LEFT - 0.3) / 2
    high, rows = 4.6, len(forms) if is_wide else 1
    figure = new_canvas(rows * (high + BELOW + BETWEEN) + 0.6 - BETWEEN)
    for number, (form, bars) in enumerate(zip(forms, terms, strict=True)):
        row, column = (number, 0) if is_wide else (0, number)
        bottom = BELOW + (rows - 1 - row) * (high + BELOW + BETWEEN)
        ax = axes(figure, LEFT + column * (width + LEFT), bottom, width, high)
        draw_bars(ax, bars)
        panel(ax, "ab"[number] if len(forms) > 1 else "", FORMS[form])
        ax.set_ylabel(in_brackets("energy", terms[0][0][1]))
    return figure


def draw_bars(ax: Axes, terms: list[tuple[str, xr.DataArray, float]]) -> None:
    """Draw a bar with its value for each term."""
    values = [value for _, _, value in terms]
    span = max(map(abs, values), default=1.0) or 1.0
    values = [value if abs(value) > ROUNDING * span else 0.0 for value in values]
    for position, value in enumerate(values):
        # what is lost is hatched and darker
        style: dict[str, Any] = (
            {"color": FED}
            if value >= 0
            else {"facecolor": LOST, "edgecolor": "white", "hatch": "////"}
        )
        ax.bar(position, value, linewidth=0, width=0.6, **style)
    for position, value in enumerate(values):
        ax.annotate(
            measured(value), (position, value), (0, 2 if value >= 0 else -2),
            textcoords="offset points", ha="center", va="bottom" if value >= 0 else "top",
            fontsize=SMALL,
        )  # fmt: skip
    zero_line(ax)
    ax.set_xticks(range(len(terms)), [text for text, _, _ in terms])
    low = min([0.0, *values])
    ax.set_ylim(low - 0.18 * span * (low < 0), max([0.0, *values]) + 0.18 * span)


def energy_title(dataset: xr.Dataset) -> str:
    """Write which loss takes most of the work of the force; empty without such work."""
    form = next(form for form in reversed(FORMS) if energy_terms(dataset, form))
    terms = {text.replace("\n", " "): value for text, _, value in energy_terms(dataset, form)}
    work = terms.pop(STEADY["energy_input"].short, 0.0)
    losses = {text: -value for text, value in terms.items() if value < 0.0}
    if work <= 0.0 or not losses:
        return ""
    top = max(losses, key=lambda text: losses[text])
    if losses[top] > work:
        return ""
    verb = "take" if top.startswith("impacts") else "takes"
    return f"{capitalised(top)} {verb} {100 * losses[top] / work:.3g} % of the work of the force"


def describe_energy(dataset: xr.Dataset) -> str:
    """Return the caption of the energies: the residual of each balance."""
    texts = [
        f"Residual of the balance {text}: {value_text(dataset[name], float(dataset[name]), 2)}"
        for name, text in ((f"{form}_residual", text) for form, text in FORMS.items())
        if name in dataset
    ]
    return sentences(
        "Energy fed in (positive) and lost (negative)", *texts, parameters_text(dataset)
    )


def draw_spectra(dataset: xr.Dataset) -> Figure:
    """Draw the harmonic amplitudes of the steady state of a motion over multiples of the forcing frequency."""
    names = [name for name in ("displacement", "velocity") if f"{name}_amplitude" in dataset]
    figure = new_canvas(SPECTRUM_CM)
    width = (WIDE - LEFT * len(names) - 0.3) / len(names)
    for number, name in enumerate(names):
        ax = axes(figure, LEFT + number * (width + LEFT), 1.1, width, SPECTRUM_CM - 1.7)
        draw_spectrum(ax, dataset, name)
        plain_ticks(ax.yaxis, 6)
        ax.set(xlabel=label("harmonic"), ylabel=axis_label(dataset[f"{name}_amplitude"], width=24))
        panel(ax, "ab"[number] if len(names) > 1 else "", name)
    handles = spectrum_handles(dataset)
    if len(handles) > 1:
        figure.axes[-1].legend(handles=handles, loc="upper right")
    return figure


def fits_spectrum(dataset: xr.Dataset) -> bool:
    """Return whether a motion has harmonics of its steady state."""
    return "displacement_amplitude" in dataset and "harmonic" in dataset.dims


def spectrum_title(dataset: xr.Dataset) -> str:
    """Write which harmonic of the displacement is the largest, and how large; empty without an orbit."""
    amplitude = dataset["displacement_amplitude"]
    if not np.isfinite(amplitude).any():
        return ""
    order = int(np.nanargmax(amplitude.values))
    if float(amplitude.values[order]) == 0.0:
        return ""
    words = f"The {ORDINALS[order]} harmonic" if order < len(ORDINALS) else f"Harmonic {order + 1}"
    size = value_text(amplitude, amplitude.values[order])
    return f"{words} of the displacement is the largest, {size}"


def describe_spectra(dataset: xr.Dataset) -> str:
    """Return the caption of a spectrum: the mean displacement and the largest harmonic."""
    amplitude = dataset["displacement_amplitude"]
    if not np.isfinite(amplitude).any():
        return sentences("No steady state was found, so there is no spectrum")
    number = int(dataset["harmonic"][int(np.nanargmax(amplitude.values))])
    mean, top = dataset["displacement_mean"], float(np.nanmax(amplitude.values))
    mean_text = value_text(mean, 0.0 if abs(float(mean)) <= ROUNDING * top else mean)
    largest = f"the largest harmonic is number {number}, {value_text(amplitude, top)}"
    return sentences(
        "Amplitudes of the harmonics of the steady state",
        f"The mean displacement is {mean_text}; {largest if top else 'all harmonics are 0'}",
        parameters_text(dataset),
    )


SPECTRUM = Picture("spectrum", draw_spectra, describe_spectra, fits_spectrum, titled=spectrum_title)
ENERGY = Picture("energy", draw_energy, describe_energy, fits_energy, titled=energy_title)
