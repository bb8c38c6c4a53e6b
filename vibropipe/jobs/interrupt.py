"""How a run of the workflow ends on Ctrl-C: with one line and exit code 130, jobs and locks cleared by snakemake."""

from __future__ import annotations

import atexit
import logging
import os
import signal
import sys
from types import FrameType

INTERRUPTED = 130
STOPPED = "interrupted; completed files are kept; run the same command to resume"


class Interrupt:
    """Answers Ctrl-C from when it is made, unless the shell ignores it (a job in the background).

    `reading` is set while rules are read: until then there is nothing to end but this process. `stopped` says
    whether Ctrl-C has come.
    """

    def __init__(self, logger: logging.Logger) -> None:
        self.logger, self.reading, self.stopped = logger, True, False
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, self._stop)
            atexit.register(self._leave)

    def _stop(self, _number: int, frame: FrameType | None) -> None:
        """End with one line; jobs have had the signal too, and what snakemake logs of their ends is noise."""
        if not self.stopped:
            self.stopped = True
            signal.signal(signal.SIGINT, lambda *_: None)
            self.logger.setLevel("CRITICAL")
            print(STOPPED, file=sys.stderr, flush=True)
        if self.reading:
            os._exit(INTERRUPTED)
        if _is_logging(frame):
            signal.signal(signal.SIGALRM, self._stop)
            signal.setitimer(signal.ITIMER_REAL, 0.05)
        else:
            raise SystemExit(INTERRUPTED)

    def _leave(self) -> None:
        """Give the exit code of Ctrl-C, by whatever way snakemake ends."""
        if self.stopped:
            sys.stdout.flush()
            os._exit(INTERRUPTED)


def _is_logging(frame: FrameType | None) -> bool:
    """Return whether a log handler is at work: those of snakemake swallow whatever ends a program."""
    while frame is not None and frame.f_code.co_name != "emit":
        frame = frame.f_back
    return frame is not None
