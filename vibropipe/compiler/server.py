"""The process that compiles for others and runs nothing: a kernel and all it calls, optimised once, as one whole."""

from __future__ import annotations

import gc
import importlib
import math
import os
import pickle
import sys
import traceback
from typing import Any

import numba
import numpy as np

from vibropipe.compiler.cache import module_folder
from vibropipe.compiler.client import DONE, FAILED
from vibropipe.compiler.numba_internals import WHOLE, use_pieces

# Seconds without a task after which the process ends; the next task starts another.
IDLE = 10.0


def compile_whole(module: str, name: str, signature: Any) -> None:
    """Compile a function for a signature into the cache."""
    piece: Any = getattr(importlib.import_module(module), name)
    options = {**piece.targetoptions, "no_cpython_wrapper": False, "cache": True}
    numba.config.CACHE_DIR = str(module_folder(module))  # type: ignore[attr-defined]
    WHOLE[:] = [piece.py_func.__qualname__]
    numba.jit(**options)(piece.py_func).compile(signature)


def _usual(n):  # type: ignore[no-untyped-def]
    """What many kernels do: compiled before the first of them, it loads most of numba."""
    return math.sqrt(np.zeros(n)[0]), np.empty(n)


def serve() -> None:
    """Compile what comes through standard input, each task in a child that starts without any piece made for
    another one, and answer by a byte; until there is no more, or nothing for a while.

    Where a process cannot be forked it ends after one task.
    """
    tasks, answers = sys.stdin.buffer, os.dup(sys.stdout.fileno())
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    use_pieces()
    numba.njit(_usual).compile((numba.int64,))
    gc.freeze()
    while _there_is_a_task(tasks):
        try:
            task = pickle.load(tasks)
        except EOFError:
            return
        importlib.import_module(task[0])
        if not hasattr(os, "fork"):
            os.write(answers, DONE if _compiles(task) else FAILED)
            return
        child = os.fork()
        if child == 0:
            # What a compiler makes lives as long as it does.
            gc.disable()
            os._exit(0 if _compiles(task) else 1)
        _child, status = os.waitpid(child, 0)
        os.write(answers, DONE if status == 0 else FAILED)


def _there_is_a_task(tasks: Any) -> bool:
    """Wait for a task, for ever where a pipe cannot be asked."""
    if os.name != "posix":
        return True
    import select

    return bool(select.select([tasks], [], [], IDLE)[0])


def _compiles(task: tuple[str, str, Any]) -> bool:
    try:
        compile_whole(*task)
    except Exception:
        traceback.print_exc()
        return False
    return True
