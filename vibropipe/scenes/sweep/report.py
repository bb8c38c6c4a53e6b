"""What a report says of sweeps: their rows by regime, and where they strike hardest."""

from __future__ import annotations

import numpy as np
import xarray as xr

from vibropipe.figures.text import REGIME_WORDS, format_number, regime_name
from vibropipe.report.section import Section
from vibropipe.report.table import DASH, Datasets, Table, blocks, breakable
from vibropipe.scenes.kind import ReportPart
from vibropipe.scenes.sweep.captions import hardest_words, peak_words, unresolved_words
from vibropipe.scenes.sweep.curves import row_kinds

CAPTION = (
    "Rows of each sweep by the regime that settles; among them stable orbits of more than one forcing period, and "
    "unstable orbits."
)


def sections(datasets: Datasets) -> list[Section]:
    """Return the section of the sweeps of a study."""
    sweeps = {name: data for name, data in datasets.items() if "regime" in data}
    if not sweeps:
        return []
    items = [
        {"name": breakable(name), "text": text}
        for name, data in sweeps.items()
        if (text := extremes(data))
    ]
    return [Section("Regimes over the sweeps", tables=regime_tables(sweeps), items=items)]


def regime_tables(sweeps: Datasets) -> list[Table]:
    """Return the rows of each sweep by regime, one column per sweep, cut where the page ends."""
    return [regime_table(block) for block in blocks(sweeps)]


def regime_table(sweeps: Datasets) -> Table:
    """Return one row per regime that occurs, then orbits of m > 1 and unstable ones among them."""
    scenes = list(sweeps.values())
    rows = [["rows", *(str(dataset["regime"].size) for dataset in scenes)]]
    for code in sorted({int(c) for d in scenes for c in np.unique(d["regime"].values)}):
        cells = [share((d["regime"].values == code).sum(), d["regime"].size) for d in scenes]
        rows.append([REGIME_WORDS[regime_name(code)], *cells])
    for says, needed, kind in (
        ("stable, m > 1", "period_multiple", "multiple"),
        ("unstable", "stable", "unstable"),
    ):
        cells = [
            share(row_kinds(d)[kind].sum(), d["regime"].size) if needed in d else DASH
            for d in scenes
        ]
        rows.append([says, *cells])
    return Table(["", *map(breakable, sweeps)], rows, CAPTION)


def share(amount: int, total: int) -> str:
    """Write an amount and its percentage of the total; 0 alone."""
    return f"{amount} ({format_number(100.0 * amount / total, 3)} %)" if amount else "0"


def extremes(dataset: xr.Dataset) -> str:
    """Say where a sweep strikes hardest and swings widest, and which rows are unresolved."""
    words = (hardest_words(dataset), peak_words(dataset), unresolved_words(dataset))
    said = [text for text in words if text]
    return f"{'. '.join(said)}." if said else ""


REPORT = ReportPart(sections)
