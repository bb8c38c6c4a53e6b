"""Units of what is shown: those that a study wrote or chose, else prefixes that give small numbers; units as text.

Datasets stay in SI. Their attribute `display_units` holds what was written or chosen; the function of that name makes
copies in these units (`solve.shown_units`), from whose variables pictures, captions, tables and pages take them.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from vibropipe.solve.shown_units import DIMENSION_OF, Shown, units_of
from vibropipe.words.parameters import PARAMETERS, PHYSICAL
from vibropipe.words.units import plain_units
from vibropipe.words.vocabulary import split_suffix

if TYPE_CHECKING:
    import xarray as xr

# digits as raised and lowered letters
RAISED = str.maketrans("-−0123456789", "⁻⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
# Prefixes that are tried for a unit, the largest first, with the factor from the stored unit.
PREFIXES: Mapping[str, tuple[tuple[str, float], ...]] = {
    "m": (("m", 1.0), ("mm", 1e3), ("µm", 1e6)),
    "m s-1": (("m s-1", 1.0), ("mm/s", 1e3), ("µm/s", 1e6)),
    "N": (("kN", 1e-3), ("N", 1.0), ("mN", 1e3), ("µN", 1e6)),
    "N m": (("N m", 1.0), ("mN m", 1e3), ("µN m", 1e6), ("nN m", 1e9)),
    "J": (("J", 1.0), ("mJ", 1e3), ("µJ", 1e6), ("nJ", 1e9)),
    "W": (("kW", 1e-3), ("W", 1.0), ("mW", 1e3), ("µW", 1e6)),
    "N s": (("N s", 1.0), ("mN s", 1e3), ("µN s", 1e6), ("nN s", 1e9)),
    "s": (("s", 1.0), ("ms", 1e3), ("µs", 1e6)),
}
# The largest magnitude of a unit, and that of each parameter, is at least this in the prefix that is chosen.
MIN_MAGNITUDE = 0.5
# Units in which parameters are usually stated: none gets a larger prefix on account of other quantities.
USUAL_UNITS: Mapping[str, str] = {"m": "mm", "N": "N"}
# What is derived from a quantity and of its size: all else, such as errors and spreads, may be of any size.
OF_ITS_SIZE = ("", "_target", "_lower", "_upper", "_measured", "_fitted")


def display_units(
    datasets: Mapping[str, xr.Dataset], prefixes: bool = True
) -> dict[str, xr.Dataset]:
    """Return the datasets of a study in units for display; those without physical units as they are.

    All quantities of one dimension get the same unit in all datasets, since pictures and tables show several together:
    the one that was written or chosen, else a prefix that gives small numbers.

    datasets : datasets in SI, or as this function returns them
    prefixes : whether units that nobody wrote or chose get a prefix instead of staying in SI
    """
    units: dict[str, str] = {}
    for dataset in datasets.values():
        units = units_of(dataset) | units
    for unit, choices in PREFIXES.items() if prefixes else ():
        sizes = [pair for dataset in datasets.values() for pair in _sizes(dataset, unit)]
        largest = max((size for _, size in sizes), default=0.0)
        if largest > 0.0 and DIMENSION_OF[unit] not in units:
            given = [size for name, size in sizes if name in {*PARAMETERS, *PHYSICAL}]
            units[DIMENSION_OF[unit]] = _prefix(choices, largest, given, USUAL_UNITS.get(unit))[0]
    shown = Shown(units)
    return {name: shown.dataset(dataset) for name, dataset in datasets.items()}


def _sizes(dataset: xr.Dataset, unit: str) -> list[tuple[str, float]]:
    """Return name and largest magnitude of the variables with a unit, without zeros and what may be of any size."""
    found = [
        (str(name), _largest(variable.values))
        for name, variable in dataset.variables.items()
        if variable.attrs.get("units") == unit and split_suffix(str(name))[1] in OF_ITS_SIZE
    ]
    return [(name, size) for name, size in found if size > 0.0]


def _prefix(
    choices: Sequence[tuple[str, float]], largest: float, given: Sequence[float], usual: str | None
) -> tuple[str, float]:
    """Return the prefix that suits the largest magnitude, at most the usual unit if one `given` would be small."""
    fitting = [entry for entry in choices if largest * entry[1] >= MIN_MAGNITUDE] or choices[-1:]
    if usual is not None and any(size * fitting[0][1] < MIN_MAGNITUDE for size in given):
        limit = dict(choices)[usual]
        fitting = [entry for entry in fitting if entry[1] >= limit]
    return fitting[0]


def _largest(values: np.ndarray) -> float:
    size = np.abs(values[np.isfinite(values)])
    return float(size.max(initial=0.0))


def unit_text(units: str) -> str:
    """Write a unit with slashes, raised powers and points for products; dimensionless is empty.

    >>> unit_text("N s m-1")
    'N·s/m'
    >>> unit_text("N s/mm"), unit_text("uN s/um")
    ('N·s/mm', 'µN·s/µm')
    """
    if units in ("", "1"):
        return ""
    text = units if "/" in units else plain_units(units)
    text = re.sub(r"(?:\^|\*\*)(\d)", lambda power: power[1].translate(RAISED), text)
    text = re.sub(r"\s*[ *·]\s*", "·", text)
    return re.sub(r"\bu(?=[mgsNJW](?![A-Za-z]))", "µ", text)
