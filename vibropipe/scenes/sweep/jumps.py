"""Between two rows of a sweep: jumps of the first harmonic, and where the motion without impacts touches a support."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.solve.shown_units import shown_factor
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import held_name

NAMES = ("nu", "f", "h", "l", "delta", "load", "f2", "friction", "m", "C")
ABSENT = {"h": 0.0, "delta": 0.0, "load": 0.0, "f2": 0.0, "friction": 0.0, "m": 1.0, "C": 1.0}
# A jump is a step of the amplitude by this share of its maximum on the line, and by this factor steeper than the
# steps on either side: a resonance curve is steep over several rows, a jump is not. A step without another one on
# either side, at an end of a line or beside a row without an orbit, cannot be told from steepness; motions without
# impacts do not jump.
JUMP_SHARE, JUMP_FACTOR = 0.1, 5.0
NO_ORBIT = Regime.APERIODIC  # regimes from here on have no orbit


@dataclass(frozen=True)
class Jump:
    """A jump between neighbouring rows of a line: the values of the parameter and the amplitudes on either side."""

    before: float
    after: float
    amplitude_before: float
    amplitude_after: float


def jumps_of(line: xr.Dataset, axis: str) -> list[Jump]:
    """Return the jumps of the first harmonic of displacement between neighbouring rows that have an orbit."""
    if "displacement_amplitude" not in line:
        return []
    amplitude = line["displacement_amplitude"].isel(harmonic=0).values
    regime, values = line["regime"].values, line[axis].values
    amplitude = np.where(regime < NO_ORBIT, amplitude, np.nan)
    return [
        Jump(*(float(v) for v in (values[n], values[n + 1], amplitude[n], amplitude[n + 1])))
        for n in jump_steps(values, amplitude, regime)
    ]


def jump_steps(
    x: NDArray[np.float64], values: NDArray[np.float64], regime: NDArray[np.int8]
) -> NDArray[np.intp]:
    """Return the rows after which a quantity over `x` jumps; values that are not finite belong to no orbit."""
    known = np.isfinite(values)
    if known.sum() < 2:
        return np.empty(0, np.intp)
    pairs = known[:-1] & known[1:]
    steps = np.where(pairs, np.abs(np.diff(np.where(known, values, 0.0))), np.inf)
    slopes = steps / np.abs(np.diff(x))
    padded = np.concatenate([[np.inf], slopes, [np.inf]])
    beside = np.maximum(padded[:-2], padded[2:])
    struck = regime != Regime.NO_IMPACT
    is_jump = (steps > JUMP_SHARE * np.abs(values[known]).max()) & (slopes > JUMP_FACTOR * beside)
    return np.flatnonzero(is_jump & pairs & (struck[:-1] | struck[1:]))


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

    from scipy.optimize import brentq  # slow to import, and no picture has a use for it

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
