"""Where the motion without impacts first touches a support, in closed form, between two rows of a sweep."""

from __future__ import annotations

import math
from collections.abc import Mapping

import xarray as xr
from scipy.optimize import brentq

from vibropipe.solve.shown_units import shown_factor
from vibropipe.words.vocabulary import held_name

NAMES = ("nu", "f", "h", "l", "delta", "load", "f2", "friction", "m", "C")
ABSENT = {"h": 0.0, "delta": 0.0, "load": 0.0, "f2": 0.0, "friction": 0.0, "m": 1.0, "C": 1.0}


def first_touch(line: xr.Dataset, axis: str, low: float, high: float) -> float | None:
    """Return the value of a parameter between two rows at which the linear motion touches a support.

    There |f| / sqrt((1 - nu^2)^2 + h^2 nu^2) = l - |delta - load|. None if it does not between these rows, if a
    parameter is not known, or under a second harmonic or friction, for which there is no such form.

    Parameters
    ----------
    line : Dataset
        Rows along a parameter, the others as scalar coordinates, in any units that are shown.
    axis : str
        The parameter.
    low, high : float
        Its values in the two rows.
    """
    held = {name: held_name(line.coords, name) for name in NAMES}
    known = {name for name in NAMES if held[name] in line.coords}
    if not {"nu", "f", "l"} <= known or any(line[held[n]].ndim for n in known if held[n] != axis):
        return None
    factors = {n: shown_factor(str(line[held[n]].attrs.get("units", "1"))) for n in known}
    numbers = ABSENT | {n: float(line[held[n]]) / factors[n] for n in known if held[n] != axis}
    swept = next((name for name in known if held[name] == axis), None)
    if swept is None or numbers["f2"] or numbers["friction"] or swept in ("f2", "friction"):
        return None

    def gap(value: float) -> float:
        return _gap({**numbers, swept: value / factors[swept]})

    ends = gap(low), gap(high)
    if not all(map(math.isfinite, ends)) or ends[0] * ends[1] >= 0.0:
        return None
    return float(brentq(gap, low, high, xtol=1e-15 * max(abs(low), abs(high)), rtol=1e-14))


def _gap(numbers: Mapping[str, float]) -> float:
    """Return the gap that the linear motion leaves to the nearer support; without units m = C = 1."""
    nu, stiffness = numbers["nu"], numbers["C"]
    size = math.hypot(stiffness - numbers["m"] * nu * nu, numbers["h"] * nu)
    amplitude = abs(numbers["f"]) / size if size > 0.0 else math.inf
    return numbers["l"] - abs(numbers["delta"] - numbers["load"] / stiffness) - amplitude
