"""Layout of a dataset on disk: netCDF4 by CF conventions, readable by any tool.

A complex quantity becomes a pair `<name>_re`, `<name>_im`, a bool int8 with flags, text a block of characters; an
attribute without a netCDF type becomes JSON text. Variables are stored in chunks of up to 1 MB, each with a checksum
(fletcher32). Integers and text are compressed (zlib 1 after shuffle) to a fiftieth; floats are not, since they shrink
only to a half and a joined file took four times as long to write. No time or place is stored, so that equal datasets
give equal bytes.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np

from vibropipe.words.vocabulary import VOCABULARY, attributes_of_dimension

if TYPE_CHECKING:
    import netCDF4
    import xarray as xr

CONVENTIONS = "CF-1.11"
CHUNK_BYTES = 1 << 20
NO_CACHE = 1
"""Size in bytes of a chunk cache that holds no chunk; 0 means the default of netCDF, 64 MB for each variable."""
RANKS = {name: rank for rank, name in enumerate(VOCABULARY)}
PART_OF = "part_of"
"""Attribute of the two parts of a complex quantity: its name."""


@dataclass(frozen=True)
class StoredVariable:
    """A variable as encoded on disk: its type is one of netCDF, its attributes can be stored.

    values : None if they are written later; chunks : None for the default.
    """

    name: str
    dims: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: np.dtype
    attrs: dict[str, Any] = field(default_factory=dict)
    values: np.ndarray | None = None
    chunks: tuple[int, ...] | None = None

    @property
    def bytes_each(self) -> int:
        """Bytes of a row, or of a sample."""
        return self.dtype.itemsize * prod(self.shape[1:])


# Variables and global attributes as encoded.
Encoded = tuple[list[StoredVariable], dict[str, Any]]


def encode(dataset: xr.Dataset) -> Encoded:
    """Encode a dataset for the disk.

    Returns the variables, coordinates first, in the order of the vocabulary, since xarray does not define one, and the
    global attributes.
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
    referenced = " ".join(str(item.attrs.get("coordinates", "")) for item in stored).split()
    orphans = [name for name, dims in coords.items() if dims != (name,) and name not in referenced]
    if orphans:
        attrs["coordinates"] = " ".join(orphans)
    return stored, attrs


def encode_coords(coords: Mapping[str, np.ndarray]) -> list[StoredVariable]:
    """Encode the coordinates of dimensions, given by name, with the attributes of the vocabulary."""
    return [
        item
        for name, values in coords.items()
        for item in _encode_values(name, (name,), values, storable(attributes_of_dimension(name)))
    ]


def _rank(name: Any) -> tuple[int, str]:
    """Return the key that sorts names in the order of the vocabulary, others last."""
    return RANKS.get(str(name), len(RANKS)), str(name)


def coordinates_attribute(
    dims: tuple[str, ...], coords: Mapping[str, tuple[str, ...]]
) -> dict[str, str]:
    """Return CF's attribute `coordinates` of a variable over `dims`, or nothing."""
    names = [
        name
        for name, own_dims in coords.items()
        if own_dims != (name,) and set(own_dims) <= set(dims)
    ]
    return {"coordinates": " ".join(names)} if names else {}


def part_names(name: str) -> tuple[str, str]:
    """Return the names of the real and the imaginary part on disk."""
    return f"{name}_re", f"{name}_im"


def storable(attrs: Mapping[Any, Any]) -> dict[str, Any]:
    """Return attributes as netCDF can hold them: text and numbers unchanged, others as JSON."""
    return {str(name): _storable(value) for name, value in attrs.items()}


def _storable(value: Any) -> Any:
    """Return the value of an attribute as netCDF can hold it."""
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
    """Return a numpy value as a Python value, for JSON."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"an attribute cannot hold {value!r}")


def _names(dims: Iterable[Any]) -> tuple[str, ...]:
    return tuple(str(dim) for dim in dims)


def _encode_values(
    name: str, dims: tuple[str, ...], values: np.ndarray, attrs: dict[str, Any]
) -> list[StoredVariable]:
    """Return the variables that hold `values`: two for complex values, else one."""
    if values.dtype.kind == "c":
        long_name = attrs.get("long_name", name)
        parts = zip(("real", "imaginary"), (values.real, values.imag), strict=True)
        return [
            _stored(
                part,
                dims,
                part_values,
                attrs | {"long_name": f"{long_name}, {word} part", PART_OF: name},
            )
            for part, (word, part_values) in zip(part_names(name), parts, strict=True)
        ]
    if values.dtype.kind == "b":
        meanings = attrs.get("flag_meanings", "false true")
        flags = {"flag_values": np.array([0, 1], np.int8), "flag_meanings": meanings}
        # xarray decodes to bool by "dtype"
        return [_stored(name, dims, values.astype(np.int8), attrs | flags | {"dtype": "bool"})]
    if values.dtype.kind in "OU":
        encoded = np.char.encode(values.astype(str), "utf-8")
        width = max(1, encoded.dtype.itemsize)
        encoded = np.ascontiguousarray(encoded.astype(f"S{width}"))
        characters = encoded.view("S1").reshape(*values.shape, width)
        return [
            _stored(name, (*dims, f"string{width}"), characters, attrs | {"_Encoding": "utf-8"})
        ]
    return [_stored(name, dims, values, attrs)]


def _stored(
    name: str, dims: tuple[str, ...], values: np.ndarray, attrs: dict[str, Any]
) -> StoredVariable:
    return StoredVariable(name, dims, values.shape, values.dtype, attrs, values)


def chunk_shape(shape: tuple[int, ...], max_elements: int) -> tuple[int, ...]:
    """Return the shape of a block of at most about `max_elements` elements, contiguous in C order.

    Trailing dimensions are whole, the one before them has a power of two, and the leading ones are 1, so that
    blocks of a larger limit consist of whole blocks of a smaller one. The last block of a dimension is stored at full
    length: where this would waste more than a sixteenth, blocks are up to eight times smaller.
    """
    chunks = [1] * len(shape)
    remaining = max(1, max_elements)
    for axis in reversed(range(len(shape))):
        size = max(1, shape[axis])
        if size > remaining:
            length = 1 << (remaining.bit_length() - 1)
            min_length = max(1, length // 8)
            while length > min_length and -size % length > size // 16:
                length //= 2
            chunks[axis] = length
            break
        chunks[axis] = size
        remaining //= size
    return tuple(chunks)


def define_variables(
    file: netCDF4.Dataset, variables: Iterable[StoredVariable], attrs: Mapping[str, Any]
) -> dict[str, netCDF4.Variable]:
    """Define variables and global attributes in an open file, write known values, and return the variables by name."""
    created = {}
    variables = list(variables)
    file.setncatts(dict(attrs))
    for item in variables:
        for dim, size in zip(item.dims, item.shape, strict=True):
            if dim not in file.dimensions:
                file.createDimension(dim, size)
        created[item.name] = _create(file, item)
    for item in variables:
        if item.values is not None and 0 not in item.shape:
            created[item.name][...] = item.values
    return created


def _create(file: netCDF4.Dataset, item: StoredVariable) -> netCDF4.Variable:
    """Create a variable with its chunks, filters and attributes."""
    filters: dict[str, Any] = {}
    if item.dims:
        chunks = item.chunks or chunk_shape(item.shape, CHUNK_BYTES // item.dtype.itemsize)
        filters = {
            "zlib": item.dtype.kind != "f",
            "complevel": 1,
            "fletcher32": True,
            "chunksizes": chunks,
            # every chunk is written once and complete: a cache would only use memory
            "chunk_cache": NO_CACHE,
        }
    # CF allows no missing values in a coordinate
    missing = np.nan if item.dtype.kind == "f" and item.dims != (item.name,) else None
    variable = file.createVariable(item.name, item.dtype, item.dims, fill_value=missing, **filters)
    variable.set_auto_maskandscale(False)
    variable.setncatts(item.attrs)
    return variable
