"""Datasets as tables: a row for each point of the grid, for each impact, or for each point of a section."""

from __future__ import annotations

from importlib.util import find_spec
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vibropipe.solve.multipliers import largest_modulus
from vibropipe.solve.physical import is_physical
from vibropipe.store.atomic import StoreError
from vibropipe.store.encoding import part_names
from vibropipe.store.files import load
from vibropipe.words.proofs import PREFIX
from vibropipe.words.quantities import FLAGS, QUANTITIES
from vibropipe.words.regimes import NEUTRAL_TOLERANCE
from vibropipe.words.units import plain_units
from vibropipe.words.vocabulary import EVENTS

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

# Dimensions that a quantity has beside those of the grid: a column for each of their values.
COMPONENTS = tuple(name for name, entry in QUANTITIES.items() if entry.axis == "parts")
# States at the section of an attractor fill more columns than a table is read with.
MAX_COMPONENTS = 64
# Quantities that a chatter, which has infinitely many impacts, has no number of.
OF_CHATTER = ("impacts_per_orbit", "impacts_per_period")
MAX_SHEET = 1_048_576, 16_384  # rows and columns of a sheet of a spreadsheet
NEUTRAL = 2  # code of `stable` in a table
# Dimensions whose length differs from row to row, or that list events.
RAGGED = tuple(EVENTS)


def table(
    dataset: xr.Dataset | xr.DataTree | str | PathLike[str],
    impacts: bool = False,
    sections: bool = False,
) -> pd.DataFrame:
    """Return a dataset as a table of pandas.

    Parameters
    ----------
    dataset : xarray.Dataset, xarray.DataTree or path
        A dataset, a scene of what `open_study` returns, or a file.
    impacts : bool
        Whether the rows are impacts instead of points of the grid.
    sections : bool
        Whether the rows are points of Poincaré sections, any number of them at each point of the grid.

    Returns
    -------
    pandas.DataFrame
        A row for each point of the grid (of a motion: for each sample, or one without samples), the swept parameters
        first, then those that are the same in every row, then the quantities. Codes such as regimes stand by their
        names. A quantity over support, harmonic or multiplier has a column for each of them, `impact_velocity_max_1`; a
        complex one has two, `_re` and `_im`. Samples of the orbits of a sweep are left out, and of basins the starts,
        the states at the section, and attractors at values of the parameter where they are not. Empty, or NaN, are the
        numbers of impacts where a mass comes to rest, and `stable` of a motion without an orbit. Designs are numbered
        from 1, as in reports. With `impacts`, a row
        for each impact, at its point of the grid, with `sections` for each state at the section. Of a dataset in SI,
        `attrs["units"]` has the unit of each column.

    Raises
    ------
    StoreError
        If the file is missing or damaged, no impacts or sections were asked for, or both are wanted in one table.

    References
    ----------
    CF Conventions, section 3.5, flags (the names of codes), and 9.3.3, contiguous ragged array representation (the
    lists of impacts).
    """
    import pandas as pd
    import xarray as xr

    if isinstance(dataset, str | PathLike):
        dataset = load(dataset)
    elif isinstance(dataset, xr.DataTree):
        dataset = dataset.to_dataset()
    if "accuracy" in dataset.dims and dataset.sizes["method"] * dataset.sizes["setting"] == 1:
        dataset = dataset.squeeze(["method", "setting"])  # no race, but what is asked
    proof = [name for name in dataset.variables if str(name).startswith(PREFIX)]
    dataset = _with_gaps(dataset.drop_vars(proof))  # of one orbit, not of rows
    grid = grid_dims(dataset)
    if impacts and sections:
        raise StoreError(
            "impacts, sections: must not be asked for at once: each has rows of its own"
        )
    read = _impact_columns if impacts else _section_columns if sections else _point_columns
    columns = dict(read(dataset, grid))
    sizes = [values.size for values in columns.values()]
    length = 0 if 0 in sizes else max(sizes, default=1)
    frame = pd.DataFrame(
        {name: np.broadcast_to(values, (length,)) for name, values in columns.items()}
    )
    if "basin_share" in frame:  # over a parameter, an attractor is not everywhere
        frame = frame[frame["basin_share"].notna()].reset_index(drop=True)
    if is_physical(dataset):
        frame.attrs["units"] = {name: _units(dataset, name) for name in columns}
    return frame


def _with_gaps(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset without what has no number, and with neutral orbits as such.

    Without a number are the impacts of a chatter, and the stability of a motion without an orbit.
    """
    masked: dict[str, xr.DataArray] = {}
    if "stable" in dataset and "floquet_multiplier" in dataset:
        # Read once, for two columns.
        dataset = dataset.assign(floquet_multiplier=dataset["floquet_multiplier"].compute())
    if "rests_per_orbit" in dataset:
        moves = dataset["rests_per_orbit"] == 0
        masked |= {name: moves for name in OF_CHATTER if name in dataset}
    if "stable" in dataset and "period_multiple" in dataset:
        has_orbit = dataset["period_multiple"] > 0
        masked |= {} if bool(has_orbit.all()) else {"stable": has_orbit}
    with_gaps = dataset.assign(
        {
            name: dataset[name].where(mask).assign_attrs(dataset[name].attrs)
            for name, mask in masked.items()
        }
    )
    if "stable" not in dataset or not is_neutral(dataset).any():
        return with_gaps
    stable = with_gaps["stable"].where(~is_neutral(dataset), NEUTRAL)
    flags = {**FLAGS["stable"], "neutral": NEUTRAL}
    names = {"flag_values": [*flags.values()], "flag_meanings": " ".join(flags)}
    return with_gaps.assign(stable=stable.assign_attrs(dataset["stable"].attrs | names))


def without_constants(frame: pd.DataFrame) -> pd.DataFrame:
    """Return a table without columns that have one value, or none, in all of several rows."""
    if len(frame) < 2:
        return frame
    kept = frame.loc[:, frame.nunique(dropna=False) > 1]
    kept.attrs = frame.attrs
    return kept


def with_units(frame: pd.DataFrame) -> pd.DataFrame:
    """Return a table of `table` with the units of a dataset in SI in the names of its columns: `omega (rad/s)`."""
    units = frame.attrs.get("units", {})
    return frame.rename(columns={name: f"{name} ({text})" for name, text in units.items() if text})


def _units(dataset: xr.Dataset, column: str) -> str:
    """Return the units of a column as they are written by hand, empty for a pure number."""
    name = column
    while name not in dataset.variables and "_" in name:
        name = name.rpartition("_")[0]  # a column of one support, harmonic or multiplier
    units = str(dataset[name].attrs.get("units", "1")) if name in dataset.variables else "1"
    return "" if units == "1" else plain_units(units)


def grid_dims(dataset: xr.Dataset) -> tuple[str, ...]:
    """Return the dimensions whose points are the rows: samples of a motion, steady states, or the largest quantity."""
    for dim in ("tau", "time"):
        if dim in dataset.dims:
            return (dim,)
    if "accuracy" in dataset.dims and "method" not in dataset.dims:
        return ("motion", "accuracy")
    if "regime" in dataset:
        return tuple(str(dim) for dim in dataset["regime"].dims)
    inner = {*COMPONENTS, *RAGGED}
    dims = [
        tuple(str(dim) for dim in values.dims if dim not in inner)
        for values in dataset.data_vars.values()
    ]
    return max(dims, key=len, default=())


def _point_columns(dataset: xr.Dataset, grid: tuple[str, ...]) -> list[tuple[str, np.ndarray]]:
    sizes = {dim: dataset.sizes[dim] for dim in grid}
    columns: list[tuple[str, np.ndarray]] = []
    for name in _ordered(dataset, grid):
        values = dataset[name].variable
        inner = [dim for dim in values.dims if dim not in grid]
        if any(dim not in COMPONENTS or dataset.sizes[dim] > MAX_COMPONENTS for dim in inner):
            continue  # events, or another grid: not one value a row
        if not values.dims:
            columns += _named(name, values)
            continue
        # Read once: every component of a lazy quantity would be read from the file anew.
        spread = values.compute().set_dims({**sizes, **{dim: dataset.sizes[dim] for dim in inner}})
        spread = spread.transpose(*grid, *inner)
        if name == "design":
            spread = spread + 1
        for index in np.ndindex(*(dataset.sizes[dim] for dim in inner)):
            labels = [str(dataset[dim].values[at]) for dim, at in zip(inner, index, strict=True)]
            part = spread.isel(dict(zip(inner, index, strict=True)))
            columns += _named("_".join([name, *labels]), part)
    return columns


def _impact_columns(dataset: xr.Dataset, grid: tuple[str, ...]) -> list[tuple[str, np.ndarray]]:
    names = [str(name) for name in dataset.data_vars if dataset[name].dims == ("impact",)]
    if not names:
        raise StoreError(
            "impacts: are not in this dataset: where its scene takes the output impacts, add it and solve again"
        )
    columns: list[tuple[str, np.ndarray]] = []
    if "row_size" in dataset:
        counts = dataset["row_size"].values.ravel()
        for name, values in _point_columns(dataset[list(grid)], grid):
            columns.append((name, np.repeat(np.broadcast_to(values, counts.shape), counts)))
    return columns + [pair for name in names for pair in _named(name, dataset[name].variable)]


def _section_columns(dataset: xr.Dataset, grid: tuple[str, ...]) -> list[tuple[str, np.ndarray]]:
    names = [
        str(name) for name, values in dataset.data_vars.items()
        if "visit" in values.dims and {*values.dims} <= {*grid, "visit"}
    ]  # fmt: skip
    if not names:
        raise StoreError(
            "sections: are not in this dataset: where its scene takes the output poincare, add it and solve again"
        )
    # Samples of a motion are no rows of its section.
    own = [dim for dim in grid if dim in dataset[names].dims]
    columns = _point_columns(dataset[names], (*own, "visit"))
    values = [column for name, column in columns if name in names]
    known = ~np.isnan(values).all(axis=0)
    return [
        (name, column[known] if column.size == known.size else column) for name, column in columns
    ]


def _ordered(dataset: xr.Dataset, grid: tuple[str, ...]) -> list[str]:
    """Return the names of a dataset: the grid, then the parameters, then the quantities."""
    inner = {*COMPONENTS, *RAGGED, *grid}
    others = [str(name) for name in dataset.coords if name not in inner]
    return [*grid, *others, *(str(name) for name in dataset.data_vars)]


def _named(name: str, values: Any) -> list[tuple[str, np.ndarray]]:
    """Return the columns of a quantity: codes by name, None for none; the parts of complex numbers apart."""
    flat = np.asarray(values.values).ravel()
    if flat.dtype == np.float32:
        # A text of fewer digits would be read as another number.
        flat = flat.astype(float)
    if flat.dtype.kind == "c":
        real, imaginary = part_names(name)
        return [(real, flat.real), (imaginary, flat.imag)]
    if "flag_meanings" in values.attrs:
        meanings = str(values.attrs["flag_meanings"]).split()
        names = dict(
            zip(np.atleast_1d(values.attrs["flag_values"]).tolist(), meanings, strict=True)
        )
        return [(name, np.array([names.get(code) for code in flat.tolist()], dtype=object))]
    return [(name, flat)]


def is_neutral(dataset: xr.Dataset) -> NDArray[np.bool_]:
    """Return where perturbations of orbits neither grow nor decay, in the shape of `stable`.

    Such is a motion without losses, a mass that friction holds, and an orbit at its bifurcation: `stable` is 0, since
    it means asymptotically stable, but nothing is unstable beyond the errors of the multipliers.
    """
    stable = dataset["stable"].values
    if "floquet_multiplier" not in dataset:
        return np.zeros(stable.shape, bool)
    errors = dataset.get("floquet_multiplier_error")
    modulus, error = largest_modulus(
        dataset["floquet_multiplier"].transpose(..., "multiplier").values,
        None if errors is None else errors.transpose(..., "multiplier").values,
    )
    # An error beyond 1 says nothing: products grow without bound, or overflow, beside a grazing.
    error = np.minimum(np.nan_to_num(error, posinf=0.0), 1.0)
    neutral: NDArray[np.bool_] = np.abs(modulus - 1.0) <= np.maximum(error, NEUTRAL_TOLERANCE)
    return neutral & (stable == 0)


def write_xlsx(rows: pd.DataFrame, file: Path) -> None:
    """Write a table as a sheet of numbers and names, its head in sight.

    Raises StoreError if openpyxl is not installed, or the rows or columns are more than a sheet has.
    """
    if find_spec("openpyxl") is None:
        raise StoreError("openpyxl: is not installed: pip install 'vibropipe[xlsx]', or write .csv")
    for what, number, most in (
        ("rows", len(rows) + 1, MAX_SHEET[0]),
        ("columns", rows.shape[1], MAX_SHEET[1]),
    ):
        if number > most:
            raise StoreError(
                f"a sheet has at most {most} {what}, the table {number}: write .csv, or leave out columns by --varying"
            )
    with file.open("wb") as stream:
        rows.to_excel(
            stream, index=False, engine="openpyxl", sheet_name="vibropipe", freeze_panes=(1, 0)
        )
