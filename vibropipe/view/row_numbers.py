"""The numbers of a row with errors and units, and what they mean in words."""

from __future__ import annotations

import math
from collections.abc import Iterator
from html import escape

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.figures.motion_words import rests_of, stability_text, times_word, window_text
from vibropipe.figures.regime_words import UNRESOLVED_TEXT, regime_text
from vibropipe.figures.text import REST, parameter_names, sentences, with_units
from vibropipe.orbits.harmonics import rest_force
from vibropipe.scenes.basins.text import percent
from vibropipe.solve.motion.contacts import log_of
from vibropipe.solve.rebuild import Motion, mass_and_stiffness
from vibropipe.solve.sweep.sweep_grid import DIRECTION
from vibropipe.view.plane import ELEMENTS
from vibropipe.view.words import number, symbol
from vibropipe.words.regimes import Chaos, Regime
from vibropipe.words.status import Status
from vibropipe.words.vocabulary import ERROR_SUFFIX
from vibropipe.words.wording import count

# Quantities that the sentence of the law says, or that are drawn.
SAID = ("regime", "status", "period_multiple", "row_size")
# Those that have no number where the mass comes to rest.
IMPACT_COUNTS = ("impacts_per_orbit", "impacts_per_period")
MAX_ELEMENTS = 6
# Relative distance of two solutions of one orbit at the section.
SAME_STATE = 1e-6
Line = tuple[str, str, str]


def law_text(row: xr.Dataset) -> str:
    """Write the law of motion of a row as sentences; of one without a motion, the reason."""
    regime = int(row["regime"])
    words = regime_text(regime)
    status = Status(int(row["status"])) if "status" in row else Status.OK
    if regime in (Regime.UNRESOLVED, Regime.UNBOUNDED):
        reason, plain = UNRESOLVED_TEXT.get(status, ""), status.remedy.replace("`", "")
        return sentences(words.capitalize() + (f": {reason}" if reason else "")) + f" {plain}"
    if regime == Regime.APERIODIC:
        rates = row["impacts_per_period"].values if "impacts_per_period" in row else ()
        struck = [
            f"{number(float(rate), 3)} on support {side}"
            for side, rate in enumerate(rates, 1)
            if rate > 0
        ]
        mean = f"Mean number of impacts in a forcing period: {', '.join(struck)}" if struck else ""
        grows = "chaos" in row and int(row["chaos"]) == Chaos.IN_WINDOW
        chaos = "Perturbations grow in it; it may be a transient" if grows else ""
        return sentences(f"{words.capitalize()} {window_text(row)}".strip(), chaos, mean)
    m = int(row["period_multiple"])
    every = "every forcing period" if m == 1 else f"every {count(m, 'forcing period')}"
    if m == 0:
        return sentences(words.capitalize())
    if regime == Regime.WITH_REST:
        return sentences(f"Repeats {every} and sticks to a support: {words}")
    impacts = np.round(_impacts_per_orbit(row, m)).astype(int).tolist()
    # in letters, since a number beside that of the support would be misread
    struck = [f"support {side} {times_word(n)}" for side, n in enumerate(impacts, 1) if n]
    what = f"strikes {' and '.join(struck)}" if struck else "strikes no support"
    stability = stability_text(row) if "stable" in row else "stable"
    said = "" if stability == "stable" else stability.capitalize()
    return sentences(f"Repeats {every} and {what}: {words}", said)


def motion_name(row: xr.Dataset) -> str:
    """Return the name of an attractor in a menu: its number, its law and its share of the starts."""
    words, share = regime_text(int(row["regime"])), float(row["basin_share"])
    return f"attractor {int(row['attractor_id'])}: {words}, {percent(share)} of the starts"


def is_same_motion(row: xr.Dataset, attractor: xr.Dataset) -> bool:
    """Return whether a row is an attractor by its state at the section; without an orbit, if the attractor has none."""
    if int(row["period_multiple"]) != int(attractor["period_multiple"]):
        return False
    if int(row["period_multiple"]) == 0:
        return True
    is_near = np.ones(attractor.sizes["visit"], bool)
    for name in ("displacement", "velocity"):
        visits = attractor[f"poincare_{name}"].values
        near = SAME_STATE * max(float(np.abs(visits).max()), 1e-300)
        is_near &= np.abs(visits - float(row[f"{name}_strobe"])) <= near
    return bool(is_near.any())


def _impacts_per_orbit(row: xr.Dataset, m: int) -> NDArray[np.float64]:
    """Return the impacts of an orbit of m forcing periods on each support; none where they are not stored."""
    if "impacts_per_orbit" in row:
        return np.asarray(row["impacts_per_orbit"].values)
    rates = row["impacts_per_period"].values if "impacts_per_period" in row else np.zeros(2)
    return np.asarray(rates * m)


def momentum(motion: Motion) -> tuple[float, float]:
    """Return the momentum given to each support per forcing period, in impacts and in rests."""
    row, exciter = motion.plain, motion.exciter
    names = ("impact_tau", "impact_support", "impact_velocity", "impact_velocity_after",
             "rest_start", "rest_end", "rest_support", "grazing_tau")  # fmt: skip
    contacts = {name: row[name].values for name in names}
    periods = motion.length / exciter.period
    log, given = log_of(exciter, contacts, periods), [0.0, 0.0]
    for impulse, support in zip(log.impulse, log.support, strict=True):
        given[abs(int(support)) - 1] += abs(float(impulse))
    for start, end, support in zip(log.rest_start, log.rest_end, log.rest_support, strict=True):
        pressed = rest_force(exciter.parameters(), int(support), 0, 1, max(0.0, start), end)
        given[int(support) - 1] += abs(pressed.real) * exciter.period
    return given[0] / periods, given[1] / periods


def momentum_lines(motion: Motion) -> Iterator[Line]:
    """Yield the momentum given to each support as lines of the table; none with soft supports or friction."""
    if motion.soft or motion.exciter.friction > 0.0:
        return
    si = mass_and_stiffness(motion.row)
    unit = 1.0 if si is None else math.sqrt(si["m"]) * math.sqrt(si["C"])
    for side, value in enumerate(momentum(motion), 1):
        text = number(value * unit) + (" N·s" if si else "")
        yield f"J{'₁₂'[side - 1]}", f"momentum given to support {side} per forcing period", text


def lines_of(row: xr.Dataset) -> Iterator[Line]:
    """Yield (symbol, long name, value with error and units) of each quantity of a row."""
    for name in parameter_names(row):
        array = row[name]
        yield symbol(array), str(array.attrs.get("long_name", "")), _value(array, None, ())
    if DIRECTION in row.coords:
        yield "", "direction in which the sweep was followed", str(row[DIRECTION].values)
    for key, array in row.data_vars.items():
        name = str(key)
        is_shown = array.dtype.kind in "iufbc" and name not in SAID
        if not is_shown or (name.endswith(ERROR_SUFFIX) and name.removesuffix(ERROR_SUFFIX) in row):
            continue
        if array.ndim > 1 or any(str(dim) not in ELEMENTS for dim in array.dims):
            continue
        error = row.get(name + ERROR_SUFFIX)
        error = None if error is None or error.dims != array.dims else error
        for at in np.ndindex(*(min(size, MAX_ELEMENTS) for size in array.shape)):
            index = at[0] + 1 if at else None
            tail = f", {array.dims[0]} {index}" if at and array.dims[0] == "support" else ""
            is_chatter = key in IMPACT_COUNTS and rests_of(row, array).values[at] > 0
            yield (
                symbol(array, index),
                f"{array.attrs.get('long_name', name)}{tail}",
                REST if is_chatter else _value(array, error, at),
            )


def _value(array: xr.DataArray, error: xr.DataArray | None, at: tuple[int, ...]) -> str:
    """Write an element of a quantity, with its error if there is one; a complex one by parts."""
    value = array.values[at]
    if np.iscomplexobj(value):
        sign = "−" if value.imag < 0 else "+"
        text = number(value.real) + (f" {sign} {number(abs(value.imag))} i" if value.imag else "")
    elif "flag_meanings" in array.attrs:
        names = str(array.attrs["flag_meanings"]).split()
        codes = np.atleast_1d(array.attrs["flag_values"]).tolist()
        text = names[codes.index(int(value))].replace("_", " ")
    else:
        text = number(float(value))
    if error is not None:
        text += f" ± {number(float(error.values[at]), 2)}"
    return with_units(array, text)


def table_html(columns: list[list[Line]]) -> str:
    """Write lines as a table; a second list of lines is a column to compare with."""
    others = [{(mark, name): text for mark, name, text in each} for each in columns[1:]]
    cells = "".join(
        f'<tr title="{escape(name)}"><td><i>{escape(mark)}</i></td><td>{escape(name)}</td><td>{escape(text)}</td>'
        + "".join(f"<td>{escape(other.get((mark, name), '–'))}</td>" for other in others)
        + "</tr>"
        for mark, name, text in columns[0]
    )
    head = "<tr><td></td><td></td><td><b>here</b></td><td><b>pinned</b></td></tr>" if others else ""
    return f'<table class="numbers">{head}{cells}</table>'
