"""What was compiled and calibrated on this machine before, kept beside the compiled kernels by name."""

from __future__ import annotations

import hashlib
import json
import os
import sys
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from vibropipe.jit import PACKAGE, cache_folder
from vibropipe.store import StoreError, whole_file

# Another version of these compiles anew or takes another time; a peer may be missing.
PACKAGES = ("numba", "llvmlite", "numpy", "scipy", "heyoka")
SETTINGS = ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES")


def done_before() -> set[str]:
    """Names of what was done with this code, these packages and this processor."""
    try:
        known = json.loads(_record().read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return set()
    return set(known) if isinstance(known, list) else set()


def note(names: Iterable[str]) -> None:
    """Keep that these are done."""
    known = sorted(done_before() | set(names))
    try:
        with whole_file(_record()) as temporary:
            temporary.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
    except (OSError, StoreError):
        return  # a machine that keeps nothing does it again


def _record() -> Path:
    """File of the names, by all that the compiler looks at before it takes a kernel from its cache."""
    import llvmlite.binding as llvm

    told = [
        str(PACKAGE),
        sys.version,
        *map(_version_of, PACKAGES),
        llvm.get_host_cpu_name(),
        llvm.get_host_cpu_features().flatten(),
        *(os.environ.get(name, "") for name in SETTINGS),
    ]
    digest = hashlib.sha256("\0".join(told).encode()).hexdigest()[:16]
    return cache_folder() / f"warmed-{digest}.json"


def _version_of(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""
