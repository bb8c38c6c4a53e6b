"""Processes of a job: side by side on its cores, ended with what started them or by Ctrl-C, errors as messages.

This module imports nothing slow, since each command reads it before all else.
"""

from __future__ import annotations

import atexit
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING

from vibropipe.solve.threads import watch_parent
from vibropipe.words.exit_codes import INTERRUPTED

if TYPE_CHECKING:
    import logging

STOPPED = "interrupted; completed files are kept; run the same command to resume"


class Interrupt:
    """Handler of Ctrl-C during a run of the workflow, which ends it with one line and has jobs and locks cleared.

    It is installed on creation unless the shell ignores the signal (a job in the background).

    reading : whether rules are still read. No job runs then, so the process ends at once
    stopped : whether Ctrl-C was pressed
    """

    def __init__(self, logger: logging.Logger) -> None:
        self.logger, self.reading, self.stopped = logger, True, False
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, self._stop)
            atexit.register(self._leave)

    def _stop(self, _number: int, frame: FrameType | None) -> None:
        """End the run with one line. Jobs receive the signal too; snakemake's log of their ends adds nothing."""
        if not self.stopped:
            self.stopped = True
            signal.signal(signal.SIGINT, lambda *_: None)
            self.logger.setLevel("CRITICAL")
            # Not by print: the signal may come while the stream is written to, which fails then.
            os.write(sys.__stderr__.fileno() if sys.__stderr__ else 2, f"{STOPPED}\n".encode())
        if self.reading:
            os._exit(INTERRUPTED)
        if _is_logging(frame) or _runs_a_loop():  # try again when it is done
            signal.signal(signal.SIGALRM, self._stop)
            signal.setitimer(signal.ITIMER_REAL, 0.05)
        else:
            raise SystemExit(INTERRUPTED)

    def _leave(self) -> None:
        """Exit with the code of Ctrl-C, however snakemake ends."""
        if self.stopped:
            sys.stdout.flush()
            os._exit(INTERRUPTED)


def _is_logging(frame: FrameType | None) -> bool:
    """Return whether a log handler is running: those of snakemake swallow every exception, SystemExit included."""
    while frame is not None and frame.f_code.co_name != "emit":
        frame = frame.f_back
    return frame is not None


def _runs_a_loop() -> bool:
    """Return whether an event loop is running: an exception here may leave its tasks waiting for ever."""
    import asyncio

    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return False
    return True


# Environment variable with the process that runs the jobs, which jobs do not outlive.
PARENT = "VIBROPIPE_PARENT"
# Bytes of the number of a task, and most tasks that a pipe holds at once on every system.
NUMBER_BYTES, MAX_TASKS = 4, 4096
# Seconds in which processes that were interrupted clean up.
GRACE = 5.0


def side_by_side(work: Callable[[int], None], count: int, processes: int) -> None:
    """Call `work(number)` once for each of the numbers below `count`, in order of the numbers.

    work : reports its errors itself
    processes : number of processes that share them. All that is imported here is imported there, so no kernel may
        have run before. With one, and where a process cannot fork, tasks are done here
    """
    processes = min(processes, count)
    if processes < 2 or not hasattr(os, "fork"):
        for number in range(count):
            work(number)
        return
    for begin in range(0, count, MAX_TASKS):
        _share(work, range(begin, min(begin + MAX_TASKS, count)), processes)


def _share(work: Callable[[int], None], numbers: range, processes: int) -> None:
    """Let forked processes take numbers from a pipe until it is empty."""
    reader, writer = os.pipe()
    os.write(writer, b"".join(number.to_bytes(NUMBER_BYTES, "big") for number in numbers))
    sys.stdout.flush()
    sys.stderr.flush()
    children = []
    for _ in range(processes):
        child = os.fork()
        if child == 0:
            os.close(writer)
            _take(work, reader)
        children.append(child)
    os.close(reader)
    os.close(writer)
    try:
        for child in children:
            os.waitpid(child, 0)
    except KeyboardInterrupt:  # it has reached them, too; who stays ends with this process
        deadline = time.monotonic() + GRACE
        while time.monotonic() < deadline and any(map(_runs, children)):
            time.sleep(0.05)
        raise


def _take(work: Callable[[int], None], reader: int) -> None:
    """Do tasks until there are none, and end this process."""
    code = 1
    try:
        watch_parent()
        while number := os.read(reader, NUMBER_BYTES):
            work(int.from_bytes(number, "big"))
        code = 0
    except KeyboardInterrupt:
        code = INTERRUPTED
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _runs(child: int) -> bool:
    try:
        return os.waitpid(child, os.WNOHANG)[0] == 0
    except ChildProcessError:
        return False


def end_with_parent() -> None:
    """End this process soon after the one that started it, if the environment says that it is a job of that one."""
    if os.environ.get(PARENT) == str(os.getppid()):
        watch_parent()


@contextmanager
def reported(log: Path | None) -> Iterator[None]:
    """Report errors in here as a command does, in a log if there is one, which also has all that is printed."""
    sys.stdout.flush()
    sys.stderr.flush()
    before = [os.dup(1), os.dup(2)]
    if log is not None:
        log.parent.mkdir(parents=True, exist_ok=True)
        with log.open("wb") as file:
            os.dup2(file.fileno(), 1)
            os.dup2(file.fileno(), 2)
    try:
        yield
    except Exception as error:
        if exit_code(error) is None:
            traceback.print_exc()
        else:
            print(f"vibropipe: {error}", file=sys.stderr)
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        for target, stream in enumerate(before, 1):
            os.dup2(stream, target)
            os.close(stream)


def exit_code(error: Exception) -> int | None:
    """Return the exit code of an error: 2 for a mistake of the user, 1 for a failure of the machine, None for a bug."""
    from vibropipe.physics.exciter import ParameterError
    from vibropipe.scenes.costs import PlanError
    from vibropipe.store import NotWrittenError, StoreError
    from vibropipe.study import StudyError

    if isinstance(error, NotWrittenError):
        return 1
    if isinstance(error, StudyError | StoreError | ParameterError | PlanError):
        return 2
    return 1 if isinstance(error, OSError) else None
