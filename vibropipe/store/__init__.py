"""The store: datasets as whole, checked, self-describing netCDF4 files.

One library writes and reads them, netCDF4: h5py carries another copy of HDF5 and must not share a
process with it.
"""

from vibropipe.store.atomic import StoreError, check_whole, whole_file
from vibropipe.store.files import open_study, read, write
from vibropipe.store.joining import join
from vibropipe.store.origin import provenance, read_sidecar, write_sidecar
from vibropipe.store.show import summary

__all__ = [
    "StoreError",
    "check_whole",
    "join",
    "open_study",
    "provenance",
    "read",
    "read_sidecar",
    "summary",
    "whole_file",
    "write",
    "write_sidecar",
]
