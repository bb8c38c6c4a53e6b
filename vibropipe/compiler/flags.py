"""The decorators of kernels: numba's flags, said once."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, TypeVar, cast

from vibropipe.compiler.cache import module_folder
from vibropipe.compiler.client import COMPILER, PIECES, SERVES, compile_elsewhere

F = TypeVar("F", bound=Callable[..., Any])

NO_WRAPPERS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def _compile(function: F, fused: bool = True, forceinline: bool = False, **flags: Any) -> F:
    import numba

    # Of fastmath only the fusing of a product and a sum (halves the latency of every polynomial); the full set
    # deletes isnan.
    fast = {"contract"} if fused else False

    # Set on every function: otherwise numba takes it from whichever caller is compiled first, and the machine
    # code depends on that order.
    flags["forceinline"] = forceinline

    folder = module_folder(function.__module__)
    if os.environ.get(COMPILER) == SERVES:
        folder /= PIECES
        flags |= NO_WRAPPERS
    # The cache folder is read when the decorator runs; it is put back for other users of numba.
    before = numba.config.CACHE_DIR  # type: ignore[attr-defined]
    numba.config.CACHE_DIR = str(folder)  # type: ignore[attr-defined]
    try:
        # numpy's error model: 1/0 gives inf, no branch per division.
        compiled: Any = numba.njit(error_model="numpy", fastmath=fast, cache=True, **flags)(
            function
        )
        if COMPILER not in os.environ:
            compile_elsewhere(compiled)
        return cast(F, compiled)
    finally:
        numba.config.CACHE_DIR = before  # type: ignore[attr-defined]


def jit(function: F) -> F:
    """Compile a scalar kernel that allocates nothing; cached on disk.

    Without reference counts: with them, every call that passes a handful of arrays pays for each of them
    twice, which made an impact five times dearer.
    """
    return _compile(function, _nrt=False)


def jit_inline(function: F) -> F:
    """Compile a scalar kernel into its callers: pieces of one hot loop, and what is done once in a forcing period.

    The compiler would rather call them, and to hand over a whole grid or log takes as long as some steps.
    """
    return _compile(function, _nrt=False, forceinline=True)


def jit_allocating(function: F) -> F:
    """Compile a kernel that makes arrays (once per row or per motion, never per step)."""
    return _compile(function)


def jit_parallel(function: F) -> F:
    """Compile a driver whose `prange` runs rows on all threads, without the interpreter's lock."""
    return _compile(function, parallel=True, nogil=True)


def jit_nogil(function: F) -> F:
    """Compile a driver that lets go of the interpreter's lock, for threads to run side by side."""
    return _compile(function, nogil=True)


def jit_unfused(function: F) -> F:
    """Compile a few products and sums that round one by one: the same bits in whatever code they end up, of one
    motion or of many side by side, where the compiler would fuse now these and now those."""
    return _compile(function, fused=False, _nrt=False, forceinline=True)
