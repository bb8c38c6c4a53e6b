"""Which scenes of a study can be explored, opened lazily: only what is shown is read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path

import xarray as xr

from vibropipe.solve.shown_units import DISPLAY_UNITS
from vibropipe.store import StoreError, check_intact, scene_files
from vibropipe.store.files import open_lazily
from vibropipe.study import load_study, shown_now
from vibropipe.words.wording import series


def check_installed() -> None:
    """Raise a StoreError that says how to install Bokeh, if it is missing."""
    if find_spec("bokeh") is None:
        raise StoreError("bokeh: is not installed: pip install 'vibropipe[view]'")


# Smaller datasets are read at once: a row then needs no file.
MAX_LOADED = 200 << 20
STUDY_ENDINGS = (".yaml", ".yml")


@dataclass(frozen=True)
class Results:
    """The datasets of a study by scene, which of them have rows to point at, and the one to begin with.

    note : what the study file has that these results do not show; empty if nothing.
    """

    title: str
    datasets: Mapping[str, xr.Dataset]
    first: str = ""
    note: str = ""

    @property
    def explorable(self) -> list[str]:
        """Names of the sweeps and basins."""
        return [name for name, data in self.datasets.items() if is_sweep(data) or is_basins(data)]


def is_sweep(dataset: xr.Dataset) -> bool:
    """Return whether a dataset has steady states over a grid of parameters."""
    has_rows = "regime" in dataset and "displacement_strobe" in dataset
    dims = dataset["regime"].dims if has_rows else ()
    return bool(dims) and all(dim in dataset.coords for dim in dims) and not is_basins(dataset)


def is_basins(dataset: xr.Dataset) -> bool:
    """Return whether a dataset has the attractors of a grid of starts, maybe at each value of a parameter."""
    return "attractor" in dataset and {"x0", "v0"} <= set(dataset["attractor"].dims)


def open_results(path: Path, folder: Path, scene: str | None = None) -> Results:
    """Open what `vibropipe view` names.

    path : a study's folder of results, one dataset, or a study file
    folder : folder of all results, for a study file
    scene : the scene to begin with
    Raises StudyError if the study file is not valid, or StoreError if there are no results, or none that can be
    explored.
    """
    place, title = path, path.stem
    study, fingerprints = None, None
    if path.suffix in STUDY_ENDINGS:
        study = load_study(path)
        place, title, fingerprints = folder / study.name, study.title, study.fingerprints
    files = scene_files(place)
    for file in files:
        check_intact(file, every_byte=False)
    datasets = {file.stem: _opened(file) for file in files}
    datasets = study.shown(datasets, False) if study else shown_now(datasets)
    note = "" if fingerprints is None else _outdated(path, fingerprints, datasets)
    results = Results(title, datasets, note=note)
    if not results.explorable:
        raise StoreError(
            f"{place}: holds neither a sweep nor basins, so there is nothing to explore"
        )
    if scene is not None and scene not in results.explorable:
        choices = ", ".join(results.explorable)
        raise StoreError(f"{place}: has no sweep and no basins {scene!r}: name one of {choices}")
    return replace(results, first=scene or results.explorable[0])


def _outdated(
    path: Path, fingerprints: Mapping[str, str], datasets: Mapping[str, xr.Dataset]
) -> str:
    """Say which results are not those of a study file as it is now."""
    old = [
        name
        for name, data in datasets.items()
        if name in fingerprints and data.attrs.get("fingerprint") != fingerprints[name]
    ]
    gone = [name for name in datasets if name not in fingerprints]
    absent = [name for name in fingerprints if name not in datasets]
    parts = [
        (old, "from before the study was changed"),
        (gone, "no longer in the study"),
        (absent, "not solved yet"),
    ]
    said = "; ".join(f"{series(names)}: {what}" for names, what in parts if names)
    return f"{said}. Solve it with: vibropipe run {path}" if old or absent else said


def _opened(file: Path) -> xr.Dataset:
    """Return a dataset, in memory unless it is large."""
    dataset = open_lazily(file, chunks=None)
    if dataset.nbytes <= MAX_LOADED:
        return dataset.load()
    # units are converted where values are read
    return open_lazily(file, chunks="auto") if DISPLAY_UNITS in dataset.attrs else dataset
