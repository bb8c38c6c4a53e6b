"""Part of the report on sweeps: rows by regime, the regimes along each line, energies."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.stability import is_neutral, is_unstable
from vibropipe.figures.text import REGIME_TEXT, format_number, regime_name
from vibropipe.report.exciter import WORDS
from vibropipe.report.findings import symbol_text, value_text
from vibropipe.report.parts import answers_of, tables_of
from vibropipe.report.section import Section
from vibropipe.report.table import DASH, Datasets, Table, blocks, breakable
from vibropipe.scenes.kind import ReportPart
from vibropipe.scenes.sweep.findings import (
    MAX_LINES,
    axis_of,
    findings,
    lines_of,
    n_lines,
    runs_text,
)
from vibropipe.scenes.sweep.quantities import is_shown
from vibropipe.words.regimes import Regime
from vibropipe.words.wording import series

CAPTION = (
    "Rows of each sweep by regime of the steady state; of these, stable orbits of more than one forcing period, "
    "unstable orbits and, if there are any, neutral ones, of which perturbations neither grow nor decay."
)
RUNS_CAPTION = "Regimes along each line of the sweeps, with the first and the last row of each; m: period multiple."
ENERGY_CAPTION = (
    "Energy of each sweep per forcing period: smallest and largest value over the rows with an orbit, and over "
    "aperiodic rows, each with its mean over a window."
)
MAX_RUNS = 24  # regimes of one line in the table; a line through chaos has hundreds
MAX_QUESTION = 110  # letters, a line of the report
ENERGIES = {
    "energy_input": "work of the force",
    "energy_damping": "loss by damping",
    "energy_impact": "loss at impacts",
    "energy_friction": "loss by friction",
}


def sections(datasets: Datasets) -> list[Section]:
    """Return the section on the sweeps of a study."""
    sweeps = {name: data for name, data in datasets.items() if "regime" in data}
    if not sweeps:
        return []
    tables = [*regime_tables(sweeps), *runs_tables(sweeps), *energy_tables(sweeps)]
    return [Section("Regimes of the sweeps", tables=tables)]


def regime_tables(sweeps: Datasets) -> list[Table]:
    """Return tables of rows by regime, one column per sweep, as many as fit on a page."""
    return [regime_table(block) for block in blocks(sweeps)]


def regime_table(sweeps: Datasets) -> Table:
    """Return a table of the rows by regime, then of orbits with m > 1 and of unstable orbits."""
    scenes = list(sweeps.values())
    rows = [["rows", *(str(dataset["regime"].size) for dataset in scenes)]]
    for code in sorted({int(c) for d in scenes for c in np.unique(d["regime"].values)}):
        cells = [share((d["regime"].values == code).sum(), d["regime"].size) for d in scenes]
        rows.append([REGIME_TEXT[regime_name(code)], *cells])
    counts = [orbits_by_stability(dataset) for dataset in scenes]
    for name in ("stable, m > 1", "unstable", "neutral"):
        if name != "neutral" or any(own.get(name) for own in counts):
            cells = [
                share(own[name], d["regime"].size) if name in own else DASH
                for own, d in zip(counts, scenes, strict=True)
            ]
            rows.append([name, *cells])
    return Table(["", *map(breakable, sweeps)], rows, CAPTION)


def orbits_by_stability(dataset: xr.Dataset) -> dict[str, int]:
    """Return the numbers of stable orbits with m > 1, and of unstable and neutral ones, as far as they are known."""
    numbers, has_orbit = {}, dataset["regime"].values < Regime.APERIODIC
    is_stable = dataset["stable"].values != 0 if "stable" in dataset else np.ones_like(has_orbit)
    if "period_multiple" in dataset:
        several = dataset["period_multiple"].values > 1
        numbers["stable, m > 1"] = int((has_orbit & is_stable & several).sum())
    if "stable" in dataset:
        numbers["unstable"] = int((has_orbit & is_unstable(dataset)).sum())
        numbers["neutral"] = int((has_orbit & is_neutral(dataset)).sum())
    return numbers


def share(amount: int, total: int) -> str:
    """Write an amount with its percentage of the total; 0 without one."""
    return f"{amount} ({format_number(100.0 * amount / total, 3)} %)" if amount else "0"


def runs_tables(sweeps: Datasets) -> list[Table]:
    """Return the table of regimes along the lines of the sweeps that have few of them."""
    rows = [
        [breakable(name), point or DASH, symbol_text(data[axis_of(data)]), runs_text(line, axis_of(data), MAX_RUNS)]
        for name, data in sweeps.items()
        if n_lines(data) <= MAX_LINES
        for point, line in lines_of(data)
    ]  # fmt: skip
    head = ["scene", "line", "along", "regimes"]
    return [Table(head, rows, RUNS_CAPTION, ("2.6cm", "auto", "auto", "1fr"), 4)] if rows else []


def energy_tables(sweeps: Datasets) -> list[Table]:
    """Return the table of energies of the sweeps whose outputs include them; friction only where there is any."""
    stored = {name: data for name, data in sweeps.items() if "energy_input" in data}
    heads = {
        key: text
        for key, text in ENERGIES.items()
        if any(is_shown(data, key) for data in stored.values())
    }
    rows = []
    for name, data in stored.items():
        is_aperiodic = data["regime"] == Regime.APERIODIC
        rows.append(
            [
                breakable(name),
                *(energy_text(data, key, data["regime"] < Regime.APERIODIC) for key in heads),
            ]
        )
        if is_aperiodic.any():
            texts = [energy_text(data, key, is_aperiodic) for key in heads]
            rows.append([f"{breakable(name)}, aperiodic", *texts])
    return [Table(["scene", *heads.values()], rows, ENERGY_CAPTION)] if rows else []


def energy_text(dataset: xr.Dataset, name: str, rows: xr.DataArray) -> str:
    """Write the range of an energy over some rows; that of impacts is the sum over both supports."""
    if not is_shown(dataset, name):
        return DASH
    energy = dataset[name].where(rows)
    values = (
        energy.sum("support", skipna=False).values if "support" in energy.dims else energy.values
    )
    values = values[np.isfinite(values)]
    if not values.size:
        return DASH
    return f"{format_number(float(values.min()))} … {value_text(energy, values.max())}"


def question(datasets: Datasets) -> str:
    """Return the question of sweeps: how the motion changes with what they run over."""
    names = dict.fromkeys(
        WORDS[str(name)] for data in datasets.values() for name in data.dims if name in WORDS
    )
    over = series(f"the {words}" for words in names) or "its start"
    text = f"How does the motion change with {over}?"
    return text if len(text) <= MAX_QUESTION else "How does the motion change with its parameters?"


REPORT = ReportPart("Steady states", question, answers_of(findings), tables_of(sections), rank=0)
