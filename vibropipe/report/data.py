"""Parts of the report that every study has: parameters, effects and outputs of its scenes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.figures.text import FEW_VALUES, clock, format_number, grid_text, grid_with_units
from vibropipe.figures.units import unit_text
from vibropipe.report.findings import is_text, symbol_text, value_text
from vibropipe.report.table import DASH, Datasets, Table, breakable
from vibropipe.words.parameters import FURTHER, PARAMETERS
from vibropipe.words.vocabulary import PLAIN_SYMBOLS, physical_name
from vibropipe.words.wording import count, series

if TYPE_CHECKING:
    import xarray as xr

# Variables whose dimensions are the grids of a scene.
GRID_OF = ("periods_to_attractor", "regime", "velocity_over_l")
PHYSICAL = {name: physical_name(name) for name in PARAMETERS if physical_name(name) != name}
# Parameters of effects beyond eqs. (5), (6).
FURTHER_EFFECTS = {
    "soft": ("k1", "k2"),
    "friction": ("friction",),
    "load": ("load",),
    "second_harmonic": ("f2",),
}
# Parameters beside which the column of the scenes takes what is left, and its width beside more of them.
MAX_PARAMETERS, SCENE_WIDTH = 10, "2.2cm"
OTHER_GRIDS = ("delta_over_l", "tau_bar", "free_period", "amplitude")


def subtitle(name: str, datasets: Datasets) -> str:
    """Write the study's name, its number of scenes, and the program that computed it."""
    sources = {str(d.attrs["source"]) for d in datasets.values() if "source" in d.attrs}
    return " · ".join([name, count(len(datasets), "scene"), *sorted(sources)])


def asked_text(kinds: Mapping[str, str], datasets: Datasets) -> str:
    """Write what was computed: the scenes of each kind together, with the parameters that they are swept over."""
    groups: dict[tuple[str, str, bool], list[str]] = {}
    for name, dataset in datasets.items():
        key = (kinds[name], grids_text(dataset), "direction" in dataset.dims)
        groups.setdefault(key, []).append(name)
    parts = []
    for (kind, grids, _), names in groups.items():
        noun = kind.replace("_", " ")
        amount = f"{len(names)} {noun} scenes" if len(names) > 1 else f"one {noun} scene"
        follows = [follow_text(datasets[name]) for name in names]
        texts = series(dict.fromkeys(text for text in follows if text))
        followed = f", followed along {texts}" if texts else ""
        parts.append(f"{amount}{f' over {grids}' if grids else ''}{followed}")
    return f"Computed: {'; '.join(parts)}." if parts else ""


def follow_text(dataset: xr.Dataset) -> str:
    """Write along which parameter and in which directions a dataset was followed; empty if it was not."""
    name, _, direction = str(dataset.attrs.get("follow", "")).partition(" ")
    if name not in dataset.variables:
        return ""
    way = {"both": "upwards and downwards"}.get(direction, f"{direction}wards")
    return f"{symbol_text(dataset[name])} {way}"


def grids_text(dataset: xr.Dataset) -> str:
    """Write the grids that a dataset runs over."""
    if "motion" in dataset.dims:
        return count(dataset.sizes["motion"], "motion")
    reference = next((name for name in GRID_OF if name in dataset), None)
    if reference is None:
        return ""
    arrays = [dataset[name] for name in dataset[reference].dims if name in dataset.coords]
    return series(
        f"{symbol_text(array)} = {grid_with_units(array)}" for array in arrays if not is_text(array)
    )


def parameter_table(kinds: Mapping[str, str], datasets: Datasets) -> Table:
    """Return a table of one row per scene: kind, grids, and value or range of each parameter."""
    names = {key: parameter_name(key, datasets) for key in PARAMETERS}
    held = {name for dataset in datasets.values() for name in dataset.variables}
    keys = {key: name for key, name in names.items() if key not in FURTHER or name in held}
    rows = []
    for name, dataset in named_datasets(kinds, datasets):
        cells = [
            values_text(dataset[key]) if key in dataset.variables else DASH for key in keys.values()
        ]
        rows.append([name, *cells])
    caption = (
        "Parameters of each scene; those with several values are swept. Branches, boundaries and designs have those of "
        "what was found. A dash: not applicable."
    )
    head = [head_text(key, name, datasets) for key, name in keys.items()]
    # what many columns leave would be too narrow for the names
    first = SCENE_WIDTH if len(head) > MAX_PARAMETERS else "1fr"
    return Table(["scene", *head], rows, caption, (first, *["auto"] * len(head)))


def values_text(array: xr.DataArray) -> str:
    """Write the values of a parameter; of a branch the different ones, or the range that it was followed through.

    Of designs the range that they lie in.
    """
    values = np.unique(array.values)
    if array.dims == ("design",) and values.size > 1:
        return " … ".join(format_number(float(end)) for end in (values[0], values[-1]))
    is_range = array.dims == ("point",) and values.size > FEW_VALUES
    return grid_text(values).partition(" (")[0] if is_range else grid_text(values)


def parameter_name(key: str, datasets: Datasets) -> str:
    """Return the name of a parameter in the datasets: in SI, nu is omega, f is F and so on."""
    physical = PHYSICAL.get(key, key)
    return physical if any(physical in dataset.variables for dataset in datasets.values()) else key


def head_text(key: str, name: str, datasets: Datasets) -> str:
    """Return the head of a parameter's column: its name, with the unit where it has one."""
    arrays = (dataset[name] for dataset in datasets.values() if name in dataset.variables)
    units = [text for array in arrays if (text := unit_text(array.attrs.get("units", "1")))]
    return f"{name} ({units[0]})" if units else key


def is_physical(datasets: Datasets) -> bool:
    """Return whether any dataset is in SI units."""
    names = PHYSICAL.values()
    return any(name in dataset.variables for dataset in datasets.values() for name in names)


def named_datasets(
    kinds: Mapping[str, str], datasets: Datasets
) -> Iterator[tuple[str, xr.Dataset]]:
    """Yield (name, dataset) of each row of the table; a scene of several motions has one row per motion."""
    for name, dataset in datasets.items():
        if "motion" in dataset.dims:
            for motion in dataset["motion"].values:
                yield f"{breakable(name)}: {breakable(str(motion))}", dataset.sel(motion=motion)
        else:
            yield f"{breakable(name)}: {kind_text(kinds[name], dataset)}", dataset


def further_effects(datasets: Datasets) -> list[str]:
    """Return the effects beyond eqs. (5), (6) that scenes have: they are named, or their parameters are stored."""
    stored = {str(name) for data in datasets.values() for name in data.variables}
    named = {
        name for data in datasets.values() for name in data.attrs.get("effects", "").split(", ")
    }
    return [
        effect
        for effect, names in FURTHER_EFFECTS.items()
        if effect in named or stored & {*names, *map(physical_name, names)}
    ]


def effects_table(outputs: Mapping[str, Any], datasets: Datasets) -> Table:
    """Return a table of one row per scene: effects of its kernels, and its outputs."""
    rows = []
    for name, dataset in datasets.items():
        effects = str(dataset.attrs.get("effects", DASH)) or "none"
        rows.append([breakable(name), breakable(effects), ", ".join(outputs[name] or [DASH])])
    caption = (
        "Physical effects and outputs computed for each scene. An effect is left out where the study, the parameters "
        "or a proven bound on the motion exclude it."
    )
    return Table(["scene", "effects", "outputs"], rows, caption, ("auto", "1fr", "auto"), left=3)


def kind_text(kind: str, dataset: xr.Dataset) -> str:
    """Write the kind of a scene with its span of tau or its grids that are no parameters."""
    if dataset.sizes.get(clock(dataset)):
        time = dataset[clock(dataset)]
        begin, end = format_number(float(time[0])), value_text(time, float(time[-1]))
        return f"{kind}, {symbol_text(time)} = {begin} … {end}"
    grids = [
        f"{PLAIN_SYMBOLS[key]} = {grid_with_units(dataset[key])}"
        for key in OTHER_GRIDS
        if key in dataset.coords and dataset[key].ndim
    ]
    return ", ".join([kind, *grids])
