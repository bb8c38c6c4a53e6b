"""Datasets as complete, checksummed, self-describing netCDF4 files.

netCDF4 writes and reads them; h5py, faster for bare values, reads the rows of shards that are joined.
"""

from vibropipe.store.atomic import (
    NotWrittenError,
    StoreError,
    atomic_file,
    check_intact,
    fingerprint_of,
    remove_leftovers,
    seal_of,
    with_fingerprint,
)
from vibropipe.store.compare import Difference, compare, compare_rows
from vibropipe.store.earlier_rows import EarlierRows, NotTakenError
from vibropipe.store.files import (
    attributes_of,
    count_equal,
    load,
    read_scenes,
    save,
    scene_files,
    selected_attributes,
)
from vibropipe.store.opening import open_study
from vibropipe.store.origin import expected_changes, provenance, read_sidecar, write_sidecar
from vibropipe.store.show import summary
from vibropipe.store.sweep_files import join, read_shards, write_grid, write_rows
from vibropipe.store.table import table

__all__ = [
    "Difference",
    "EarlierRows",
    "NotTakenError",
    "NotWrittenError",
    "StoreError",
    "atomic_file",
    "attributes_of",
    "check_intact",
    "compare",
    "compare_rows",
    "count_equal",
    "expected_changes",
    "fingerprint_of",
    "join",
    "load",
    "open_study",
    "provenance",
    "read_scenes",
    "read_shards",
    "read_sidecar",
    "remove_leftovers",
    "save",
    "scene_files",
    "seal_of",
    "selected_attributes",
    "summary",
    "table",
    "with_fingerprint",
    "write_grid",
    "write_rows",
    "write_sidecar",
]
