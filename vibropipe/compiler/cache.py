"""The cache of compiled kernels: a folder for each module, named by the hash of all that the module imports.

numba's own cache checks only the source file of the outermost function and misses edits of the functions it calls. Here
an edit changes the folder of exactly the kernels that depend on it.
"""

from __future__ import annotations

import atexit
import functools
import hashlib
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from vibropipe.compiler.sources import COMPILER, kernel_hash, source_hash


@functools.cache
def cache_root() -> Path:
    """Return the folder of all cached files: `VIBROPIPE_CACHE_DIR`, else the user's cache.

    If that is not writable, it is a temporary folder, removed when this process ends, and a warning goes to stderr.
    """
    base = os.environ.get("VIBROPIPE_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    root = (Path(base) if base else Path.home() / ".cache") / "vibropipe"
    try:
        root.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=root):
            return root
    except OSError as error:
        print(
            f"vibropipe: the kernel cache {root} cannot be written ({error.strerror}); kernels are compiled "
            "for this process only. Set VIBROPIPE_CACHE_DIR to a folder that can be written.",
            file=sys.stderr,
        )
    own = Path(tempfile.mkdtemp(prefix="vibropipe-kernels-"))
    atexit.register(shutil.rmtree, own, ignore_errors=True)
    return own / "vibropipe"


def cache_folder() -> Path:
    """Return the folder of records of this version of the solvers, such as the run times of scenes."""
    return _made(cache_root() / kernel_hash())


@functools.cache
def module_folder(module: str) -> Path:
    """Return the folder of the compiled kernels of a module."""
    if not module.startswith("vibropipe."):
        return _made(cache_root() / "other")  # numba checks these sources itself
    return _made(_folder_of(module))


def has_kernels(module: str) -> bool:
    """Return whether kernels of a module of this package have been compiled before, for any effects."""
    return any(_folder_of(module).rglob("*.nbi"))


def _folder_of(module: str) -> Path:
    """Return the path of the folder of the kernels of a module of this package."""
    return cache_root() / f"{module.removeprefix('vibropipe.')}-{source_hash([module, COMPILER])}"


@contextmanager
def one_at_a_time(task: str) -> Iterator[None]:
    """Hold a lock of this name, so that other processes wait for it.

    Where files cannot be locked nobody waits, and the task is done twice.

    Parameters
    ----------
    task : str
        Name of the lock.
    """
    name = hashlib.sha256(task.encode()).hexdigest()[:16]
    with (_made(cache_root() / "locks") / name).open("ab") as file:
        with suppress(ImportError, OSError):
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _made(folder: Path) -> Path:
    """Create a folder and return it."""
    folder.mkdir(parents=True, exist_ok=True)
    return folder
