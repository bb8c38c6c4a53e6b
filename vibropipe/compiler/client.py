"""Compilation of missing kernels in another process, which leaves them in the cache to be loaded from there.

A process that compiles runs pieces that were optimised one by one. A process that loads optimises them again as one
whole and fuses other products and sums, which chaotic motions amplify. Therefore no process runs what it compiled,
unless no other process can compile it.

Processes that need the same kernel wait for the first of them to compile it; different kernels are compiled at the same
time. `compile_side_by_side` compiles the kernels that a process knows it will need.
"""

from __future__ import annotations

import atexit
import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from typing import Any

from vibropipe.compiler.cache import cache_root, module_folder, one_at_a_time
from vibropipe.compiler.numba_internals import is_cached, on_missing

# Environment variable of a process that compiles for others (SERVES) or for itself (HERE).
COMPILER, SERVES, HERE = "VIBROPIPE_COMPILES", "serves", "here"
# Subfolder of the pieces of a serving process, which cannot be called.
PIECES = "pieces"
# Answers of the serving process to a task.
DONE, FAILED = b"1", b"0"
COMMAND = "from vibropipe.compiler.server import serve; serve()"

on_compiling: list[Callable[[str], None]] = []
"""Called with the name of a kernel that is to be compiled; the command line prints it."""

_idle: list[tuple[int, subprocess.Popen[bytes]]] = []
_ahead: list[_Ahead] = []


class _PendingError(Exception):
    """A kernel is still being compiled."""


class _Ahead:
    """Compilations in progress, in threads that each wait for a process."""

    def __init__(self, processes: int) -> None:
        self.pool = ThreadPoolExecutor(processes)
        self.tasks: dict[str, Future[bool]] = {}

    def compile(self, dispatcher: Any, signature: Any) -> bool:
        """Return whether a kernel was compiled; raise _PendingError while it is not."""
        name = _task_name(dispatcher, signature)
        if name not in self.tasks:
            self.tasks[name] = self.pool.submit(_compile_once, dispatcher, signature)
        task = self.tasks[name]
        if not task.done():
            raise _PendingError(name)
        return task.result()

    def under_way(self) -> list[Future[bool]]:
        """Return the compilations that are not finished."""
        return [task for task in self.tasks.values() if not task.done()]


def compile_side_by_side(calls: Sequence[Callable[[], object]], processes: int) -> None:
    """Make some calls, whose missing kernels are compiled by several processes at once.

    Parameters
    ----------
    calls : sequence of callable
        Each is repeated until all its kernels are compiled, so it must cost almost nothing besides.
    processes : int
        Number of compiling processes.
    """
    ahead = _Ahead(processes)
    _ahead.append(ahead)
    try:
        while calls:
            pending = []
            for call in calls:
                try:
                    call()
                except _PendingError:
                    pending.append(call)
            # the first to finish may let a call proceed to its next kernel
            wait(ahead.under_way(), return_when=FIRST_COMPLETED)
            calls = pending
    finally:
        _ahead.remove(ahead)
        ahead.pool.shutdown(cancel_futures=True)


def compile_elsewhere(dispatcher: Any) -> None:
    """Let another process compile the kernels of a dispatcher that are not in the cache."""
    function = getattr(dispatcher, "py_func", None)  # none where numba is switched off
    # only of this package: another process can import its modules
    if function is not None and function.__module__.startswith("vibropipe."):
        on_missing(dispatcher, _compile, _compile_here)


def _compile(dispatcher: Any, signature: Any) -> bool:
    """Compile a missing kernel in another process; return whether it is in the cache now."""
    if COMPILER in os.environ:
        return False
    done = (_ahead[-1].compile if _ahead else _compile_once)(dispatcher, signature)
    if not done:
        _compile_here()
    return done


def _compile_here() -> None:
    """Let this process compile for itself from now on, with all that its kernels call."""
    os.environ[COMPILER] = HERE


def _task_name(dispatcher: Any, signature: Any) -> str:
    """Return a name of a kernel with its sources, signature and interpreter."""
    function = dispatcher.py_func
    folder = module_folder(function.__module__)  # named by the sources that the kernel depends on
    tag = sys.implementation.cache_tag
    return f"{folder} {tag} {function.__module__}.{function.__qualname__} {signature}"


def _compile_once(dispatcher: Any, signature: Any) -> bool:
    """Compile a kernel into the cache unless another process just did; return whether it is there."""
    function = dispatcher.py_func
    try:
        task = pickle.dumps((function.__module__, function.__qualname__, signature))
    except (pickle.PicklingError, TypeError, AttributeError):
        return False
    with one_at_a_time(_task_name(dispatcher, signature)):
        if is_cached(dispatcher, signature):
            return True
        for callback in on_compiling:
            callback(f"{function.__module__.removeprefix('vibropipe.')}.{function.__qualname__}")
        # Twice: an idle compiler ends after a while, possibly just before it gets the task.
        for _ in range(2):
            answer = _send_task(task)
            if answer:
                return answer == DONE
    return False


def _send_task(task: bytes) -> bytes:
    """Return the answer of a compiler to a task; empty if the compiler has ended."""
    compiler = _compiler()
    assert compiler.stdin is not None
    assert compiler.stdout is not None
    try:
        compiler.stdin.write(task)
        compiler.stdin.flush()
        answer = compiler.stdout.read(1)
    except OSError:
        return b""
    except BaseException:
        _kill(compiler)
        raise
    _idle.append((os.getpid(), compiler))
    return answer


def _compiler() -> subprocess.Popen[bytes]:
    """Return a process that compiles for this one (`vibropipe.compiler.server`): an idle one, or a new one."""
    while _idle:
        owner, waiting = _idle.pop()
        # after a fork the list still holds the compilers of the parent
        if owner == os.getpid() and waiting.poll() is None:
            return waiting
    path = os.pathsep.join(entry or os.getcwd() for entry in sys.path)
    environment = os.environ | {COMPILER: SERVES, "PYTHONPATH": path}
    environment["VIBROPIPE_CACHE_DIR"] = str(cache_root().parent)
    # In a process group of its own: Ctrl-C interrupts this process only, which then ends the compiler.
    group = {"process_group": 0} if hasattr(os, "killpg") else {}
    started = subprocess.Popen(
        # -P: the working directory may hold another copy of this package
        [sys.executable, "-P", "-c", COMMAND],
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        **group,  # type: ignore[call-overload]
    )
    atexit.register(_close_compiler, started, os.getpid())
    return started


def _kill(compiler: subprocess.Popen[bytes]) -> None:
    """Kill a compiler and the child that it forked."""
    with suppress(ProcessLookupError):
        if hasattr(os, "killpg"):
            os.killpg(compiler.pid, signal.SIGKILL)
        else:
            compiler.kill()


def _close_compiler(compiler: subprocess.Popen[bytes], owner: int) -> None:
    """End a compiler by closing its input."""
    if owner == os.getpid():
        with suppress(OSError, ValueError):
            compiler.communicate()
