"""Where compiled kernels lie: a folder for each module, named by the hash of all that the module imports.

numba's own cache looks only at the source file of the outermost function, so an edit of a function it calls
would go unseen. Another source is another folder here, for the kernels that depend on it and for no others.
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
    """Folder of all that is kept: `VIBROPIPE_CACHE_DIR`, else the user's cache; if that cannot be written, one
    that goes with this process (which then compiles anew, and says so once on stderr)."""
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
    """Folder of what is noted of this version of the solvers, such as how long scenes take."""
    return _made(cache_root() / kernel_hash())


@functools.cache
def module_folder(module: str) -> Path:
    """Folder of the compiled kernels of a module."""
    if not module.startswith("vibropipe."):
        return _made(cache_root() / "other")  # numba tells sources apart that it alone knows
    name = f"{module.removeprefix('vibropipe.')}-{source_hash([module, COMPILER])}"
    return _made(cache_root() / name)


@contextmanager
def one_at_a_time(task: str) -> Iterator[None]:
    """Keep other processes that name the same task waiting until this one is done with it.

    Where files cannot be locked nobody waits, and the same is done twice.
    """
    name = hashlib.sha256(task.encode()).hexdigest()[:16]
    with (_made(cache_root() / "locks") / name).open("ab") as file:
        with suppress(ImportError, OSError):
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _made(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return folder
