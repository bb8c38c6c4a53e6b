"""Text of numbers and parameters in figures and reports: plain text or mathtext, never markup.

Only values and names of the vocabulary pass through here, never a user's own text.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterable

import numpy as np
import xarray as xr

from vibropipe.figures.units import RAISED, unit_text
from vibropipe.solve.shown_units import shows_cycles
from vibropipe.words.parameters import FORCES, FURTHER, PARAMETERS, PHYSICAL
from vibropipe.words.quantities import FLAGS
from vibropipe.words.vocabulary import (
    ERROR_SUFFIX,
    PLAIN_SYMBOLS,
    VOCABULARY,
    physical_name,
    quantity,
)

# Width of a line of parameters across a figure, in digits: 14.6 cm, with many units 15.6 cm.
LINE_DIGITS = 95


def in_lines(parts: list[str], most: float = LINE_DIGITS) -> str:
    """Join texts by commas, in as few lines of at most so many digits as they need, all about as long."""
    ends = np.cumsum([width_in_digits(f"{part},  ") for part in parts])
    for amount in range(1, len(parts) + 1):
        middles = ends - np.diff(ends, prepend=0) / 2
        line_of = (amount * middles / ends[-1]).astype(int)
        lines = [
            ",  ".join(part for part, n in zip(parts, line_of, strict=True) if n == line)
            for line in dict.fromkeys(line_of.tolist())
        ]
        if max(map(width_in_digits, lines)) <= most:
            break
    return ",\n".join(lines) if parts else ""


def width_in_digits(text: str) -> float:
    """Return about how wide a mathtext is, in digits: spaces and points are narrow, capitals and signs are wide."""
    shown = re.sub(r"[${}^_]", "", re.sub(r"\\[A-Za-z]+ ?", "x", text))
    narrow = sum(letter in " ,.·/" for letter in shown)
    wide = sum(letter.isupper() or letter in "=−" for letter in shown)
    return len(shown) - 0.5 * narrow + 0.4 * wide


# Amplitudes of the force, with and without units.
OF_FORCE = (*FORCES, *map(physical_name, FORCES))
# Parameters whose values are words, and these.
WORDED = {
    each.name: [word.replace("_", " ") for word in each.range.words]
    for each in PARAMETERS.values()
    if each.range.words
}
# Restitution of each support, and the names of the stiffness without which it is rigid.
RIGID_RESTITUTION = {f"R{n}": (f"k{n}", physical_name(f"k{n}")) for n in (1, 2)}
# Text in place of a number of impacts where the mass comes to rest.
REST = "rest"
# Text in place of a missing curve.
NO_SAMPLES = "Displacement and velocity are not stored: add motion to outputs, with samples_per_period above 0"
NO_IMPACTS = "Impacts are not stored: add impacts to outputs"
NO_CURVES = "Regimes only, since outputs include neither harmonics nor impacts"
NO_SUPPORT_STRUCK = "No support is struck"
FEW_VALUES = 8
CYCLES = "/2π"
ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth")


def format_number(value: float | str, digits: int = 4) -> str:
    """Write a number with `digits` significant digits, a true minus sign and powers of ten from 10⁵ on; text stays.

    >>> format_number(-0.035367)
    '−0.03537'
    >>> format_number(1.5e-13)
    '1.5 × 10⁻¹³'
    """
    if isinstance(value, str):  # a direction
        return value
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    mantissa, _, exponent = f"{value + 0.0:.{digits}g}".partition("e")
    if exponent and 0 < int(exponent) < 5:
        mantissa, exponent = f"{float(f'{mantissa}e{exponent}'):.0f}", ""
    whole, point, decimals = mantissa.partition(".")
    if len(whole.lstrip("-")) > 3:
        mantissa = f"{int(whole):,}{point}{decimals}"
    text = mantissa.replace("-", "−")
    if not exponent:
        return text
    raised = str(int(exponent)).translate(RAISED)
    return f"{text} × 10{raised}"


def modulus_text(value: float) -> str:
    """Write the modulus of a multiplier in 3 digits, or as many as tell it from 1.

    >>> modulus_text(0.33333), modulus_text(0.999988), modulus_text(1.0)
    ('0.333', '0.99999', '1')
    """
    texts = (format_number(value, digits) for digits in range(3, 9))
    return next((text for text in texts if text != "1"), "1")


def measured(value: float, digits: int = 3) -> str:
    """Write a computed number with all its significant digits, also where the last ones are zeros.

    >>> measured(1.0), measured(-0.0999999), measured(166.2), measured(0.0)
    ('1.00', '−0.100', '166', '0')
    """
    text = format_number(value, digits)
    missing = digits - sum(letter.isdigit() for letter in text.lstrip("−0."))
    if missing < 1 or missing == digits or "×" in text or not text[-1].isdigit():
        return text
    return f"{text}{'' if '.' in text else '.'}{'0' * missing}"


def axis_label(array: xr.DataArray, index: int | None = None, width: int = 0) -> str:
    """Return the label of an axis: long name, symbol and units of an array, from its attributes.

    array : a variable of a dataset; what its attributes lack is taken from the vocabulary
    index : number that takes the place of the index k of the symbol, as in A_1
    width : letters of a line, for labels of several lines (default: one line)
    """
    words = _words(array)
    symbol = _indexed(words["symbol"], index)
    units = unit_text(words["units"])
    text = words["long_name"].partition(", 0 if ")[0]  # what a number stands for is told in tables
    lines = textwrap.wrap(text, width) if width else [text]
    tail = " ".join(filter(None, ["" if symbol == text else symbol, units and f"({units})"]))
    if width and lines and len(lines[-1]) + 3 + len(units) > width:
        return "\n".join(filter(None, [*lines, tail]))
    return " ".join(filter(None, ["\n".join(lines), tail]))


def symbol_of(array: xr.DataArray, index: int | None = None) -> str:
    """Return the symbol of an array as mathtext; `index` takes the place of its index k."""
    return _indexed(_words(array)["symbol"], index)


def value_text(array: xr.DataArray, value: float | str | None = None) -> str:
    """Write a value of an array with its symbol and units as mathtext (default: its own value)."""
    shown = array.values.item() if value is None else value
    if isinstance(shown, str):
        return f"followed {shown}wards" if array.name == "direction" else shown
    return f"{symbol_of(array)} = {with_units(array, number_text(array, shown))}"


def plain_value(array: xr.DataArray) -> str:
    """Write the value of a scalar array with its symbol and units as plain text."""
    value = array.values.item()
    if isinstance(value, str):
        return value_text(array)
    return f"{plain_symbol_of(array)} = {with_units(array, number_text(array, value))}"


def number_text(array: xr.DataArray, value: float) -> str:
    """Write a value of an array, of a parameter whose values are words its word."""
    words = WORDED.get(str(array.name))
    return words[int(value)] if words else format_number(float(value))


def with_units(array: xr.DataArray, number: str) -> str:
    """Write a number with the units of an array."""
    return f"{number} {unit_text(_words(array)['units'])}".strip()


def in_brackets(text: str, array: xr.DataArray) -> str:
    """Write a text with the units of an array in brackets, if it has any."""
    units = with_units(array, "")
    return f"{text} ({units})" if units else text


def flag_texts(flags: str) -> dict[int, str]:
    """Return the text of each integer of a flag variable: the name of its meaning, with spaces."""
    return {code: name.replace("_", " ") for name, code in FLAGS[flags].items()}


def plain_symbol(name: str) -> str:
    """Return the symbol of a parameter or coordinate as plain text."""
    return PLAIN_SYMBOLS.get(name, name)


def plain_symbol_of(array: xr.DataArray) -> str:
    """Return the plain symbol of an array beside its numbers: of a frequency in cycles, such as Hz, ω/2π."""
    return plain_symbol(str(array.name)) + (CYCLES if shows_cycles(array) else "")


def _words(array: xr.DataArray) -> dict[str, str]:
    """Return long name, symbol and units of an array: its own, else those of the vocabulary."""
    name = str(array.name)
    words = {"long_name": name.replace("_", " "), "symbol": "", "units": "1"}
    if name in VOCABULARY or name.endswith(ERROR_SUFFIX):
        entry = quantity(name)
        words = {"long_name": entry.long_name, "symbol": entry.symbol, "units": entry.units}
    return words | {key: str(array.attrs[key]) for key in words if key in array.attrs}


def _indexed(symbol: str, index: int | None) -> str:
    return symbol if index is None else re.sub(r"_[kjs](?![a-z])", f"_{index}", symbol)


def clock(dataset: xr.Dataset) -> str:
    """Return the name of time in a dataset, sampled or not: `time` in physical units, else `tau`."""
    return "time" if {"time", "C"} & {*dataset.variables} else "tau"


def times_of(dataset: xr.Dataset, event: str) -> xr.DataArray:
    """Return the times of the impacts or grazings of a motion, under the name that the dataset has for them."""
    name = f"{event}_{clock(dataset)}"
    return dataset[name if name in dataset else f"{event}_tau"]


def time_label(dataset: xr.Dataset, event: str) -> str:
    """Return the label of an axis of time, which may be unsampled, in the units of the times of `event`."""
    units = times_of(dataset, event).attrs.get("units", "1")
    return axis_label(xr.DataArray(0.0, name=clock(dataset), attrs={"units": units}))


def frequency(dataset: xr.Dataset) -> str:
    """Return the name of the excitation frequency in a dataset: `omega` in physical units, else `nu`."""
    return "omega" if "omega" in dataset.variables else "nu"


def force_amplitude(dataset: xr.Dataset) -> str:
    """Return the name of the amplitude of the excitation in a dataset: `F` in physical units, else `f`."""
    return "F" if "F" in dataset.variables else "f"


def parameter_names(dataset: xr.Dataset) -> list[str]:
    """Return the names of the parameters in a dataset, swept or not, with those in physical units first."""
    common = [name for name in PHYSICAL if PHYSICAL[name].non_dimensional not in FURTHER]
    names = dict.fromkeys((*common, *PARAMETERS, *PHYSICAL))
    return [name for name in names if name in dataset.variables]


def is_forced(dataset: xr.Dataset) -> bool:
    """Return whether a force acts anywhere in a dataset; without one no period of it is a period of the motion."""
    forces = [dataset[name] for name in OF_FORCE if name in dataset.variables]
    return any(bool((force != 0.0).any()) for force in forces)


def scalar_parameters(dataset: xr.Dataset) -> dict[str, float]:
    """Return the parameters of the exciter that are not swept in a dataset."""
    return {
        name: float(dataset[name]) for name in parameter_names(dataset) if dataset[name].ndim == 0
    }


def shown_parameters(dataset: xr.Dataset, leave_out: Iterable[str] = ()) -> list[str]:
    """Return the names of the parameters that are not swept, of the force only if there is one."""
    of_force = () if is_forced(dataset) else (frequency(dataset), force_amplitude(dataset))
    left_out = {*leave_out, *of_force}
    return [
        name
        for name in scalar_parameters(dataset)
        if name not in left_out and not is_soft_without_restitution(dataset, name)
    ]


def stated(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return the values of a parameter, NaN for the restitution 1, of none stated, of a soft support."""
    values = dataset[name]
    for stiffness in RIGID_RESTITUTION.get(name, ()):
        if stiffness in dataset.variables:
            values = values.where((values != 1) | (dataset[stiffness] == 0))
    return values


def is_soft_without_restitution(dataset: xr.Dataset, name: str) -> bool:
    """Return whether a parameter is the restitution 1, of none stated, of a support that is soft throughout."""
    return name in RIGID_RESTITUTION and bool(stated(dataset, name).isnull().all())


def parameter_line(dataset: xr.Dataset) -> str:
    """Write the parameters that are not swept as mathtext: nu = 1, f = -1, ..., in as few lines as fit on a figure."""
    return in_lines([value_text(dataset[name]) for name in shown_parameters(dataset)])


def parameters_text(dataset: xr.Dataset, leave_out: Iterable[str] = ()) -> str:
    """Write the parameters that are not swept as plain text: ν = 1, f = −1, ...; and how parameters are tied."""
    shown = ", ".join(plain_value(dataset[name]) for name in shown_parameters(dataset, leave_out))
    return "; tied: ".join(filter(None, [shown, ties_text(dataset)]))


def ties_text(dataset: xr.Dataset) -> str:
    """Write how parameters are tied as plain text: R₂ = R₁, f = 0.3 · ν²; empty if none are."""
    text = str(dataset.attrs.get("ties", "")).replace("; ", ", ")
    text = re.sub(r"\b[A-Za-z]\w*", lambda name: plain_symbol(name[0]), text)
    text = re.sub(r"\*\*(\d)(?![\d.])", lambda power: power[1].translate(RAISED), text)
    return re.sub(r" ?(?<!\*)\*(?!\*) ?", " · ", text)


def sentences(*parts: str) -> str:
    """Join sentences, given without their full stops; empty ones are left out."""
    return " ".join(f"{part}." for part in parts if part)


def grid_text(values: np.ndarray) -> str:
    """Write the values of a grid; of more than FEW_VALUES, the ends and the number."""
    if values.size <= FEW_VALUES:
        return ", ".join(format_number(value) for value in values.tolist())
    return f"{format_number(float(values.min()))} … {format_number(float(values.max()))} ({values.size} values)"


def grid_with_units(array: xr.DataArray) -> str:
    """Write the values of a grid with the units of its array."""
    text, _, number = grid_text(array.values).partition(" (")
    return with_units(array, text) + (f" ({number}" if number else "")


def times(amount: int) -> str:
    """Write a number of occurrences: once, twice, 7 times."""
    return {1: "once", 2: "twice"}.get(amount, f"{amount} times")


def departure(dataset: xr.Dataset) -> float:
    """Return the largest deviation of displacement from the exact motion."""
    return float(np.abs(dataset["displacement"] - dataset["displacement_exact"]).max())


def digits(value: float) -> str:
    """Write a computed number with three significant digits, in full from 100 to 1e6; whole ones without decimals.

    >>> digits(1098.4), digits(1.4001), digits(-0.2101), digits(2.0)
    ('1,098', '1.40', '−0.210', '2')
    """
    if 100 <= value < 1e6:
        return f"{value:,.0f}"
    return format_number(value) if float(value).is_integer() else measured(value)
