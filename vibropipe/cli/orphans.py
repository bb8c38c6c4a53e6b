"""A command that is part of a run ends when the run was killed: the shell between them would let it go on."""

from __future__ import annotations

import os
import threading
import time
from contextlib import suppress
from pathlib import Path

# Environment variable with the record of the run that a command is part of (`vibropipe.jobs.locks`); set where jobs run
# on the host of the run. This module imports nothing slow.
RUN = "VIBROPIPE_RUN"
# Seconds between two looks, and the exit code of a command whose run was killed.
LOOK_EVERY, ORPHANED = 1.0, 1


def end_with_run() -> None:
    """End this process soon after the run that it is part of, if there is one."""
    record = Path(os.environ.get(RUN, ""))
    if record.is_file():
        threading.Thread(target=_watch, args=(os.open(record, os.O_RDONLY),), daemon=True).start()


def _watch(record: int) -> None:
    while not _is_free(record):
        time.sleep(LOOK_EVERY)
    # at once, even within a kernel; files appear only when whole
    os._exit(ORPHANED)


def _is_free(record: int) -> bool:
    """Return whether the run that locks an open record has ended."""
    with suppress(ImportError, OSError):  # it is locked, or nothing can be
        import fcntl

        fcntl.flock(record, fcntl.LOCK_SH | fcntl.LOCK_NB)
        return True
    return False
