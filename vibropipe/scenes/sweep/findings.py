"""Findings of a sweep: impact velocities, changes of regime, jumps, constant part.

A line of a sweep runs along the parameter with the finest grid, at fixed values of the others.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

import numpy as np
import xarray as xr

from vibropipe.figures.text import (
    REGIME_TEXT,
    format_number,
    reasons_text,
    regime_name,
)
from vibropipe.report.findings import (
    Finding,
    extent_text,
    is_text,
    largest,
    point_text,
    range_text,
    symbol_text,
    value_text,
)
from vibropipe.report.table import Datasets
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import series

# Up to so many lines, the impacts and the jumps of each are named; more lines are described together, as a map.
FEW_LINES, MAX_LINES = 4, 12
MAX_RUNS = 6  # regimes along one line that a sentence names; the table names all
# Jumps that a sentence lists on each line, and up to which number in all it states the amplitudes.
MAX_JUMPS, FEW_JUMPS = 6, 3
# A jump is a step of the amplitude by this share of its maximum on the line, and by this factor larger than the
# steps on either side: a resonance curve is steep over several rows, a jump is not. A step without another one on
# either side, at an end of a line or beside a row without an orbit, cannot be told from steepness.
JUMP_SHARE, JUMP_FACTOR = 0.1, 5.0
IMPACTS = (Regime.ONE_SIDED_1, Regime.ONE_SIDED_2, Regime.TWO_SIDED, Regime.WITH_REST)
NO_ORBIT = Regime.APERIODIC  # regimes from here on have no orbit


@dataclass(frozen=True)
class Jump:
    """A jump between neighbouring rows of a line: the values of the parameter and the amplitudes on either side."""

    before: float
    after: float
    amplitude_before: float
    amplitude_after: float


def findings(datasets: Datasets) -> list[Finding]:
    """Return the findings of each sweep."""
    return [Finding(sweep_texts(data), name) for name, data in datasets.items() if "regime" in data]


def sweep_texts(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return the findings of one sweep, a sentence each."""
    return (
        velocity_text(dataset),
        force_text(dataset),
        changes_text(dataset) if n_lines(dataset) <= FEW_LINES else shares_text(dataset),
        jumps_text(dataset) if n_lines(dataset) <= MAX_LINES else "",
        mean_text(dataset),
        unresolved_text(dataset),
    )


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
    names = [n for n in ("regime", "period_multiple", "displacement_amplitude") if n in dataset]
    ordered = dataset[names].sortby(axis)
    for position in np.ndindex(*(dataset.sizes[name] for name in others)):
        line = ordered.isel(dict(zip(others, position, strict=True)))
        yield point_text(line["regime"], others), line


def velocity_text(dataset: xr.Dataset) -> str:
    """Write the largest impact velocity, its support and its place."""
    if "impact_velocity_max" not in dataset:
        return ""
    velocity = dataset["impact_velocity_max"]
    top = largest(velocity)
    if top is None or not float(top):
        return "No support is struck"
    text = (
        f"The largest impact velocity is {value_text(top, top)}, on support {int(top['support'])} "
        f"at {point_text(top, dataset['regime'].dims)}"
    )
    second = largest(velocity.sel(support=3 - int(top["support"])))
    if second is None or not float(second):
        return f"{text}; the other support is not struck"
    return f"{text}; on support {int(second['support'])} it reaches {value_text(second, second)}"


def force_text(dataset: xr.Dataset) -> str:
    """Write the largest force of a soft support and its place; empty if all are rigid or none is struck."""
    top = largest(dataset["support_force_max"]) if "support_force_max" in dataset else None
    if top is None:
        return ""
    return (
        f"The largest force of a soft support is {value_text(top, top)}, of support {int(top['support'])} "
        f"at {point_text(top, dataset['regime'].dims)}"
    )


def mean_text(dataset: xr.Dataset) -> str:
    """Write the largest constant part of displacement and its place; empty if it is rounding."""
    if "displacement_mean" not in dataset:
        return ""
    mean = dataset["displacement_mean"]
    top = largest(mean)
    if top is None:
        return ""
    scale = largest(dataset["displacement_amplitude"].isel(harmonic=0))
    if scale is not None and abs(float(top)) <= 1e-9 * abs(float(scale)):
        return "The constant part of displacement is zero throughout"
    return (
        f"The constant part of displacement is largest, {value_text(top, top)}, "
        f"at {point_text(top, dataset['regime'].dims)}"
    )


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
    """Write the regimes along the lines of a sweep; of several lines, where there are impacts."""
    axis, lines = axis_of(dataset), list(lines_of(dataset))
    symbol = symbol_text(dataset[axis])
    if len(lines) == 1 and len(runs_of(lines[0][1])) <= MAX_RUNS:
        return f"Regimes along {symbol}: {runs_text(lines[0][1], axis)}"
    texts = []
    for point, line in lines:
        values, codes = line[axis].values, line["regime"].values
        struck = np.isin(codes, (*IMPACTS, Regime.APERIODIC))
        text = range_text(line[axis], values[struck]) if struck.any() else f"no {symbol}"
        inner = struck[struck.argmax() : struck.size - struck[::-1].argmax()]
        gaps = " (with gaps)" if struck.any() and not inner.all() else ""
        texts.append(f"{text}{gaps}" + (f" ({point})" if point else ""))
    return f"Impacts occur at {series(texts)}"


def shares_text(dataset: xr.Dataset) -> str:
    """Write the share of each regime of a map and the ranges that it lies in, the most frequent first."""
    regime = dataset["regime"]
    codes, amounts = np.unique(regime.values, return_counts=True)
    texts = []
    for n in np.argsort(-amounts, kind="stable"):
        share = f"{format_number(100.0 * float(amounts[n]) / regime.size, 3)} %"
        name = REGIME_TEXT[regime_name(int(codes[n]))]
        where = extent_text(regime == codes[n], part=True)
        texts.append(f"{name} at {share}{f' ({where})' if where else ''}")
    return f"Of {regime.size} points, the steady state is {series(texts)}"


def jumps_of(line: xr.Dataset, axis: str) -> list[Jump]:
    """Return the jumps of the first harmonic of displacement between neighbouring rows that have an orbit."""
    if "displacement_amplitude" not in line:
        return []
    amplitude = line["displacement_amplitude"].isel(harmonic=0).values
    has_orbit = (line["regime"].values < NO_ORBIT) & np.isfinite(amplitude)
    if has_orbit.sum() < 2:
        return []
    pairs = has_orbit[:-1] & has_orbit[1:]
    steps = np.where(pairs, np.abs(np.diff(np.where(has_orbit, amplitude, 0.0))), np.inf)
    padded = np.concatenate([[np.inf], steps, [np.inf]])
    beside = np.maximum(padded[:-2], padded[2:])
    is_jump = (steps > JUMP_SHARE * amplitude[has_orbit].max()) & (steps > JUMP_FACTOR * beside)
    values = line[axis].values
    return [
        Jump(*(float(v) for v in (values[n], values[n + 1], amplitude[n], amplitude[n + 1])))
        for n in np.flatnonzero(is_jump)
    ]


def jumps_text(dataset: xr.Dataset) -> str:
    """Write the jumps of a sweep line by line: their places, and of few ones the amplitudes on either side."""
    axis = axis_of(dataset)
    by_line = [(point, line, jumps_of(line, axis)) for point, line in lines_of(dataset)]
    total = sum(len(jumps) for _, _, jumps in by_line)
    texts = []
    for point, line, jumps in by_line:
        shown = jumps[:MAX_JUMPS]
        if not shown:
            continue
        places = [value_text(dataset[axis], (jump.before + jump.after) / 2) for jump in shown]
        if total <= FEW_JUMPS:
            places = [
                f"{place} from {sides_text(jump, line, dataset)}"
                for place, jump in zip(places, shown, strict=True)
            ]
        if len(jumps) > MAX_JUMPS:
            places.append(f"{len(jumps) - MAX_JUMPS} more")
        texts.append(f"{series(places)}{f' ({point})' if point else ''}")
    return (
        f"The first harmonic has large jumps at {symbol_text(dataset[axis])} = {'; '.join(texts)}"
        if texts
        else ""
    )


def sides_text(jump: Jump, line: xr.Dataset, dataset: xr.Dataset) -> str:
    """Write the amplitudes before and after a jump, in the direction in which the line is followed."""
    direction = line["direction"].item() if "direction" in line.coords else ""
    is_down = str(dataset.attrs.get("follow", "")).endswith(" down") or direction == "down"
    sides = (jump.amplitude_before, jump.amplitude_after)
    first, last = sides[::-1] if is_down else sides
    return f"{format_number(first, 3)} to {value_text(line['displacement_amplitude'], last, 3)}"


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
