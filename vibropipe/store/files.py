"""Datasets to files and back: one at a time in memory, or a whole study opened lazily."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from difflib import get_close_matches
from functools import partial
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.store.atomic import StoreError, atomic_file, check_intact, seal
from vibropipe.store.encoding import PART_OF, define_variables, encode, part_names
from vibropipe.store.shards import ROW_RANGE_ATTRS, open_raw, raw
from vibropipe.words.wording import series

if TYPE_CHECKING:
    import xarray as xr

ENDING = ".nc"
DASK_BYTES = 16 << 20
"""A chunk of dask: some chunks of the file, and little enough for a few at once on every thread."""
CACHE_BYTES = 4 << 20
"""Of each variable, where netCDF would keep 64 MB: a file has some thirty variables."""


def write(dataset: xr.Dataset, path: str | PathLike[str]) -> None:
    """Write ``dataset`` to the netCDF4 file ``path``, which appears only when whole.

    Equal datasets give equal bytes. Folders are made. Raises NotWrittenError (the file and what to do)
    on a full disk or a folder that cannot be written; ``path`` is then as it was.
    """
    import netCDF4

    variables, attrs = encode(dataset)
    with atomic_file(path) as temporary:
        with netCDF4.Dataset(temporary, "w") as file:
            define_variables(file, variables, attrs)
        seal(temporary)


def read(path: str | PathLike[str]) -> xr.Dataset:
    """Read a file written by :func:`write` or :func:`join` into memory, and close it.

    Complex quantities are complex, truth values bool, text str. Every byte is checked: raises
    StoreError when the file is missing, truncated or damaged.
    """
    check_intact(path)
    with _open(Path(path), chunks=None) as lazy:
        return lazy.load()


def load(path: str | PathLike[str]) -> xr.Dataset:
    """Load one dataset into memory.

    Parameters
    ----------
    path : path
        A file of a study's results: `results/<study>/<scene>.nc`.

    Returns
    -------
    xarray.Dataset
        Its quantities with units and long names; where they come from stands in the attributes.

    Raises
    ------
    StoreError
        If the file is missing, truncated or damaged.
    """
    return read(path)


def open_study(folder: str | PathLike[str]) -> xr.DataTree:
    """Open the results of a study, values left on disk until they are used: a slice reads a slice.

    Parameters
    ----------
    folder : path
        The results of a study: a file for each scene.

    Returns
    -------
    xr.DataTree
        One group per scene, with its dimensions, its quantities in dask chunks, their units in the attribute
        `units` ("1": non-dimensional), and where they come from in its attributes. Closing the tree closes all
        files.

    Raises
    ------
    StoreError
        If there is no such folder, it holds no scene, or a scene's file is truncated; single flipped bytes are
        found by `vibropipe verify`.
    """
    import xarray as xr

    paths = _files_in(Path(folder))
    for path in paths:
        check_intact(path, every_byte=False)
    scenes = {path.stem: _open(path, chunks="auto") for path in paths}
    tree = xr.DataTree.from_dict(dict(scenes), name=Path(folder).name)
    files = ExitStack()
    for scene in scenes.values():
        files.callback(scene.close)
    tree.set_close(files.close)
    return tree


def read_scenes(
    folder: str | PathLike[str], scenes: Iterable[str], fingerprints: Mapping[str, str]
) -> dict[str, xr.Dataset]:
    """Read the datasets of a study's scenes from ``folder``, by scene, each as :func:`read` does.

    ``fingerprints``: what a scene's data must have been made of; a scene without one is not checked.
    Raises StoreError when a dataset is missing, damaged, a shard, or of another study.
    """
    folder = Path(folder)
    _check_folder(folder)
    paths = {name: folder / f"{name}{ENDING}" for name in scenes}
    missing = [name for name, path in paths.items() if not path.is_file()]
    if missing:
        raise StoreError(f"{folder}: holds no dataset of {series(missing)}: solve the study first")
    datasets = {name: read(path) for name, path in paths.items()}
    for name, dataset in datasets.items():
        if ROW_RANGE_ATTRS[0] in dataset.attrs:
            raise StoreError(f"{paths[name]}: is a shard of a sweep: join all its shards first")
        if name in fingerprints and dataset.attrs.get("fingerprint") != fingerprints[name]:
            raise StoreError(
                f"{paths[name]}: was made from another study, or from this one before it was changed: "
                "recompute the scene"
            )
    return datasets


def scene_files(place: str | PathLike[str]) -> list[Path]:
    """Return the files of a study's scenes, in order of their names; of a file, itself.

    Raises StoreError when there is none.
    """
    place = Path(place)
    if not place.is_file():
        return _files_in(place)
    if place.suffix != ENDING:
        raise StoreError(
            f"{place}: is no dataset (its name does not end in {ENDING}): name a {ENDING} file"
        )
    return [place]


def attributes_of(path: str | PathLike[str]) -> dict[str, Any]:
    """Return the global attributes of a file every byte of which is checked; StoreError as ``read``."""
    check_intact(path)
    with open_raw(Path(path)) as file:
        return {name: file.getncattr(name) for name in file.ncattrs()}


def count_equal(path: str | PathLike[str], name: str, value: int) -> int:
    """Return how many values of the variable ``name`` are ``value``; 0 where there is no such variable.

    One chunk is in memory. Raises StoreError if the file cannot be read.
    """
    with raw(Path(path)) as file:
        if name not in file:
            return 0
        values = file[name]
        parts = values.iter_chunks() if values.chunks else [()]
        return sum(int(np.count_nonzero(values[part] == value)) for part in parts)


def _check_folder(folder: Path) -> None:
    if not folder.is_dir():
        raise StoreError(f"{folder}: does not exist{_nearest(folder)}: solve the study first")


def _files_in(folder: Path) -> list[Path]:
    _check_folder(folder)
    # temporary files begin with a dot and shards lie in a folder of their own
    paths = [path for path in sorted(folder.glob("[!.]*" + ENDING)) if path.is_file()]
    if not paths:
        raise StoreError(f"{folder}: holds no scene (no file *{ENDING}): solve the study first")
    return paths


def _open(path: Path, chunks: str | None) -> xr.Dataset:
    """Open a file lazily, complex quantities joined."""
    import dask
    import xarray as xr

    open_it = partial(xr.open_dataset, path, engine="netcdf4")
    try:
        with dask.config.set({"array.chunk-size": DASK_BYTES}), _chunk_cache(CACHE_BYTES):
            dataset = open_it(chunks=None)
            variables = dict(dataset.data_vars)
            text = [str(name) for name, values in variables.items() if values.dtype.kind == "O"]
            if chunks is not None:
                # dask cannot tell how much text is; it is little, and read at once
                words = dataset[text].load()
                dataset.close()
                dataset = open_it(chunks=chunks, drop_variables=text)
                both = {**words, **dataset}
                variables = {name: both[name] for name in variables}
    except (OSError, RuntimeError, ValueError) as error:
        raise StoreError(f"{path}: cannot be read: {error}") from error
    joined = _join_parts(xr.Dataset(variables, dataset.coords, dataset.attrs))
    joined.set_close(dataset.close)
    return joined


@contextmanager
def _chunk_cache(size: int) -> Iterator[None]:
    """Let each variable of files opened meanwhile keep up to ``size`` bytes of what was read."""
    import netCDF4

    usual = netCDF4.get_chunk_cache()
    netCDF4.set_chunk_cache(size)
    try:
        yield
    finally:
        netCDF4.set_chunk_cache(*usual)


def _join_parts(dataset: xr.Dataset) -> xr.Dataset:
    """Replace each pair ``<name>_re``, ``<name>_im`` by the complex ``<name>``, in its place."""
    import xarray as xr

    variables: dict[Any, xr.DataArray] = {}
    for key, variable in dataset.data_vars.items():
        name = variable.attrs.get(PART_OF)
        if name is None:
            variables[key] = variable
        elif key == part_names(name)[0]:
            other = dataset[part_names(name)[1]]
            whole = xr.apply_ufunc(
                _complex, variable, other, dask="parallelized", output_dtypes=[np.complex128]
            )
            whole.attrs = {k: v for k, v in variable.attrs.items() if k != PART_OF}
            whole.attrs["long_name"] = str(whole.attrs["long_name"]).removesuffix(", real part")
            variables[name] = whole
    return xr.Dataset(variables, dataset.coords, dataset.attrs)


def _complex(real: np.ndarray, imaginary: np.ndarray) -> np.ndarray:
    """Join two halves; real + 1j * imaginary would turn an infinite half into nan."""
    whole = np.empty(np.shape(real), np.complex128)
    whole.real, whole.imag = real, imaginary
    return whole


def _nearest(folder: Path) -> str:
    """Return a hint at a folder beside with a like name, if there is one."""
    beside = [path.name for path in folder.parent.glob("*") if path.is_dir()]
    close = get_close_matches(folder.name, beside, 1)
    return f" (there is {folder.parent / close[0]})" if close else ""
