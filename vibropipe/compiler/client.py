"""Kernels that are not in the cache are compiled by another process, and loaded from there.

A process that compiles runs pieces that were optimised apart; one that loads runs them optimised once more in
one whole, with other products and sums fused. Chaotic motions show the difference. So nothing runs where it
was compiled, unless it cannot be compiled elsewhere.

Processes that need the same kernel wait for the first of them to compile it; different kernels are compiled at
once. A process that knows what it will need has its kernels compiled side by side (`compile_side_by_side`).
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

# In the environment: whether a process serves others as compiler, or has to compile for itself.
COMPILER, SERVES, HERE = "VIBROPIPE_COMPILES", "serves", "here"
# Subfolder of what a serving process makes for its own use, which nobody calls.
PIECES = "pieces"
# What it answers to a task.
DONE, FAILED = b"1", b"0"
COMMAND = "from vibropipe.compiler.server import serve; serve()"

on_compiling: list[Callable[[str], None]] = []
"""Called with the name of a kernel that is to be compiled; the command line prints it."""

_idle: list[tuple[int, subprocess.Popen[bytes]]] = []
_ahead: list[_Ahead] = []


class _PendingError(Exception):
    """A kernel is being compiled meanwhile."""


class _Ahead:
    """Compilations under way in some threads, each of which waits for a process of its own."""

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
        """Return the compilations that are not done."""
        return [task for task in self.tasks.values() if not task.done()]


def compile_side_by_side(calls: Sequence[Callable[[], object]], processes: int) -> None:
    """Make some calls, whose missing kernels are compiled by so many processes at once.

    Each call is made again until all its kernels are there; it must do next to nothing besides.
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
            # whatever is done first may let some call go on to its next kernel
            wait(ahead.under_way(), return_when=FIRST_COMPLETED)
            calls = pending
    finally:
        _ahead.remove(ahead)
        ahead.pool.shutdown(cancel_futures=True)


def compile_elsewhere(dispatcher: Any) -> None:
    """Let what is not in the cache be compiled by another process and loaded from there."""
    function = getattr(dispatcher, "py_func", None)  # none where numba is switched off
    # of this package, so that another process finds the module
    if function is not None and function.__module__.startswith("vibropipe."):
        on_missing(dispatcher, _compile, _compile_here)


def _compile(dispatcher: Any, signature: Any) -> bool:
    if COMPILER in os.environ:
        return False
    done = (_ahead[-1].compile if _ahead else _compile_once)(dispatcher, signature)
    if not done:
        _compile_here()
    return done


def _compile_here() -> None:
    """Let this process compile for itself: what is called from a kernel that it compiles is not tried elsewhere."""
    os.environ[COMPILER] = HERE


def _task_name(dispatcher: Any, signature: Any) -> str:
    function = dispatcher.py_func
    folder = module_folder(function.__module__)  # named by the sources that the kernel depends on
    return f"{folder} {function.__module__}.{function.__qualname__} {signature}"


def _compile_once(dispatcher: Any, signature: Any) -> bool:
    """Compile a kernel for a signature into the cache, unless another process just did; whether it is there."""
    function = dispatcher.py_func
    try:
        task = pickle.dumps((function.__module__, function.__qualname__, signature))
    except (pickle.PicklingError, TypeError, AttributeError):
        return False
    with one_at_a_time(_task_name(dispatcher, signature)):
        if is_cached(dispatcher, signature):
            return True
        for tell in on_compiling:
            tell(f"{function.__module__.removeprefix('vibropipe.')}.{function.__qualname__}")
        # One without work for a while has ended, at worst just now.
        for _ in range(2):
            answer = _send_task(task)
            if answer:
                return answer == DONE
    return False


def _send_task(task: bytes) -> bytes:
    """What a compiler answers to a task; nothing if it is no more."""
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
    """A process that compiles for this one (`vibropipe.compiler.server`): one without work, or a new one."""
    while _idle:
        owner, waiting = _idle.pop()
        if (
            owner == os.getpid() and waiting.poll() is None
        ):  # those of a parent are not this process's
            return waiting
    path = os.pathsep.join(entry or os.getcwd() for entry in sys.path)
    environment = os.environ | {COMPILER: SERVES, "PYTHONPATH": path}
    environment["VIBROPIPE_CACHE_DIR"] = str(cache_root().parent)
    # In a group of its own: a Ctrl-C is for this process, which then ends the other.
    group = {"process_group": 0} if hasattr(os, "killpg") else {}
    started = subprocess.Popen(
        # -P: the folder one is in may hold another copy of this package
        [sys.executable, "-P", "-c", COMMAND],
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        **group,  # type: ignore[call-overload]
    )
    atexit.register(_close_compiler, started, os.getpid())
    return started


def _kill(compiler: subprocess.Popen[bytes]) -> None:
    with suppress(ProcessLookupError):
        if hasattr(os, "killpg"):
            os.killpg(compiler.pid, signal.SIGKILL)
        else:
            compiler.kill()


def _close_compiler(compiler: subprocess.Popen[bytes], owner: int) -> None:
    """No task will come: it ends."""
    if owner == os.getpid():
        with suppress(OSError, ValueError):
            compiler.communicate()
