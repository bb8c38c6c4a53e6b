"""Everything the template is given, as one tree of text and numbers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Protocol

import numpy as np
import xarray as xr

from vibropipe.figures import Scene, caption
from vibropipe.figures import Study as Drawn
from vibropipe.figures.captions import grid_words, hardest_words, peak_words, unresolved_words
from vibropipe.figures.sweep import row_kinds
from vibropipe.figures.text import (
    PLAIN_SYMBOLS,
    REGIME_WORDS,
    number,
    regime_name,
)
from vibropipe.report.accuracy import Sidecars, accuracy_table, accuracy_text, provenance_table
from vibropipe.report.costs import effect_tables, effect_words, race_tables
from vibropipe.report.hard_cases import hard_case_tables, hard_case_words
from vibropipe.report.steady import asymmetry, steady_scenes, steady_tables
from vibropipe.report.table import DASH, Datasets, Table, blocks, breakable
from vibropipe.words.vocabulary import PARAMETERS
from vibropipe.words.wording import count

OTHER_GRIDS = ("delta_over_l", "tau_bar", "amplitude")


class Study(Drawn, Protocol):
    """What the report needs to know of a study."""

    @property
    def title(self) -> str:
        """Title of the report."""

    @property
    def description(self) -> str:
        """Text that opens the report, paragraphs parted by empty lines."""


def report_data(study: Study, datasets: Datasets, sidecars: Sidecars) -> dict[str, Any]:
    """Return the template's data: strings, lists and mappings only, JSON without loss.

    ``datasets`` and ``sidecars`` are by scene; figures are expected at ``figures/<scene>.pdf``.
    """
    steady = steady_scenes(datasets)
    sweeps = {
        n: d for n, d in datasets.items() if "regime" in d and study.scenes[n].kind == "sweep"
    }
    return {
        "title": study.title,
        "subtitle": subtitle(study, datasets),
        "description": paragraphs(study.description or ""),
        "free_law": any("velocity_over_l" in dataset for dataset in datasets.values()),
        "parameters": parameter_table(study, datasets).as_data(),
        "effects": effects_table(study, datasets).as_data(),
        "figures": [figure_entry(name, study.scenes[name], datasets) for name in datasets],
        "steady": [table.as_data() for table in steady_tables(steady)],
        "asymmetry": asymmetry(steady),
        "hard_cases": {
            "tables": [table.as_data() for table in hard_case_tables(datasets)],
            "text": hard_case_words(datasets),
        },
        "races": [table.as_data() for table in race_tables(datasets)],
        "effect_costs": {
            "tables": [table.as_data() for table in effect_tables(datasets)],
            "text": effect_words(datasets),
        },
        "sweeps": [table.as_data() for table in regime_tables(sweeps)],
        "extremes": [
            {"name": breakable(name), "text": text}
            for name, data in sweeps.items()
            if (text := extremes(data))
        ],
        "accuracy": {
            **accuracy_table(datasets, sidecars).as_data(),
            "text": accuracy_text(datasets),
        },
        "provenance": provenance_table(datasets).as_data(),
    }


def subtitle(study: Study, datasets: Datasets) -> str:
    """Write one line: the study's name, its size, and the program that made it."""
    sources = {str(d.attrs["source"]) for d in datasets.values() if "source" in d.attrs}
    return " · ".join([study.name, count(len(datasets), "scene"), *sorted(sources)])


def paragraphs(text: str) -> list[str]:
    """Cut text at its empty lines."""
    blocks = [" ".join(block.split()) for block in text.replace("\r\n", "\n").split("\n\n")]
    return [block for block in blocks if block]


def figure_entry(name: str, scene: Scene, datasets: Datasets) -> dict[str, str]:
    """Return one figure: its file, title, caption, and the words for those who cannot see it."""
    said = caption(scene, datasets[name], datasets)
    written = " ".join(str(getattr(scene, "caption", "") or "").split())
    return {
        "scene": name,
        "path": f"figures/{name}.pdf",
        "title": str(getattr(scene, "title", "") or "") or breakable(name),
        "caption": written or said,
        "alt": said,
    }


def parameter_table(study: Study, datasets: Datasets) -> Table:
    """Return one row per scene: its kind and grids, and its value or range of each parameter."""
    rows = []
    for name, dataset in one_by_one(study, datasets):
        cells = [
            grid_words(np.atleast_1d(dataset[key].values)) if key in dataset.variables else DASH
            for key in PARAMETERS
        ]
        rows.append([name, *cells])
    return Table(["scene", *PARAMETERS], rows)


def one_by_one(study: Study, datasets: Datasets) -> Iterator[tuple[str, xr.Dataset]]:
    """Yield each scene with what it is called in the table; motions that are raced one by one."""
    for name, dataset in datasets.items():
        if "motion" in dataset.dims:
            for raced in dataset["motion"].values:
                yield f"{breakable(name)}: {breakable(str(raced))}", dataset.sel(motion=raced)
        else:
            yield f"{breakable(name)}: {kind_words(study.scenes[name].kind, dataset)}", dataset


def effects_table(study: Study, datasets: Datasets) -> Table:
    """Return one row per scene: the effects its kernels had, and the outputs that were asked."""
    rows = []
    for name, dataset in datasets.items():
        outputs = getattr(study.scenes[name], "outputs", None) or [DASH]
        effects = str(dataset.attrs.get("effects", DASH)) or "none"
        rows.append([breakable(name), breakable(effects), ", ".join(outputs)])
    return Table(["scene", "effects", "outputs"], rows)


def kind_words(kind: str, dataset: xr.Dataset) -> str:
    """Write the kind of scene and what it runs over beside parameters."""
    if kind == "motion":
        if not dataset.sizes.get("tau"):
            return kind
        begin, end = float(dataset["tau"][0]), float(dataset["tau"][-1])
        return f"{kind}, τ = {number(begin)} … {number(end)}"
    grids = [
        f"{PLAIN_SYMBOLS[key]} = {grid_words(dataset[key].values)}"
        for key in OTHER_GRIDS
        if key in dataset.coords and dataset[key].ndim
    ]
    return ", ".join([kind, *grids])


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
    return Table(["", *map(breakable, sweeps)], rows)


def share(amount: int, total: int) -> str:
    """Write an amount and its percentage of the total; 0 alone."""
    return f"{amount} ({number(100.0 * amount / total, 3)} %)" if amount else "0"


def extremes(dataset: xr.Dataset) -> str:
    """Say where a sweep strikes hardest and swings widest, and which rows are unresolved."""
    words = (hardest_words(dataset), peak_words(dataset), unresolved_words(dataset))
    said = [text for text in words if text]
    return f"{'. '.join(said)}." if said else ""
