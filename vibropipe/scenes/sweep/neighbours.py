"""What neighbouring rows of a sweep tell: jumps, and where the motion without impacts touches a support.

Of a followed sweep they tell where two motions are stable, and no border of either. Each row starts from the steady
state of the row before. The step of the parameter disturbs it, and the transient may lead elsewhere although the motion
is stable for some steps more: a row where a followed motion is left is no border of it. The first row of a line starts
anew, from the start of the sweep: a change after it is no border of anything.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import groupby
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from vibropipe.figures.claims import at_least, at_most, between_text
from vibropipe.figures.motion_words import times_word
from vibropipe.figures.text import with_units
from vibropipe.report.findings import equal_text, point_text, symbol_text
from vibropipe.report.parts import Answer
from vibropipe.scenes.sweep.sweep_rows import directions, strikes
from vibropipe.solve.shown_units import shown_factor
from vibropipe.solve.sweep.sweep_grid import DIRECTION
from vibropipe.words.regimes import Regime
from vibropipe.words.vocabulary import held_name

NAMES = ("nu", "f", "h", "l", "delta", "load", "f2", "friction", "shaker", "m", "C")
ABSENT = dict.fromkeys(("h", "delta", "load", "f2", "friction", "shaker"), 0.0) | {
    "m": 1.0,
    "C": 1.0,
}
# A jump is a step of the amplitude by this share of its maximum on the line, and by this factor steeper than the
# steps on either side: a resonance curve is steep over several rows, a jump is not. A step without another one on
# either side, at an end of a line or beside a row without an orbit, cannot be told from steepness; motions without
# impacts do not jump.
JUMP_SHARE, JUMP_FACTOR, MAX_BESIDE = 0.1, 5.0, 3
MIN_DOUBLINGS = 2  # of the period, that are told as a way to chaos


@dataclass(frozen=True)
class Jump:
    """A jump between neighbouring rows of a line: the values of the parameter on either side, and its size."""

    before: float
    after: float
    size: float


def jumps_of(line: xr.Dataset, axis: str) -> list[Jump]:
    """Return the jumps of the first harmonic of displacement between neighbouring rows that have an orbit."""
    if "displacement_amplitude" not in line:
        return []
    amplitude = line["displacement_amplitude"].isel(harmonic=0).values
    regime, values = line["regime"].values, line[axis].values
    # Beside a mass that lies on a support for good, too, a jump cannot be told from motions that die out.
    moves = (regime == Regime.NO_IMPACT) | strikes(line).values
    amplitude = np.where(moves & (regime < Regime.APERIODIC), amplitude, np.nan)
    return [
        Jump(float(values[n]), float(values[n + 1]), abs(float(amplitude[n + 1] - amplitude[n])))
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
    slopes, ways = steps / np.abs(np.diff(x)), np.sign(np.diff(values))
    is_large = pairs & (steps > JUMP_SHARE * np.abs(values[known]).max())
    # Jumps may lie side by side: each is compared with what lies beside them all.
    starts = np.flatnonzero(np.diff(np.concatenate([[0], is_large.astype(int)])) == 1)
    ends = np.flatnonzero(np.diff(np.concatenate([is_large.astype(int), [0]])) == -1)
    padded, is_jump = np.concatenate([[np.inf], slopes, [np.inf]]), np.zeros(len(steps), bool)
    for first, last in zip(starts.tolist(), ends.tolist(), strict=True):
        beside = max(padded[first], padded[last + 2])
        if last - first < MAX_BESIDE:
            for n in range(first, last + 1):
                # Two steps the same way that are alike are steepness, or two jumps: that cannot be told.
                alike = [
                    slopes[k] for k in (n - 1, n + 1) if first <= k <= last and ways[k] == ways[n]
                ]
                is_jump[n] = slopes[n] > JUMP_FACTOR * max([beside, *alike])
    struck = regime != Regime.NO_IMPACT
    return np.flatnonzero(is_jump & pairs & (struck[:-1] | struck[1:]))


def first_touch(line: xr.Dataset, axis: str, low: float, high: float) -> float | None:
    """Return the value of a parameter between two rows at which the linear motion touches a support.

    There |f + shaker nu^2| / sqrt((1 - nu^2)^2 + h^2 nu^2) = l - |delta - load|. None if it does not between these
    rows, if a parameter is not known, or under a second harmonic, friction, a housing that may slide or no damping,
    with which a free vibration of the start remains: there is no such form.

    line : rows along a parameter, the others as scalar coordinates, in any units that are shown
    low, high : its values in the two rows
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
    ratio = held_name(line.coords, "mass_ratio")
    if (swept != "h" and numbers["h"] == 0.0) or (
        ratio in line.coords and line[ratio].values.any()
    ):
        return None

    from scipy.optimize import brentq  # slow to import, and no picture has a use for it

    def gap(value: float) -> float:
        return _gap({**numbers, swept: value / factors[swept]})

    ends = gap(low), gap(high)
    if not all(map(math.isfinite, ends)) or ends[0] * ends[1] >= 0.0:
        return None
    return float(brentq(gap, low, high, xtol=1e-15 * max(abs(low), abs(high)), rtol=1e-14))


def border_text(line: xr.Dataset, axis: str, followed: bool = False) -> str:
    """Write where the impacts of a line begin or end first; empty if they do not.

    That the motion without impacts touches a support there is told where the closed form says so; of followed rows
    nothing else is.
    """
    codes, values = line["regime"].values, line[axis].values
    known = codes < Regime.UNBOUNDED
    still = ~strikes(line).values
    touches = np.flatnonzero((still[1:] != still[:-1]) & known[1:] & known[:-1])
    if not touches.size:
        return ""
    n = int(touches[0])
    low, high = float(values[n]), float(values[n + 1])
    place = first_touch(line, axis, low, high)
    if place is not None:
        step = abs(high - low)
        digits = max(4, 3 + int(np.ceil(np.log10(max(abs(place), step) / step))))
        where = equal_text(line[axis], place, digits)
        return f"The motion without impacts touches a support at {where}."
    if followed:
        return ""
    verb = "begin" if still[n] else "end"
    first = "first " if (still[touches] == still[n]).sum() > 1 else ""
    return f"Impacts {first}{verb} {between_text(line[axis], low, high)}."


def _gap(numbers: Mapping[str, float]) -> float:
    """Return the gap that the linear motion leaves to the nearer support; without units m = C = 1."""
    nu, stiffness = numbers["nu"], numbers["C"]
    size = math.hypot(stiffness - numbers["m"] * nu * nu, numbers["h"] * nu)
    force = numbers["f"] + numbers["m"] * numbers["shaker"] * nu * nu
    amplitude = abs(force) / size if size > 0.0 else math.inf
    return numbers["l"] - abs(numbers["delta"] - numbers["load"] / stiffness) - amplitude


# Of two rows in one orbit: they agree within this share of the largest value.
SAME_ORBIT = 1e-6
DIGITS = 6
# Quantities that tell orbits of one regime and period multiple apart, as far as a sweep has them.
COMPARED = ("impacts_per_period", "displacement_amplitude", "displacement_mean")
LEFT_EARLY = (
    "A followed motion may be left before it ends: a change between rows is no border of it"
)


class Rows(NamedTuple):
    """Neighbouring rows of one line, by the first and the last value of the parameter, and the line in words."""

    low: float
    high: float
    point: str


def is_followed(dataset: xr.Dataset) -> bool:
    """Return whether rows start from the steady states of their neighbours."""
    return bool(directions(dataset))


def differing_rows(dataset: xr.Dataset, axis: str) -> list[Rows]:
    """Return the rows in which both directions are on different stable orbits, the widest range first."""
    if DIRECTION not in dataset["regime"].dims:
        return []
    ordered = dataset.sortby(axis)
    up, down = (ordered.sel({DIRECTION: way}) for way in ("up", "down"))
    differs = (up["regime"] != down["regime"]) | (up["period_multiple"] != down["period_multiple"])
    for name in (name for name in COMPARED if name in dataset):
        change = abs(up[name] - down[name]) > SAME_ORBIT * float(abs(dataset[name]).max())
        extra = [dim for dim in change.dims if dim not in differs.dims]
        differs = differs | change.any(extra)
    for way in (up, down):
        differs = differs & (way["regime"] < Regime.APERIODIC)
        if "stable" in dataset:
            differs = differs & (way["stable"] != 0)
    found = [rows for line in _lines(differs, axis) for rows in line]
    return sorted(found, key=lambda rows: rows.low - rows.high)


def _lines(mask: xr.DataArray, axis: str) -> Iterator[list[Rows]]:
    """Yield the ranges of each line in which a mask is true."""
    others = [str(dim) for dim in mask.dims if dim != axis]
    values = mask[axis].values
    for position in np.ndindex(*(mask.sizes[name] for name in others)):
        line = mask.isel(dict(zip(others, position, strict=True)))
        runs = [list(run) for kept, run in groupby(range(values.size), line.values.item) if kept]
        point = point_text(line, others)
        yield [Rows(float(values[run[0]]), float(values[run[-1]]), point) for run in runs]


def together_answer(dataset: xr.Dataset, axis: str) -> Answer | None:
    """Return in which rows both directions are on different orbits; none if in none or not followed both ways."""
    found = differing_rows(dataset, axis)
    if not found:
        return None
    rows = found[0]
    where = f"{'from' if rows.low < rows.high else 'at'} {range_text(dataset, axis, rows)}"
    widths = [each.high - each.low for each in found]
    one = "The widest range" if widths.count(widths[0]) == 1 else "One of the widest ranges"
    widest = "They are in the rows" if len(found) == 1 else f"{one} of such rows is"
    lead = "Among the motions followed here, at least two are stable together."
    return Answer(lead, f"{widest} {where}.")


def range_text(dataset: xr.Dataset, axis: str, rows: Rows) -> str:
    """Write a range of rows, rounded inwards, so that all of them are within it."""
    low, high = at_most(rows.low, DIGITS), with_units(dataset[axis], at_least(rows.high, DIGITS))
    symbol = symbol_text(dataset[axis])
    return f"{symbol} = {low} to {high}" if rows.low < rows.high else f"{symbol} = {high}"


class Doublings(NamedTuple):
    """Runs of rows whose period doubles (period, first and last value), up to the first aperiodic row `end`."""

    runs: list[tuple[int, float, float]]
    end: float
    is_falling: bool


def doublings_of(dataset: xr.Dataset, axis: str) -> Doublings | None:
    """Return the longest way of doublings along one line to aperiodic motion; None with fewer than two.

    A flip doubles the impacts, too: other laws of twice the periods are other motions, to which a row may jump. Rows
    without a result are passed over.
    """
    if dataset["regime"].ndim > 1 or not {"period_multiple", "impacts_per_orbit"} <= {*dataset}:
        return None
    best: Doublings | None = None
    for falls in (False, True):
        line = dataset.sortby(axis, ascending=not falls)
        regime, values = line["regime"].values, line[axis].values
        known = np.flatnonzero(regime <= Regime.APERIODIC)
        multiples = np.where(regime < Regime.APERIODIC, line["period_multiple"].values, 0)[known]
        impacts = line["impacts_per_orbit"].transpose(axis, ...).values[known]
        runs: list[tuple[int, float, float]] = []  # period, first and last value
        for m, found in groupby(range(known.size), key=multiples.tolist().__getitem__):
            rows = [*found]
            first, last = values[known[rows[0]]].item(), values[known[rows[-1]]].item()
            if not m and len(runs) > max(MIN_DOUBLINGS, len(best.runs) if best else 0):
                best = Doublings(runs, first, falls)
            doubles = bool(runs) and m == 2 * runs[-1][0]
            doubles &= np.array_equal(impacts[rows[0]], 2.0 * impacts[rows[0] - 1])
            runs = [*(runs if doubles else []), (m, first, last)]
    return best


def doubling_answer(dataset: xr.Dataset, axis: str) -> Answer | None:
    """Write how often the period doubles along one line before the motion is aperiodic; None for fewer than twice."""
    found = doublings_of(dataset, axis)
    if found is None:
        return None
    runs = found.runs
    way = f"With {'falling' if found.is_falling else 'rising'} {symbol_text(dataset[axis])}"
    return Answer(
        f"{way} the period doubles {times_word(len(runs) - 1)} before aperiodic motion.",
        f"First {between_text(dataset[axis], runs[0][2], runs[1][1])}.",
    )
