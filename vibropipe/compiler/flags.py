"""The decorators of kernels, which set the flags of numba."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, TypeVar, cast

from vibropipe.compiler.cache import module_folder
from vibropipe.compiler.client import COMPILER, PIECES, SERVES, compile_elsewhere

F = TypeVar("F", bound=Callable[..., Any])

NO_WRAPPERS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def _compile(function: F, forceinline: bool = False, **flags: Any) -> F:
    """Return a function compiled by numba, which rounds every product and sum as Python does."""
    import numba

    # Set on every function: otherwise numba takes it from whichever caller is compiled first, and the machine
    # code depends on that order.
    flags["forceinline"] = forceinline

    folder = module_folder(function.__module__)
    if os.environ.get(COMPILER) == SERVES:
        folder /= PIECES
        flags |= NO_WRAPPERS
    # numba reads the cache folder when the decorator runs; it is restored for other users of numba.
    before = numba.config.CACHE_DIR  # type: ignore[attr-defined]
    numba.config.CACHE_DIR = str(folder)  # type: ignore[attr-defined]
    try:
        # numpy's error model: 1/0 gives inf, no branch per division.
        compiled: Any = numba.njit(error_model="numpy", cache=True, **flags)(function)
        if COMPILER not in os.environ:
            compile_elsewhere(compiled)
        return cast(F, compiled)
    finally:
        numba.config.CACHE_DIR = before  # type: ignore[attr-defined]


def jit(function: F) -> F:
    """Compile a scalar kernel that allocates nothing; cached on disk.

    Reference counts are off: each call that passes arrays would update a count twice per array, which makes an impact
    five times slower.
    """
    return _compile(function, _nrt=False)


def jit_inline(function: F) -> F:
    """Compile a scalar kernel into its callers: parts of one hot loop, and calls once per forcing period.

    The compiler by itself would not inline them, and passing a grid or a log takes as long as several steps.
    """
    return _compile(function, _nrt=False, forceinline=True)


def jit_allocating(function: F) -> F:
    """Compile a kernel that creates arrays (once per row or motion, never per step)."""
    return _compile(function)


def jit_parallel(function: F) -> F:
    """Compile a driver whose `prange` distributes rows over all threads, without the interpreter's lock."""
    return _compile(function, parallel=True, nogil=True)


def jit_nogil(function: F) -> F:
    """Compile a driver that releases the interpreter's lock, so that threads run in parallel."""
    return _compile(function, nogil=True)
