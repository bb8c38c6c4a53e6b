"""What leans on private parts of numba, all of it; `pyproject.toml` bounds the versions it was tried with.

Where one of these parts is missing, kernels are compiled by the process that runs them: slower to compile, and a
chaotic motion may come out with other bits than in a process that finds them in the cache.

numba by itself optimises each function together with all it calls and makes machine code of it, then does the
same with each of its callers: what lies deep is compiled a dozen times over. In a process that serves as compiler
a function that is called by the one asked for remains as it was lowered (a piece), and only what is asked for is
optimised, with its pieces linked in: a third of the time, for code as fast.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from vibropipe.compiler.cache import one_at_a_time


def on_missing(
    dispatcher: Any, compile_it: Callable[[Any, Any], bool], give_up: Callable[[], None]
) -> None:
    """Have a kernel that is not in the cache compiled by `compile_it`, and load what that left in the cache.

    compile_it: called with the dispatcher and a signature; returns whether the kernel is in the cache then.
    give_up: called where it should be there and cannot be loaded; this process compiles it then.
    """
    cache: Any = getattr(dispatcher, "_cache", None)
    load = getattr(cache, "load_overload", None)
    if load is None:
        return

    def load_overload(signature: Any, target: Any) -> Any:
        found = load(signature, target)
        if found is None and compile_it(dispatcher, signature):
            found = load(signature, target)
            if found is None:
                give_up()
        return found

    cache.load_overload = load_overload


def is_cached(dispatcher: Any, signature: Any) -> bool:
    """Whether a kernel lies in the cache; it is not loaded."""
    from numba.core.registry import cpu_target

    cache = dispatcher._cache
    key = cache._index_key(signature, cpu_target.target_context.codegen())
    return key in cache._cache_file._load_index()


def use_pieces() -> None:
    """Let numba make pieces in this process, and nothing that could be called."""
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

    def save_overload(cache: Any, signature: Any, made: Any) -> None:
        # two that save signatures of one function at the same time would choose the same name for their files
        with one_at_a_time("saving"):
            save(cache, signature, made)

    Cache.save_overload = save_overload  # type: ignore[method-assign]


WHOLE: list[str] = []
"""Name of the function that a serving process was asked for; all others are pieces."""


def _piece_library() -> Any:
    from numba.core.codegen import JITCodeLibrary

    class PartialLibrary(JITCodeLibrary):
        """The code of a function: of the one asked for as numba makes it; of all others a piece."""

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
            """What the cache keeps: without machine code of a piece."""
            if self._is_piece():
                return tuple(self.serialize_using_bitcode())
            return tuple(super().serialize_using_object_code())

    return PartialLibrary
