"""The process of a worker: it runs the commands of jobs one after another (`vibropipe.cli.workers`)."""

from __future__ import annotations

import _thread
import gc
import json
import os
import select
import signal
import socket
import sys
import threading
import traceback
from contextlib import suppress
from importlib import import_module
from typing import Any

from vibropipe.cli import block_dask_import, main
from vibropipe.cli.workers import remove_socket
from vibropipe.words.exit_codes import INTERRUPTED

# What the commands of jobs import, `dask.base` and `pint` by xarray's checks of types; an idle worker also imports what
# figures and reports need.
SOLVING = (
    "vibropipe.cli.commands",
    "vibropipe.jobs.progress",
    "vibropipe.jobs.solving",
    "vibropipe.scenes.sweep.cut",
    "dask.base",
    "h5py",
    "netCDF4",
    "pint",
)
DRAWING = (
    "vibropipe.scenes.sweep.pictures",
    "vibropipe.scenes.sweep.report",
    "vibropipe.jobs.reporting",
    "matplotlib.backends.backend_svg",
    "matplotlib.backends.backend_pdf",
    "PIL.PngImagePlugin",
    "contourpy",
    "fontTools.subset",
    "typst",
)

MAX_WORKERS = 1 << 16
# Seconds in which a command that is interrupted cleans up.
GRACE = 5.0


def serve() -> None:
    """Run the commands that arrive at a socket, until the process that started this one has ended.

    The arguments of the process are the descriptors of the socket, and of a pipe whose other end the starting process
    holds; for each byte in the pipe this process forks another worker, which has everything imported, too. A command
    that is interrupted ends this process.
    """
    # Ctrl-C reaches all processes of a run; an idle one ends with the run.
    on_interrupt = signal.signal(signal.SIGINT, signal.SIG_IGN)
    listener, lifeline = socket.socket(fileno=int(sys.argv[1])), int(sys.argv[2])
    block_dask_import()
    _load_numba()
    _import(SOLVING)
    to_import = [DRAWING]
    code = 0
    while code != INTERRUPTED:
        waited: list[Any] = [listener, lifeline]
        ready, *_ = select.select(waited, [], [], 0 if to_import else None)
        if lifeline in ready:
            # before the first job, which may start threads
            more = os.read(lifeline, MAX_WORKERS)
            if not more:
                remove_socket()
                return
            any(os.fork() == 0 for _ in more)  # a forked worker forks no further
            continue
        if not ready:
            _import(to_import.pop())
            continue
        try:
            link, _ = listener.accept()
        except BlockingIOError:  # another worker was faster
            continue
        with link:
            signal.signal(signal.SIGINT, on_interrupt)
            code = _answer(link)
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        gc.collect()  # figures refer to themselves


def _import(names: tuple[str, ...]) -> None:
    """Import modules, and spare all that is loaded from the collection of garbage."""
    for name in names:
        import_module(name)
    gc.freeze()


def _load_numba() -> None:
    """Compile a function that does nothing: this loads what numba needs for its first kernel."""
    import numba

    numba.njit(lambda n: n).compile((numba.int64,))


def _answer(link: socket.socket) -> int:
    """Run the command of a client with its streams; send it the exit code and return this."""
    head, streams, *_ = socket.recv_fds(link, 8, 3)
    with link.makefile("rb") as sent:
        folder, arguments = json.loads(sent.read(int.from_bytes(head, "big")))
    os.chdir(folder)
    _use_streams(streams)
    done = threading.Event()
    watch = threading.Thread(target=_interrupt_at_end, args=(link, done))
    watch.start()
    code = _exit_code(arguments)
    done.set()
    _use_streams([os.open(os.devnull, os.O_RDWR) for _ in streams])
    with suppress(OSError):  # the client may have been killed
        link.send(bytes([code]))
        link.shutdown(socket.SHUT_RDWR)
    watch.join()
    return code


def _exit_code(arguments: list[str]) -> int:
    """Run a command and return its exit code."""
    try:
        main(arguments)
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else int(stop.code is not None)
    except Exception:
        traceback.print_exc()
        return 1
    return 0


def _use_streams(streams: list[int]) -> None:
    """Make descriptors the standard streams, and close them."""
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    for target, stream in enumerate(streams):
        os.dup2(stream, target)
        os.close(stream)


def _interrupt_at_end(link: socket.socket, done: threading.Event) -> None:
    """Interrupt the command, as Ctrl-C does, if its client ends before it."""
    if not link.recv(1) and not done.is_set():
        _thread.interrupt_main()
        if not done.wait(GRACE):  # within a kernel
            os._exit(INTERRUPTED)
