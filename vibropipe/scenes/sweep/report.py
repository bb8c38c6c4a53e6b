"""Part of the report on sweeps: rows by regime, and largest impact velocities."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.text import REGIME_TEXT, format_number, regime_name, sentences
from vibropipe.report.section import Section
from vibropipe.report.table import DASH, Datasets, Table, blocks, breakable
from vibropipe.scenes.kind import ReportPart
from vibropipe.scenes.sweep.captions import peak_text, unresolved_text, velocity_text
from vibropipe.scenes.sweep.curves import row_kinds

CAPTION = (
    "Rows of each sweep by regime of the steady state; of these, stable orbits of more than one forcing period, and "
    "unstable orbits."
)


def sections(datasets: Datasets) -> list[Section]:
    """Return the section on the sweeps of a study."""
    sweeps = {name: data for name, data in datasets.items() if "regime" in data}
    if not sweeps:
        return []
    items = [
        {"name": breakable(name), "text": text}
        for name, data in sweeps.items()
        if (text := extremes(data))
    ]
    return [Section("Regimes of the sweeps", tables=regime_tables(sweeps), items=items)]


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
    for text, needed, kind in (
        ("stable, m > 1", "period_multiple", "multiple"),
        ("unstable", "stable", "unstable"),
    ):
        cells = [
            share(row_kinds(d)[kind].sum(), d["regime"].size) if needed in d else DASH
            for d in scenes
        ]
        rows.append([text, *cells])
    return Table(["", *map(breakable, sweeps)], rows, CAPTION)


def share(amount: int, total: int) -> str:
    """Write an amount with its percentage of the total; 0 without one."""
    return f"{amount} ({format_number(100.0 * amount / total, 3)} %)" if amount else "0"


def extremes(dataset: xr.Dataset) -> str:
    """Write the largest impact velocities and first harmonic of a sweep, and its unresolved rows."""
    return sentences(velocity_text(dataset), peak_text(dataset), unresolved_text(dataset))


REPORT = ReportPart(sections)
