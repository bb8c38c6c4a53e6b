"""How a dataset lies on disk: netCDF4 by CF conventions, readable by any tool.

Complex quantities become a pair ``<name>_re``, ``<name>_im``; truth values int8 with flags; text
a block of characters; attributes that netCDF has no type for JSON text. Variables are cut in chunks
of up to 1 MB, each with a checksum (fletcher32). Whole numbers and text are compressed to a fiftieth
(zlib 1 after shuffle). Floats are not: they would shrink to a half, and a joined file took four times
as long to write. Nothing of time or place goes in: equal datasets are equal bytes.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.words.vocabulary import VOCABULARY

if TYPE_CHECKING:
    import netCDF4
    import xarray as xr

CONVENTIONS = "CF-1.11"
CHUNK_BYTES = 1 << 20
NO_CACHE = 1
"""Bytes of a chunk cache that holds no chunk; 0 stands for netCDF's own choice, 64 MB a variable."""
RANKS = {name: rank for rank, name in enumerate(VOCABULARY)}
PART_OF = "part_of"
"""Attribute of the two halves of a complex quantity: the name they make together."""


@dataclass(frozen=True)
class StoredVariable:
    """One variable as it lies on disk: every type is one of netCDF's, every attribute storable.

    ``values`` is None where they are streamed in later; ``grows`` says that the length of its first
    dimension is not known before. ``chunks`` is None for the usual ones.
    """

    name: str
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: np.dtype
    attrs: dict[str, Any] = field(default_factory=dict)
    values: np.ndarray | None = None
    chunks: tuple[int, ...] | None = None
    grows: bool = False


def encode(dataset: xr.Dataset) -> tuple[list[StoredVariable], dict[str, Any]]:
    """Turn a dataset in memory into its variables on disk and its global attributes.

    Coordinates come first, in the order of the vocabulary: xarray gives them no order of its own.
    """
    coords = {str(name): _names(dataset[name].dims) for name in sorted(dataset.coords, key=_rank)}
    stored: list[StoredVariable] = []
    for name in [*coords, *dataset.data_vars]:
        variable = dataset.variables[name]
        dims = _names(variable.dims)
        attrs = storable(variable.attrs)
        if name in dataset.data_vars:
            attrs |= coordinates_attribute(dims, coords)
        stored += _encode_values(str(name), dims, np.asarray(variable.values), attrs)
    attrs = {"Conventions": CONVENTIONS} | storable(dataset.attrs)
    used = " ".join(str(item.attrs.get("coordinates", "")) for item in stored).split()
    orphans = [name for name, dims in coords.items() if dims != (name,) and name not in used]
    if orphans:
        attrs["coordinates"] = " ".join(orphans)
    return stored, attrs


def _rank(name: Any) -> tuple[int, str]:
    """Return a key that sorts names as the vocabulary does, others last."""
    return RANKS.get(str(name), len(RANKS)), str(name)


def coordinates_attribute(
    dims: tuple[str, ...], coords: Mapping[str, tuple[str, ...]]
) -> dict[str, str]:
    """Return CF's ``coordinates`` attribute of a variable over ``dims``, or nothing."""
    names = [name for name, own in coords.items() if own != (name,) and set(own) <= set(dims)]
    return {"coordinates": " ".join(names)} if names else {}


def part_names(name: str) -> tuple[str, str]:
    """Return the names of the real and the imaginary part of ``name`` on disk."""
    return f"{name}_re", f"{name}_im"


def storable(attrs: Mapping[Any, Any]) -> dict[str, Any]:
    """Return attributes that netCDF can hold: text and numbers as they are, the rest as JSON."""
    return {str(name): _storable(value) for name, value in attrs.items()}


def _storable(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic) and value.dtype.kind in "iuf":
        return value
    if isinstance(value, str | int | float) and not isinstance(value, bool):
        return value
    if isinstance(value, list | tuple) and value:
        array = np.asarray(value) if all(isinstance(item, int | float) for item in value) else None
        if array is not None and array.dtype.kind in "iuf":
            return array
    return json.dumps(value, ensure_ascii=False, default=_plain)


def _plain(value: Any) -> Any:
    """Turn numpy's values into Python's, for JSON."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"an attribute cannot hold {value!r}")


def _names(dims: Iterable[Any]) -> tuple[str, ...]:
    return tuple(str(dim) for dim in dims)


def _encode_values(
    name: str, dims: tuple[str, ...], values: np.ndarray, attrs: dict[str, Any]
) -> list[StoredVariable]:
    """Return the variables that hold ``values``: two for complex ones, else one."""
    if values.dtype.kind == "c":
        long_name = attrs.get("long_name", name)
        halves = zip(("real", "imaginary"), (values.real, values.imag), strict=True)
        return [
            _stored(
                part, dims, half, attrs | {"long_name": f"{long_name}, {word} part", PART_OF: name}
            )
            for part, (word, half) in zip(part_names(name), halves, strict=True)
        ]
    if values.dtype.kind == "b":
        meanings = attrs.get("flag_meanings", "false true")
        flags = {"flag_values": np.array([0, 1], np.int8), "flag_meanings": meanings}
        # xarray reads "dtype" and gives truth values back
        return [_stored(name, dims, values.astype(np.int8), attrs | flags | {"dtype": "bool"})]
    if values.dtype.kind in "OU":
        letters = np.char.encode(values.astype(str), "utf-8")
        width = max(1, letters.dtype.itemsize)
        letters = np.ascontiguousarray(letters.astype(f"S{width}"))
        cut = letters.view("S1").reshape(*values.shape, width)
        return [_stored(name, (*dims, f"string{width}"), cut, attrs | {"_Encoding": "utf-8"})]
    return [_stored(name, dims, values, attrs)]


def _stored(
    name: str, dims: tuple[str, ...], values: np.ndarray, attrs: dict[str, Any]
) -> StoredVariable:
    return StoredVariable(name, dims, values.shape, values.dtype, attrs, values)


def chunk_shape(shape: tuple[int, ...], most: int) -> tuple[int, ...]:
    """Return the shape of a block of at most about ``most`` elements, contiguous in C order.

    Trailing dimensions are whole; the one before them is cut at a power of two, so that blocks
    of a larger ``most`` never cut those of a smaller one; the leading ones are cut to 1. The last
    block of a cut is stored as long as the others: where that would waste more than a sixteenth,
    blocks are down to eight times smaller.
    """
    chunks = [1] * len(shape)
    left = max(1, most)
    for axis in reversed(range(len(shape))):
        size = max(1, shape[axis])
        if size > left:
            length = 1 << (left.bit_length() - 1)
            least = max(1, length // 8)
            while length > least and -size % length > size // 16:
                length //= 2
            chunks[axis] = length
            break
        chunks[axis] = size
        left //= size
    return tuple(chunks)


def define_variables(
    file: netCDF4.Dataset, variables: Iterable[StoredVariable], attrs: Mapping[str, Any]
) -> dict[str, netCDF4.Variable]:
    """Define ``variables`` and the global attributes in an open file, and fill what has values."""
    created = {}
    variables = list(variables)
    file.setncatts(dict(attrs))
    for item in variables:
        for axis, (dim, size) in enumerate(zip(item.dims, item.shape, strict=True)):
            if dim not in file.dimensions:
                file.createDimension(dim, None if item.grows and axis == 0 else size)
        created[item.name] = _create(file, item)
    for item in variables:
        if item.values is not None and 0 not in item.shape:
            created[item.name][...] = item.values
    return created


def _create(file: netCDF4.Dataset, item: StoredVariable) -> netCDF4.Variable:
    filters: dict[str, Any] = {}
    if item.dims:
        chunks = item.chunks or chunk_shape(item.shape, CHUNK_BYTES // item.dtype.itemsize)
        filters = {
            "zlib": item.dtype.kind != "f",
            "complevel": 1,
            "fletcher32": True,
            "chunksizes": chunks,
            # every chunk is written once and whole: a cache would only hold memory
            "chunk_cache": NO_CACHE,
        }
    # CF allows no missing values in a coordinate
    missing = np.nan if item.dtype.kind == "f" and item.dims != (item.name,) else None
    variable = file.createVariable(item.name, item.dtype, item.dims, fill_value=missing, **filters)
    variable.set_auto_maskandscale(False)
    variable.setncatts(item.attrs)
    return variable
