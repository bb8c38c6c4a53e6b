"""All uses of private parts of numba: `pyproject.toml` bounds the versions tried, and plain numba does without.

By itself numba optimises a function with all that it calls, emits machine code, and repeats this for each caller. Here
it is an entry for Python, optimised as a whole, and a piece for compiled callers, kept as lowered: compiled apart.
"""

import functools
from typing import Any

import llvmlite.binding as llvm
from numba.core.caching import CompileResultCacheImpl, FunctionCache, NullCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import compile_result
from numba.core.registry import CPUDispatcher
from numba.core.types import unliteral

from vibropipe.compiler.absent import DecidingCompiler
from vibropipe.compiler.cache import compiling, interrupted_between, one_at_a_time, opened


class _Library(JITCodeLibrary):
    def _optimize_final_module(self) -> None:
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == llvm.Linkage.external:
                function.linkage = "linkonce_odr"

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._shared_module, self._finalized = self._final_module, True

    def serialize_using_object_code(self) -> Any:
        return self.serialize_using_bitcode()


class _PieceCompiler(DecidingCompiler):
    def __init__(self, typing: Any, target: Any, _none: None, *rest: Any) -> None:
        rest[2].no_compile = rest[2].no_cpython_wrapper = rest[2].no_cfunc_wrapper = True
        super().__init__(typing, target, _Library(target.codegen(), "piece"), *rest)


class _Stored(CompileResultCacheImpl):
    def rebuild(self, target: Any, payload: Any) -> Any:
        (name, _kind, code), function, environment, signature, *_rest, environments = payload
        library = _Library(target.codegen(), name)
        library._final_module = llvm.parse_bitcode(code)
        library._finalize_final_module()
        return compile_result(entry_point=library, library=library, target_context=target, signature=signature,
                              fndesc=function, environment=environment, referenced_envs=environments)  # fmt: skip


class _Cache(FunctionCache):
    def save_overload(self, *arguments: Any) -> None:
        with one_at_a_time("saving"):  # of a function, which names the files of all signatures
            super().save_overload(*arguments)


class _PieceCache(_Cache):
    _impl_class = _Stored  # type: ignore[assignment]


class _Piece(CPUDispatcher):
    _cache: Any

    def compile(self, signature: Any) -> Any:
        with interrupted_between():
            return super().compile(signature)

    def add_overload(self, kernel: Any) -> None:
        if kernel.entry_point is None:
            kernel = kernel._replace(entry_point=kernel.library, type_annotation=None)
            self.targetctx.insert_user_function(kernel.library, kernel.fndesc, [kernel.library])
        self.overloads[tuple(kernel.signature.args)] = kernel


class _Entry(CPUDispatcher):
    _cache: Any

    def compile(self, signature: Any) -> Any:
        if isinstance(self._cache, NullCache):  # most functions that are imported are never called
            self._cache = opened(_Cache, self.py_func)
        with (
            one_at_a_time(f"{self.stats.cache_path} {self.py_func.__qualname__} {signature}"),
            interrupted_between(),
        ):
            return super().compile(signature)

    def add_overload(self, kernel: Any) -> None:
        for environment in kernel._find_referenced_environments():  # also those of its pieces
            kernel.codegen.set_env(environment.env_name, environment)
        super().add_overload(kernel)


def compiled(function: Any, options: Any) -> Any:
    """Return a function for Python, whose compiled callers get its piece; both are cached."""
    entry: Any = _Entry(function, None, options, DecidingCompiler)
    entry._compiler.compile = compiling(function)(entry._compiler.compile)

    @functools.cache
    def piece() -> Any:
        called = _Piece(function, None, options, _PieceCompiler)
        called._cache = opened(_PieceCache, function, "pieces")
        return called

    entry.get_call_template = lambda arguments, named: piece().get_call_template(
        [unliteral(each) for each in arguments],
        {name: unliteral(each) for name, each in named.items()},
    )
    entry.get_overload = lambda signature: piece().get_overload(signature)
    return entry
