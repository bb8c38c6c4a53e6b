"""Datasets written to files and read back."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from difflib import get_close_matches
from functools import partial
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.physics.parameter_error import ParameterError
from vibropipe.solve.shown_units import DISPLAY_UNITS
from vibropipe.store.atomic import StoreError, atomic_file, check_intact, seal, units_in
from vibropipe.store.encoding import PART_OF, define_variables, encode, part_names
from vibropipe.store.shards import ROW_RANGE_ATTRS, open_raw, raw
from vibropipe.words.wording import series

if TYPE_CHECKING:
    import xarray as xr

ENDING, REPORT = ".nc", "report.pdf"
DASK_BYTES = 16 << 20
"""Size of a dask chunk: several chunks of the file, and small enough for several at once on every thread."""
CACHE_BYTES = 4 << 20
"""Chunk cache of each variable instead of netCDF's 64 MB, since a file has some thirty variables."""


def save(dataset: xr.Dataset, path: str | PathLike[str]) -> None:
    """Save a dataset in a netCDF4 file, which appears only when complete; `load` reads it.

    Equal datasets give equal bytes; missing folders are created.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a call of this package.
    path : path
        Of the file, as `motion.nc`; one that exists is replaced.

    Raises
    ------
    ParameterError
        If it is no dataset.
    StoreError
        If the disk is full or the folder is not writable; the file is then as before.
    """
    import netCDF4
    import xarray as xr

    if not isinstance(dataset, xr.Dataset):
        raise ParameterError("dataset", dataset, "an xarray.Dataset", got=type(dataset).__name__)

    variables, attrs = encode(dataset)
    with atomic_file(path) as temporary:
        with netCDF4.Dataset(temporary, "w") as file:
            define_variables(file, variables, attrs)
        seal(temporary)


def load(path: str | PathLike[str]) -> xr.Dataset:
    """Load one dataset into memory and check every byte.

    Parameters
    ----------
    path : path
        A file of a study's results, `results/<study>/<scene>.nc`, or any other of `save` or `join`.

    Returns
    -------
    xarray.Dataset
        Its quantities with units and long names; where they come from stands in the attributes. Complex quantities are
        complex, flags of truth bool, text str.

    Raises
    ------
    StoreError
        If the file is missing, truncated or damaged.

    References
    ----------
    J. G. Fletcher, "An arithmetic checksum for serial transmissions", IEEE Transactions on Communications 30 (1982)
    247-252 (the checksum of each chunk of a file).
    """
    check_intact(path)
    with open_lazily(Path(path), chunks=None) as lazy:
        return lazy.load()


def read_scenes(
    folder: str | PathLike[str], scenes: Iterable[str], fingerprints: Mapping[str, str]
) -> dict[str, xr.Dataset]:
    """Read the datasets of a study's scenes.

    fingerprints : expected fingerprint of each scene; a scene without one is not checked
    Returns datasets by scene, as of `load`.
    Raises StoreError if a dataset is missing, damaged, a shard, or of another study.
    """
    folder = Path(folder)
    _check_folder(folder)
    paths = {name: folder / f"{name}{ENDING}" for name in scenes}
    missing = [name for name, path in paths.items() if not path.is_file()]
    if missing:
        raise StoreError(f"{folder}: holds no dataset of {series(missing)}: solve the study first")
    datasets = {name: load(path) for name, path in paths.items()}
    for name, dataset in datasets.items():
        if ROW_RANGE_ATTRS[0] in dataset.attrs:
            raise StoreError(f"{paths[name]}: is a shard of a sweep: join all its shards first")
        if name in fingerprints and dataset.attrs.get("fingerprint") != fingerprints[name]:
            raise StoreError(
                f"{paths[name]}: was made from another study, or from this one before it was changed: "
                "recompute the scene"
            )
    return datasets


def scene_files(path: str | PathLike[str]) -> list[Path]:
    """Return the files of a study's scenes in order of their names; for a file, itself.

    Raises StoreError if there is none.
    """
    path = Path(path)
    if not path.is_file():
        return files_in(path)
    if path.suffix != ENDING:
        raise StoreError(
            f"{path}: is no dataset (its name does not end in {ENDING}): name a {ENDING} file"
        )
    return [path]


def attributes_of(path: str | PathLike[str]) -> dict[str, Any]:
    """Return the global attributes of a file after checking every byte.

    Raises StoreError if the file is missing, truncated or damaged.

    References
    ----------
    J. G. Fletcher, "An arithmetic checksum for serial transmissions", IEEE Transactions on Communications 30 (1982)
    247-252 (the checksum of each chunk of a file).
    """
    check_intact(path)
    with open_raw(Path(path)) as file:
        return {name: file.getncattr(name) for name in file.ncattrs()}


def selected_attributes(path: str | PathLike[str], names: Iterable[str]) -> dict[str, Any]:
    """Return those of some global attributes that a file has, as text or numbers; only its head is read.

    Raises StoreError if the file cannot be read.
    """
    with raw(Path(path)) as file:
        found = {name: file.attrs[name] for name in names if name in file.attrs}
    return {
        name: value.decode() if isinstance(value, bytes) else value for name, value in found.items()
    }


def count_equal(path: str | PathLike[str], sought: Mapping[str, int]) -> int:
    """Return how many values of the first variable that a file has equal the value sought; 0 if it has none of them.

    One chunk at a time is in memory.

    Raises StoreError if the file cannot be read.
    """
    with raw(Path(path)) as file:
        name = next((name for name in sought if name in file), None)
        if name is None:
            return 0
        values, value = file[name], sought[name]
        parts = values.iter_chunks() if values.chunks else [()]
        return sum(int(np.count_nonzero(values[part] == value)) for part in parts)


def _check_folder(folder: Path) -> None:
    if not folder.is_dir():
        raise StoreError(f"{folder}: does not exist{_nearest(folder)}: solve the study first")


def files_in(folder: Path) -> list[Path]:
    """Return the files of scenes in a folder."""
    _check_folder(folder)
    # names of temporary files begin with a dot, and shards are in a folder of their own
    paths = [path for path in sorted(folder.glob("[!.]*" + ENDING)) if path.is_file()]
    if not paths:
        # names of scenes begin with a letter, those of shards are numbers
        studies = sorted({str(path.parent) for path in folder.glob(f"*/[a-z]*{ENDING}")})
        if studies:
            named = f"name {'it' if len(studies) == 1 else 'one'}: {', '.join(studies)}"
            raise StoreError(f"{folder}: holds no scene but the results of studies: {named}")
        raise StoreError(f"{folder}: holds no scene (no file *{ENDING}): solve the study first")
    return paths


def open_lazily(path: Path, chunks: str | None) -> xr.Dataset:
    """Open a file lazily and combine the parts of complex quantities."""
    import dask
    import xarray as xr

    open_it = partial(xr.open_dataset, path, engine="netcdf4")
    try:
        with dask.config.set({"array.chunk-size": DASK_BYTES}), _chunk_cache(CACHE_BYTES):
            dataset = open_it(chunks=None)
            # variables without coordinates, which xarray need not align
            variables = {name: dataset.variables[name] for name in dataset.data_vars}
            texts = [str(name) for name, values in variables.items() if values.dtype.kind == "O"]
            if chunks is not None:
                # dask cannot estimate the size of text, which is small: read it at once
                text_variables = dataset[texts].load()
                dataset.close()
                dataset = open_it(chunks=chunks, drop_variables=texts)
                all_variables = {**text_variables.variables, **dataset.variables}
                variables = {name: all_variables[name] for name in variables}
    except (OSError, RuntimeError, ValueError) as error:
        check_intact(path)  # says so of a damaged file
        raise StoreError(f"{path}: cannot be read: {error}") from error
    words = {
        name: values.astype(str)
        for name, values in dataset.coords.items()
        if values.dtype.kind == "O" and name in dataset.dims
    }
    coords = dataset.assign_coords(words).coords  # text as it was written, not objects
    joined = _join_parts(
        xr.Dataset(variables, coords, {**dataset.attrs, **_later_units(path, dataset)})
    )
    joined.set_close(dataset.close)
    joined.encoding["source"] = str(path.resolve())
    return joined


def _later_units(path: Path, dataset: xr.Dataset) -> dict[str, str]:
    """Return the units of the study's report, which is newer than the data if only its key `units` has changed."""
    report = path.with_name(REPORT)
    if DISPLAY_UNITS not in dataset.attrs or not report.is_file():
        return {}
    is_newer = report.stat().st_mtime_ns >= path.stat().st_mtime_ns
    units = units_in(report) if is_newer else ""
    return {DISPLAY_UNITS: units} if units else {}


@contextmanager
def _chunk_cache(size: int) -> Iterator[None]:
    """Limit the chunk cache of each variable of files opened in this block to `size` bytes."""
    import netCDF4

    default = netCDF4.get_chunk_cache()
    netCDF4.set_chunk_cache(size)
    try:
        yield
    finally:
        netCDF4.set_chunk_cache(*default)


def _join_parts(dataset: xr.Dataset) -> xr.Dataset:
    """Replace each pair `<name>_re`, `<name>_im` by the complex `<name>` at the same position."""
    import xarray as xr

    variables: dict[Any, xr.Variable] = {}
    for key in dataset.data_vars:
        variable = dataset.variables[key]
        name = variable.attrs.get(PART_OF)
        if name is None:
            variables[key] = variable
        elif key == part_names(name)[0]:
            other = dataset.variables[part_names(name)[1]]
            joined = xr.apply_ufunc(
                _complex, variable, other, dask="parallelized", output_dtypes=[np.complex128]
            )
            joined.attrs = {k: v for k, v in variable.attrs.items() if k != PART_OF}
            joined.attrs["long_name"] = str(joined.attrs["long_name"]).removesuffix(", real part")
            variables[name] = joined
    return xr.Dataset(variables, dataset.coords, dataset.attrs)


def _complex(real: np.ndarray, imaginary: np.ndarray) -> np.ndarray:
    """Combine real and imaginary part; real + 1j * imaginary would turn an infinite part into nan."""
    joined = np.empty(np.shape(real), np.complex128)
    joined.real, joined.imag = real, imaginary
    return joined


def _nearest(folder: Path) -> str:
    """Return a hint at a neighbouring folder with a similar name, or nothing."""
    neighbours = [path.name for path in folder.parent.glob("*") if path.is_dir()]
    similar = get_close_matches(folder.name, neighbours, 1)
    return f" (there is {folder.parent / similar[0]})" if similar else ""
