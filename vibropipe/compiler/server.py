"""The process that compiles kernels for others and runs none: each with all that it calls, optimised as one whole."""

from __future__ import annotations

import gc
import importlib
import math
import os
import pickle
import sys
import traceback
from contextlib import suppress
from typing import Any

import numba
import numpy as np

from vibropipe.compiler.cache import module_folder
from vibropipe.compiler.client import DONE, FAILED
from vibropipe.compiler.numba_internals import WHOLE, use_pieces

# Seconds without a task after which the process ends; the next task starts a new one.
IDLE = 60.0


def compile_whole(module: str, name: str, signature: Any) -> None:
    """Compile a function for a signature into the cache."""
    piece: Any = getattr(importlib.import_module(module), name)
    options = {**piece.targetoptions, "no_cpython_wrapper": False, "cache": True}
    numba.config.CACHE_DIR = str(module_folder(module))  # type: ignore[attr-defined]
    WHOLE[:] = [piece.py_func.__qualname__]
    numba.jit(**options)(piece.py_func).compile(signature)


def _usual(n):  # type: ignore[no-untyped-def]
    """Compile this before the first kernel: it loads most parts of numba that kernels need."""
    return math.sqrt(np.zeros(n)[0]), np.empty(n)


def serve() -> None:
    """Compile the tasks that arrive on standard input and answer each by one byte.

    Each task is compiled in a forked child, which starts without the pieces of other tasks. The process ends at the end
    of its input or after IDLE seconds; where it cannot fork, after one task.
    """
    tasks, answers = sys.stdin.buffer, os.dup(sys.stdout.fileno())
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    use_pieces()
    numba.njit(_usual).compile((numba.int64,))
    gc.freeze()
    while _has_task(tasks):
        try:
            task = pickle.load(tasks)
        except EOFError:
            return
        importlib.import_module(task[0])
        if not hasattr(os, "fork"):
            _answer(answers, _compiles(task))
            return
        child = os.fork()
        if child == 0:
            # The child ends after this task: collecting garbage is wasted time.
            gc.disable()
            os._exit(0 if _compiles(task) else 1)
        _child, status = os.waitpid(child, 0)
        _answer(answers, status == 0)


def _answer(answers: int, is_done: bool) -> None:
    """Say that a task is done or has failed, unless the process that sent it was killed."""
    with suppress(BrokenPipeError):
        os.write(answers, DONE if is_done else FAILED)


def _has_task(tasks: Any) -> bool:
    """Wait for a task and return whether one came; without a time limit where pipes cannot be polled."""
    if os.name != "posix":
        return True
    import select

    return bool(select.select([tasks], [], [], IDLE)[0])


def _compiles(task: tuple[str, str, Any]) -> bool:
    """Compile a task and return whether this succeeded; print the error if not."""
    try:
        compile_whole(*task)
    except Exception:
        traceback.print_exc()
        return False
    return True
