"""The cache of compiled kernels: a folder for each module, named by the hash of all that the module imports.

numba's own cache checks only the source file of the outermost function and misses edits of the functions it calls. Here
an edit changes the folder of exactly the kernels that depend on it.
"""

from __future__ import annotations

import atexit
import functools
import gc
import hashlib
import os
import shutil
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import Any

from vibropipe.compiler.sources import kernel_hash, source_hash

on_compiling: list[Callable[[str, float | None], None]] = []
"""Called with the name of a function that is to be compiled and None, and again, compiled, with the seconds it took."""
compile_seconds: list[float] = []
"""CPU seconds of this process for each function that it compiled."""


@functools.cache
def cache_root() -> Path:
    """Return the folder of all cached files: `VIBROPIPE_CACHE_DIR`, the user's cache or, if need be, one of its own."""
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
    """Return the folder of the compiled kernels of a module, which numba makes when it stores the first."""
    if not module.startswith("vibropipe."):
        return cache_folder() / "other"  # numba checks these sources itself
    return _folder_of(module)


def has_kernels(module: str) -> bool:
    """Return whether kernels of a module of this package have been compiled before, for any effects."""
    return any(_folder_of(module).rglob("*.nbi"))


def _folder_of(module: str) -> Path:
    """Return the path of the folder of the kernels of a module of this package."""
    return cache_root() / f"{module.removeprefix('vibropipe.')}-{source_hash([module])}"


@contextmanager
def one_at_a_time(task: str) -> Iterator[None]:
    """Hold the lock of a task, for which other processes wait; where files cannot be locked it is done twice."""
    name = hashlib.sha256(task.encode()).hexdigest()[:16]
    with (_made(cache_root() / "locks") / name).open("ab") as file:
        with suppress(ImportError, OSError):
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX)
        yield


def opened(cache: Callable[[Any], Any], function: Any, part: str = "") -> Any:
    """Return numba's cache of a function in the folder of its module; numba reads its setting when one is made."""
    import numba

    before = numba.config.CACHE_DIR  # type: ignore[attr-defined]
    numba.config.CACHE_DIR = str(module_folder(function.__module__) / part)  # type: ignore[attr-defined]
    try:
        return cache(function)
    finally:
        numba.config.CACHE_DIR = before  # type: ignore[attr-defined]


class _Interrupt:
    """Handler of SIGINT that remembers Ctrl-C and raises nothing."""

    pressed = False

    def __call__(self, _number: int, _frame: FrameType | None) -> None:
        self.pressed = True

    def check(self) -> None:
        """Raise what Ctrl-C would have raised."""
        if self.pressed:
            raise KeyboardInterrupt


@contextmanager
def interrupted_between() -> Iterator[None]:
    """Let Ctrl-C wait for the begin or end of such a context.

    LLVM calls functions of Python, where an exception is lost or ends the process by a segmentation fault.
    """
    handler = signal.getsignal(signal.SIGINT)
    if isinstance(handler, _Interrupt):  # a function is compiled for another one
        handler.check()
        yield
        handler.check()
        return
    if (
        handler is not signal.default_int_handler
        or threading.current_thread() is not threading.main_thread()
    ):
        yield
        return
    interrupt = _Interrupt()
    signal.signal(signal.SIGINT, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        interrupt.check()


@contextmanager
def compiling(function: Any) -> Iterator[None]:
    """Announce the compilation of a function, and collect no garbage meanwhile: it takes a tenth of the time."""
    name = f"{function.__module__}.{function.__qualname__}".removeprefix("vibropipe.")
    for callback in on_compiling:
        callback(name, None)
    was_enabled, begin, begin_work = gc.isenabled(), time.perf_counter(), time.process_time()
    gc.disable()
    try:
        yield
    finally:
        compile_seconds.append(time.process_time() - begin_work)
        if was_enabled:
            gc.enable()
    for callback in on_compiling:
        callback(name, time.perf_counter() - begin)


def _made(folder: Path) -> Path:
    """Create a folder and return it."""
    folder.mkdir(parents=True, exist_ok=True)
    return folder
