"""Findings of a sweep: impact velocities, changes of regime, jumps, constant part.

A line of a sweep runs along the parameter with the finest grid, at fixed values of the others.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

import numpy as np
import xarray as xr

from vibropipe.figures.claims import between_text, only_between_text, with_rise
from vibropipe.figures.text import REGIME_TEXT, format_number, reasons_text, regime_name
from vibropipe.report.findings import (
    Finding,
    is_text,
    largest,
    point_text,
    symbol_text,
    value_text,
)
from vibropipe.report.table import Datasets
from vibropipe.scenes.sweep.first_touch import first_touch
from vibropipe.scenes.sweep.followed import is_followed, together_text
from vibropipe.scenes.sweep.jumps import NO_ORBIT, jumps_of
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import series

# Up to so many lines, the impacts and the jumps are told; more lines are described together, as a map.
FEW_LINES, MAX_LINES = 4, 12
MAX_RUNS = 6  # regimes along one line that a sentence names; the table names all
MAX_SENTENCES = 3
OF_LINES = ("regime", "period_multiple", "displacement_amplitude")
IMPACTS = (Regime.ONE_SIDED_1, Regime.ONE_SIDED_2, Regime.TWO_SIDED, Regime.WITH_REST)


def findings(datasets: Datasets) -> list[Finding]:
    """Return the findings of each sweep."""
    return [Finding(sweep_texts(data), name) for name, data in datasets.items() if "regime" in data]


def sweep_texts(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return the findings of one sweep, at most three sentences: the most useful, then the limit of what is known."""
    lines, unresolved = n_lines(dataset), unresolved_text(dataset)
    texts = [
        changes_text(dataset) if lines <= FEW_LINES else shares_text(dataset),
        together_text(dataset, axis_of(dataset)),
        velocity_text(dataset),
        force_text(dataset),
        aperiodic_text(dataset),
        jumps_text(dataset) if lines <= MAX_LINES else "",
        mean_text(dataset),
    ]
    told = [text for text in texts if text][: MAX_SENTENCES - bool(unresolved)]
    return (*told, *([unresolved] if unresolved else []))


def axis_of(dataset: xr.Dataset) -> str:
    """Return the dimension of the lines: that with the finest grid of numbers."""
    regime = dataset["regime"]
    numbers = [str(name) for name in regime.dims if not is_text(dataset[name])]
    return max(numbers, key=lambda name: dataset.sizes[name])


def n_lines(dataset: xr.Dataset) -> int:
    """Return the number of lines of a sweep."""
    return int(dataset["regime"].size // dataset.sizes[axis_of(dataset)])


def lines_of(dataset: xr.Dataset) -> Iterator[tuple[str, xr.Dataset]]:
    """Yield (point of the other parameters, its rows along the axis with increasing parameter)."""
    axis = axis_of(dataset)
    others = [str(name) for name in dataset["regime"].dims if name != axis]
    ordered = dataset[[n for n in OF_LINES if n in dataset]].sortby(axis)
    for position in np.ndindex(*(dataset.sizes[name] for name in others)):
        line = ordered.isel(dict(zip(others, position, strict=True)))
        yield point_text(line["regime"], others), line


def of_orbits(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Return a quantity of the rows with an orbit; NaN in the others."""
    return dataset[name].where(dataset["regime"] < NO_ORBIT)


def velocity_text(dataset: xr.Dataset) -> str:
    """Write the largest impact velocity of the orbits, its support and its row."""
    if "impact_velocity_max" not in dataset:
        return ""
    velocity = of_orbits(dataset, "impact_velocity_max")
    top = largest(velocity)
    if top is None or not float(top):
        struck = largest(dataset["impact_velocity_max"])
        return "" if struck is not None and float(struck) else "No support is struck"
    text = (
        f"Orbits strike support {int(top['support'])} hardest: {value_text(top, top)} in the row "
        f"{point_text(top, dataset['regime'].dims)}"
    )
    return with_rise(text, velocity, top, dataset["regime"].dims)


def aperiodic_text(dataset: xr.Dataset) -> str:
    """Write the largest impact velocity of aperiodic rows, if it exceeds that of the orbits."""
    if "impact_velocity_max" not in dataset:
        return ""
    velocity = dataset["impact_velocity_max"]
    top = largest(velocity.where(dataset["regime"] == Regime.APERIODIC))
    of_orbit = largest(of_orbits(dataset, "impact_velocity_max"))
    if top is None or (of_orbit is not None and float(top) <= float(of_orbit)):
        return ""
    window = ""
    if "window_periods" in dataset:
        at = {str(dim): top[dim].item() for dim in dataset["regime"].dims}
        window = f", in a window of {int(dataset['window_periods'].sel(at))} periods"
    return f"Aperiodic motion strikes harder than any orbit: {value_text(top, top)}{window}"


def force_text(dataset: xr.Dataset) -> str:
    """Write the largest force of a soft support and its row; empty if all are rigid or none is struck."""
    if "support_force_max" not in dataset:
        return ""
    force = of_orbits(dataset, "support_force_max")
    top = largest(force)
    if top is None:
        return ""
    text = (
        f"Soft support {int(top['support'])} has the largest force: {value_text(top, top)} in the row "
        f"{point_text(top, dataset['regime'].dims)}"
    )
    return with_rise(text, force, top, dataset["regime"].dims)


def mean_text(dataset: xr.Dataset) -> str:
    """Write the largest constant part of displacement of the orbits and its row; empty if it is rounding."""
    if "displacement_mean" not in dataset:
        return ""
    mean = of_orbits(dataset, "displacement_mean")
    top = largest(mean)
    if top is None:
        return ""
    scale = largest(of_orbits(dataset, "displacement_amplitude").isel(harmonic=0))
    if scale is not None and abs(float(top)) <= 1e-9 * abs(float(scale)):
        return "The constant part of displacement is zero throughout"
    text = (
        f"The constant part of displacement is not zero: it reaches {value_text(top, top)} in the row "
        f"{point_text(top, dataset['regime'].dims)}"
    )
    return with_rise(text, mean, top, dataset["regime"].dims)


def runs_of(line: xr.Dataset) -> list[tuple[str, int, int]]:
    """Return (text, first row, last row) of each run of rows of one regime and one period multiple."""
    codes = line["regime"].values
    if "period_multiple" in line:
        multiples = np.where(codes < NO_ORBIT, line["period_multiple"].values, 0)
    else:
        multiples = np.zeros_like(codes)
    runs, first = [], 0
    for (code, multiple), rows in groupby(zip(codes.tolist(), multiples.tolist(), strict=True)):
        last = first + len(list(rows)) - 1
        text = REGIME_TEXT[regime_name(code)]
        runs.append((f"{text}, m = {multiple}" if multiple > 1 else text, first, last))
        first = last + 1
    return runs


def runs_text(line: xr.Dataset, axis: str, at_most: int = MAX_RUNS) -> str:
    """Write the regimes along a line, each with its range of rows; beyond `at_most`, their number."""
    values, runs = line[axis].values, runs_of(line)
    texts = []
    for text, first, last in runs[:at_most]:
        low, high = format_number(float(values[first])), value_text(line[axis], values[last])
        texts.append(f"{text} ({high})" if first == last else f"{text} ({low} … {high})")
    texts += [f"… ({len(runs) - at_most} more)"] if len(runs) > at_most else []
    return "; ".join(texts)


def changes_text(dataset: xr.Dataset) -> str:
    """Write the regimes along a line of a sweep, or where impacts occur, and a border as far as it is known."""
    axis, lines = axis_of(dataset), list(lines_of(dataset))
    runs = runs_of(lines[0][1])
    if len(lines) > 1 or len(runs) > MAX_RUNS:
        return impacts_text(dataset)
    symbol = symbol_text(dataset[axis])
    if len(runs) == 1:
        return f"The regime is {runs[0][0]} in all rows along {symbol}"
    texts = f"Along {symbol} the regime is in turn {series(text for text, _, _ in runs)}"
    border = border_text(lines[0][1], axis, is_followed(dataset))
    return f"{texts}; {border}" if border else texts


def border_text(line: xr.Dataset, axis: str, followed: bool = False) -> str:
    """Write where the impacts of a line begin or end first, or else its first change of regime.

    That the motion without impacts touches a support there is told where the closed form says so; of followed rows
    nothing else is.
    """
    codes, values = line["regime"].values, line[axis].values
    changes = np.flatnonzero(codes[1:] != codes[:-1])
    if not changes.size:
        return ""
    touches = [
        n for n in changes if (codes[n] == Regime.NO_IMPACT) != (codes[n + 1] == Regime.NO_IMPACT)
    ]
    n = int((touches or changes)[0])
    low, high = float(values[n]), float(values[n + 1])
    place = first_touch(line, axis, low, high) if touches else None
    if place is not None:
        step = abs(high - low)
        digits = max(4, 3 + int(np.ceil(np.log10(max(abs(place), step) / step))))
        where = f"{symbol_text(line[axis])} = {value_text(line[axis], place, digits)}"
        return f"the motion without impacts touches a support at {where}"
    if followed:
        return ""
    if not touches:
        return f"the first change lies {between_text(line[axis], low, high)}"
    verb = "begin" if codes[n] == Regime.NO_IMPACT else "end"
    return f"impacts {verb} {between_text(line[axis], low, high)}"


def impacts_text(dataset: xr.Dataset) -> str:
    """Write outside which rows along the axis no line has impacts, and whether there are such rows between."""
    axis, lines = axis_of(dataset), [line for _, line in lines_of(dataset)]
    struck = [np.isin(line["regime"].values, (*IMPACTS, Regime.APERIODIC)) for line in lines]
    number = sum(bool(mask.any()) for mask in struck)
    if not number:
        return f"No row along {symbol_text(dataset[axis])} has impacts"
    where = only_between_text(lines[0][axis], np.any(struck, axis=0))
    which = (
        ""
        if len(lines) == 1
        else ", on each line"
        if number == len(lines)
        else ", not on each line"
    )
    if not where:
        where = "in some rows, up to both ends of the range,"
        where = "in all rows" if all(bool(mask.all()) for mask in struck) else where
    return f"Impacts occur {where} along {symbol_text(dataset[axis])}{which}"


def shares_text(dataset: xr.Dataset) -> str:
    """Write the most frequent regimes of a map, and in what share of its points they are."""
    regime = dataset["regime"]
    codes, amounts = np.unique(regime.values, return_counts=True)
    permutation = np.argsort(-amounts, kind="stable")
    names = [REGIME_TEXT[regime_name(int(codes[n]))] for n in permutation]
    shares = [f"{format_number(100.0 * float(amounts[n]) / regime.size, 3)} %" for n in permutation]
    if len(names) == 1:
        return f"The regime is {names[0]} at all points of the map"
    most = "at most points" if 2 * amounts.max() > regime.size else "at more points than any other"
    return (
        f"The regime {most} of the map is {names[0]}: {shares[0]}, then {names[1]} with {shares[1]}"
    )


def jumps_text(dataset: xr.Dataset) -> str:
    """Write between which rows the first harmonic jumps most; empty of followed rows, which may jump early."""
    if is_followed(dataset):
        return ""
    axis = axis_of(dataset)
    found = [
        (jump, point, line) for point, line in lines_of(dataset) for jump in jumps_of(line, axis)
    ]
    if not found:
        return ""
    jump, point, line = max(
        found, key=lambda each: abs(each[0].amplitude_after - each[0].amplitude_before)
    )
    where = between_text(line[axis], jump.before, jump.after) + (f" ({point})" if point else "")
    if len(found) == 1:
        return f"The first harmonic jumps {where}"
    return f"The first harmonic jumps in several places, most {where}"


def unresolved_text(dataset: xr.Dataset) -> str:
    """Write the number of unresolved rows by reason, and of unbounded rows."""
    codes = dataset["regime"].values
    texts = []
    for code in (Regime.UNRESOLVED, Regime.UNBOUNDED):
        mask = codes == code
        if mask.any():
            verb = "is" if mask.sum() == 1 else "are"
            has_reasons = code == Regime.UNRESOLVED and "status" in dataset
            reasons = f": {reasons_text(dataset['status'].values[mask])}" if has_reasons else ""
            texts.append(
                f"{int(mask.sum())} of {codes.size} rows {verb} {code.name.lower()}{reasons}"
            )
    return series(texts)
