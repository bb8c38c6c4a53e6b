"""The compiler: the decorators of kernels, the cache of compiled kernels, and the hash of sources.

A function with a decorator of this module may be called from Python and from other such functions. `pieces` compiles
each once for both, and `sources` finds the code that stored numbers depend on.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from vibropipe.compiler.cache import module_folder, opened
from vibropipe.compiler.sources import kernel_hash

__all__ = ["jit", "jit_allocating", "jit_inline", "jit_nogil", "jit_parallel", "kernel_hash"]
F = TypeVar("F", bound=Callable[..., Any])


def _compile(function: F, **flags: Any) -> F:
    """Return a function compiled by numba, which rounds every product and sum as Python does."""
    import numba

    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        return function
    # numpy's error model: 1/0 gives inf, no branch per division. Inlining is set on every function: otherwise numba
    # takes it from whichever caller is compiled first, and the machine code depends on that order.
    flags = {"error_model": "numpy", "forceinline": False} | flags
    # Named now, by the sources that are imported: later ones may be edited.
    module_folder(function.__module__)
    try:
        from vibropipe.compiler.pieces import compiled
    except (ImportError, AttributeError):  # another version of numba: slower, but right
        from vibropipe.compiler.absent import DecidingCompiler

        plain = numba.njit(cache=True, pipeline_class=DecidingCompiler, **flags)  # type: ignore[call-overload]
        return cast(F, opened(plain, function))
    return cast(F, compiled(function, flags | {"nopython": True, "boundscheck": None}))


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
