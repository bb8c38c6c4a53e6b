"""Ctrl-C during a run of the workflow: one line, exit code 130, and snakemake clears its jobs and locks."""

from __future__ import annotations

import asyncio
import atexit
import logging
import os
import signal
import sys
from types import FrameType

from vibropipe.words.exit_codes import INTERRUPTED

STOPPED = "interrupted; completed files are kept; run the same command to resume"


class Interrupt:
    """Handler of Ctrl-C, installed on creation unless the shell ignores the signal (a job in the background).

    Parameters
    ----------
    logger : logging.Logger
        The logger of snakemake; silenced after Ctrl-C.

    Attributes
    ----------
    reading : bool
        Whether rules are still read. No job runs then, so the process ends at once.
    stopped : bool
        Whether Ctrl-C was pressed.
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
            print(STOPPED, file=sys.stderr, flush=True)
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
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return False
    return True
