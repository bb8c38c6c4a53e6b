"""All uses of private parts of numba; `pyproject.toml` bounds the versions that were tested.

Where a part is missing, the process that runs a kernel compiles it: this is slower, and a chaotic motion may differ in
its bits from that of a process that loads the kernel from the cache.

By itself numba optimises each function together with all that it calls, emits machine code, and repeats this for each
caller, so inner functions are compiled a dozen times. In a serving process a function called by the requested one stays
as lowered (a piece). Only the requested function is optimised, with its pieces linked in: this takes a third of the
time for code of equal speed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from vibropipe.compiler.cache import one_at_a_time


def on_missing(
    dispatcher: Any, compile_it: Callable[[Any, Any], bool], give_up: Callable[[], None]
) -> None:
    """Let a function compile the kernels of a dispatcher that are not in the cache.

    Parameters
    ----------
    dispatcher : numba dispatcher
    compile_it : callable
        Called with the dispatcher and a signature; returns whether the kernel is in the cache afterwards.
    give_up : callable
        Called where the kernel should be in the cache but cannot be loaded; this process then compiles it.
    """
    cache: Any = getattr(dispatcher, "_cache", None)
    load = getattr(cache, "load_overload", None)
    if load is None:
        return

    def load_overload(signature: Any, target: Any) -> Any:
        kernel = load(signature, target)
        if kernel is None and compile_it(dispatcher, signature):
            kernel = load(signature, target)
            if kernel is None:
                give_up()
        return kernel

    cache.load_overload = load_overload


def is_cached(dispatcher: Any, signature: Any) -> bool:
    """Return whether a kernel is in the cache, without loading it."""
    from numba.core.registry import cpu_target

    cache = dispatcher._cache
    key = cache._index_key(signature, cpu_target.target_context.codegen())
    return key in cache._cache_file._load_index()


def use_pieces() -> None:
    """Let numba create pieces in this process, which cannot be called."""
    from numba import _dynfunc  # type: ignore[attr-defined]
    from numba.core.caching import Cache
    from numba.core.registry import cpu_target
    from numba.core.runtime.nrt import rtsys

    context = cpu_target.target_context
    rtsys.initialize(context)
    context.codegen()._library_class = _piece_library()
    context.codegen().set_env = lambda name, environment: None

    def get_executable(library: Any, function: Any, environment: Any) -> Any:
        name = function.qualname.split(".")[-1]
        return _dynfunc.make_function(function.lookup_module(), name, "", 0, environment, ())

    context.get_executable = get_executable

    save = Cache.save_overload

    def save_overload(cache: Any, signature: Any, kernel: Any) -> None:
        # two processes that save signatures of one function would choose the same file name
        with one_at_a_time("saving"):
            save(cache, signature, kernel)

    Cache.save_overload = save_overload  # type: ignore[method-assign]


WHOLE: list[str] = []
"""Name of the requested function of a serving process; all others are pieces."""


def _piece_library() -> Any:
    """Return the class that replaces numba's library of code."""
    from numba.core.codegen import JITCodeLibrary

    class PartialLibrary(JITCodeLibrary):
        """Code of a function: numba's own for the requested function, a piece for all others."""

        def _is_piece(self) -> bool:
            return self.name not in WHOLE

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
            """Return what the cache stores: of a piece no machine code."""
            if self._is_piece():
                return tuple(self.serialize_using_bitcode())
            return tuple(super().serialize_using_object_code())

    return PartialLibrary
