"""The process that compiles for others and runs nothing: a kernel and all it calls, optimised once, as one whole.

numba by itself optimises each function together with all it calls and makes machine code of it, then does the
same with each of its callers: what lies deep is compiled a dozen times over. Here a function that is called
by the one asked for remains as it was lowered (a piece, kept in a folder of its own), and only what is asked
for is optimised, with its pieces linked in: a third of the time, for code as fast.
"""

from __future__ import annotations

import fcntl
import gc
import importlib
import math
import os
import pickle
import select
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import numba
import numpy as np
from numba import _dynfunc  # type: ignore[attr-defined]
from numba.core.caching import Cache
from numba.core.codegen import JITCodeLibrary
from numba.core.registry import cpu_target
from numba.core.runtime.nrt import rtsys

from vibropipe.jit import DONE, FAILED, cache_folder

# Seconds without a task after which the process ends; the next task starts another.
IDLE = 10.0


class Library(JITCodeLibrary):
    """The code of a function: of the one asked for (`whole` is its name) as numba makes it; of all others a piece."""

    whole: str | None = None

    def _is_piece(self) -> bool:
        return self.name != Library.whole

    def _optimize_final_module(self) -> None:
        if not self._is_piece():
            super()._optimize_final_module()

    def _finalize_final_module(self) -> None:
        if not self._is_piece():
            super()._finalize_final_module()
            return
        self._finalize_dynamic_globals()
        self._finalized = True

    def serialize_using_object_code(self) -> tuple[Any, ...]:
        """What the cache keeps: without machine code of a piece."""
        if self._is_piece():
            return tuple(self.serialize_using_bitcode())
        return tuple(super().serialize_using_object_code())


def use_pieces() -> None:
    """Let numba make pieces in this process, and nothing that could be called."""
    context = cpu_target.target_context
    rtsys.initialize(context)
    context.codegen()._library_class = Library
    context.codegen().set_env = lambda name, environment: None

    def get_executable(library: Any, function: Any, environment: Any) -> Any:
        name = function.qualname.split(".")[-1]
        return _dynfunc.make_function(function.lookup_module(), name, "", 0, environment, ())

    context.get_executable = get_executable

    save = Cache.save_overload

    def save_overload(cache: Any, signature: Any, made: Any) -> None:
        with one_writer():
            save(cache, signature, made)

    Cache.save_overload = save_overload  # type: ignore[method-assign]


@contextmanager
def one_writer() -> Iterator[None]:
    """Keep other processes from writing to the cache: two that save signatures of one function at the same time
    would choose the same name for their files."""
    with (cache_folder() / "writer").open("ab") as file:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(file, fcntl.LOCK_EX)
        yield


def compile_whole(module: str, name: str, signature: Any) -> None:
    """Compile a function for a signature into the cache."""
    piece: Any = getattr(importlib.import_module(module), name)
    options = {**piece.targetoptions, "no_cpython_wrapper": False, "cache": True}
    numba.config.CACHE_DIR = str(cache_folder())  # type: ignore[attr-defined]
    Library.whole = piece.py_func.__qualname__
    numba.jit(**options)(piece.py_func).compile(signature)


def _usual(n):  # type: ignore[no-untyped-def]
    """What many kernels do: compiled before the first of them, it loads most of numba."""
    return math.sqrt(np.zeros(n)[0]), np.empty(n)


def serve() -> None:
    """Compile what comes through standard input, each task in a child that starts without any piece made for
    another one, and answer by a byte; until there is no more, or nothing for a while."""
    tasks, answers = sys.stdin.buffer, os.dup(sys.stdout.fileno())
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    use_pieces()
    numba.njit(_usual).compile((numba.int64,))
    gc.freeze()
    while select.select([tasks], [], [], IDLE)[0]:
        try:
            task = pickle.load(tasks)
        except EOFError:
            return
        importlib.import_module(task[0])
        child = os.fork()
        if child == 0:
            # What a compiler makes lives as long as it does.
            gc.disable()
            failed = 0
            try:
                compile_whole(*task)
            except Exception:
                traceback.print_exc()
                failed = 1
            os._exit(failed)
        _child, status = os.waitpid(child, 0)
        os.write(answers, DONE if status == 0 else FAILED)
