"""The numbers beside the drawing of the exciter: the values of each parameter, or the range that it has."""

from __future__ import annotations

import string
from typing import Any

import numpy as np
import xarray as xr

from vibropipe.figures.text import (
    CYCLES,
    is_forced,
    number_text,
    parameters_text,
    shown_parameters,
    stated,
    with_units,
)
from vibropipe.report.parts import SYMBOLS, Datasets, Row, Side
from vibropipe.solve.physical import is_physical
from vibropipe.solve.shown_units import shows_cycles
from vibropipe.words.exciter import EFFECTS, PARAMETERS
from vibropipe.words.parameters import DEFAULTS, FURTHER, PHYSICAL, THROUGH_OTHERS, of_effect
from vibropipe.words.vocabulary import physical_name

FEW = 3  # values that are listed
# Words of each parameter, with and without units, in the order of the rows.
WORDS = {"m": "mass", "C": "stiffness"} | {
    name: each.words for each in PARAMETERS for name in (each.name, physical_name(each.name))
}
WORDS["M"] = "mass of the housing"
# Words of two equal parameters that are not those of the first one of both supports.
OF_PAIRS = {"R1": "restitution"} | dict.fromkeys(
    ("D1", "housing_friction_1"), "housing friction, both ways"
)
OF_FORCE = tuple(name for each in of_effect("forcing") for name in (each, physical_name(each)))
# Constant forces, friction and a shaker, under both names: datasets without one leave it out.
FORCES = {
    each
    for name, entry in PHYSICAL.items()
    if entry.non_dimensional in FURTHER
    and (entry.dimension == "force" or THROUGH_OTHERS.get(entry.non_dimensional))
    for each in (name, entry.non_dimensional)
}
LETTERS = SYMBOLS | {each.name: each.plain for each in PARAMETERS}


def side_of(datasets: Datasets) -> Side:
    """Return the parameters of the exciter in some datasets; equal ones of both supports share a row."""
    forced = any(is_forced(data) for data in datasets.values())
    names = [name for name in WORDS if forced or name not in OF_FORCE]
    texts = {name: text for name in names if (text := values_text(name, datasets))}
    rows = []
    for name, text in texts.items():
        twin = f"{name[:-1]}2"
        if name.endswith("2") and texts.get(f"{name[:-1]}1") == text:
            continue
        is_pair = name.endswith("1") and texts.get(twin) == text
        symbol, words = LETTERS.get(name, name), WORDS[name]
        if any(name in data and shows_cycles(data[name]) for data in datasets.values()):
            symbol += CYCLES
        if is_pair:
            symbol += f", {LETTERS.get(twin, twin)}"
            words = OF_PAIRS.get(name, words.replace("support 1", "the supports"))
        rows.append(Row(symbol, text, words))
    return Side(rows)


def bare_symbols(datasets: Datasets) -> str:
    """Return letters that are symbols, as l and R, without a value beside them: no units, nor names of motions.

    With units h is the hour of km/h.
    """
    names = ("friction", "load", "shaker")
    forces = "".join(SYMBOLS[name] for name in names if has_value(name, datasets))
    if not any(is_physical(data) for data in datasets.values()):
        return f"fh{forces}"
    motions = max(data.sizes.get("attractor_id", 0) for data in datasets.values())
    own = "CFHMP" if has_value("mass_ratio", datasets) else "CFHP"
    capitals = (each for each in own if string.ascii_uppercase.index(each) >= motions)
    return "".join([*capitals, forces])


def side_of_first(datasets: Datasets) -> Side:
    """Return the parameters and the drawing of the exciter of the first dataset, that of the hero."""
    label = next(iter(datasets))
    first = {label: datasets[label]}
    return Side(side_of(first).rows, drawn=first)


def values_text(name: str, datasets: Datasets) -> str:
    """Write the values of a parameter over all datasets with their unit; empty without it or its effect.

    Those that designs have found count only where no other dataset has any.
    """
    arrays = arrays_of(name, datasets)
    found = np.concatenate([np.empty(0), *(np.ravel(array.values) for array in arrays)])
    if name in FORCES and len(arrays) < len(datasets):
        found = np.append(found, 0.0)  # datasets without a force leave it out
    values = np.unique(found[np.isfinite(found)])
    absent = next((DEFAULTS[each] for each in FURTHER if name in (each, physical_name(each))), None)
    if not values.size or (values == absent).all():
        return ""
    # values that the rounding of a damping alone tells apart are one
    parts = [*dict.fromkeys(number_text(arrays[0], value) for value in values)]
    text = ", ".join(parts) if len(parts) <= FEW else f"{parts[0]} … {parts[-1]}"
    return with_units(arrays[0], text)


def said_beside(caption: str, dataset: xr.Dataset, datasets: Datasets) -> str:
    """Return a caption without the sentence of the parameters of its dataset, if all stand beside the exciter."""
    text, names = parameters_text(dataset), shown_parameters(dataset)
    is_said = all(values_text(n, datasets) == values_text(n, {"": dataset}) for n in names)
    if not text or "tied" in text or not is_said:
        return caption
    return caption.replace(f"{text}.", "").replace("  ", " ").strip()


def arrays_of(name: str, datasets: Datasets) -> list[xr.DataArray]:
    """Return the values of a parameter in each dataset, those of designs only where there are no others."""
    arrays = [stated(data, name) for data in datasets.values() if name in data.variables]
    return [array for array in arrays if "design" not in array.dims] or arrays


def offset_sign(datasets: Datasets) -> int:
    """Return on which side the drawing has the equilibrium: −1, right of the middle, only if no offset is positive."""
    offsets = [array.values for array in arrays_of("delta", datasets)]
    is_negative = any((each < 0).any() for each in offsets)
    return -1 if is_negative and not any((each > 0).any() for each in offsets) else 1


def has_value(name: str, datasets: Datasets) -> bool:
    """Return whether a parameter, under its name with units or without, has a value other than its absence."""
    return any(values_text(each, datasets) for each in (name, physical_name(name)))


def of_calls(effect: str) -> tuple[str, ...]:
    """Return the parameters that call for a further effect."""
    return next(each.calls for each in EFFECTS if each.name == effect)


def sentences_of(datasets: Datasets) -> list[str]:
    """Return what a report says of each further effect that occurs in some datasets."""
    return [
        each.sentence
        for each in EFFECTS
        if each.sentence and any(has_value(name, datasets) for name in each.calls)
    ]


def is_of_many_exciters(dataset: xr.Dataset) -> bool:
    """Return whether a dataset has forced motions of exciters whose parameters it does not hold."""
    effects = str(dataset.attrs.get("effects", "")).split(", ")
    return "forcing" in effects and not any(name in dataset.variables for name in WORDS)


def force_text(datasets: Datasets, has_units: bool) -> str:
    """Write the force of the drawing: its formula if that is one sine of a stated size; empty without a force."""
    if any(is_of_many_exciters(data) for data in datasets.values()):
        return "f(τ)"
    if not any(is_forced(data) for data in datasets.values()):
        return ""
    others = (*of_calls("second_harmonic"), *of_calls("shaker"))
    if any(has_value(name, datasets) for name in others):
        return "F(t)" if has_units else "f(τ)"
    return "F sin ωt" if has_units else "f sin ντ"


def drawing_of(datasets: Datasets) -> dict[str, Any]:
    """Return what the drawing shows: soft supports, friction, a load, a housing, the side of the offset, symbols."""
    has_units = any("C" in data.variables for data in datasets.values())
    soft = [has_value(name, datasets) for name in of_calls("soft")]
    stiffness = ("C₁", "C₂") if has_units else ("k₁", "k₂")
    return {
        "soft": soft,
        "friction": has_value("friction", datasets),
        "load": has_value("load", datasets),
        "housing": has_value("mass_ratio", datasets),
        "offset": offset_sign(datasets),
        "symbols": {
            "stiffness": "C" if has_units else "1",
            "damping": "H" if has_units else "h",
            "force": force_text(datasets, has_units),
            "supports": [
                s if is_soft else r
                for s, r, is_soft in zip(stiffness, ("R₁", "R₂"), soft, strict=True)
            ],
        },
    }
