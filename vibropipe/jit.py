"""The compiler: one decorator, its flags, and the on-disk cache that can never serve stale physics.

numba's cache looks only at the source file of the outermost function, so an edit of a function it calls
would go unseen. Here every compiled function is cached in a folder named by a hash of all the sources that
numbers depend on: another source, another folder.
"""

from __future__ import annotations

import atexit
import functools
import hashlib
import os
import pickle
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar, cast

F = TypeVar("F", bound=Callable[..., Any])

PACKAGE = Path(__file__).parent
# Set in the environment of a process that compiles by itself what is not in the cache.
COMPILER = "VIBROPIPE_COMPILES"
# Where it keeps what it makes for its own use only, and what nobody calls of that.
PIECES = "pieces"
NO_WRAPPERS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
# What it answers to a task.
DONE, FAILED = b"1", b"0"
# Whatever can change a stored number; figures, reports and the store are left out on purpose.
HASHED = ("jit.py", "apart.py", "status.py", "physics", "kernels", "batch")

_compilers: dict[int, subprocess.Popen[bytes]] = {}


@functools.cache
def kernel_hash() -> str:
    """Hash (16 hex digits) of all sources that stored numbers depend on; needs no compiler."""
    digest = hashlib.sha256()
    for entry in HASHED:
        path = PACKAGE / entry
        for source in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            digest.update(source.relative_to(PACKAGE).as_posix().encode() + b"\0")
            digest.update(source.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


@functools.cache
def cache_folder() -> Path:
    """Folder of compiled kernels: `VIBROPIPE_CACHE_DIR`, else the user's cache; if that cannot be written, one
    that goes with this process (which then compiles anew, and says so once on stderr)."""
    base = os.environ.get("VIBROPIPE_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    chosen = Path(base) if base else Path.home() / ".cache"
    folder = chosen / "vibropipe" / kernel_hash()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError as error:
        print(
            f"vibropipe: the kernel cache {folder} cannot be written ({error.strerror}); kernels are compiled "
            "for this process only. Set VIBROPIPE_CACHE_DIR to a folder that can be written.",
            file=sys.stderr,
        )
    own = Path(tempfile.mkdtemp(prefix="vibropipe-kernels-"))
    atexit.register(shutil.rmtree, own, ignore_errors=True)
    folder = own / "vibropipe" / kernel_hash()
    folder.mkdir(parents=True)
    return folder


def _compile(function: F, fused: bool = True, forceinline: bool = False, **flags: Any) -> F:
    import numba

    # Of fastmath only the fusing of a product and a sum (halves the latency of every polynomial); the full set
    # deletes isnan.
    fast = {"contract"} if fused else False

    # Said of every function: what is not said it would inherit from the caller that is compiled first, and the
    # same kernel would come out in one way or another.
    flags["forceinline"] = forceinline

    # The cache folder is read when the decorator runs; it is put back for other users of numba.
    before = numba.config.CACHE_DIR  # type: ignore[attr-defined]
    numba.config.CACHE_DIR = str(cache_folder())  # type: ignore[attr-defined]
    if os.environ.get(COMPILER) == "apart":
        numba.config.CACHE_DIR = str(cache_folder() / PIECES)  # type: ignore[attr-defined]
        flags |= NO_WRAPPERS
    try:
        # numpy's error model: 1/0 gives inf, no branch per division.
        compiled: Any = numba.njit(error_model="numpy", fastmath=fast, cache=True, **flags)(
            function
        )
        if COMPILER not in os.environ and hasattr(compiled, "_cache"):
            _load_or_compile_apart(compiled)
        return cast(F, compiled)
    finally:
        numba.config.CACHE_DIR = before  # type: ignore[attr-defined]


def _load_or_compile_apart(dispatcher: Any) -> None:
    """Let what is not in the cache be compiled by another process and loaded from there.

    A process that compiles runs pieces that were optimised apart; one that loads runs them optimised once
    more in one whole, with other products and sums fused. Chaotic motions show the difference. So nothing
    runs where it was compiled, unless it cannot be compiled elsewhere.
    """
    function, cache = dispatcher.py_func, dispatcher._cache
    load, place = cache.load_overload, (function.__module__, function.__qualname__)

    def load_overload(signature: Any, target: Any) -> Any:
        found = load(signature, target)
        ours = place[0].startswith(PACKAGE.name + ".")  # another process finds the module
        if found is None and COMPILER not in os.environ and ours:
            if _compile_apart(*place, signature):
                found = load(signature, target)
            else:
                os.environ[COMPILER] = "here"  # what is called from here is not tried again
        return found

    cache.load_overload = load_overload


def _compile_apart(module: str, name: str, signature: Any) -> bool:
    """Compile a function for a signature into the cache, in a process that does nothing else; whether it did."""
    try:
        task = pickle.dumps((module, name, signature))
    except (pickle.PicklingError, TypeError, AttributeError):
        return False
    # One without work for a while has ended, at worst just now.
    for _ in range(2):
        answer = _ask(_compiler(), task)
        if answer:
            return answer == DONE
    return False


def _compiler() -> subprocess.Popen[bytes]:
    """The process that compiles for this one (`vibropipe.apart`), started when first needed."""
    running = _compilers.get(os.getpid())  # a fork has none
    if running is not None and running.poll() is None:
        return running
    command = [sys.executable, "-c", "from vibropipe.apart import serve; serve()"]
    path = os.pathsep.join(entry or os.getcwd() for entry in sys.path)
    environment = os.environ | {COMPILER: "apart", "PYTHONPATH": path}
    environment["VIBROPIPE_CACHE_DIR"] = str(cache_folder().parents[1])
    # In a group of its own: a Ctrl-C is for this process, which then ends the other.
    started = subprocess.Popen(
        command,
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        process_group=0,
    )
    _compilers[os.getpid()] = started
    atexit.register(_dismiss, started)
    return started


def _ask(compiler: subprocess.Popen[bytes], task: bytes) -> bytes:
    """What a compiler answers to a task; nothing if it is no more."""
    assert compiler.stdin is not None
    assert compiler.stdout is not None
    try:
        compiler.stdin.write(task)
        compiler.stdin.flush()
        return compiler.stdout.read(1)
    except BrokenPipeError:
        return b""
    except BaseException:
        with suppress(ProcessLookupError):
            os.killpg(compiler.pid, signal.SIGKILL)
        raise


def _dismiss(compiler: subprocess.Popen[bytes]) -> None:
    """No task will come: it ends."""
    with suppress(OSError):
        compiler.communicate()


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
