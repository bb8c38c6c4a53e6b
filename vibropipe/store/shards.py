"""The shards of a sweep as files: what each holds, that they fit together, their rows in order.

A shard's variables are of four kinds: those that run over ``row`` (and more), ragged ones that run
over the sample dimension of a count per row (CF contiguous ragged arrays), the swept parameters
themselves, and those that are the same in every shard.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.store.atomic import StoreError, check_whole
from vibropipe.store.encoding import NO_CACHE
from vibropipe.store.grid import Grid
from vibropipe.words.wording import count

if TYPE_CHECKING:
    import h5py
    import netCDF4

__all__ = ["ROW", "Rows", "Shard", "Variable", "counts_of", "inspect", "opened"]

ROW = "row"
OWN = ("row_start", "row_stop")
SAME = ("kernel_hash", "fingerprint")
"""Attributes in which shards of one sweep cannot differ: the code, and what was asked of it."""


@dataclass(frozen=True)
class Variable:
    """A variable of a shard without its values."""

    dims: tuple[str, ...]
    dtype: np.dtype
    attrs: dict[str, Any]


@dataclass(frozen=True)
class Shard:
    """What a shard holds: rows [start, stop) of its variables, the same constants as the others."""

    path: Path
    start: int
    stop: int
    attrs: dict[str, Any]
    sizes: dict[str, int]
    variables: dict[str, Variable]
    constants: Values

    @cached_property
    def samples(self) -> dict[str, str]:
        """For each sample dimension, the name of its count per row."""
        found = {}
        for name, variable in self.variables.items():
            if "sample_dimension" in variable.attrs:
                found[variable.attrs["sample_dimension"]] = name
        return found

    @property
    def gridded(self) -> list[str]:
        """Names of the variables over ``row``."""
        return [name for name, item in self.variables.items() if item.dims[:1] == (ROW,)]

    @property
    def ragged(self) -> list[str]:
        """Names of the variables over a sample dimension."""
        return [name for name, item in self.variables.items() if set(item.dims) & set(self.samples)]


Values = dict[str, np.ndarray]


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn what netCDF4 and h5py raise while a file is read into a StoreError that names it."""
    try:
        yield
    except StoreError:
        raise
    except (OSError, RuntimeError) as error:
        raise StoreError(f"{path} cannot be read: {error}") from error


@contextmanager
def opened(path: Path) -> Iterator[netCDF4.Dataset]:
    """Open a netCDF4 file for reading raw values; StoreError if it cannot be read."""
    import netCDF4

    with reading(path), netCDF4.Dataset(path) as file:
        file.set_auto_maskandscale(False)
        file.set_auto_chartostring(False)
        for variable in file.variables.values():
            if variable.dimensions:
                # read once and whole: a cache would hold all of it a second time
                variable.set_var_chunk_cache(size=NO_CACHE)
        yield file


@contextmanager
def raw(path: Path) -> Iterator[h5py.File]:
    """Open a file for the bare values of its variables; StoreError if they cannot be read.

    h5py reads a block of rows in half the time of netCDF4, which looks up what a variable is each time.
    """
    import h5py

    # each chunk is read once, or twice where two blocks share it: a cache would only take room
    with reading(path), h5py.File(path, "r", rdcc_nbytes=0) as file:
        yield file


def inspect(paths: Sequence[Path], grid: Grid) -> list[Shard]:
    """Read the heads of shards, in the order of their rows.

    Raises StoreError when one is damaged, when they do not hold each row of the grid exactly once,
    or when they do not come from one sweep.
    """
    if not paths:
        raise StoreError("no shards to join: solve them first")
    shards = sorted((_head(path) for path in paths), key=lambda shard: (shard.start, shard.stop))
    _check_cover(shards, grid.rows)
    for shard in shards[1:]:
        _check_alike(shards[0], shard)
    return shards


def _head(path: Path) -> Shard:
    check_whole(path)
    with opened(path) as file:
        attrs = {name: file.getncattr(name) for name in file.ncattrs()}
        if not all(name in attrs for name in OWN):
            raise StoreError(f"{path} is no shard: it has no {' and '.join(OWN)}")
        start, stop = (int(attrs.pop(name)) for name in OWN)
        sizes = {name: len(dim) for name, dim in file.dimensions.items()}
        variables = {
            name: Variable(
                tuple(item.dimensions),
                item.dtype,
                {key: item.getncattr(key) for key in item.ncattrs() if key != "_FillValue"},
            )
            for name, item in file.variables.items()
            # numbers of rows and samples start anew in each shard
            if name != ROW
        }
        sampled = {item.attrs.get("sample_dimension") for item in variables.values()} - {None}
        variables = {name: item for name, item in variables.items() if name not in sampled}
        varying = {ROW, *sampled}
        constants = {
            name: np.asarray(file.variables[name][...])
            for name, item in variables.items()
            if not varying & set(item.dims)
        }
        shard = Shard(path, start, stop, attrs, sizes, variables, constants)
        if sizes.get(ROW) != stop - start:
            raise StoreError(f"{path} says rows {start} to {stop - 1} but holds {sizes.get(ROW)}")
        for dim, count in shard.samples.items():
            if file.variables[count][...].sum(dtype=np.int64) != sizes[dim]:
                held = f"{sizes[dim]} of {dim!r}"
                raise StoreError(f"{path} holds {held} but {count} counts another sum")
    return shard


def counts_of(shards: Iterable[Shard], name: str) -> Iterator[tuple[int, np.ndarray]]:
    """Read the count ``name`` of each shard, one after the other, each with its first row."""
    for shard in shards:
        with raw(shard.path) as file:
            counts = file[name][...]
        yield shard.start, counts


def _check_cover(shards: Sequence[Shard], rows: int) -> None:
    """Raise unless the shards hold each of the rows [0, rows) exactly once."""
    reached = 0
    before: Shard | None = None
    for shard in shards:
        if shard.start > reached:
            break
        if shard.start < reached and before is not None:
            raise StoreError(
                f"{before.path} and {shard.path} both hold row {shard.start}: "
                "join the shards of one cut only"
            )
        reached, before = shard.stop, shard
    else:
        if reached == rows:
            return
        if reached > rows:
            raise StoreError(
                f"{shards[-1].path} holds rows up to {reached - 1} of {count(rows, 'row')}"
            )
    following = next((shard.start for shard in shards if shard.start > reached), rows)
    held = f"in none of the {len(shards)} shards" if len(shards) > 1 else "not in the only shard"
    raise StoreError(
        f"rows {reached} to {following - 1} of {rows} are {held}: solve the shards that hold them"
    )


def _check_alike(first: Shard, other: Shard) -> None:
    """Raise unless two shards come from one sweep."""
    between = f"{first.path} and {other.path} are not of one sweep"
    for name in SAME:
        if first.attrs.get(name) != other.attrs.get(name):
            raise StoreError(f"{between}: their {name} differs. Solve the older again")
    if list(first.variables) != list(other.variables):
        odd = sorted(set(first.variables) ^ set(other.variables))
        raise StoreError(f"{between}: only one holds {', '.join(odd) or 'them in this order'}")
    for name, variable in first.variables.items():
        twin = other.variables[name]
        if (variable.dims, variable.dtype) != (twin.dims, twin.dtype):
            raise StoreError(f"{between}: {name} has other dimensions or another type")
        free = {ROW, *first.samples}
        if any(first.sizes[dim] != other.sizes[dim] for dim in variable.dims if dim not in free):
            raise StoreError(f"{between}: {name} has another size")
    for name, values in first.constants.items():
        if values.tobytes() != other.constants[name].tobytes():
            raise StoreError(f"{between}: {name} has other values")


class Rows:
    """The rows of all shards, taken in order; in memory are those asked for."""

    def __init__(self, shards: Iterable[Shard]) -> None:
        self._left = iter(shards)
        self._shard: Shard | None = None
        self._bounds: Values = {}
        self._open = ExitStack()

    def close(self) -> None:
        """Close the shard that was read last."""
        self._open.close()

    def take(self, start: int, stop: int) -> Values:
        """Return the rows [start, stop) of every variable over ``row`` or a sample dimension.

        Each call goes on where the one before ended.
        """
        parts: dict[str, list[np.ndarray]] = {}
        while start < stop:
            shard = self._shard_of(start)
            end = min(stop, shard.stop)
            with reading(shard.path):
                values = self._read(shard, start, end)
            for name, part in values.items():
                parts.setdefault(name, []).append(part)
            start = end
        return {
            name: pieces[0] if len(pieces) == 1 else np.concatenate(pieces)
            for name, pieces in parts.items()
        }

    def _shard_of(self, row: int) -> Shard:
        """Return the shard of a row; a new one is opened, and where the samples of its rows begin is found."""
        if self._shard is not None and row < self._shard.stop:
            return self._shard
        self.close()
        shard = self._shard = next(self._left)
        self._file = self._open.enter_context(raw(shard.path))
        self._bounds = {
            dim: np.concatenate([[0], np.cumsum(self._file[name][...], dtype=np.int64)])
            for dim, name in shard.samples.items()
        }
        return shard

    def _read(self, shard: Shard, start: int, stop: int) -> Values:
        places = {ROW: (start - shard.start, stop - shard.start)}
        places |= {dim: tuple(ends[list(places[ROW])]) for dim, ends in self._bounds.items()}
        values = {}
        for name in [*shard.gridded, *shard.ragged]:
            first, last = places[shard.variables[name].dims[0]]
            values[name] = self._file[name][first:last]
        return values
